// Torques against the a-priori model, or against the mass that any arm of that length may have: another unit
// or another clock shows as a factor.

#include <algorithm>
#include <array>
#include <cmath>

#include "dense.hpp"
#include "identify/check/checks.hpp"
#include "identify/check/torque_probe.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Sizes that differ from the a-priori ones by such factors are another unit, or another sampling rate.
constexpr double wrong_unit = 8.0;
constexpr double wrong_clock = 20.0;  // of inertia against gravity: the square of the clock's factor
// Inertia of a joint over those of joints nearer to the base that no arm has.
constexpr double larger_behind = 20.0;
// Part of the torques that gravity, or inertia, must make up to be compared; what makes up more than
// `cancelled` of them is cancelled by another column, as inertia by that of the rotor where one joint moves
// at a time.
constexpr double visible = 0.1;
constexpr double cancelled = 3.0;
// Mass that moves with a joint, as inertia over its squared reach, beyond which no arm is [kg].
constexpr double lightest = 0.01;
constexpr double heaviest = 1500.0;

// Factors of the a-priori model that the torques ask for.
struct Sizes {
  double gravity = 0.0;  // 0 where gravity is not seen, or nothing is known
  double inertia = 0.0;
  double dry_friction = 0.0;
};

bool knows_inertias(const Robot& robot) {
  return std::ranges::all_of(robot.inertials, [](const Inertial& i) { return i[inertial_count - 1] > 0.0; });
}

// Columns of the fit of one joint beside gravity and inertia: q̇, sign q̇, 1, q̈.
constexpr Index own = 4;

// Rows of joint j: [gravity, inertia, own columns of each joint | torque], brought to norm 1.
struct SizeRows {
  Matrix W;
  Vector tau;
};

SizeRows size_rows(const ProbedLog& log, const Robot& robot, const Reading& reading, const Motion& motion,
                   const Matrix& held, const Matrix& moved, Index j) {
  const auto at = static_cast<std::size_t>(j);
  const std::vector<Index> rows = TorqueProbe::moving_rows(log, reading.position[at]);
  const auto count = static_cast<Index>(rows.size());
  SizeRows out{Matrix::Zero(count, 2 + own * robot.size()),
               reading.torque_sign[j] * log.tau.col(reading.torque[at])(rows)};
  out.W.col(0) = held.col(j)(rows);
  out.W.col(1) = moved.col(j)(rows);
  const Vector v = motion.qd.col(j)(rows);
  out.W.col(2 + own * j) = v;
  out.W.col(3 + own * j) = v.cwiseSign();
  out.W.col(4 + own * j).setOnes();
  if (robot.joints[at].rotor_inertia) {
    out.W.col(5 + own * j) = motion.qdd.col(j)(rows);
  }
  const double norm = out.tau.norm();
  if (norm > 0.0) {
    out.W /= norm;
    out.tau /= norm;
  }
  return out;
}

// Torques of all joints along a motion, (samples × n).
Matrix torques(const Robot& robot, const BaseParameters& base, const Motion& motion, const Vector& chi) {
  const Observation W = observation(robot, base, motion);
  Matrix out(motion.samples(), robot.size());
  for (Index j = 0; j < robot.size(); ++j) {
    const JointRows& rows = W.joints[static_cast<std::size_t>(j)];
    out.col(j) = rows.W * chi(rows.columns);
  }
  return out;
}

// Geometric mean of fitted over a-priori dry friction, of the joints where both are known; else 0.
double friction_size(const Robot& robot, const Vector& x) {
  double logarithms = 0.0;
  double told = 0.0;
  for (Index j = 0; j < robot.size(); ++j) {
    const double Fc = robot.joints[static_cast<std::size_t>(j)].Fc;
    const double fitted = x[3 + own * j];
    if (Fc > 0.0 && fitted > 0.0) {
      logarithms += std::log(fitted / Fc);
      told += 1.0;
    }
  }
  return told > 0.0 ? std::exp(logarithms / told) : 0.0;
}

// Minimum-norm solution in columns of norm 1.
Vector solved(const StreamingQr& qr) {
  constexpr double independent = 1e-6;
  const Matrix R = qr.R();
  Vector norms = R.colwise().norm();
  norms = norms.unaryExpr([](double x) { return x > 0.0 ? x : 1.0; });
  return norms.cwiseInverse().cwiseProduct(
      minimum_norm_solution(R * norms.cwiseInverse().asDiagonal(), qr.qty(), independent));
}

// One factor for the a-priori gravity and one for the a-priori inertia of all joints, beside friction and
// rotor inertia of each joint.
Sizes sizes(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base,
            const Reading& reading) {
  const Index n = robot.size();
  Robot frictionless = robot;
  for (Joint& joint : frictionless.joints) {
    joint.Fv = joint.Fc = joint.Ia = 0.0;
  }
  const Vector chi = base.from_standard(frictionless.chi_st());
  const Robot loaded = probe.robot_with(reading.gravity);
  StreamingQr qr(2 + own * n, 1);
  double gravity = 0.0;
  double inertia = 0.0;
  for (const ProbedLog& log : probe.logs()) {
    const Motion motion = probe.motion_at(log, reading);
    const Matrix none = Matrix::Zero(motion.samples(), n);
    const Matrix held = torques(loaded, base, {motion.q, none, none}, chi);
    const Matrix moved = torques(loaded, base, motion, chi) - held;
    for (Index j = 0; j < n; ++j) {
      const SizeRows rows = size_rows(log, robot, reading, motion, held, moved, j);
      qr.add(rows.W, rows.tau);
      gravity += rows.W.col(0).squaredNorm();
      inertia += rows.W.col(1).squaredNorm();
    }
  }
  const Vector x = solved(qr);
  const double all = static_cast<double>(n) * static_cast<double>(probe.logs().size());
  const auto seen = [&](double factor, double square) {
    const double part = std::abs(factor) * std::sqrt(square / all);
    return visible < part && part < cancelled ? factor : 0.0;
  };
  return {.gravity = seen(x[0], gravity),
          .inertia = seen(x[1], inertia),
          .dry_friction = friction_size(robot, x)};
}

bool mended_already(const Findings& found) {
  return std::ranges::any_of(std::array{"gravity_direction", "torque_sign", "position_sign", "torque_order",
                                        "position_order", "joint_order"},
                             [&](const char* code) { return found.has(code); });
}

// A joint carries all that the joints behind it carry, so its inertia is not many times smaller than theirs,
// unless their torques have another unit. Returns whether one was found.
bool check_inertias_in_order(const Robot& robot, const Matrix& M, Findings& out) {
  double before = 0.0;  // largest inertia of a revolute joint nearer to the base
  bool found = false;
  for (Index j = 0; j < robot.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (joint.type != JointType::revolute || M(j, j) <= 0.0) {
      continue;
    }
    if (before > 0.0 && M(j, j) > larger_behind * before) {
      out.add("torque_unit", joint.name,
              "its torque asks for an inertia of " + number(M(j, j), 2) +
                  " kg·m², joints nearer to the base for " + number(before, 2) + " kg·m² at most");
      found = true;
    } else {
      before = std::max(before, M(j, j));
    }
  }
  return found;
}

bool off_by(double factor, double limit) { return factor > limit || factor < 1.0 / limit; }

}  // namespace

void check_sizes(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base,
                 const Reading& reading, const Vector& chi, Findings& out) {
  const std::string all = "all joints";
  if (out.has("torque_unit") || out.has("time_scale")) {
    return;
  }
  if (knows_inertias(robot)) {
    const Sizes found = sizes(probe, robot, base, reading);
    if (found.gravity < -visible && !mended_already(out)) {
      out.add("gravity_direction", (robot.base.empty() ? "base" : robot.base),
              "torques ask for " + number(found.gravity, 2) + " times the weight of the a-priori masses");
    }
    // What does not depend on the clock, as far as it is known.
    const bool by_gravity = found.gravity > 0.0;
    const double timeless = by_gravity ? found.gravity : found.dry_friction;
    const double torque = timeless > 0.0 ? timeless : found.inertia;
    if (torque > 0.0 && off_by(torque, wrong_unit)) {
      out.add("torque_unit", all,
              "torques ask for " + number(torque, 2) + " times the a-priori " +
                  (by_gravity ? "masses"
                   : timeless > 0.0
                       ? "dry friction"
                       : "inertias; or the sampling rate is wrong by " + number(std::sqrt(torque), 2)));
    }
    if (timeless > 0.0 && found.inertia > 0.0 && off_by(found.inertia / timeless, wrong_clock)) {
      const double clock = std::sqrt(found.inertia / timeless);
      out.add("time_scale", all,
              "against " + std::string(by_gravity ? "gravity" : "dry friction") + " inertia is " +
                  number(found.inertia / timeless, 2) +
                  " times that of the a-priori model: the rate would be " +
                  number(probe.logs().front().log->f_m * clock, 2) + " Hz");
    }
    return;
  }
  const Matrix M = probe.inertias(chi);
  if (check_inertias_in_order(robot, M, out)) {
    return;
  }
  double mass = 0.0;
  for (Index j = 0; j < robot.size(); ++j) {
    double reach = 0.2;
    for (std::size_t k = static_cast<std::size_t>(j) + 1; k < robot.chain.links.size(); ++k) {
      reach += robot.chain.links[k].p.norm();
    }
    const bool turns = robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute;
    mass = std::max(mass, M(j, j) / (turns ? reach * reach : 1.0));
  }
  if (mass > heaviest || (mass > 0.0 && mass < lightest)) {
    out.add("torque_unit", all, "torques ask for a mass of some " + number(mass, 2) + " kg for this reach");
  }
}

}  // namespace rivid::detail
