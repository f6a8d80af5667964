// Torques against the a-priori model, or against the mass that any arm of that length may have: another unit
// or another clock shows as a factor.

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "dense.hpp"
#include "identify/check/checks.hpp"
#include "identify/check/torque_probe.hpp"
#include "ranges.hpp"
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

// Whether the inertials of the URDF describe bodies, rather than fill their place: a link without mass, links
// whose masses or inertias are all alike, masses of grams, or inertias of bodies larger than any link.
bool describes_bodies(const Robot& robot) {
  constexpr double next_to_nothing = 0.01;  // [kg] for each link on average; a choice
  constexpr double least_length = 0.5;      // [m] of an arm, for robots whose links have no lengths; a choice
  constexpr double largest_gyration = 0.5;  // over the length; a choice: a rod of that length has 0.29
  const double length = sum_of(robot.chain.links, [&](const Chain::Link& link) { return link.p.norm(); });
  std::vector<double> masses;
  std::vector<double> inertias;  // half the trace about the centre of mass
  for (const Inertial& i : robot.inertials) {
    const double mass = i[inertial_count - 1];
    if (!(mass > 0.0)) {
      return false;
    }
    masses.push_back(mass);
    inertias.push_back(0.5 * (i[0] + i[3] + i[5]) - i.segment<3>(6).squaredNorm() / mass);
    if (inertias.back() > mass * std::pow(largest_gyration * std::max(length, least_length), 2)) {
      return false;
    }
  }
  const auto alike = [](const std::vector<double>& x) {
    constexpr double rounding = 1e-9;  // relative: masses or inertias that differ by less are all the same
    const auto [least, most] = std::ranges::minmax(x);
    return x.size() > 1 && most - least <= rounding * std::abs(most);
  };
  return !alike(masses) && !alike(inertias) &&
         std::reduce(masses.begin(), masses.end()) > next_to_nothing * static_cast<double>(masses.size());
}

// Columns of the fit of one joint beside gravity and inertia: q̇, sign q̇, 1, q̈.
constexpr Index own = 4;

// Rows of joint j: [gravity, inertia, own columns of each joint | torque], brought to norm 1.
struct SizeRows {
  Matrix W;
  Vector tau;
};

SizeRows size_rows(const ProbedLog& log, const std::vector<Index>& instants, const Robot& robot,
                   const Reading& reading, const Motion& motion, const Matrix& held, const Matrix& moved,
                   Index j) {
  const auto at = static_cast<std::size_t>(j);
  std::vector<Index> rows;
  std::ranges::copy_if(instants, std::back_inserter(rows),
                       [&](Index i) { return log.moves(i, reading.position[at]); });
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
  // of the largest pivot; a choice: smaller ones count as zero
  constexpr double independent = 1e-6;
  const Matrix R = qr.R();
  Vector norms = R.colwise().norm();
  norms = norms.unaryExpr([](double x) { return x > 0.0 ? x : 1.0; });
  return norms.cwiseInverse().cwiseProduct(
      minimum_norm_solution(R * norms.cwiseInverse().asDiagonal(), qr.qty(), independent));
}

// One factor for the a-priori gravity and one for the a-priori inertia of all joints, beside friction and
// rotor inertia of each joint.
Sizes sizes(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base, const Reading& reading,
            Part of_logs) {
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
      const SizeRows rows =
          size_rows(log, probe.instants_of(log, of_logs), robot, reading, motion, held, moved, j);
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

bool off_by(double factor, double limit) { return factor > limit || factor < 1.0 / limit; }

// Those of all rows that each half of the logs says as well.
Sizes agreed_sizes(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base,
                   const Reading& reading) {
  // factor between a half of the logs and all; a choice: a size in which halves disagree more is no fault
  constexpr double alike = 1.5;
  constexpr double harmless = 4.0;  // factor; a choice: sizes within it are taken without asking the halves
  Sizes out = sizes(probe, robot, base, reading, Part::all);
  const auto fine = [](double size) { return size == 0.0 || (size > 0.0 && !off_by(size, harmless)); };
  if (fine(out.gravity) && fine(out.inertia) && fine(out.dry_friction)) {
    return out;
  }
  for (const Part part : {Part::first_half, Part::second_half}) {
    const Sizes half = sizes(probe, robot, base, reading, part);
    for (double Sizes::* const size : {&Sizes::gravity, &Sizes::inertia, &Sizes::dry_friction}) {
      const double ratio = out.*size != 0.0 ? half.*size / (out.*size) : 0.0;
      out.*size = ratio > 1.0 / alike && ratio < alike ? out.*size : 0.0;
    }
  }
  return out;
}

bool mended_already(const Findings& found) {
  return std::ranges::any_of(std::array{"gravity_direction", "torque_sign", "position_sign", "torque_order",
                                        "position_order", "joint_order"},
                             [&](const char* code) { return found.has(code); });
}

// A joint carries all that the joints behind it carry, so its inertia is not many times smaller than theirs,
// unless their torques have another unit: the joint where this is not so, beside the largest inertia nearer
// to the base.
//
// least, most  what the diagonal of the mass matrix can be
std::optional<std::pair<Index, double>> out_of_order(const Robot& robot, const Vector& least,
                                                     const Vector& most) {
  double before = 0.0;
  for (Index j = 0; j < robot.size(); ++j) {
    if (robot.joints[static_cast<std::size_t>(j)].type != JointType::revolute || most[j] <= 0.0) {
      continue;
    }
    if (before > 0.0 && least[j] > larger_behind * before) {
      return std::pair(j, before);
    }
    before = std::max(before, most[j]);
  }
  return std::nullopt;
}

// Whether such a joint was found, in both halves of the logs too: an inertia of few accelerations is any
// number.
bool check_order(const TorqueProbe& probe, const Robot& robot, const Reading& reading, const Vector& inertias,
                 Findings& out) {
  if (!out_of_order(robot, inertias, inertias)) {
    return false;
  }
  Vector least = inertias.cwiseMax(0.0);
  Vector most = inertias;
  for (const Part part : {Part::first_half, Part::second_half}) {
    const Vector half = probe.inertias(probe.score(reading, probe.factors(reading, part)).chi).diagonal();
    least = least.cwiseMin(half.cwiseMax(0.0));
    most = most.cwiseMax(half);
  }
  const auto found = out_of_order(robot, least, most);
  if (found) {
    out.add("torque_unit", robot.joints[static_cast<std::size_t>(found->first)].name,
            "its torque asks for an inertia of " + number(least[found->first], 2) +
                " kg·m², joints nearer to the base for " + number(found->second, 2) + " kg·m² at most");
  }
  return found.has_value();
}

}  // namespace

void check_sizes(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base,
                 const Reading& reading, const Vector& chi, Findings& out) {
  const std::string all = "all joints";
  if (out.has("torque_unit") || out.has("time_scale")) {
    return;
  }
  if (describes_bodies(robot)) {
    const Sizes found = agreed_sizes(probe, robot, base, reading);
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
                  number(probe.logs().front().log->f_m * clock, 2) + " Hz",
              {{.key = "log.rate_hz", .numbers = {probe.logs().front().log->f_m * clock}}});
    }
    return;
  }
  const Matrix M = probe.inertias(chi);
  if (check_order(probe, robot, reading, M.diagonal(), out)) {
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
