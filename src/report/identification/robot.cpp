#include "joined.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

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

List coupling_list(const Robot& robot) {
  const auto joint = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  List out{"couplings"};
  for (const Coupling& coupling : robot.couplings) {
    std::vector<std::string> turned_by;
    for (std::size_t k = 0; k < coupling.joints.size(); ++k) {
      turned_by.push_back(joint(coupling.joints[k]) + " (" + number(coupling.ratios[k], 6) + ")");
    }
    out.items.push_back({.text = "The motor of " + joint(coupling.motor) + " is turned by " +
                                 joined(turned_by) + " as well: inertia " +
                                 std::string(name(coupling.inertia)) + ", Coulomb " +
                                 std::string(name(coupling.coulomb)) + "."});
  }
  return out;
}

std::string friction_words(const Joint& joint) {
  return std::string(name(joint.friction)) +
         (joint.sign_speed > 0.0 ? ", smooth over " + number(joint.sign_speed, 4) : "");
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
                plots_block("", {std::move(skeleton)})};
  return out;
}

Section provenance_section(const Robot& robot, const Identification& result, const Provenance& provenance) {
  using J = Joint;
  Settings settings = row_settings(result.estimation.signal);
  settings.insert(settings.begin(), {"Method", result.title});
  const Eigen::Vector3d& g = robot.chain.gravity;
  Section out{"provenance", "Provenance", "Settings and files", {}, Shown::page};
  out.blocks = {
      {run_table(provenance, settings)},
      {inputs_table(provenance)},
      {Heading{"Robot"}},
      {table_of(
          robot.joints,
          {{{"joint"}, &J::name},
           {{"moves"}, &J::link},
           {{"type"}, [](const J& j) { return j.type == JointType::revolute ? "revolute" : "prismatic"; }},
           {{"friction"}, friction_words},
           {{"rotor inertia"}, [](const J& j) { return j.rotor_inertia ? "yes" : "no"; }},
           {{"drive gain", format::significant(6)}, &J::drive_gain},
           {{"gear ratio", format::significant(6)}, &J::gear_ratio}})},
      {coupling_list(robot)},
      {Sentence{"Gravity in the frame of the base: " + number(g.x(), 6) + ", " + number(g.y(), 6) + ", " +
                number(g.z(), 6) + " m/s²"}}};
  return out;
}

}  // namespace rivid::detail
