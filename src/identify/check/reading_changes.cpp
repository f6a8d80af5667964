#include "identify/check/reading_changes.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

void add_sign_changes(const Robot& robot, const Reading& reading, std::vector<Change>& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    Reading r = reading;
    r.torque_sign[j] *= -1.0;
    out.push_back({"torque_sign", joint_name(robot, j), "its torque has the other sign", std::move(r)});
  }
  if (robot.size() > 1) {
    Reading all = reading;
    all.torque_sign *= -1.0;
    out.push_back({"torque_sign", "all joints", "all torques have the other sign", std::move(all)});
  }
  for (Index j = 0; j < robot.size(); ++j) {
    Reading r = reading;
    r.position_scale[j] *= -1.0;
    Reading both = r;
    both.torque_sign[j] *= -1.0;
    out.push_back({"position_sign", joint_name(robot, j), "its position has the other sign", std::move(r)});
    out.push_back({"position_sign", joint_name(robot, j), "its position and its torque have the other sign",
                   std::move(both)});
  }
}

// Zeros that are a quarter or half a turn away.
void add_zero_changes(const Robot& robot, const Reading& reading, std::vector<Change>& out) {
  constexpr double quarter = 0.5 * std::numbers::pi;
  for (Index j = 0; j < robot.size(); ++j) {
    if (robot.joints[static_cast<std::size_t>(j)].type != JointType::revolute) {
      continue;
    }
    for (const double turns : {1.0, -1.0, 2.0}) {
      Reading r = reading;
      r.position_offset[j] += turns * quarter;
      out.push_back({"zero_offset", joint_name(robot, j),
                     "its zero is " + number(90.0 * turns) + "° away, offset = " +
                         number(turns * quarter, 6) + " for its column in [log] position",
                     std::move(r)});
    }
  }
}

void add_order_changes(const Robot& robot, const Reading& reading, std::vector<Change>& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    for (Index i = 0; i < j; ++i) {
      const auto a = static_cast<std::size_t>(i);
      const auto b = static_cast<std::size_t>(j);
      const std::string pair = joint_name(robot, i) + " and " + joint_name(robot, j);
      Reading torques = reading;
      std::swap(torques.torque[a], torques.torque[b]);
      std::swap(torques.torque_sign[i], torques.torque_sign[j]);
      Reading positions = reading;
      std::swap(positions.position[a], positions.position[b]);
      std::swap(positions.position_scale[i], positions.position_scale[j]);
      Reading both = torques;
      both.position = positions.position;
      both.position_scale = positions.position_scale;
      out.push_back({"torque_order", pair, "their torques are exchanged", std::move(torques)});
      out.push_back({"position_order", pair, "their positions are exchanged", std::move(positions)});
      out.push_back({"joint_order", pair, "positions and torques are exchanged", std::move(both)});
    }
  }
  if (robot.size() > 2) {
    Reading reversed = reading;
    std::ranges::reverse(reversed.position);
    std::ranges::reverse(reversed.torque);
    reversed.position_scale.reverseInPlace();
    reversed.torque_sign.reverseInPlace();
    out.push_back({"joint_order", "all joints", "the columns run from tip to base", std::move(reversed)});
  }
}

void add_unit_changes(const Robot& robot, const Reading& reading, std::vector<Change>& out) {
  constexpr double degree = std::numbers::pi / 180.0;
  for (const double scale : {degree, 1.0 / degree}) {
    const bool degrees = scale < 1.0;
    Reading every = reading;
    for (Index j = 0; j < robot.size(); ++j) {
      if (robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute) {
        Reading r = reading;
        r.position_scale[j] *= scale;
        every.position_scale[j] *= scale;
        out.push_back({"position_unit", joint_name(robot, j),
                       degrees ? "its position is in degrees" : "its position was turned from degrees twice",
                       std::move(r)});
      }
    }
    out.push_back({"position_unit", "all joints",
                   degrees ? "positions are in degrees" : "positions were turned from degrees twice",
                   std::move(every)});
  }
  for (const double scale : {0.5, 2.0, 1e-3, 1e3}) {
    const std::string times = number(1.0 / scale) + " times what it should be";
    Reading every = reading;
    every.position_scale *= scale;
    for (Index j = 0; robot.size() > 1 && j < robot.size(); ++j) {
      Reading r = reading;
      r.position_scale[j] *= scale;
      out.push_back({"position_scale", joint_name(robot, j), "its position is " + times, std::move(r)});
    }
    out.push_back({"position_scale", "all joints", "each position is " + times, std::move(every)});
  }
  for (Index j = 0; robot.size() > 1 && j < robot.size(); ++j) {
    for (const double scale : {1e-3, 1e3}) {
      Reading r = reading;
      r.torque_sign[j] *= scale;
      out.push_back({"torque_unit", joint_name(robot, j),
                     scale < 1.0 ? "its torque is a thousand times that of the others, as N·mm would be"
                                 : "its torque is a thousandth of that of the others, as kN·m would be",
                     std::move(r)});
    }
  }
}

void add_gravity_changes(const Robot& robot, const Reading& reading, std::vector<Change>& out) {
  constexpr double standard_gravity = 9.80665;  // [m/s²]
  constexpr std::array axes = {"x", "y", "z"};
  const double g = reading.gravity.norm() > 0.0 ? reading.gravity.norm() : standard_gravity;
  if (reading.gravity.norm() > 0.0) {
    Reading r = reading;
    r.gravity.setZero();
    out.push_back(
        {"torque_without_gravity", "all joints", "torques hold nothing of the weight", std::move(r)});
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Reading r = reading;
      r.gravity = sign * g * Eigen::Vector3d::Unit(axis);
      if (!r.gravity.isApprox(reading.gravity)) {
        out.push_back({"gravity_direction", base_name(robot),
                       std::string("gravity points along ") + (sign < 0.0 ? "-" : "+") +
                           axes[static_cast<std::size_t>(axis)] + " of the base",
                       std::move(r)});
      }
    }
  }
}

}  // namespace

std::string joint_name(const Robot& robot, Index j) { return robot.joints[static_cast<std::size_t>(j)].name; }

std::string base_name(const Robot& robot) { return robot.base.empty() ? "base" : robot.base; }

std::vector<Change> changes(const Robot& robot, const Reading& reading) {
  std::vector<Change> out;
  add_sign_changes(robot, reading, out);
  add_order_changes(robot, reading, out);
  add_unit_changes(robot, reading, out);
  add_gravity_changes(robot, reading, out);
  add_zero_changes(robot, reading, out);
  return out;
}

}  // namespace rivid::detail
