#include <algorithm>
#include <pugixml.hpp>

#include "export/model_tree.hpp"
#include "export/xml_edit.hpp"
#include "joined.hpp"
#include "report/markup.hpp"
#include "rivid/text.hpp"

// What Drake and Pinocchio have beside a URDF: transmissions, rotor parameters, Python modules.
namespace rivid::detail {

namespace {

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

std::string python_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : on_one_line(text)) {
    out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  }
  return out + "\"";
}

template <typename Range, typename Item>
std::string python_list(const Range& range, const Item& item) {
  return "[" + joined(range, ", ", item) + "]";
}

std::string python_list(const Eigen::Vector3d& values) { return python_list(values, exact); }

// (value, φ of speed and sign, direction of the motion that it counts for or 0)
std::string friction_term(const JointValues::FrictionTerm& term) {
  const int direction = term.direction == Direction::positive   ? 1
                        : term.direction == Direction::negative ? -1
                                                                : 0;
  return "(" + exact(term.value) + ", lambda speed, sign: " + std::string(term.function) + ", " +
         std::to_string(direction) + ")";
}

// Docstring, imports, constants and friction(), which both modules have.
std::string module_start(const ExportTask& task, const std::string& title, const std::string& imports) {
  std::string out = "\"\"\"" + title + "\n\n";
  for (std::string line : task.heading) {
    for (std::size_t at = line.find_first_of("\"\\"); at != std::string::npos;
         at = line.find_first_of("\"\\", at + 1)) {
      line[at] = '\'';
    }
    out += on_one_line(line) + "\n";
  }
  out +=
      "\"\"\"\n\nfrom math import exp, fabs, sqrt, tanh  # noqa: F401\nfrom pathlib import Path\n\nimport "
      "numpy as np\n" +
      imports + "\nHERE = Path(__file__).resolve().parent\nURDF = HERE / " +
      python_text(task.file.filename().string()) + "\nGRAVITY = " + python_list(task.tree.gravity) +
      "  # m/s², in the frame of the root\nJOINTS = " +
      python_list(task.robot.joints, [](const Joint& joint) { return python_text(joint.name); }) +
      "\n# τ = Σ value φ(speed, sign) of each joint: (value, φ, sign of the speed that it counts for, or 0 "
      "for both)\n"
      "FRICTION = [\n";
  for (const JointValues& joint : task.values) {
    out += "    " + python_list(joint.friction_terms, friction_term) + ",\n";
  }
  return out + "]\n# friction in proportion to the load\nLOAD_FRICTION = " +
         python_list(task.values, [](const JointValues& joint) { return exact(joint.load_friction); }) +
         "\n# v_s of tanh(speed / v_s) in the place of sign(speed) [rad/s, m/s]; 0: the sign "
         "itself\nSIGN_SPEED = " +
         python_list(task.robot.joints, [](const Joint& joint) { return exact(joint.sign_speed); }) + R"py(


def friction(v, load=None, sign_speed=0.0):
    """Identified friction torques at the velocities v of JOINTS, (n) [N·m | N].

    load: torques M a + N without friction, of which LOAD_FRICTION is a part, (n) [N·m | N]; without them it is left out.
    A sign_speed above zero makes the sign of the velocity smooth where it was not identified so.
    """
    out = np.zeros(len(JOINTS))
    for joint, terms in enumerate(FRICTION):
        speed = float(v[joint])
        smooth = SIGN_SPEED[joint] or sign_speed
        sign = tanh(speed / smooth) if smooth else float(np.sign(speed))
        for value, phi, direction in terms:
            if direction == 0 or direction == np.sign(speed):
                out[joint] += value * phi(speed, sign)
        if load is not None:
            out[joint] += LOAD_FRICTION[joint] * abs(load[joint]) * sign
    return out
)py";
}

}  // namespace

std::string with_transmissions(const ExportTask& task) {
  const UrdfDocument document(task.xml, task.urdf.string());
  Splice splice(task.xml);
  for (const pugi::xml_node node : document.robot().children("transmission")) {
    if (moves_joint_of(task.robot, node)) {
      remove_element(splice, node);
    }
  }
  const StartTag robot = start_tag(task.xml, offset_of(document.robot()));
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

std::string rotor_parameters(const ExportTask& task, std::vector<std::string>& /*missing*/) {
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

std::string drake_module(const ExportTask& task, std::vector<std::string>& /*missing*/) {
  const std::string& root = task.tree.link(task.tree.root).name;
  const std::string weld = root == "world"
                               ? ""
                               : "    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(" +
                                     python_text(root) + ", model))\n";
  const std::string damping =
      python_list(task.values, [](const JointValues& joint) { return exact(joint.damping.value_or(0.0)); });
  return module_start(task, task.tree.name + " with identified parameters, for Drake.",
                      "from pydrake.multibody.parsing import Parser\n") +
         "\nDAMPING = " + damping + "  # of the plant's joints\n" + R"py(

def load(plant):
    """Adds the robot, its root welded to the world, to a plant that is not finalized, and sets the plant's gravity.

    Returns the model instance.
    """
    (model,) = Parser(plant).AddModels(str(URDF))
)py" + weld +
         R"py(    plant.mutable_gravity_field().set_gravity_vector(GRAVITY)
    return model


def friction_left_out(v, load=None, sign_speed=0.0):
    """Friction that the plant does not have, all but the damping of its joints, (n) [N·m | N]; see friction()."""
    return friction(v, load, sign_speed) - np.multiply(DAMPING, v)
)py";
}

std::string pinocchio_module(const ExportTask& task, std::vector<std::string>& /*missing*/) {
  return module_start(task, task.tree.name + " with identified parameters, for Pinocchio.",
                      "import pinocchio\n") +
         R"py(

def load():
    """The model, with rotor inertias and gravity."""
    model = pinocchio.buildModelFromUrdf(str(URDF))
    pinocchio.loadRotorParameters(model, str(URDF.with_suffix(".srdf")), False)
    model.gravity.linear = np.array(GRAVITY)
    return model


def inverse_dynamics(model, data, q, v, a, sign_speed=0.0):
    """Torques of JOINTS with friction, (n) [N·m | N]: rnea() and friction(). Other joints stand still at zero.

    q, v, a: positions, velocities and accelerations of JOINTS, (n).
    """
    position, velocity, acceleration = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    joints = [model.joints[model.getJointId(name)] for name in JOINTS]
    places = [joint.idx_v for joint in joints]
    for joint, angle in zip(joints, q):
        # A continuous joint has cosine and sine for its position.
        position[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
    velocity[places], acceleration[places] = v, a
    load = pinocchio.rnea(model, data, position, velocity, acceleration)[places]
    return load + friction(v, load, sign_speed)
)py";
}

}  // namespace rivid::detail
