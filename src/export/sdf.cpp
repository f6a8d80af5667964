#include <algorithm>
#include <pugixml.hpp>
#include <sstream>

#include "export/model_tree.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Shape = ModelTree::Shape;

pugi::xml_node text_of(pugi::xml_node parent, const char* name, const std::string& content) {
  pugi::xml_node out = parent.append_child(name);
  out.text() = content.c_str();
  return out;
}

void name_it(pugi::xml_node node, const std::string& name) { node.append_attribute("name") = name.c_str(); }

void pose_of(pugi::xml_node parent, const ModelTree::Pose& pose, const std::string& relative_to = "") {
  Vector all(6);
  all << pose.xyz, pose.rpy;
  pugi::xml_node node = text_of(parent, "pose", exact_list(all));
  if (!relative_to.empty()) {
    node.append_attribute("relative_to") = relative_to.c_str();
  }
}

class SdfWriter {
 public:
  SdfWriter(const ExportTask& task, std::vector<std::string>& missing)
      : task_(task), tree_(task.tree), missing_(missing) {}

  std::string run() {
    pugi::xml_node sdf = document_.append_child("sdf");
    sdf.append_attribute("version") = "1.9";
    sdf.append_attribute("xmlns:drake") = "http://drake.mit.edu";
    pugi::xml_node heading = sdf.append_child(pugi::node_comment);
    pugi::xml_node world = sdf.append_child("world");
    name_it(world, tree_.name + "_world");
    text_of(world, "gravity", exact_list(tree_.gravity));
    model_ = world.append_child("model");
    name_it(model_, tree_.name);
    write_links();
    fix_root();
    for (const ModelTree::Joint& joint : tree_.joints) {
      write_joint(joint);
    }
    std::vector<std::string> lines = task_.heading;
    lines.insert(lines.end(), missing_.begin(), missing_.end());
    heading.set_value(comment_text(lines).c_str());
    std::ostringstream out;
    document_.save(out, "  ");
    return out.str();
  }

 private:
  // A link without a body is a frame of the link that carries it: SDF would give it a mass of 1 kg.
  [[nodiscard]] bool is_frame(const ModelTree::Link& link) const {
    return !link.body && link.parent >= 0 && tree_.joint(link.parent).type == "fixed";
  }

  [[nodiscard]] int carrier(int place) const {
    while (is_frame(tree_.link(place))) {
      place = tree_.joint(tree_.link(place).parent).parent;
    }
    return place;
  }

  [[nodiscard]] bool is_world(int place) const {
    return place == tree_.root && tree_.link(place).name == "world";
  }

  // Links and joints share one space of names.
  [[nodiscard]] std::string joint_name(const ModelTree::Joint& joint) const {
    const bool taken =
        std::ranges::find(tree_.links, joint.name, &ModelTree::Link::name) != tree_.links.end();
    return taken ? joint.name + "_joint" : joint.name;
  }

  void write_links() {
    std::vector<pugi::xml_node> nodes(tree_.links.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const ModelTree::Link& link = tree_.links[i];
      if (is_world(static_cast<int>(i))) {
        continue;
      }
      nodes[i] = model_.append_child(is_frame(link) ? "frame" : "link");
      name_it(nodes[i], link.name);
      if (is_frame(link)) {
        const ModelTree::Joint& joint = tree_.joint(link.parent);
        nodes[i].append_attribute("attached_to") = tree_.link(joint.parent).name.c_str();
        pose_of(nodes[i], joint.pose);
      } else if (link.parent >= 0) {
        pose_of(nodes[i], {}, joint_name(tree_.joint(link.parent)));
      }
      if (link.body) {
        write_body(nodes[i], *link.body);
      }
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto owner = static_cast<std::size_t>(carrier(static_cast<int>(i)));
      int count = 0;
      for (const Shape& shape : tree_.links[i].shapes) {
        if (nodes[owner]) {
          write_shape(nodes[owner], tree_.links[i].name, shape, ++count, owner != i);
        }
      }
    }
  }

  static void write_body(pugi::xml_node link, const UrdfBody& body) {
    pugi::xml_node inertial = link.append_child("inertial");
    pose_of(inertial, body.pose);
    text_of(inertial, "mass", exact(body.mass));
    const pugi::xml_node inertia = inertial.append_child("inertia");
    for (std::size_t k = 0; k < body.inertia.size(); ++k) {
      text_of(inertia, urdf_tensor_names[k], exact(body.inertia[k]));
    }
  }

  void write_shape(pugi::xml_node link, const std::string& owner, const Shape& shape, int count, bool moved) {
    pugi::xml_node node = link.append_child(shape.collision ? "collision" : "visual");
    name_it(node, owner + (shape.collision ? "_collision_" : "_visual_") + std::to_string(count));
    pose_of(node, shape.pose, moved ? owner : "");
    pugi::xml_node geometry = node.append_child("geometry");
    switch (shape.kind) {
      case Shape::Kind::box:
        text_of(geometry.append_child("box"), "size", exact_list(shape.size));
        break;
      case Shape::Kind::cylinder: {
        const pugi::xml_node cylinder = geometry.append_child("cylinder");
        text_of(cylinder, "radius", exact(shape.size[0]));
        text_of(cylinder, "length", exact(shape.size[1]));
        break;
      }
      case Shape::Kind::sphere:
        text_of(geometry.append_child("sphere"), "radius", exact(shape.size[0]));
        break;
      case Shape::Kind::mesh: {
        const pugi::xml_node mesh = geometry.append_child("mesh");
        text_of(mesh, "uri", mesh_uri(shape.mesh));
        text_of(mesh, "scale", exact_list(shape.size));
        break;
      }
    }
    if (shape.rgba && !shape.collision) {
      const pugi::xml_node material = node.append_child("material");
      const std::string colour = exact_list(Eigen::Vector4d(shape.rgba->data()));
      text_of(material, "ambient", colour);
      text_of(material, "diffuse", colour);
    }
  }

  // A name with a scheme is for the reader to resolve; others stand relative to the file.
  [[nodiscard]] std::string mesh_uri(const std::string& name) const {
    const auto file = name.find("://") == std::string::npos ? mesh_file(name, task_.urdf) : std::nullopt;
    return file ? beside_written(*file, task_) : name;
  }

  void fix_root() {
    if (is_world(tree_.root)) {
      return;
    }
    pugi::xml_node joint = model_.append_child("joint");
    name_it(joint, tree_.link(tree_.root).name + "_to_world");
    joint.append_attribute("type") = "fixed";
    text_of(joint, "parent", "world");
    text_of(joint, "child", tree_.link(tree_.root).name);
  }

  void write_joint(const ModelTree::Joint& joint) {
    if (is_frame(tree_.link(joint.child))) {
      return;
    }
    pugi::xml_node node = model_.append_child("joint");
    name_it(node, joint_name(joint));
    const bool known = joint.slides() || joint.turns() || joint.type == "fixed";
    node.append_attribute("type") = known ? joint.type.c_str() : "fixed";
    const std::string& parent = tree_.link(joint.parent).name;
    pose_of(node, joint.pose, is_world(joint.parent) ? "__model__" : parent);
    text_of(node, "parent", parent);
    text_of(node, "child", tree_.link(joint.child).name);
    if (!known) {
      missing_.push_back("joint \"" + joint.name + "\" (" + joint.type + ") is fixed: SDF has no such joint");
    }
    if (joint.slides() || joint.turns()) {
      write_axis(node, joint);
    }
    if (joint.mimic) {
      missing_.push_back("joint \"" + joint.name + "\" does not follow \"" + joint.mimic->joint +
                         "\" as in the URDF");
    }
    if (joint.index >= 0) {
      const Joint& drive = task_.robot.joints[static_cast<std::size_t>(joint.index)];
      const double Ia = task_.values[static_cast<std::size_t>(joint.index)].Ia;
      text_of(node, "drake:rotor_inertia", exact(Ia / (drive.gear_ratio * drive.gear_ratio)));
      text_of(node, "drake:gear_ratio", exact(drive.gear_ratio));
    }
  }

  static void write_axis(pugi::xml_node node, const ModelTree::Joint& joint) {
    pugi::xml_node axis = node.append_child("axis");
    text_of(axis, "xyz", exact_list(joint.axis));
    pugi::xml_node limit = axis.append_child("limit");
    const auto put = [&](const char* name, std::optional<double> value) {
      if (value) {
        text_of(limit, name, exact(*value));
      }
    };
    put("lower", joint.lower);
    put("upper", joint.upper);
    put("effort", joint.effort);
    put("velocity", joint.velocity);
    const pugi::xml_node dynamics = axis.append_child("dynamics");
    text_of(dynamics, "damping", exact(joint.damping));
    text_of(dynamics, "friction", exact(joint.friction));
  }

  const ExportTask& task_;
  const ModelTree& tree_;
  std::vector<std::string>& missing_;
  pugi::xml_document document_;
  pugi::xml_node model_;
};

}  // namespace

std::string sdf(const ExportTask& task, std::vector<std::string>& missing) {
  return SdfWriter(task, missing).run();
}

}  // namespace rivid::detail
