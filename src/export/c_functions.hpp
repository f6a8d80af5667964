#pragma once

#include <string_view>

namespace rivid::detail {

// What a generated C header has. @ is the robot's name; what stands between $ and $ is recorded from the
// library's kernels, see c_header.cpp.
//
// A payload λ is an external torque −L λ to the arm. Its momentum passes through the observer's low-pass as
// that of the arm does, so that r = −L_f λ without accelerations. Its least squares have loops, and stand
// here alone.
inline constexpr std::string_view c_functions = R"(#ifndef RIVID_@_H
#define RIVID_@_H

#include <math.h>

#define @_JOINTS $joints$

/* M(q) qdd + N(q, qd): inertia, rotors, Coriolis, centrifugal and gravity torques. */
static inline void @_rigid_body(const double q[@_JOINTS], const double qd[@_JOINTS], const double qdd[@_JOINTS],
                                double tau[@_JOINTS]) {
  (void)q, (void)qd, (void)qdd;
$rigid_body$
}

/* N(q, 0): what holds the robot against gravity. */
static inline void @_gravity(const double q[@_JOINTS], double tau[@_JOINTS]) {
  (void)q;
$gravity$
}

/* Friction. smoothing_speed: null for sign(qd), 0 at rest; else v_s of each joint, positive, of tanh(qd / v_s). What was
   identified with a smooth sign keeps its own. */
static inline void @_friction(const double qd[@_JOINTS], const double* smoothing_speed, double tau[@_JOINTS]) {
  (void)qd, (void)smoothing_speed;
$friction$
}

/* tau = M(q) qdd + N(q, qd) + friction(qd), with the sign of qd as it is. Friction that follows the load, of which a joint
   takes a part of |M(q) qdd + N(q, qd)|, is here alone. */
static inline void @_inverse_dynamics(const double q[@_JOINTS], const double qd[@_JOINTS],
                                      const double qdd[@_JOINTS], double tau[@_JOINTS]) {
  double friction[@_JOINTS];
  @_rigid_body(q, qd, qdd, tau);
  @_friction(qd, (const double*)0, friction);
$with_friction$
}

/* Sine, cosine and position of each joint; of its link, in the link's axes, twist w and v, the acceleration of free fall, reversed,
   and the momentum and weight of the link itself, a load: linear and angular momentum, the force and moment that hold it. */
typedef struct @_motion {
  double c[@_JOINTS], s[@_JOINTS], q[@_JOINTS];
  double link[@_JOINTS][21];
} @_motion;

static inline void @_set_motion(const double* q, const double* qd, @_motion* to) {
$sweep$
}

/* What joint j sees of the momentum and weight of all behind it, and the same in the frame before. */
static inline void @_share(int j, const @_motion* at, double load[12], double p[@_JOINTS], double rate[@_JOINTS]) {
  switch (j) {
$shares$
    default:
      break;
  }
}

static inline void @_body_load(const @_motion* at, const double body[10], double load[12]) {
$body$
}

/* Generalised momentum p and dT/dq - gravity torques, of the links (body null) or of a body XX ... M in the last frame alone. */
static inline void @_momenta(const @_motion* at, const double* body, double p[@_JOINTS], double rate[@_JOINTS]) {
  double load[12] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  int i, j;
  if (body) {
    @_body_load(at, body, load);
  }
  for (j = @_JOINTS - 1; j >= 0; --j) {
    for (i = 0; !body && i < 12; ++i) {
      load[i] += at->link[j][9 + i];
    }
    @_share(j, at, load, p, rate);
  }
}

/* New momentum through the low-pass: driven is what else changes it. */
static inline double @_low_pass(double r, double keep, double before, double now, double driven, double f_m) {
$low_pass$
}

/* Observer of external torques by the generalised momentum; all zeros at the begin. */
typedef struct @_observer {
  double torque[@_JOINTS]; /* that acts on the robot from outside [N m | N], behind a low-pass of `bandwidth` */
  double p[@_JOINTS];
  double rate[@_JOINTS];
  double friction[@_JOINTS];
  int running;
} @_observer;

/* Whether a tick is one: finite, and at most 1e6 rad or m, 1e9 rad/s or m/s, 1e9 N m or N. */
static inline int @_is_tick(const double* q, const double* qd, const double* tau) {
  int j;
  for (j = 0; j < @_JOINTS; ++j) {
    if (!(fabs(q[j]) <= 1e6 && fabs(qd[j]) <= 1e9 && fabs(tau[j]) <= 1e9)) {
      return 0;
    }
  }
  return 1;
}

/* A tick of the observer at a motion. tau: from the last tick to this one; smoothing_speed as in friction(); bandwidth [rad/s]. */
static inline void @_observe_at(@_observer* o, const @_motion* at, const double* qd, const double* tau,
                                const double* smoothing_speed, double bandwidth, double f_m) {
  const double keep = exp(-bandwidth / f_m);
  double p[@_JOINTS], rate[@_JOINTS], friction[@_JOINTS], driven[@_JOINTS];
  int i;
  @_momenta(at, (const double*)0, p, rate);
  {
$rotors$
  }
  @_friction(qd, smoothing_speed, friction);
  for (i = 0; i < @_JOINTS; ++i) {
    driven[i] = tau[i] - 0.5 * (o->friction[i] + friction[i]);
  }
  /* What the gears pass on, where friction follows the load. */
  {
$passed_on$
  }
  for (i = 0; i < @_JOINTS; ++i) {
    driven[i] += 0.5 * (o->rate[i] + rate[i]);
    o->torque[i] = o->running ? @_low_pass(o->torque[i], keep, o->p[i], p[i], driven[i], f_m) : 0.0;
    o->p[i] = p[i];
    o->rate[i] = rate[i];
    o->friction[i] = friction[i];
  }
  o->running = 1;
}

/* Returns 1; 0 for a tick that is none, with a NaN, say: the torque stays as it was, and the next tick is the first one. */
static inline int @_observe(@_observer* o, const double q[@_JOINTS], const double qd[@_JOINTS],
                            const double tau[@_JOINTS], const double* smoothing_speed, double bandwidth, double f_m) {
  @_motion at;
  if (!@_is_tick(q, qd, tau)) {
    o->running = 0;
    return 0;
  }
  @_set_motion(q, qd, &at);
  @_observe_at(o, &at, qd, tau, smoothing_speed, bandwidth, f_m);
  return 1;
}

/* Orientation of the last frame in the frame of the last link. */
static const double @_last_axes[3][3] = $last_axes$;

/* A body on the last link by recursive least squares; all zeros at the begin, and again when the payload has changed. */
typedef struct @_payload {
  double mass;       /* [kg] */
  double mass_sigma; /* standard deviation by the noise of the torques; 0 before the first tick */
  double com[3];     /* centre of mass in the frame of the last link [m] */
  double com_sigma[3];
  double rest[@_JOINTS];      /* external torque that this payload does not explain: contacts */
  @_observer arm;             /* without the payload */
  double column[10][@_JOINTS]; /* of XX ... M in the last frame, behind the same low-pass */
  double p[10][@_JOINTS];
  double rate[10][@_JOINTS];
  double moving[@_JOINTS]; /* time since the joint was slow [s] */
  double A[10][10];        /* information, without what is known beforehand */
  double b[10];
} @_payload;

/* A x = b by Cholesky's factor L of A, which takes its place. */
static inline void @_solve(double L[10][10], const double b[10], double x[10]) {
  int i, j, k;
  for (j = 0; j < 10; ++j) {
    for (i = j; i < 10; ++i) {
      for (k = 0; k < j; ++k) {
        L[i][j] -= L[i][k] * L[j][k];
      }
      L[i][j] = i == j ? sqrt(L[i][j]) : L[i][j] / L[j][j];
    }
  }
  for (i = 0; i < 10; ++i) {
    x[i] = b[i];
    for (k = 0; k < i; ++k) {
      x[i] -= L[i][k] * x[k];
    }
    x[i] /= L[i][i];
  }
  for (i = 9; i >= 0; --i) {
    for (k = i + 1; k < 10; ++k) {
      x[i] -= L[k][i] * x[k];
    }
    x[i] /= L[i][i];
  }
}

/* Standard deviation of slope . x by the factor of its information. */
static inline double @_deviation(double L[10][10], const double slope[10]) {
  double y[10], sum = 0.0;
  int i, k;
  for (i = 0; i < 10; ++i) {
    y[i] = slope[i];
    for (k = 0; k < i; ++k) {
      y[i] -= L[i][k] * y[k];
    }
    y[i] /= L[i][i];
    sum += y[i] * y[i];
  }
  return sqrt(sum);
}

/* What the information says. Known beforehand: ten kilograms at 15 cm are usual, and nothing else. */
static inline void @_solve_payload(@_payload* o) {
  double L[10][10], x[10];
  double com[3], slope[3][10], mass[10] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
  int i, j, k;
  for (i = 0; i < 10; ++i) {
    const double usual = 10.0 * (i < 6 ? 0.15 * 0.15 : i < 9 ? 0.15 : 1.0);
    for (k = 0; k < 10; ++k) {
      L[i][k] = o->A[i][k] + (i == k ? 1.0 / (usual * usual) : 0.0);
    }
  }
  @_solve(L, o->b, x);
  o->mass = x[9];
  o->mass_sigma = @_deviation(L, mass);
  for (j = 0; j < @_JOINTS; ++j) {
    o->rest[j] = o->arm.torque[j];
    for (k = 0; k < 10; ++k) {
      o->rest[j] += o->column[k][j] * x[k];
    }
  }
  for (i = 0; i < 3; ++i) {
    com[i] = x[9] > 0.0 ? x[6 + i] / x[9] : 0.0;
  }
  for (i = 0; i < 3; ++i) {
    o->com[i] = 0.0;
    for (k = 0; k < 10; ++k) {
      slope[i][k] = 0.0;
    }
    for (k = 0; k < 3; ++k) {
      o->com[i] += @_last_axes[i][k] * com[k];
      slope[i][6 + k] = x[9] > 0.0 ? @_last_axes[i][k] / x[9] : 0.0;
    }
    slope[i][9] = x[9] > 0.0 ? -o->com[i] / x[9] : 0.0;
    o->com_sigma[i] = @_deviation(L, slope[i]);
  }
}

/* A tick. Joints slower than 3 smoothing_speed, or so shortly before, do not count: their friction is not known.
   sigma: standard deviation of each joint's observed torque without a payload [N m | N]; forgetting: time constant [s], 0: none.
   Returns 1; 0 for a tick that is none: what is known of the payload stays, and the observer's next tick is the first one. */
static inline int @_estimate_payload(@_payload* o, const double q[@_JOINTS], const double qd[@_JOINTS],
                                     const double tau[@_JOINTS], const double smoothing_speed[@_JOINTS],
                                     const double sigma[@_JOINTS], double forgetting, double bandwidth, double f_m) {
  const double keep = exp(-bandwidth / f_m);
  const double fade = forgetting > 0.0 ? exp(-1.0 / (forgetting * f_m)) : 1.0;
  const int running = o->arm.running;
  @_motion at;
  int i, j, k;
  if (!@_is_tick(q, qd, tau)) {
    o->arm.running = 0;
    return 0;
  }
  @_set_motion(q, qd, &at);
  @_observe_at(&o->arm, &at, qd, tau, smoothing_speed, bandwidth, f_m);
  for (k = 0; k < 10; ++k) {
    double unit[10] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    double p[@_JOINTS], rate[@_JOINTS];
    unit[k] = 1.0;
    @_momenta(&at, unit, p, rate);
    for (j = 0; j < @_JOINTS; ++j) {
      const double driven = 0.5 * (o->rate[k][j] + rate[j]);
      o->column[k][j] = running ? @_low_pass(o->column[k][j], keep, o->p[k][j], p[j], driven, f_m) : 0.0;
      o->p[k][j] = p[j];
      o->rate[k][j] = rate[j];
    }
  }
  for (i = 0; i < 10; ++i) {
    o->b[i] *= fade;
    for (k = 0; k < 10; ++k) {
      o->A[i][k] *= fade;
    }
  }
  for (j = 0; j < @_JOINTS; ++j) {
    /* The low-pass makes noise of neighbouring ticks alike: 2 f_m / bandwidth of them are worth one. */
    const double weight = 0.5 * bandwidth / (f_m * sigma[j] * sigma[j]);
    o->moving[j] = fabs(qd[j]) > 3.0 * smoothing_speed[j] ? o->moving[j] + 1.0 / f_m : 0.0;
    for (i = 0; o->moving[j] * bandwidth > 5.0 && i < 10; ++i) {
      o->b[i] -= weight * o->column[i][j] * o->arm.torque[j];
      for (k = 0; k < 10; ++k) {
        o->A[i][k] += weight * o->column[i][j] * o->column[k][j];
      }
    }
  }
  @_solve_payload(o);
  return 1;
}

#endif
)";

}  // namespace rivid::detail
