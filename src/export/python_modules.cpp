#include "export/model_tree.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::string python_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : on_one_line(text)) {
    out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  }
  return out + "\"";
}

template <typename Range, typename Item>
std::string python_list(const Range& range, const Item& item) {
  std::string out;
  for (const auto& each : range) {
    out += (out.empty() ? "" : ", ") + item(each);
  }
  return "[" + out + "]";
}

std::string python_list(const Eigen::Vector3d& values) {
  return python_list(values, [](double value) { return exact(value); });
}

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

std::string drake_module(const ExportTask& task) {
  const std::string& root = task.tree.link(task.tree.root).name;
  const std::string weld = root == "world"
                               ? ""
                               : "    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(" +
                                     python_text(root) + ", model))\n";
  std::string damping = "[";
  for (const JointValues& joint : task.values) {
    damping += (damping.size() > 1 ? ", " : "") + exact(joint.damping.value_or(0.0));
  }
  return module_start(task, task.tree.name + " with identified parameters, for Drake.",
                      "from pydrake.multibody.parsing import Parser\n") +
         "\nDAMPING = " + damping + "]  # of the plant's joints\n" + R"py(

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

std::string pinocchio_module(const ExportTask& task) {
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
