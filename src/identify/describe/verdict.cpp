#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "identify/describe/describe.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// A deviation above this part of the value makes a parameter weak.
constexpr double weak_percent = 30.0;
// Correlation of two estimates from which on they are named together.
constexpr double confounded = 0.9;
// A joint hardly moves where its rms velocity is below this part of the fastest joint's of the same type.
constexpr double hardly = 0.05;
// Velocities are differences over so long a time that the noise of an encoder does not count [s].
constexpr double velocity_span = 0.1;
// Means of showing a parameter that reach this part of the best one are named.
constexpr double helpful = 0.5;
// A parameter that is known to lie below this part of its like is small.
constexpr double small = 0.1;
// that a column's rms is taken over; a choice: it only compares parameters
constexpr Index random_poses = 24;
constexpr unsigned pose_seed = 1961;  // any: it only makes results repeat

// How strongly motions of one kind show each base parameter: rms of its column over random poses, (b).
Vector strength(const Robot& robot, const BaseParameters& base, const Motion& motion) {
  const Observation W = observation(robot, base, motion);
  Vector out = Vector::Zero(base.size());
  for (const JointRows& rows : W.joints) {
    for (std::size_t c = 0; c < rows.columns.size(); ++c) {
      out[rows.columns[c]] += rows.W.col(static_cast<Index>(c)).squaredNorm();
    }
  }
  return out.cwiseSqrt();
}

// What shows the parameters of a robot, by the structure of its regressor alone.
struct Ways {
  Matrix acceleration;  // (b × n) of each joint alone
  Vector gravity;       // (b) that poses differ in
};

Ways ways(const Robot& robot, const BaseParameters& base) {
  const Index n = robot.size();
  std::mt19937_64 random(pose_seed);
  std::uniform_real_distribution<double> turn(-std::numbers::pi, std::numbers::pi);
  Matrix q = Matrix::NullaryExpr(random_poses, n, [&]() { return turn(random); });
  for (Index k = 0; k < random_poses; ++k) {
    robot.chain.into_reach([&](int j) -> double& { return q(k, j); });
  }
  const Matrix none = Matrix::Zero(random_poses, n);
  Robot weightless = robot;
  weightless.chain.gravity.setZero();
  Ways out{.acceleration = Matrix(base.size(), n), .gravity = strength(robot, base, {q, none, none})};
  // An offset of friction shows at rest as well.
  out.gravity = (out.gravity.cwiseAbs2() - strength(weightless, base, {q, none, none}).cwiseAbs2())
                    .cwiseMax(0.0)
                    .cwiseSqrt();
  for (Index k = 0; k < n; ++k) {
    Matrix qdd = none;
    qdd.col(k).setOnes();
    out.acceleration.col(k) = strength(weightless, base, {q, none, qdd});
  }
  return out;
}

bool holds_zero(const ParameterEstimate& p) { return p.interval_95[0] <= 0.0 && p.interval_95[1] >= 0.0; }

// Largest value that is seen, or known a priori, among the parameters of a unit that belong to the same
// joint. Friction, unlike inertia, does not shrink towards the tip: there all joints count.
double usual_size(const BaseParameters& base, const std::vector<ParameterEstimate>& all, std::size_t i) {
  const StandardParameter& own = base.parameters[i].leading;
  double size = std::abs(all[i].value);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const ParameterEstimate& p = all[k];
    const StandardParameter& other = base.parameters[k].leading;
    const bool near = other.joint == own.joint || (is_friction(own.kind) && is_friction(other.kind));
    if (near && p.unit == all[i].unit) {
      const bool seen = std::isfinite(p.sigma) && !holds_zero(p);
      size = std::max({size, seen ? std::abs(p.value) : 0.0, std::abs(p.a_priori)});
    }
  }
  return size;
}

Verdict verdict_of(const BaseParameters& base, const std::vector<ParameterEstimate>& all, std::size_t i) {
  const ParameterEstimate& p = all[i];
  if (!std::isfinite(p.sigma)) {
    return Verdict::not_excited;
  }
  if (holds_zero(p) && 0.5 * (p.interval_95[1] - p.interval_95[0]) > usual_size(base, all, i)) {
    return Verdict::not_excited;
  }
  return holds_zero(p) || p.relative_sigma_percent > weak_percent ? Verdict::weak : Verdict::identified;
}

// The other parameter whose estimate moves most with this one, or nothing.
std::string partner(const Matrix& C, const std::vector<ParameterEstimate>& all, std::size_t i) {
  double most = confounded;
  std::string text;
  const auto row = static_cast<Index>(i);
  for (Index k = 0; k < C.cols(); ++k) {
    const double scale = std::sqrt(C(row, row) * C(k, k));
    const double correlation = C(row, k) / scale;
    // Of variances that are zero but for roundings there is none.
    constexpr double at_most = 1.0 + 1e-6;
    if (k != row && std::abs(correlation) > most && std::abs(correlation) <= at_most) {
      most = std::abs(correlation);
      text = "; hard to distinguish from " + all[static_cast<std::size_t>(k)].name + " (correlation " +
             number(correlation, 2) + ")";
    }
  }
  return text;
}

std::string called(const Robot& robot, Index joint, const std::vector<std::uint8_t>& still) {
  const auto j = static_cast<std::size_t>(joint);
  return robot.joints[j].name + (still[j] != 0 ? " (which hardly moves)" : "");
}

// The motion that would show an inertial parameter.
//
// own  joint of the parameter's link, whose positions change what the others' accelerations show
std::string inertial_motion(const Robot& robot, const Ways& ways, Index i, Index own,
                            const std::vector<std::uint8_t>& still) {
  Index best = 0;
  const double most = ways.acceleration.row(i).maxCoeff(&best);
  std::string out;
  if (most > 0.0) {
    out = "larger accelerations of " + called(robot, best, still);
    Vector others = ways.acceleration.row(i);
    others[best] = 0.0;
    Index second = 0;
    if (others.maxCoeff(&second) >= helpful * most) {
      out += " and " + called(robot, second, still);
    } else {
      second = best;
    }
    // A dependent joint moves as those do that it follows.
    if (own < std::ssize(still) && still[static_cast<std::size_t>(own)] != 0 && own != best &&
        own != second) {
      out += " while " + called(robot, own, still) + " moves";
    }
  }
  if (ways.gravity[i] > 0.0) {
    out += (out.empty() ? "" : ", or ") + std::string("poses that gravity loads differently");
  }
  return out.empty() ? "faster motion of several joints at once" : out;
}

std::string helpful_motion(const Robot& robot, const StandardParameter& leading, const Ways& ways, Index i,
                           const std::vector<std::uint8_t>& still) {
  if (role(leading.kind) == Role::inertial) {
    return inertial_motion(robot, ways, i, leading.joint, still);
  }
  const std::string joint = called(robot, leading.joint, still);
  switch (role(leading.kind)) {
    case Role::viscous:
      return "slow and fast motion of " + joint;
    case Role::dry:
      return "steady motion of " + joint + " both ways";
    case Role::constant:
      return "motion of " + joint + " both ways over the same positions";
    case Role::rotor:
    case Role::inertial:
      break;
  }
  return "larger accelerations of " + joint;
}

// What an alternative to the model would make of a parameter whose deviation is mostly its doing; empty for
// others.
std::string by_alternative(const ParameterEstimate& p) {
  const double own = p.sigma * p.sigma - p.model_shift * p.model_shift;
  if (p.widened_by.empty() || !(own < 0.5 * p.sigma * p.sigma)) {
    return {};
  }
  return "wide by " + p.widened_by + ": with it about " + number(p.value + p.model_shift, 4) + " ± " +
         number(std::sqrt(own), 2) + ", without it " + number(p.value, 4) +
         "; what that finding says to do settles it";
}

std::string reason(const BaseParameters& base, const std::vector<ParameterEstimate>& all, std::size_t i) {
  const ParameterEstimate& p = all[i];
  if (!std::isfinite(p.sigma)) {
    return "not determined";
  }
  if (p.verdict == Verdict::not_excited) {
    return "any usual value would fit as well";
  }
  if (!holds_zero(p)) {
    return "deviation of " + number(p.relative_sigma_percent, 2) + " %";
  }
  const double bound = std::max(-p.interval_95[0], p.interval_95[1]) / usual_size(base, all, i);
  return bound < small ? "small rather than unseen: within " + number(100.0 * bound, 1) + " % of its like"
                       : "its interval holds zero";
}

}  // namespace

std::vector<std::uint8_t> hardly_moving(const Robot& robot, const SquaredVelocities& velocities) {
  const Vector v = (velocities.sums / std::max(velocities.count, 1.0)).cwiseSqrt();
  std::vector<std::uint8_t> out;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    double fastest = 0.0;
    for (std::size_t k = 0; k < robot.joints.size(); ++k) {
      if (robot.joints[k].type == robot.joints[j].type) {
        fastest = std::max(fastest, v[static_cast<Index>(k)]);
      }
    }
    out.push_back(v[static_cast<Index>(j)] <= hardly * fastest ? 1 : 0);
  }
  return out;
}

SquaredVelocities squared_velocities(std::span<const Log> logs, Index n) {
  SquaredVelocities out = {.sums = Vector::Zero(n)};
  for (const Log& log : logs) {
    const Index span = std::clamp<Index>(static_cast<Index>(std::lround(velocity_span * log.f_m)), 1,
                                         std::max<Index>(1, log.samples() / 4));
    for (Index k = span; k < log.samples(); k += span) {
      const Vector v = (log.q.row(k) - log.q.row(k - span)) * (log.f_m / static_cast<double>(span));
      out.sums += v.cwiseAbs2();
      out.count += 1.0;
    }
  }
  return out;
}

void judge_parameters(const Robot& robot, const BaseParameters& base, const Matrix& C,
                      const SquaredVelocities& velocities, std::vector<ParameterEstimate>& parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    parameters[i].verdict = verdict_of(base, parameters, i);
  }
  const auto good = [](const ParameterEstimate& p) { return p.verdict == Verdict::identified; };
  if (std::ranges::all_of(parameters, good)) {
    return;
  }
  const Ways found = ways(robot, base);
  const std::vector<std::uint8_t> still = hardly_moving(robot, velocities);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (good(parameters[i])) {
      continue;
    }
    parameters[i].advice = by_alternative(parameters[i]);
    if (parameters[i].advice.empty()) {
      parameters[i].advice =
          reason(base, parameters, i) + partner(C, parameters, i) + "; needs " +
          helpful_motion(robot, base.parameters[i].leading, found, static_cast<Index>(i), still);
    }
  }
}

}  // namespace rivid::detail
