#include "report/html_page.hpp"
#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid::detail {

namespace {

using Align = HtmlTable::Align;

std::string settings_table(const Identification& result, const Provenance& provenance) {
  HtmlTable table({{"", Align::text}, {"", Align::text}});
  const auto add = [&](const std::string& what, const std::string& value) {
    table.add({what, escaped(value)});
  };
  add("Program", provenance.program + ", rivid " + version);
  add("Method", result.title);
  for (const auto& [what, value] : row_settings(result.estimation.signal)) {
    add(what, value);
  }
  for (const auto& [flag, value] : provenance.overrides) {
    add("Flag --" + escaped(flag), value);
  }
  return table.markup();
}

std::string joint_name(const Robot& robot, int j) {
  return escaped(robot.joints[static_cast<std::size_t>(j)].name);
}

std::string coupling_words(const Robot& robot) {
  std::string out;
  for (const Coupling& coupling : robot.couplings) {
    std::string turned_by;
    for (std::size_t k = 0; k < coupling.joints.size(); ++k) {
      turned_by += (k == 0 ? "" : ", ") + joint_name(robot, coupling.joints[k]) + " (" +
                   number(coupling.ratios[k], 6) + ")";
    }
    out += element("li", "The motor of " + joint_name(robot, coupling.motor) + " is turned by " + turned_by +
                             " as well: inertia " + std::string(name(coupling.inertia)) + ", Coulomb " +
                             std::string(name(coupling.coulomb)) + ".");
  }
  return out.empty() ? out : element("ul", out);
}

std::string robot_section(const Robot& robot) {
  HtmlTable table({{"joint", Align::text},
                   {"moves", Align::text},
                   {"type", Align::text},
                   {"friction", Align::text},
                   {"rotor inertia", Align::text},
                   {"drive gain", Align::number},
                   {"gear ratio", Align::number}});
  for (const Joint& joint : robot.joints) {
    std::string friction(name(joint.friction));
    if (joint.sign_speed > 0.0) {
      friction += ", smooth over " + number(joint.sign_speed, 4);
    }
    table.add({escaped(joint.name), escaped(joint.link),
               joint.type == JointType::revolute ? "revolute" : "prismatic", friction,
               joint.rotor_inertia ? "yes" : "no", number(joint.drive_gain, 6), number(joint.gear_ratio, 6)});
  }
  const Eigen::Vector3d& g = robot.chain.gravity;
  return element("h3", "Robot") + table.markup() + coupling_words(robot) +
         element("p", "Gravity in the frame of the base: " + number(g.x(), 6) + ", " + number(g.y(), 6) +
                          ", " + number(g.z(), 6) + " m/s².");
}

}  // namespace

std::string provenance_section(const Robot& robot, const Identification& result,
                               const Provenance& provenance) {
  return element("section", element("h2", "Provenance", "id=\"provenance\"") +
                                settings_table(result, provenance) + inputs_table(provenance) +
                                robot_section(robot));
}

}  // namespace rivid::detail
