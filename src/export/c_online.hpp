#pragma once

#include <string_view>

namespace rivid::detail {

// What a generated C header has for a control loop: ContactObserver's residual, and a payload by recursive least squares on it. @ is the
// robot's name.
//
// A payload λ is an external torque −L λ to the arm. Its momentum passes through the observer's low-pass as that of the arm does, so that
// r = −L_f λ without accelerations.
inline constexpr std::string_view c_online_functions = R"(
/* Poses, twists and the acceleration of free fall, reversed, of all links in their own axes. */
typedef struct @_motion {
  double T[@_JOINTS][9]; /* orientation of frame j in frame j - 1, by rows */
  double p[@_JOINTS][3];
  double w[@_JOINTS][3];
  double v[@_JOINTS][3];
  double a[@_JOINTS][3];
} @_motion;

static inline void @_set_motion(const double* q, const double* qd, @_motion* to) {
  int i, j;
  for (j = 0; j < @_JOINTS; ++j) {
    const double* const R = @_R[j];
    const double s = @_revolute[j] ? sin(q[j]) : 0.0;
    const double c = @_revolute[j] ? cos(q[j]) : 1.0;
    const double slide = @_revolute[j] ? 0.0 : q[j];
    double* const T = to->T[j];
    double* const r = to->p[j];
    double w[3] = {0.0, 0.0, 0.0}, v[3] = {0.0, 0.0, 0.0};
    const double* const a = j > 0 ? to->a[j - 1] : @_base_acceleration;
    for (i = 0; i < 3; ++i) {
      T[3 * i] = R[3 * i] * c + R[3 * i + 1] * s;
      T[3 * i + 1] = R[3 * i + 1] * c - R[3 * i] * s;
      T[3 * i + 2] = R[3 * i + 2];
      r[i] = @_p[j][i] + R[3 * i + 2] * slide;
    }
    if (j > 0) {
      for (i = 0; i < 3; ++i) {
        w[i] = to->w[j - 1][i];
      }
      v[0] = to->v[j - 1][0] + w[1] * r[2] - w[2] * r[1];
      v[1] = to->v[j - 1][1] + w[2] * r[0] - w[0] * r[2];
      v[2] = to->v[j - 1][2] + w[0] * r[1] - w[1] * r[0];
    }
    for (i = 0; i < 3; ++i) {
      to->w[j][i] = T[i] * w[0] + T[3 + i] * w[1] + T[6 + i] * w[2];
      to->v[j][i] = T[i] * v[0] + T[3 + i] * v[1] + T[6 + i] * v[2];
      to->a[j][i] = T[i] * a[0] + T[3 + i] * a[1] + T[6 + i] * a[2];
    }
    if (@_revolute[j]) {
      to->w[j][2] += qd[j];
    } else {
      to->v[j][2] += qd[j];
    }
  }
}

/* Generalised momentum p and dT/dq - gravity torques, of the links (body null) or of a body XX ... M in the last frame alone. */
static inline void @_momentum(const @_motion* at, const double* body, double p[@_JOINTS], double rate[@_JOINTS]) {
  double linear[3] = {0.0, 0.0, 0.0}, angular[3] = {0.0, 0.0, 0.0}; /* momentum of link j and all behind it */
  double f[3] = {0.0, 0.0, 0.0}, n[3] = {0.0, 0.0, 0.0};            /* wrench that holds them */
  int i, j;
  for (j = @_JOINTS - 1; j >= 0; --j) {
    const double* const w = at->w[j];
    const double* const v = at->v[j];
    const double* const a = at->a[j];
    const double* const T = at->T[j];
    const double* const r = at->p[j];
    const double* const I = !body ? @_inertial[j] : j == @_JOINTS - 1 ? body : (const double*)0;
    double out[4][3];
    if (I) {
      linear[0] += I[9] * v[0] + w[1] * I[8] - w[2] * I[7];
      linear[1] += I[9] * v[1] + w[2] * I[6] - w[0] * I[8];
      linear[2] += I[9] * v[2] + w[0] * I[7] - w[1] * I[6];
      angular[0] += I[0] * w[0] + I[1] * w[1] + I[2] * w[2] + I[7] * v[2] - I[8] * v[1];
      angular[1] += I[1] * w[0] + I[3] * w[1] + I[4] * w[2] + I[8] * v[0] - I[6] * v[2];
      angular[2] += I[2] * w[0] + I[4] * w[1] + I[5] * w[2] + I[6] * v[1] - I[7] * v[0];
      for (i = 0; i < 3; ++i) {
        f[i] += I[9] * a[i];
      }
      n[0] += I[7] * a[2] - I[8] * a[1];
      n[1] += I[8] * a[0] - I[6] * a[2];
      n[2] += I[6] * a[1] - I[7] * a[0];
    }
    p[j] = @_revolute[j] ? angular[2] : linear[2];
    rate[j] = @_revolute[j] ? angular[0] * w[1] - angular[1] * w[0] + linear[0] * v[1] - linear[1] * v[0] - n[2]
                            : linear[0] * w[1] - linear[1] * w[0] - f[2];
    for (i = 0; i < 3; ++i) {
      const double* const row = T + 3 * i;
      out[0][i] = row[0] * linear[0] + row[1] * linear[1] + row[2] * linear[2];
      out[1][i] = row[0] * angular[0] + row[1] * angular[1] + row[2] * angular[2];
      out[2][i] = row[0] * f[0] + row[1] * f[1] + row[2] * f[2];
      out[3][i] = row[0] * n[0] + row[1] * n[1] + row[2] * n[2];
    }
    for (i = 0; i < 3; ++i) {
      const int k = (i + 1) % 3, l = (i + 2) % 3;
      linear[i] = out[0][i];
      angular[i] = out[1][i] + r[k] * out[0][l] - r[l] * out[0][k];
      f[i] = out[2][i];
      n[i] = out[3][i] + r[k] * out[2][l] - r[l] * out[2][k];
    }
  }
}

/* Observer of external torques by the generalised momentum; all zeros at the begin. */
typedef struct @_observer {
  double torque[@_JOINTS]; /* that acts on the robot from outside [N m | N], behind a low-pass of `bandwidth` */
  double p[@_JOINTS];
  double rate[@_JOINTS];
  double friction[@_JOINTS];
  int running;
} @_observer;

/* The part of joint i's torque that its gear passes on, where friction follows the load. */
static inline double @_passed_on(int i, double torque, double speed, const double* smoothing_speed) {
  int e;
  for (e = 0; e < @_dry_count; ++e) {
    if (@_dry_load[e] > 0.0 && @_dry_torque[e][i] != 0.0) {
      const double v_s = @_dry_sign_speed[e] > 0.0 ? @_dry_sign_speed[e] : smoothing_speed ? smoothing_speed[i] : 0.0;
      const double sign = v_s > 0.0 ? tanh(speed / v_s) : speed > 0.0 ? 1.0 : speed < 0.0 ? -1.0 : 0.0;
      torque /= 1.0 + (torque > 0.0 ? 1.0 : -1.0) * @_dry_load[e] * sign;
    }
  }
  return torque;
}

/* New momentum through the low-pass: driven is what else changes it. */
static inline double @_low_pass(double r, double keep, double before, double now, double driven, double f_m) {
  return keep * r + (1.0 - keep) * ((now - before) * f_m - driven);
}

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
  double p[@_JOINTS], rate[@_JOINTS], friction[@_JOINTS];
  int i, j;
  @_momentum(at, (const double*)0, p, rate);
  @_friction(qd, smoothing_speed, friction);
  for (i = 0; i < @_JOINTS; ++i) {
    for (j = 0; j < @_JOINTS; ++j) {
      p[i] += @_rotor[i][j] * qd[j];
    }
    if (o->running) {
      const double left = tau[i] - 0.5 * (o->friction[i] + friction[i]);
      const double driven = @_passed_on(i, left, qd[i], smoothing_speed) + 0.5 * (o->rate[i] + rate[i]);
      o->torque[i] = @_low_pass(o->torque[i], keep, o->p[i], p[i], driven, f_m);
    } else {
      o->torque[i] = 0.0;
    }
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
    @_momentum(&at, unit, p, rate);
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
)";

}  // namespace rivid::detail
