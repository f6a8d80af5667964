#include "comma_list.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

List coupling_list(const Robot& robot) {
  const auto joint = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  List out{"couplings"};
  for (const Coupling& coupling : robot.couplings) {
    std::vector<std::string> turned_by;
    for (std::size_t k = 0; k < coupling.joints.size(); ++k) {
      turned_by.push_back(joint(coupling.joints[k]) + " (" + number(coupling.ratios[k], 6) + ")");
    }
    out.items.push_back({.text = "The motor of " + joint(coupling.motor) + " is turned by " +
                                 comma_list(turned_by) + " as well: inertia " +
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

Section provenance_section(const Robot& robot, const Identification& result, const Provenance& provenance) {
  using J = Joint;
  Settings settings = row_settings(result.estimation.signal);
  settings.insert(settings.begin(), {"Method", result.title});
  const Eigen::Vector3d& g = robot.chain.gravity;
  Section out{"provenance", "Provenance", "Provenance", {}, Shown::page};
  out.blocks = {
      {run_table(provenance, settings)},
      {inputs_table(provenance)},
      {Heading{"Robot"}},
      {table_of(
          robot.joints,
          {{{"joint"}, [](const J& j) { return j.name; }},
           {{"moves"}, [](const J& j) { return j.link; }},
           {{"type"}, [](const J& j) { return j.type == JointType::revolute ? "revolute" : "prismatic"; }},
           {{"friction"}, friction_words},
           {{"rotor inertia"}, [](const J& j) { return j.rotor_inertia ? "yes" : "no"; }},
           {{"drive gain", format::significant(6)}, [](const J& j) { return j.drive_gain; }},
           {{"gear ratio", format::significant(6)}, [](const J& j) { return j.gear_ratio; }}})},
      {coupling_list(robot)},
      {Sentence{"Gravity in the frame of the base: " + number(g.x(), 6) + ", " + number(g.y(), 6) + ", " +
                number(g.z(), 6) + " m/s²"}}};
  return out;
}

}  // namespace rivid::detail
