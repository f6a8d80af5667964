#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <pugixml.hpp>
#include <sstream>
#include <tuple>
#include <variant>

#include "dense.hpp"
#include "export/model_tree.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Shape = ModelTree::Shape;

// The impedance and time constant with which frictionloss comes nearest to dry friction: the joint holds
// without creeping, and the torque is that of the velocity one time step of 2 ms later. MuJoCo's own defaults
// are softer: below 0.3 rad/s they miss the friction of a robot by up to 8 % of its largest torque.
constexpr const char* stiff_impedance = "0.9999 0.9999 0.001 0.5 2";
constexpr const char* stiff_reference = "0.004 1";

constexpr std::array<std::string_view, 3> mesh_formats = {".stl", ".obj", ".msh"};

pugi::xml_node child_of(pugi::xml_node parent, const char* name) { return parent.append_child(name); }

void put(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name) = value.c_str();
}

void put(pugi::xml_node node, const char* name, const Eigen::Ref<const Vector>& values) {
  put(node, name, exact_list(values));
}

void put_pose(pugi::xml_node node, const ModelTree::Pose& pose) {
  if (!pose.xyz.isZero(0.0)) {
    put(node, "pos", pose.xyz);
  }
  if (!pose.rpy.isZero(0.0)) {
    put(node, "euler", pose.rpy);
  }
}

class MjcfWriter {
 public:
  MjcfWriter(const ExportTask& task, std::vector<std::string>& missing)
      : task_(task), tree_(task.tree), missing_(missing) {}

  std::string run() {
    model_ = document_.append_child("mujoco");
    put(model_, "model", tree_.name);
    model_.append_child(pugi::node_comment).set_value(comment_text(task_.heading).c_str());
    const pugi::xml_node compiler = child_of(model_, "compiler");
    put(compiler, "angle", "radian");
    put(compiler, "eulerseq", "XYZ");
    put(compiler, "inertiafromgeom", "false");
    put(child_of(model_, "option"), "gravity", tree_.gravity);
    write_defaults();
    assets_ = child_of(model_, "asset");
    const pugi::xml_node world = child_of(model_, "worldbody");
    const bool root_is_world = tree_.link(tree_.root).name == "world";
    write_link(root_is_world ? world : child_of(world, "body"), tree_.root, !root_is_world);
    write_contacts();
    write_equalities();
    write_motors();
    for (const char* const part : {"asset", "contact", "equality", "actuator"}) {
      if (!model_.child(part).first_child()) {
        model_.remove_child(part);
      }
    }
    std::ostringstream out;
    document_.save(out, "  ");
    return out.str();
  }

 private:
  void write_defaults() {
    const pugi::xml_node all = child_of(model_, "default");
    pugi::xml_node visual = child_of(all, "default");
    put(visual, "class", "visual");
    visual = child_of(visual, "geom");
    put(visual, "contype", "0");
    put(visual, "conaffinity", "0");
    put(visual, "group", "2");
    const pugi::xml_node collision = child_of(all, "default");
    put(collision, "class", "collision");
    put(child_of(collision, "geom"), "group", "3");
    for (const ModelTree::Joint& joint : tree_.joints) {
      if (!moves(joint)) {
        continue;
      }
      pugi::xml_node own = child_of(all, "default");
      put(own, "class", joint.name);
      own = child_of(own, "joint");
      if (joint.index >= 0) {
        put(own, "armature", exact(values(joint).Ia));
      }
      put(own, "damping", exact(joint.damping));
      put(own, "frictionloss", exact(joint.friction));
      if (joint.friction > 0.0) {
        put(own, "solreffriction", stiff_reference);
        put(own, "solimpfriction", stiff_impedance);
      }
    }
  }

  [[nodiscard]] const JointValues& values(const ModelTree::Joint& joint) const {
    return task_.values[static_cast<std::size_t>(joint.index)];
  }

  [[nodiscard]] bool has_mass(int link) const {
    return tree_.link(link).body || std::ranges::any_of(tree_.link(link).children, [&](int child) {
             return tree_.joint(child).type == "fixed" && has_mass(tree_.joint(child).child);
           });
  }

  // MuJoCo has no planar joints, floating ones for bodies of the world alone, and no joints that move
  // nothing.
  [[nodiscard]] bool moves(const ModelTree::Joint& joint) const {
    return (joint.slides() || joint.turns()) && (joint.index >= 0 || has_mass(joint.child));
  }

  void write_link(pugi::xml_node body, int place, bool named) {
    const ModelTree::Link& link = tree_.link(place);
    if (named) {
      put(body, "name", link.name);
    }
    if (link.parent >= 0) {
      put_pose(body, tree_.joint(link.parent).pose);
    }
    if (named && link.body) {
      write_inertial(body, *link.body);
    }
    if (link.parent >= 0 && tree_.joint(link.parent).type != "fixed") {
      write_joint(body, tree_.joint(link.parent));
    }
    for (const Shape& shape : link.shapes) {
      write_shape(body, link, shape);
    }
    for (const int child : link.children) {
      write_link(child_of(body, "body"), tree_.joint(child).child, true);
    }
  }

  static void write_inertial(pugi::xml_node body, const UrdfBody& values) {
    const SymmetricEigen principal = symmetric_eigen(symmetric_tensor(values.inertia.data()));
    Eigen::Matrix3d axes = principal.vectors;
    axes.col(2) *= axes.determinant() < 0.0 ? -1.0 : 1.0;
    // MuJoCo refuses a triangle inequality that rounding violates.
    Eigen::Vector3d moments = principal.values;
    moments[2] = std::min(moments[2], moments[0] + moments[1]);
    const Eigen::Quaterniond q(values.pose.rotation() * axes);
    const pugi::xml_node node = child_of(body, "inertial");
    put(node, "pos", values.pose.xyz);
    put(node, "quat", Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
    put(node, "mass", exact(values.mass));
    put(node, "diaginertia", moments);
  }

  void write_joint(pugi::xml_node body, const ModelTree::Joint& joint) {
    if (!moves(joint)) {
      missing_.push_back("joint \"" + joint.name + "\" (" + joint.type +
                         ") is fixed: MuJoCo has no such joint there, or it moves nothing");
      return;
    }
    const pugi::xml_node node = child_of(body, "joint");
    put(node, "name", joint.name);
    put(node, "class", joint.name);
    if (joint.slides()) {
      put(node, "type", "slide");
    }
    put(node, "axis", joint.axis);
    if (joint.lower && *joint.lower < *joint.upper) {
      put(node, "range", Eigen::Vector2d(*joint.lower, *joint.upper));
    }
  }

  void write_shape(pugi::xml_node body, const ModelTree::Link& link, const Shape& shape) {
    const std::optional<std::string> mesh =
        shape.kind == Shape::Kind::mesh ? mesh_asset(link, shape) : std::optional<std::string>("");
    if (!mesh) {
      return;
    }
    const pugi::xml_node node = child_of(body, "geom");
    put(node, "class", shape.collision ? "collision" : "visual");
    switch (shape.kind) {
      case Shape::Kind::box:
        put(node, "type", "box");
        put(node, "size", Eigen::Vector3d(0.5 * shape.size));
        break;
      case Shape::Kind::cylinder:
        put(node, "type", "cylinder");
        put(node, "size", Eigen::Vector2d(shape.size[0], 0.5 * shape.size[1]));
        break;
      case Shape::Kind::sphere:
        put(node, "size", exact(shape.size[0]));
        break;
      case Shape::Kind::mesh:
        put(node, "type", "mesh");
        put(node, "mesh", *mesh);
        break;
    }
    put_pose(node, shape.pose);
    if (shape.rgba) {
      put(node, "rgba", Eigen::Vector4d(shape.rgba->data()));
    }
  }

  // The name of the asset; none where MuJoCo can not read the file.
  std::optional<std::string> mesh_asset(const ModelTree::Link& link, const Shape& shape) {
    const auto file = mesh_file(shape.mesh, task_.urdf);
    const std::string who = "mesh " + in_quotes(shape.mesh) + " of link \"" + link.name + "\" is left out: ";
    std::string ending = std::filesystem::path(shape.mesh).extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
    if (!file) {
      missing_.push_back(who + "the file is not found");
      return std::nullopt;
    }
    if (std::ranges::find(mesh_formats, ending) == mesh_formats.end()) {
      missing_.push_back(who + "MuJoCo reads .stl, .obj and .msh");
      return std::nullopt;
    }
    const std::string key = file->string() + '\n' + exact_list(shape.size);
    const auto [at, is_new] = meshes_.try_emplace(key, "");
    if (is_new) {
      at->second = file->stem().string() + "_" + std::to_string(meshes_.size());
      const pugi::xml_node node = child_of(assets_, "mesh");
      put(node, "name", at->second);
      put(node, "file", beside_written(*file, task_));
      put(node, "inertia", "shell");  // an open surface has no volume; inertias come from <inertial>
      if (shape.size != Eigen::Vector3d::Ones()) {
        put(node, "scale", shape.size);
      }
    }
    return at->second;
  }

  // Bodies that a joint connects touch. MuJoCo knows that save for those that stand still.
  void write_contacts() {
    const pugi::xml_node contact = child_of(model_, "contact");
    for (const ModelTree::Joint& joint : tree_.joints) {
      if (!moves(joint) || !tree_.link(joint.parent).still) {
        continue;
      }
      for (const ModelTree::Link& link : tree_.links) {
        const bool touches = link.still && std::ranges::any_of(link.shapes, &Shape::collision);
        if (touches && link.name != "world") {
          const pugi::xml_node pair = child_of(contact, "exclude");
          put(pair, "body1", link.name);
          put(pair, "body2", tree_.link(joint.child).name);
        }
      }
    }
  }

  void write_equalities() {
    const pugi::xml_node equality = child_of(model_, "equality");
    for (const ModelTree::Joint& joint : tree_.joints) {
      if (joint.mimic && moves(joint)) {
        const pugi::xml_node node = child_of(equality, "joint");
        put(node, "joint1", joint.name);
        put(node, "joint2", joint.mimic->joint);
        put(node, "polycoef", exact(joint.mimic->offset) + " " + exact(joint.mimic->multiplier) + " 0 0 0");
      }
    }
    const auto bar_of = [](const Chain::Dependent& dependent) {
      return dependent.curve ? std::get_if<FourBarAngle>(&*dependent.curve) : nullptr;
    };
    const auto linkage = [&](const Chain::Dependent& of) {
      const FourBarAngle& b = *bar_of(of);
      return std::tuple(of.terms.front().joint, b.ground, b.crank, b.coupler, b.rocker, b.crank_angle,
                        b.mirrored);
    };
    for (const Chain::Dependent& coupler : task_.robot.chain.dependents) {
      const FourBarAngle* const bar = bar_of(coupler);
      for (const Chain::Dependent& rocker : task_.robot.chain.dependents) {
        const FourBarAngle* const other = bar_of(rocker);
        if (bar != nullptr && other != nullptr && !bar->of_rocker && other->of_rocker &&
            linkage(coupler) == linkage(rocker)) {
          const pugi::xml_node node = child_of(equality, "connect");
          put(node, "body1", coupler.link);
          put(node, "body2", rocker.link);
          put(node, "anchor", Vector::Map(bar->closing.data(), 3));
        }
      }
    }
  }

  void write_motors() {
    const pugi::xml_node actuators = child_of(model_, "actuator");
    for (const Joint& joint : task_.robot.joints) {
      const auto in_tree = std::ranges::find(tree_.joints, joint.name, &ModelTree::Joint::name);
      const pugi::xml_node motor = child_of(actuators, "motor");
      put(motor, "name", joint.name);
      put(motor, "joint", joint.name);
      if (in_tree->effort.value_or(0.0) > 0.0) {
        put(motor, "ctrlrange", Eigen::Vector2d(-*in_tree->effort, *in_tree->effort));
      }
    }
  }

  const ExportTask& task_;
  const ModelTree& tree_;
  std::vector<std::string>& missing_;
  pugi::xml_document document_;
  pugi::xml_node model_;
  pugi::xml_node assets_;
  std::map<std::string, std::string> meshes_;
};

}  // namespace

std::string mjcf(const ExportTask& task, std::vector<std::string>& missing) {
  // What is left out is known at the end, and stands at the top.
  const std::size_t known = missing.size();
  std::string first = MjcfWriter(task, missing).run();
  if (missing.size() == known) {
    return first;
  }
  ExportTask again = task;
  again.heading.insert(again.heading.end(), missing.begin() + static_cast<std::ptrdiff_t>(known),
                       missing.end());
  std::vector<std::string> repeated;
  return MjcfWriter(again, repeated).run();
}

}  // namespace rivid::detail
