#include "rivid/excite/limits.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

// Limits that so many joints share by chance are rare: they fill a place in the file.
constexpr Index joints_of_a_placeholder = 4;

std::string_view position_unit(const Joint& joint) { return joint.type == JointType::revolute ? "rad" : "m"; }

// One value a joint from a member of the robot's joints.
Vector of_joints(const Robot& robot, double Joint::* member) {
  Vector out(robot.size());
  for (Index j = 0; j < robot.size(); ++j) {
    out[j] = robot.joints[static_cast<std::size_t>(j)].*member;
  }
  return out;
}

Vector given_or(const Vector& given, const Vector& otherwise) { return given.size() > 0 ? given : otherwise; }

[[noreturn]] void refuse(const Joint& joint, const std::string& what) {
  throw InputError("motion_bounds: " + joint.name + ": " + what);
}

// Positions, of which the share about the middle is left.
void bound_positions(const Robot& robot, const MotionLimits& limits, MotionBounds& out) {
  out.lower = given_or(limits.lower, of_joints(robot, &Joint::lower));
  out.upper = given_or(limits.upper, of_joints(robot, &Joint::upper));
  for (Index j = 0; j < robot.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (const auto [least, most] = robot.chain.reach(static_cast<int>(j)); std::isfinite(most - least)) {
      out.lower[j] = std::max(out.lower[j], least);  // of a linkage or a table
      out.upper[j] = std::min(out.upper[j], most);
    }
    // What a description has in place of no limit is as none.
    const bool from_below = MotionLimits::positions.holds(out.lower[j]);
    const bool from_above = MotionLimits::positions.holds(out.upper[j]);
    if (!from_below || !from_above) {
      if (joint.type == JointType::prismatic) {
        out.lower[j] = from_below ? out.lower[j] : -no_limit;
        out.upper[j] = from_above ? out.upper[j] : no_limit;
        continue;
      }
      out.lower[j] = from_below ? out.lower[j] : -std::numbers::pi;
      out.upper[j] = from_above ? out.upper[j] : std::numbers::pi;
      out.findings.push_back(Finding{"limit_assumed", joint.name,
                                     from_below ? "has no upper position limit; the motion is kept below π"
                                     : from_above
                                         ? "has no lower position limit; the motion is kept above −π"
                                         : "has no position limits; the motion is kept within −π and π"});
    }
    if (!(out.lower[j] < out.upper[j])) {
      refuse(joint,
             "positions from " + number(out.lower[j], 4) + " to " + number(out.upper[j], 4) + " " +
                 std::string(position_unit(joint)) +
                 " leave no room to move; correct lower and upper in [excitation.limits] or the robot");
    }
    const double middle = 0.5 * (out.lower[j] + out.upper[j]);
    const double half = 0.5 * (out.upper[j] - out.lower[j]) * limits.position_share;
    out.lower[j] = middle - half;
    out.upper[j] = middle + half;
  }
}

void doubt_placeholders(const Robot& robot, double Joint::* member, const char* what, MotionBounds& out) {
  const Vector values = of_joints(robot, member);
  if (robot.size() >= joints_of_a_placeholder && std::isfinite(values[0]) &&
      (values.array() == values[0]).all()) {
    out.findings.push_back(Finding{"limit_doubt", robot.name,
                                   std::string("the ") + what + " limit is " + number(values[0], 6) +
                                       " for all joints, which looks like a placeholder"});
  }
}

bool has_inertials(const Robot& robot) {
  for (const Inertial& inertial : robot.inertials) {
    if (!inertial.isZero(0.0)) {
      return true;
    }
  }
  return false;
}

void bound_torques(const Robot& robot, const MotionLimits& limits, MotionBounds& out) {
  out.torque = given_or(limits.torque, of_joints(robot, &Joint::max_effort)) * limits.torque_share;
  if (!has_inertials(robot)) {
    out.torque.setConstant(no_limit);
    out.findings.push_back(
        Finding{"no_torque_model", robot.name,
                "the links have no a-priori masses, so torques can not be predicted and are not "
                "limited"});
  }
}

}  // namespace

std::optional<std::string> MotionLimits::complaint(Index n) const {
  const std::array<std::pair<const char*, const Vector*>, 6> lists = {{{"lower", &lower},
                                                                       {"upper", &upper},
                                                                       {"velocity", &velocity},
                                                                       {"acceleration", &acceleration},
                                                                       {"jerk", &jerk},
                                                                       {"torque", &torque}}};
  for (const auto& [key, list] : lists) {
    if (list->size() != 0 && list->size() != n) {
      return std::string(key) + " has " + counted(list->size(), "entry") +
             ", must have one for each of the " + counted(n, "joint");
    }
  }
  // Infinite is no limit, on its own side.
  for (const auto& [key, list, nowhere] :
       {std::tuple{"lower", &lower, no_limit}, std::tuple{"upper", &upper, -no_limit}}) {
    for (Index j = 0; j < list->size(); ++j) {
      const double value = (*list)[j];
      if (std::isnan(value) || value == nowhere) {
        return std::string(key) + " of joint " + std::to_string(j + 1) + " is " + number(value) +
               ", must be a number, or " + number(-nowhere) + " where there is no limit";
      }
    }
  }
  MotionLimits rest = *this;
  rest.lower = rest.upper = {};
  return range_fault(rest);
}

MotionBounds motion_bounds(const Robot& robot, const MotionLimits& limits) {
  if (const auto fault = limits.complaint(robot.size())) {
    throw InputError("motion_bounds: " + *fault);
  }
  const Vector none = Vector::Constant(robot.size(), no_limit);
  MotionBounds out;
  bound_positions(robot, limits, out);
  out.velocity = given_or(limits.velocity, of_joints(robot, &Joint::max_velocity)) * limits.velocity_share;
  out.acceleration = given_or(limits.acceleration, none);
  out.jerk = given_or(limits.jerk, none);
  bound_torques(robot, limits, out);
  if (limits.velocity.size() == 0) {
    doubt_placeholders(robot, &Joint::max_velocity, "velocity", out);
  }
  if (limits.torque.size() == 0) {
    doubt_placeholders(robot, &Joint::max_effort, "torque", out);
  }
  return out;
}

std::optional<std::string> missing_limit(const Robot& robot, const MotionBounds& bounds) {
  for (Index j = 0; j < robot.size(); ++j) {
    const std::string& joint = robot.joints[static_cast<std::size_t>(j)].name;
    if (!std::isfinite(bounds.lower[j]) || !std::isfinite(bounds.upper[j])) {
      return joint + ": has no position limits; give lower and upper in [excitation.limits]";
    }
    if (!std::isfinite(bounds.velocity[j])) {
      return joint + ": has no velocity limit; give velocity in [excitation.limits]";
    }
    if (!std::isfinite(bounds.acceleration[j]) && !std::isfinite(bounds.torque[j])) {
      return joint +
             ": neither its acceleration nor its torque is limited; give acceleration in "
             "[excitation.limits]";
    }
  }
  return std::nullopt;
}

}  // namespace rivid
