#include <algorithm>
#include <pugixml.hpp>

#include "export/model_tree.hpp"
#include "export/xml_edit.hpp"
#include "model/urdf_document.hpp"
#include "report/markup.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// `key="value"` with a blank before it.
std::string xml_attribute(std::string_view key, std::string_view value) {
  return " " + std::string(key) + "=\"" + escaped(value) + '"';
}

std::string xml_attribute(std::string_view key, double value) { return xml_attribute(key, exact(value)); }

// Ia is the inertia on the joint's side.
double rotor_inertia(const Joint& joint, const JointValues& values) {
  return values.Ia / (joint.gear_ratio * joint.gear_ratio);
}

std::vector<std::string> transmission(const Joint& joint, const JointValues& values) {
  return {"<transmission" + xml_attribute("name", joint.name + "_transmission") + ">",
          "  <type>transmission_interface/SimpleTransmission</type>",
          "  <joint" + xml_attribute("name", joint.name) + ">",
          "    <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>",
          "  </joint>",
          "  <actuator" + xml_attribute("name", joint.name + "_motor") + ">",
          "    <drake:rotor_inertia" + xml_attribute("value", rotor_inertia(joint, values)) + "/>",
          "    <drake:gear_ratio" + xml_attribute("value", joint.gear_ratio) + "/>",
          "  </actuator>",
          "</transmission>"};
}

bool moves_joint_of(const Robot& robot, pugi::xml_node transmission) {
  return std::ranges::any_of(transmission.children("joint"), [&](pugi::xml_node joint) {
    return std::ranges::find(robot.joints, joint.attribute("name").value(), &Joint::name) !=
           robot.joints.end();
  });
}

std::size_t offset_of(pugi::xml_node node) { return static_cast<std::size_t>(node.offset_debug()); }

// Takes an element out of a text, with the blanks before it.
void remove_element(Splice& splice, pugi::xml_node node) {
  const std::string_view text = splice.text();
  const StartTag tag = start_tag(text, offset_of(node));
  std::size_t end = tag.end;
  if (!tag.closed) {
    pugi::xml_node last = node;
    while (last.last_child()) {
      last = last.last_child();
    }
    end = text.find('>', text.find("</" + std::string(node.name()), offset_of(last))) + 1;
  }
  const std::size_t before = text.find_last_not_of(" \t\r\n", offset_of(node) - 2) + 1;
  splice.replace(before, end - before, "");
}

}  // namespace

std::string with_transmissions(std::string_view xml, const std::string& source, const ExportTask& task) {
  const UrdfDocument document(xml, source);
  Splice splice(xml);
  for (const pugi::xml_node node : document.robot().children("transmission")) {
    if (moves_joint_of(task.robot, node)) {
      remove_element(splice, node);
    }
  }
  const StartTag robot = start_tag(xml, offset_of(document.robot()));
  if (robot.attribute("xmlns:drake") == nullptr) {
    splice.set(robot, "xmlns:drake", "http://drake.mit.edu");
  }
  std::vector<std::string> lines;
  for (std::size_t j = 0; j < task.values.size(); ++j) {
    std::ranges::copy(transmission(task.robot.joints[j], task.values[j]), std::back_inserter(lines));
  }
  splice.insert_child(robot, lines);
  return splice.result();
}

std::string rotor_parameters(const ExportTask& task) {
  std::string out = "<?xml version=\"1.0\"?>\n<!--" + comment_text(task.heading) +
                    "-->\n<!-- \"mass\" is Pinocchio's word for the rotor inertia. -->\n<robot" +
                    xml_attribute("name", task.tree.name) + ">\n  <rotor_params>\n";
  for (std::size_t j = 0; j < task.values.size(); ++j) {
    const Joint& joint = task.robot.joints[j];
    out += "    <joint" + xml_attribute("name", joint.name) +
           xml_attribute("mass", rotor_inertia(joint, task.values[j])) +
           xml_attribute("gear_ratio", joint.gear_ratio) + "/>\n";
  }
  return out + "  </rotor_params>\n</robot>\n";
}

}  // namespace rivid::detail
