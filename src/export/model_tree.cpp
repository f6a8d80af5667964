#include "export/model_tree.hpp"

#include <algorithm>
#include <map>

#include "model/mesh.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Shape = ModelTree::Shape;

// Reads what a URDF has beside the numbers that rivid itself needs.
class TreeReader {
 public:
  TreeReader(std::string_view xml, const std::string& source, const Robot& robot)
      : document_(xml, source), tree_(urdf_topology(document_)), robot_(robot) {}

  [[nodiscard]] ModelTree read() {
    read_colours();
    ModelTree out;
    out.name = document_.robot().attribute("name").as_string("robot");
    out.root = tree_.root;
    for (const UrdfTopology::Link& link : tree_.links) {
      out.links.push_back({.name = link.name,
                           .body = body(link.node),
                           .shapes = shapes(link.node),
                           .parent = link.parent,
                           .children = link.children});
    }
    for (const UrdfTopology::Joint& joint : tree_.joints) {
      out.joints.push_back(read_joint(joint));
    }
    mark_still(out, out.root);
    out.gravity = base_rotation(out) * robot_.chain.gravity;
    return out;
  }

 private:
  // None where it has no mass.
  [[nodiscard]] std::optional<UrdfBody> body(pugi::xml_node link) const {
    const std::optional<UrdfBody> out = document_.body(link);
    return out && out->mass != 0.0 ? out : std::nullopt;
  }

  static std::optional<std::array<double, 4>> colour(pugi::xml_node material) {
    std::istringstream text(material.child("color").attribute("rgba").value());
    std::array<double, 4> out{};
    for (double& part : out) {
      if (!(text >> part)) {
        return std::nullopt;
      }
    }
    return out;
  }

  void read_colours() {
    for (const pugi::xml_node material : document_.robot().children("material")) {
      if (const auto found = colour(material)) {
        colours_[material.attribute("name").value()] = *found;
      }
    }
  }

  // None where the URDF describes a shape that it should not have.
  [[nodiscard]] std::optional<Shape> shape(pugi::xml_node node, bool collision) const {
    Shape out{.collision = collision, .pose = document_.pose(node)};
    const pugi::xml_node geometry = node.child("geometry");
    if (const pugi::xml_node box = geometry.child("box")) {
      out.size = document_.triple_or(Eigen::Vector3d::Zero(), box, "size", "box");
    } else if (const pugi::xml_node cylinder = geometry.child("cylinder")) {
      out.kind = Shape::Kind::cylinder;
      out.size = {document_.number(cylinder, "radius", "cylinder"),
                  document_.number(cylinder, "length", "cylinder"), 0.0};
    } else if (const pugi::xml_node sphere = geometry.child("sphere")) {
      out.kind = Shape::Kind::sphere;
      out.size = {document_.number(sphere, "radius", "sphere"), 0.0, 0.0};
    } else if (const pugi::xml_node mesh = geometry.child("mesh")) {
      out.kind = Shape::Kind::mesh;
      out.mesh = mesh.attribute("filename").value();
      out.size = document_.triple_or(Eigen::Vector3d::Ones(), mesh, "scale", "mesh");
    } else {
      return std::nullopt;
    }
    const pugi::xml_node material = node.child("material");
    out.rgba = colour(material);
    const auto named = colours_.find(material.attribute("name").value());
    if (!out.rgba && named != colours_.end()) {
      out.rgba = named->second;
    }
    return out;
  }

  [[nodiscard]] std::vector<Shape> shapes(pugi::xml_node link) const {
    std::vector<Shape> out;
    for (const bool collision : {false, true}) {
      for (const pugi::xml_node node : link.children(collision ? "collision" : "visual")) {
        if (const auto found = shape(node, collision)) {
          out.push_back(*found);
        }
      }
    }
    return out;
  }

  [[nodiscard]] std::optional<double> limit(pugi::xml_node node, const char* attribute) const {
    const pugi::xml_node limit = node.child("limit");
    return limit.attribute(attribute) ? std::optional<double>(document_.number(limit, attribute, "limit"))
                                      : std::nullopt;
  }

  [[nodiscard]] ModelTree::Joint read_joint(const UrdfTopology::Joint& joint) const {
    ModelTree::Joint out{.name = joint.name,
                         .type = joint.type,
                         .parent = joint.parent,
                         .child = joint.child,
                         .pose = document_.pose(joint.node)};
    out.axis = document_.triple_or(out.axis, joint.node.child("axis"), "xyz", "axis");
    out.effort = limit(joint.node, "effort");
    out.velocity = limit(joint.node, "velocity");
    if (joint.type == "revolute" || joint.type == "prismatic") {
      out.lower = limit(joint.node, "lower").value_or(0.0);
      out.upper = limit(joint.node, "upper").value_or(0.0);
    }
    const pugi::xml_node dynamics = joint.node.child("dynamics");
    out.damping = document_.number_or(0.0, dynamics, "damping", "dynamics");
    out.friction = document_.number_or(0.0, dynamics, "friction", "dynamics");
    if (const pugi::xml_node mimic = joint.node.child("mimic")) {
      out.mimic = {.joint = mimic.attribute("joint").value(),
                   .multiplier = document_.number_or(1.0, mimic, "multiplier", "mimic"),
                   .offset = document_.number_or(0.0, mimic, "offset", "mimic")};
    }
    const auto at = std::ranges::find(robot_.joints, joint.name, &rivid::Joint::name);
    out.index = at == robot_.joints.end() ? -1 : static_cast<int>(at - robot_.joints.begin());
    return out;
  }

  void mark_still(ModelTree& tree, int link) const {
    tree.links[static_cast<std::size_t>(link)].still = true;
    for (const int child : tree.link(link).children) {
      if (!tree_.joint(child).moves()) {
        mark_still(tree, tree.joint(child).child);
      }
    }
  }

  // Orientation of the robot's base in the root, moving joints between the two at zero.
  [[nodiscard]] Eigen::Matrix3d base_rotation(const ModelTree& tree) const {
    const auto base = std::ranges::find(tree.links, robot_.base, &ModelTree::Link::name);
    Eigen::Matrix3d out = Eigen::Matrix3d::Identity();
    for (int joint = base == tree.links.end() ? -1 : base->parent; joint >= 0;) {
      out = tree.joint(joint).pose.rotation() * out;
      joint = tree.link(tree.joint(joint).parent).parent;
    }
    return out;
  }

  UrdfDocument document_;
  UrdfTopology tree_;
  const Robot& robot_;
  std::map<std::string, std::array<double, 4>> colours_;
};

}  // namespace

ModelTree model_tree(std::string_view xml, const std::string& source, const Robot& robot) {
  return TreeReader(xml, source, robot).read();
}

std::optional<std::filesystem::path> mesh_file(const std::string& name, const std::filesystem::path& urdf) {
  const auto out = found_mesh(name, std::filesystem::absolute(urdf).parent_path());
  return out ? std::optional(out->lexically_normal()) : std::nullopt;
}

std::string beside_written(const std::filesystem::path& mesh, const ExportTask& task) {
  return std::filesystem::proximate(mesh, std::filesystem::absolute(task.file).parent_path()).string();
}

std::string comment_text(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) {
    out += (out.empty() ? " " : "\n     ") + on_one_line(line);
  }
  for (std::size_t at = out.find("--"); at != std::string::npos; at = out.find("--")) {
    out.replace(at, 2, "- -");
  }
  return out + " ";
}

}  // namespace rivid::detail
