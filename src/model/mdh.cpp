#include "rivid/model/mdh.hpp"

#include <cmath>

#include "rivid/error.hpp"

namespace rivid {

Robot robot_from(std::span<const MdhRow> table, const Eigen::Vector3d& gravity) {
  Robot robot;
  robot.chain.gravity = gravity;
  for (const MdhRow& row : table) {
    const std::string number = std::to_string(robot.joints.size() + 1);
    Joint joint;
    joint.type = row.type;
    joint.name = row.name.empty() ? "joint_" + number : row.name;
    joint.link = "link_" + number;

    const double sa = std::sin(row.alpha);
    const double ca = std::cos(row.alpha);
    const double st = std::sin(row.theta);
    const double ct = std::cos(row.theta);
    Chain::Link link;
    link.type = row.type;
    link.R << ct, -st, 0.0, ca * st, ca * ct, -sa, sa * st, sa * ct, ca;
    link.p << row.a, -row.d * sa, row.d * ca;

    robot.joints.push_back(joint);
    robot.chain.links.push_back(link);
    robot.inertials.emplace_back(Inertial::Zero());
  }
  if (const auto fault = robot.complaint()) {
    throw InputError("robot_from(MDH): " + *fault);
  }
  return robot;
}

}  // namespace rivid
