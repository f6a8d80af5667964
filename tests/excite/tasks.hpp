#pragma once

#include <memory>
#include <string>
#include <vector>

#include "excite/problem.hpp"
#include "rivid/model/urdf.hpp"
#include "support/birdy.hpp"
#include "support/robots.hpp"

namespace rivid::test {

/// Limits that leave room, of any robot.
inline MotionBounds wide_bounds(Index n) {
  return {.lower = Vector::Constant(n, -2.0),
          .upper = Vector::Constant(n, 2.0),
          .velocity = Vector::Constant(n, 2.0),
          .acceleration = Vector::Constant(n, 8.0),
          .jerk = Vector::Constant(n, 80.0),
          .torque = Vector::Constant(n, 200.0),
          .findings = {}};
}

/// A task within them, with a-priori values of all parameters.
inline detail::Task task(const Robot& robot, detail::Objective objective = detail::Information{},
                         const Space& space = {.self_collision = false}) {
  const BaseParameters base = base_parameters(robot);
  const Index b = base.size();
  const MotionBounds bounds = wide_bounds(robot.size());
  std::vector<Finding> findings;
  return {.robot = robot,
          .base = base,
          .chi = base.from_standard(distinct_friction(robot)),
          .weights = Vector::LinSpaced(robot.size(), 1.0, 4.0),
          .known = Matrix::Zero(b, b),
          .objective = std::move(objective),
          .bounds = bounds,
          .space = space,
          .clearances =
              std::make_shared<const detail::Clearances>(robot, space, bounds.lower, bounds.upper, findings)};
}

/// Robots of all kinds: the paper's, arms of six joints with and without coupled motors, mixed joints, every
/// friction law but the asymmetric one, whose columns have a kink.
inline std::vector<Robot> many_robots() {
  std::vector<Robot> out = {read_urdf(RIVID_DATA "/six_axis/six_axis.urdf"),
                            read_urdf(RIVID_DATA "/scara/scara.urdf"), BirdyTx40().robot};
  out.push_back(BirdyTx40().robot);
  out.back().name = "coupled";
  out.back().couplings = {{.motor = 5, .joints = {4}, .ratios = {-1.0}}};
  std::mt19937_64 random(2024);
  for (const int n : {1, 3, 5, 7}) {
    out.push_back(random_robot(n, random));
    for (std::size_t j = 0; j < out.back().joints.size(); ++j) {
      out.back().joints[j].friction =
          static_cast<Friction>(j % static_cast<std::size_t>(Friction::asymmetric));
    }
  }
  return out;
}

}  // namespace rivid::test
