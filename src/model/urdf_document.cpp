#include "urdf_document.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <ranges>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr std::string_view blanks = " \t\r\n";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> out;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const std::size_t end = std::min(text.find_first_of(blanks), text.size());
    out.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return out;
}

std::optional<double> finite(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
    text.remove_prefix(1);
  }
  return finite_number(text);
}

std::string as_written(pugi::xml_node node, const char* attribute) {
  return std::string("<") + node.name() + ' ' + attribute + "=\"" + node.attribute(attribute).value() + "\">";
}

bool is_xacro(std::string_view value) {
  return value.find("${") != std::string_view::npos || value.find("$(") != std::string_view::npos;
}

}  // namespace

UrdfDocument::UrdfDocument(std::string_view xml, std::string source) : source_(std::move(source)) {
  if (trimmed(xml).empty()) {
    throw InputError(source_ + ": is empty, must be a URDF");
  }
  for (std::size_t i = xml.find('\n'); i != std::string_view::npos; i = xml.find('\n', i + 1)) {
    newlines_.push_back(i);
  }
  check_well_formed(document_.load_buffer(xml.data(), xml.size()));
  check_elements();
}

void UrdfDocument::check_well_formed(const pugi::xml_parse_result& result) const {
  if (result.status == pugi::status_no_document_element) {
    throw InputError(source_ + ": is not XML, must be a URDF");
  }
  if (!result) {
    throw InputError(where(result.offset) + "not well-formed XML: " + result.description());
  }
  const pugi::xml_node root = document_.document_element();
  if (std::string_view(root.name()) != "robot") {
    const bool sdf = std::string_view(root.name()) == "sdf";
    refuse(root, std::string("is not a URDF: the outermost element is <") + root.name() +
                     ">, must be <robot>" + (sdf ? "; convert the SDF to a URDF first" : ""));
  }
  for (pugi::xml_node next = root.next_sibling(); next; next = next.next_sibling()) {
    if (next.type() == pugi::node_element) {
      refuse(next, std::string("not well-formed XML: <") + next.name() + "> follows the end of <robot>");
    }
  }
}

void UrdfDocument::check_elements() const {
  const std::string advice = "; this is a xacro file, expand it first: xacro in.xacro > out.urdf";
  const pugi::xml_node root = robot();
  // Without recursion: a hostile file can nest deeper than the stack.
  pugi::xml_node node = root;
  while (node) {
    if (std::string_view(node.name()).starts_with("xacro:")) {
      refuse(node, std::string("<") + node.name() + "> is not URDF" + advice);
    }
    std::set<std::string_view> attributes;
    for (const pugi::xml_attribute attribute : node.attributes()) {
      const auto is_control = [](char c) {
        return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\n' && c != '\r';
      };
      if (std::ranges::any_of(std::string_view(attribute.value()), is_control)) {
        refuse(node, std::string("not well-formed XML: <") + node.name() +
                         "> has a control character in attribute " + attribute.name());
      }
      if (is_xacro(attribute.value())) {
        refuse(node, as_written(node, attribute.name()) + " holds an expression" + advice);
      }
      if (!attributes.insert(attribute.name()).second) {
        refuse(node, std::string("not well-formed XML: <") + node.name() + "> has two attributes " +
                         attribute.name());
      }
    }
    if (node.first_child()) {
      node = node.first_child();
      continue;
    }
    while (node != root && !node.next_sibling()) {
      node = node.parent();
    }
    node = node == root ? pugi::xml_node() : node.next_sibling();
  }
}

std::string UrdfDocument::where(std::ptrdiff_t offset) const {
  if (offset < 0) {
    return source_ + ": ";
  }
  const auto line = std::lower_bound(newlines_.begin(), newlines_.end(), static_cast<std::size_t>(offset));
  return source_ + ':' + std::to_string(line - newlines_.begin() + 1) + ": ";
}

std::string UrdfDocument::where(pugi::xml_node node) const { return where(node.offset_debug()); }

void UrdfDocument::refuse(pugi::xml_node node, const std::string& message) const {
  throw InputError(where(node) + message);
}

pugi::xml_node UrdfDocument::only_child(pugi::xml_node parent, const char* name,
                                        const std::string& who) const {
  const pugi::xml_node child = parent.child(name);
  if (const pugi::xml_node second = child.next_sibling(name)) {
    refuse(second, who + ": has a second <" + name + ">, must have one at most");
  }
  return child;
}

std::string UrdfDocument::text(pugi::xml_node node, const char* attribute, const std::string& who) const {
  if (trimmed(node.attribute(attribute).value()).empty()) {
    refuse(node, who + ": <" + node.name() + "> has no " + attribute);
  }
  return node.attribute(attribute).value();
}

double UrdfDocument::number(pugi::xml_node node, const char* attribute, const std::string& who) const {
  if (!node.attribute(attribute)) {
    refuse(node, who + ": <" + node.name() + "> has no " + attribute);
  }
  const std::optional<double> value = finite(node.attribute(attribute).value());
  if (!value) {
    refuse(node, who + ": " + as_written(node, attribute) + " must be a finite number, such as 1.5e-3");
  }
  return *value;
}

double UrdfDocument::number_or(double fallback, pugi::xml_node node, const char* attribute,
                               const std::string& who) const {
  return node.attribute(attribute) ? number(node, attribute, who) : fallback;
}

Eigen::Vector3d UrdfDocument::triple_or(const Eigen::Vector3d& fallback, pugi::xml_node node,
                                        const char* attribute, const std::string& who) const {
  if (!node.attribute(attribute)) {
    return fallback;
  }
  const std::vector<std::string_view> parts = words(node.attribute(attribute).value());
  Eigen::Vector3d out = fallback;
  bool good = parts.size() == 3;
  for (std::size_t i = 0; good && i < 3; ++i) {
    const std::optional<double> value = finite(parts[i]);
    good = value.has_value();
    out[static_cast<Eigen::Index>(i)] = value.value_or(0.0);
  }
  if (!good) {
    refuse(node, who + ": " + as_written(node, attribute) +
                     " must be three finite numbers with blanks between them, such as \"0 0 1.5e-3\"");
  }
  return out;
}

UrdfPose UrdfDocument::pose(pugi::xml_node node) const {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const pugi::xml_node origin = node.child("origin");
  return {triple_or(zero, origin, "xyz", "origin"), triple_or(zero, origin, "rpy", "origin")};
}

std::optional<UrdfBody> UrdfDocument::body(pugi::xml_node link) const {
  const pugi::xml_node node = link.child("inertial");
  if (!node) {
    return std::nullopt;
  }
  UrdfBody out{.pose = pose(node), .mass = number(node.child("mass"), "value", "mass")};
  for (std::size_t k = 0; k < out.inertia.size(); ++k) {
    out.inertia[k] = number(node.child("inertia"), urdf_tensor_names[k], "inertia");
  }
  return out;
}

Eigen::Matrix3d UrdfPose::rotation() const {
  return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Isometry3d UrdfPose::isometry() const {
  Eigen::Isometry3d out(rotation());
  out.translation() = xyz;
  return out;
}

Eigen::Matrix3d symmetric_tensor(const double* entries) {
  const double* const I = entries;
  Eigen::Matrix3d out;
  out << I[0], I[1], I[2], I[1], I[3], I[4], I[2], I[4], I[5];
  return out;
}

namespace {

constexpr std::array<std::string_view, 6> joint_types = {"revolute", "continuous", "prismatic",
                                                         "fixed",    "floating",   "planar"};

std::vector<std::string> names(const std::vector<UrdfTopology::Link>& links) {
  std::vector<std::string> out;
  out.reserve(links.size());
  for (const UrdfTopology::Link& link : links) {
    out.push_back(link.name);
  }
  return out;
}

// Numbers elements by name and refuses a name that two of them have.
class Places {
 public:
  Places(const UrdfDocument& document, const char* kind) : document_(document), kind_(kind) {}

  void add(const std::string& name, pugi::xml_node node) {
    const auto [place, is_new] = places_.emplace(name, static_cast<int>(places_.size()));
    if (!is_new) {
      document_.refuse(node,
                       std::string("two ") + kind_ + "s are called \"" + name + "\"; names must differ");
    }
  }

  [[nodiscard]] std::optional<int> find(const std::string& name) const {
    const auto place = places_.find(name);
    return place == places_.end() ? std::nullopt : std::optional(place->second);
  }

 private:
  const UrdfDocument& document_;
  const char* kind_;
  std::map<std::string, int> places_;
};

int end_of(const UrdfDocument& document, pugi::xml_node joint, const char* end, const std::string& who,
           const Places& places, const UrdfTopology& tree) {
  const pugi::xml_node node = document.only_child(joint, end, who);
  if (!node) {
    document.refuse(joint, who + ": has no <" + end + ">");
  }
  const std::string name = document.text(node, "link", who);
  const std::optional<int> place = places.find(name);
  if (!place) {
    document.refuse(node, who + ": its " + end + " link \"" + name + "\" does not exist" +
                              did_you_mean(name, names(tree.links)));
  }
  return *place;
}

void check_tree(const UrdfDocument& document, UrdfTopology& tree) {
  std::vector<std::string> roots;
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    if (tree.links[i].parent < 0) {
      roots.push_back(tree.links[i].name);
      tree.root = static_cast<int>(i);
    }
  }
  if (roots.size() > 1) {
    document.refuse(document.robot(), "the links make " + std::to_string(roots.size()) +
                                          " separate trees, with the roots " + quoted_list(roots) +
                                          "; a URDF must have one root");
  }
  std::vector<bool> reached(tree.links.size(), false);
  std::vector<int> open;
  if (tree.root >= 0) {
    open.push_back(tree.root);
  }
  while (!open.empty()) {
    const int link = open.back();
    open.pop_back();
    reached[static_cast<std::size_t>(link)] = true;
    for (const int joint : tree.link(link).children) {
      open.push_back(tree.joint(joint).child);
    }
  }
  const auto lost = std::find(reached.begin(), reached.end(), false);
  if (lost != reached.end()) {
    const UrdfTopology::Link& link = tree.links[static_cast<std::size_t>(lost - reached.begin())];
    document.refuse(link.node, "link \"" + link.name + "\": its joints lead round in a cycle and to no root");
  }
}

int named_link(const UrdfDocument& document, const UrdfTopology& tree, const std::string& name,
               const std::string& option) {
  const std::vector<std::string> all = names(tree.links);
  const auto place = std::find(all.begin(), all.end(), name);
  if (place == all.end()) {
    throw InputError(document.source() + ": " + option + " is \"" + name + "\", but no link is called so" +
                     did_you_mean(name, all) + (all.size() > 1 ? " (links: " : " (link: ") +
                     quoted_list(all) + ")");
  }
  return static_cast<int>(place - all.begin());
}

// The joints from the base to a link; empty where the base does not carry it.
std::vector<int> way_to(const UrdfTopology& tree, int base, int link) {
  std::vector<int> out;
  while (link != base && tree.link(link).parent >= 0) {
    out.push_back(tree.link(link).parent);
    link = tree.joint(out.back()).parent;
  }
  std::ranges::reverse(out);
  return link == base ? out : std::vector<int>{};
}

// Every joint that moves by itself behind `base`, and those that are no joints of one axis, which are refused
// later.
std::vector<int> moving_joints(const UrdfTopology& tree, int base) {
  std::vector<int> out;
  for (int j = 0; j < static_cast<int>(tree.joints.size()); ++j) {
    const UrdfTopology::Joint& joint = tree.joint(j);
    if (joint.moves() && !joint.mimic() && !way_to(tree, base, joint.child).empty()) {
      out.push_back(j);
    }
  }
  return out;
}

// Those joints behind `base` that follow others, as stated, or as the file says of leaders that move.
void add_followers(const UrdfTopology& tree, int base, std::span<const DependentJoint> stated,
                   std::vector<int>& moving) {
  const auto moves = [&](const std::string& name) {
    return std::ranges::any_of(moving, [&](int j) { return tree.joint(j).name == name; });
  };
  for (bool more = true; std::exchange(more, false);) {
    for (int j = 0; j < static_cast<int>(tree.joints.size()); ++j) {
      const UrdfTopology::Joint& joint = tree.joint(j);
      const bool follows = std::ranges::find(stated, joint.name, &DependentJoint::joint) != stated.end() ||
                           (joint.mimic() && moves(joint.leader()));
      if (follows && joint.moves() && !moves(joint.name) && !way_to(tree, base, joint.child).empty()) {
        moving.push_back(j);
        more = true;
      }
    }
  }
}

int named_joint(const UrdfDocument& document, const UrdfTopology& tree, const std::string& name) {
  std::vector<std::string> all;
  for (const UrdfTopology::Joint& joint : tree.joints) {
    all.push_back(joint.name);
  }
  const auto place = std::ranges::find(all, name);
  if (place == all.end()) {
    throw InputError(document.source() + ": moving names \"" + name + "\", but no joint is called so" +
                     did_you_mean(name, all));
  }
  const UrdfTopology::Joint& joint = tree.joint(static_cast<int>(place - all.begin()));
  if (!joint.moves()) {
    document.refuse(joint.node, "joint \"" + name + "\": is fixed, but moving names it");
  }
  return static_cast<int>(place - all.begin());
}

// Joints that are marked, depth first in the order of the file.
std::vector<int> depth_first(const UrdfTopology& tree, int base, const std::vector<bool>& marked) {
  std::vector<int> out;
  std::vector<int> open = {base};
  while (!open.empty()) {
    const int link = open.back();
    open.pop_back();
    if (link != base) {
      out.push_back(tree.link(link).parent);
    }
    for (const int joint : tree.link(link).children | std::views::reverse) {
      if (marked[static_cast<std::size_t>(joint)]) {
        open.push_back(tree.joint(joint).child);
      }
    }
  }
  return out;
}

// Holds what moves on the way, but for these joints.
void hold_others(UrdfTopology& tree, const UrdfPath& path, const std::vector<int>& moving) {
  for (const int j : path.joints) {
    UrdfTopology::Joint& joint = tree.joints[static_cast<std::size_t>(j)];
    joint.held = joint.moves() && std::ranges::find(moving, j) == moving.end();
  }
}

// Holds joints of a chain that follow one beside it.
void hold_mimics(UrdfTopology& tree, std::span<const DependentJoint> stated, const UrdfPath& path) {
  std::vector<int> moving;
  std::ranges::copy_if(path.joints, std::back_inserter(moving),
                       [&](int j) { return tree.joint(j).moves() && !tree.joint(j).mimic(); });
  add_followers(tree, path.base, stated, moving);
  hold_others(tree, path, moving);
}

UrdfPath path_to_tip(const UrdfDocument& document, UrdfTopology& tree, int base, const UrdfOptions& options) {
  const int tip = named_link(document, tree, options.tip, "tip");
  UrdfPath path{base, way_to(tree, base, tip)};
  const std::string names_tip = "tip \"" + tree.link(tip).name + "\"";
  if (path.joints.empty() && tip != base) {
    std::vector<std::string> way;
    for (const int joint : way_to(tree, tree.root, tip)) {
      way.push_back(tree.link(tree.joint(joint).parent).name);
    }
    way.push_back(tree.link(tip).name);
    throw InputError(document.source() + ": base \"" + tree.link(base).name + "\" does not carry " +
                     names_tip + "; the way to the tip is " + quoted_list(way));
  }
  hold_mimics(tree, options.dependent, path);
  if (std::ranges::none_of(path.joints, [&](int joint) { return tree.joint(joint).moves(); })) {
    throw InputError(document.source() + ": no joint moves between base \"" + tree.link(base).name +
                     "\" and " + names_tip);
  }
  return path;
}

}  // namespace

UrdfTopology urdf_topology(const UrdfDocument& document) {
  UrdfTopology tree;
  const pugi::xml_node robot = document.robot();
  Places links(document, "link");
  for (const pugi::xml_node node : robot.children("link")) {
    const std::string name = document.text(node, "name", "a link");
    links.add(name, node);
    tree.links.push_back({name, node, -1, {}});
  }
  if (tree.links.empty()) {
    document.refuse(robot, "the robot has no <link>");
  }
  Places joints(document, "joint");
  for (const pugi::xml_node node : robot.children("joint")) {
    UrdfTopology::Joint joint;
    joint.name = document.text(node, "name", "a joint");
    joint.node = node;
    const std::string who = "joint \"" + joint.name + "\"";
    joints.add(joint.name, node);
    joint.type = document.text(node, "type", who);
    if (std::find(joint_types.begin(), joint_types.end(), joint.type) == joint_types.end()) {
      document.refuse(node,
                      who + ": type is \"" + joint.type +
                          "\", must be one of revolute, continuous, prismatic, fixed, floating, planar");
    }
    joint.parent = end_of(document, node, "parent", who, links, tree);
    joint.child = end_of(document, node, "child", who, links, tree);
    UrdfTopology::Link& child = tree.links[static_cast<std::size_t>(joint.child)];
    if (child.parent >= 0) {
      document.refuse(node, who + ": its child link \"" + child.name + "\" is already the child of joint \"" +
                                tree.joint(child.parent).name + "\"; a link must have one parent");
    }
    const auto place = static_cast<int>(tree.joints.size());
    child.parent = place;
    tree.links[static_cast<std::size_t>(joint.parent)].children.push_back(place);
    tree.joints.push_back(joint);
  }
  check_tree(document, tree);
  return tree;
}

UrdfPath urdf_path(const UrdfDocument& document, UrdfTopology& tree, const UrdfOptions& options) {
  const int base = options.base.empty() ? tree.root : named_link(document, tree, options.base, "base");
  if (!options.tip.empty()) {
    if (!options.moving.empty()) {
      throw InputError(document.source() + ": both tip and moving are given, must be one of them");
    }
    return path_to_tip(document, tree, base, options);
  }
  std::vector<int> moving;
  for (const std::string& name : options.moving) {
    moving.push_back(named_joint(document, tree, name));
  }
  if (moving.empty()) {
    moving = moving_joints(tree, base);
  }
  if (options.followers) {
    add_followers(tree, base, options.dependent, moving);
  }
  if (moving.empty()) {
    document.refuse(document.robot(), "no joint moves behind link \"" + tree.link(base).name + "\"");
  }
  std::vector<bool> marked(tree.joints.size(), false);
  for (const int joint : moving) {
    const std::vector<int> way = way_to(tree, base, tree.joint(joint).child);
    if (way.empty()) {
      throw InputError(document.source() + ": base \"" + tree.link(base).name + "\" does not carry joint \"" +
                       tree.joint(joint).name + "\"");
    }
    for (const int on_it : way) {
      marked[static_cast<std::size_t>(on_it)] = true;
    }
  }
  UrdfPath path{base, depth_first(tree, base, marked)};
  hold_others(tree, path, moving);
  return path;
}

}  // namespace rivid::detail
