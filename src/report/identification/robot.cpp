#include "report/analysis.hpp"
#include "report/identification/sections.hpp"

namespace rivid::detail {

namespace {

// The posture at the middle of the first log's rows.
Vector middle_posture(const Evidence& evidence) {
  Vector out = Vector::Zero(evidence.robot.size());
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    const Vector& position = evidence.logs.front().joints[j].fitted.position;
    out[static_cast<Index>(j)] = position.size() > 0 ? position[position.size() / 2] : 0.0;
  }
  return out;
}

std::vector<Inertial> inertials_of(const BaseParameters& base, const Vector& chi_st, std::size_t links) {
  std::vector<Inertial> out(links, Inertial::Zero());
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const StandardParameter& parameter = base.standard[i];
    if (role(parameter.kind) == Role::inertial) {
      out[static_cast<std::size_t>(parameter.joint)][static_cast<Index>(parameter.kind)] =
          chi_st[static_cast<Index>(i)];
    }
  }
  return out;
}

}  // namespace

Section robot_section(const Evidence& evidence) {
  Section out{"robot", "Robot", "Robot", {}, Shown::page};
  const Robot& robot = evidence.robot;
  const Vector q = middle_posture(evidence);
  Skeleton skeleton = skeleton_of(robot, q);
  skeleton.id = "robot-picture";
  skeleton.title = "Arm and ellipsoids of inertia";
  skeleton.label = "The robot as lines with the ellipsoids of inertia of its links";
  add_ellipsoids(robot, q, robot.inertials, "described", skeleton);
  std::vector<std::pair<std::string, std::string>> keys = {{"arm", "joints, base to tip"},
                                                           {"described", "robot description"}};
  std::string remark = "Identified links need physically consistent parameters: --physical.";
  if (const std::optional<PhysicalModel>& physical = evidence.result.physical) {
    add_ellipsoids(robot, q,
                   inertials_of(evidence.result.base, physical->parameters.chi_st, robot.inertials.size()),
                   "identified", skeleton);
    keys.emplace_back("identified", "identified, physically consistent");
    remark = "An ellipsoid of uniform density with the mass and the inertia of its link.";
  }
  if (skeleton.ellipsoids.empty() && robot.size() < 2) {
    return out;
  }
  out.blocks = {{Legend{std::move(keys), remark + " Drag, or use the arrow keys, to turn the robot."}},
                {Plots{"", {}, {{"", "", {std::move(skeleton)}}}}}};
  return out;
}

}  // namespace rivid::detail
