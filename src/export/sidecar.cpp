#include <array>

#include "export/write_back.hpp"
#include "report/markup.hpp"
#include "rivid/error.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::JointValues;

struct Format {
  Sidecar sidecar;
  std::string_view name;
  std::string_view extension;
};

constexpr std::array<Format, 3> formats = {{{Sidecar::mujoco, "mujoco", ".mujoco.xml"},
                                            {Sidecar::drake, "drake", ".drake.xml"},
                                            {Sidecar::pinocchio, "pinocchio", ".srdf"}}};

// `key="value"` with a blank before it.
std::string attribute(std::string_view key, std::string_view value) {
  return " " + std::string(key) + "=\"" + detail::escaped(value) + '"';
}

std::string attribute(std::string_view key, double value) { return attribute(key, exact(value)); }

double not_negative(double value, const char* what, const Joint& joint) {
  if (value < 0.0) {
    throw InputError("sidecar: joint \"" + joint.name + "\": " + what + " is " + number(value, 4) +
                     ", must not be negative");
  }
  return value;
}

std::string unsaid(const JointValues& values) {
  return values.rest.empty() ? std::string()
                             : "<!-- no place for " + detail::joined(values.unsaid(false)) + " -->";
}

std::string mujoco_joint(const Joint& joint, const JointValues& values) {
  std::string out = "    <default" + attribute("class", joint.name) + ">\n      <joint" +
                    attribute("armature", not_negative(values.Ia, "Ia", joint));
  if (values.damping) {
    out += attribute("damping", not_negative(*values.damping, "damping", joint));
  }
  if (values.friction) {
    out += attribute("frictionloss", not_negative(*values.friction, "friction", joint));
  }
  out += "/>";
  return out + unsaid(values) + "\n    </default>\n";
}

double rotor_inertia(const Joint& joint, const JointValues& values) {
  return not_negative(values.Ia, "Ia", joint) / (joint.gear_ratio * joint.gear_ratio);
}

std::string drake_joint(const Joint& joint, const JointValues& values) {
  return "  <transmission" + attribute("name", joint.name + "_transmission") +
         ">\n    <type>transmission_interface/SimpleTransmission</type>\n    <joint" +
         attribute("name", joint.name) +
         ">\n      <hardwareInterface>EffortJointInterface</hardwareInterface>\n" +
         "    </joint>\n    <actuator" + attribute("name", joint.name + "_motor") +
         ">\n      <drake:rotor_inertia" + attribute("value", rotor_inertia(joint, values)) +
         "/>\n      <drake:gear_ratio" + attribute("value", joint.gear_ratio) + "/>" + unsaid(values) +
         "\n    </actuator>\n  </transmission>\n";
}

std::string pinocchio_joint(const Joint& joint, const JointValues& values) {
  return "    <joint" + attribute("name", joint.name) + attribute("mass", rotor_inertia(joint, values)) +
         attribute("gear_ratio", joint.gear_ratio) + "/>" + unsaid(values) + "\n";
}

const Format& format_of(Sidecar sidecar) { return formats[static_cast<std::size_t>(sidecar)]; }

}  // namespace

std::string_view name(Sidecar sidecar) { return format_of(sidecar).name; }

std::string_view extension(Sidecar sidecar) { return format_of(sidecar).extension; }

std::optional<Sidecar> sidecar_named(std::string_view name) {
  for (const Format& format : formats) {
    if (format.name == name) {
      return format.sidecar;
    }
  }
  return std::nullopt;
}

std::string sidecar(Sidecar format, const Robot& robot, const Eigen::Ref<const Vector>& chi_st) {
  const std::vector<JointValues> values = detail::joint_values(robot, chi_st, "sidecar");
  const auto each = [&](auto joint_text) {
    std::string out;
    for (std::size_t j = 0; j < values.size(); ++j) {
      out += joint_text(robot.joints[j], values[j]);
    }
    return out;
  };
  const std::string robot_name = attribute("name", robot.name.empty() ? "robot" : robot.name);
  const std::string title = "<?xml version=\"1.0\"?>\n";
  switch (format) {
    case Sidecar::mujoco:
      return title + "<!-- Include this file, and give each joint the class of its name. -->\n" +
             "<mujocoinclude>\n  <default>\n" + each(mujoco_joint) + "  </default>\n</mujocoinclude>\n";
    case Sidecar::drake:
      return title + "<!-- Copy the transmissions and xmlns:drake into the URDF. -->\n<robot" + robot_name +
             attribute("xmlns:drake", "http://drake.mit.edu") + ">\n" + each(drake_joint) + "</robot>\n";
    case Sidecar::pinocchio:
      return title + "<!-- \"mass\" is what Pinocchio calls the rotor inertia. -->\n<robot" + robot_name +
             ">\n  <rotor_params>\n" + each(pinocchio_joint) + "  </rotor_params>\n</robot>\n";
  }
  return {};
}

}  // namespace rivid
