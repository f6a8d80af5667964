#include "rivid/model/urdf.hpp"

#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <kdl/tree.hpp>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/model/kdl.hpp"
#include "urdf_document.hpp"

namespace rivid {

namespace {

KDL::Vector kdl(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

KDL::Frame kdl(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  return {KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w), kdl(pose.position)};
}

// The joint stands at the root of KDL's segment, and so does the tip frame: it is the URDF's link frame.
KDL::Joint kdl_joint(const urdf::Joint& joint, const KDL::Frame& tip) {
  using Type = KDL::Joint::JointType;
  if (joint.type == urdf::Joint::FIXED) {
    return KDL::Joint(joint.name, Type::Fixed);
  }
  const Type type = joint.type == urdf::Joint::PRISMATIC ? Type::TransAxis : Type::RotAxis;
  const double damping = joint.dynamics ? joint.dynamics->damping : 0.0;
  return {joint.name, tip.p, tip.M * kdl(joint.axis), type, 1.0, 0.0, 0.0, damping};
}

KDL::RigidBodyInertia kdl_inertia(const urdf::Link& link) {
  if (!link.inertial) {
    return KDL::RigidBodyInertia::Zero();
  }
  const urdf::Inertial& in = *link.inertial;
  const KDL::Frame origin = kdl(in.origin);
  const KDL::RigidBodyInertia at_com(in.mass, KDL::Vector::Zero(),
                                     KDL::RotationalInertia(in.ixx, in.iyy, in.izz, in.ixy, in.ixz, in.iyz));
  return origin * at_com;
}

KDL::Tree kdl_tree(const urdf::ModelInterface& model) {
  KDL::Tree tree(model.getRoot()->name);
  std::vector<urdf::LinkConstSharedPtr> open = {model.getRoot()};
  while (!open.empty()) {
    const urdf::LinkConstSharedPtr parent = open.back();
    open.pop_back();
    for (const urdf::LinkSharedPtr& link : parent->child_links) {
      const KDL::Frame tip = kdl(link->parent_joint->parent_to_joint_origin_transform);
      tree.addSegment(KDL::Segment(link->name, kdl_joint(*link->parent_joint, tip), tip, kdl_inertia(*link)),
                      parent->name);
      open.push_back(link);
    }
  }
  return tree;
}

// Inertia of everything that hangs on a link, except behind links of the robot, all joints at zero.
KDL::RigidBodyInertia branches(const KDL::TreeElement& element, const std::set<std::string>& links) {
  KDL::RigidBodyInertia sum = KDL::RigidBodyInertia::Zero();
  std::vector<std::pair<const KDL::TreeElement*, KDL::Frame>> open = {{&element, KDL::Frame::Identity()}};
  while (!open.empty()) {
    const auto [parent, pose] = open.back();
    open.pop_back();
    for (const auto& child : parent->children) {
      if (!links.contains(child->first)) {
        const KDL::Segment& segment = child->second.segment;
        const KDL::Frame tip = pose * segment.getFrameToTip();
        sum = sum + tip * segment.getInertia();
        open.emplace_back(&child->second, tip);
      }
    }
  }
  return sum;
}

// The links of the robot alone, what else hangs on them lumped into them.
KDL::Tree lumped_tree(const KDL::Tree& tree, const detail::CheckedUrdf& checked) {
  const std::set<std::string> links(checked.links.begin(), checked.links.end());
  KDL::Tree out(checked.base);
  for (const std::string& link : checked.links) {
    const KDL::TreeElement& element = tree.getSegment(link)->second;
    KDL::Segment segment = element.segment;
    segment.setInertia(segment.getInertia() + branches(element, links));
    out.addSegment(segment, element.parent->first);
  }
  return out;
}

double limit(double value) {
  return std::abs(value) < detail::urdf_unlimited
             ? value
             : std::copysign(std::numeric_limits<double>::infinity(), value);
}

void take_limits_and_friction(Joint& joint, const urdf::Joint& from) {
  if (from.limits) {
    joint.lower = limit(from.limits->lower);
    joint.upper = limit(from.limits->upper);
    joint.max_velocity = limit(from.limits->velocity);
    joint.max_effort = limit(from.limits->effort);
  }
  if (from.dynamics) {
    joint.Fc = from.dynamics->friction;
  }
}

// Name, kind and axis of Robot::base_joints.
struct BaseJoint {
  std::string_view name;
  std::string_view type;
  std::string_view axis;
};
constexpr std::array base_joints = {
    BaseJoint{"base_x", "prismatic", "1 0 0"},      BaseJoint{"base_y", "prismatic", "0 1 0"},
    BaseJoint{"base_z", "prismatic", "0 0 1"},      BaseJoint{"base_yaw", "continuous", "0 0 1"},
    BaseJoint{"base_pitch", "continuous", "0 1 0"}, BaseJoint{"base_roll", "continuous", "1 0 0"}};

// Of [robot] moving, with the joints of a floating base.
UrdfOptions with_base_joints(UrdfOptions options) {
  const bool named = std::ranges::find(options.moving, base_joints.front().name) != options.moving.end();
  if (options.floating && !options.moving.empty() && !named) {
    for (const BaseJoint& joint : base_joints) {
      options.moving.emplace_back(joint.name);
    }
  }
  return options;
}

void free_base(Robot& robot) {
  robot.base_joints = std::ssize(base_joints);
  for (Joint& joint : std::span(robot.joints).first(base_joints.size())) {
    joint = {.name = joint.name,
             .link = joint.link,
             .type = joint.type,
             .friction = Friction::none,
             .rotor_inertia = false};
  }
}

}  // namespace

std::string detail::floating_joints(const UrdfDocument& document) {
  const UrdfTopology tree = urdf_topology(document);
  std::string out = "<link name=\"world_of_base\"/>";
  std::string parent = "world_of_base";
  for (const BaseJoint& joint : base_joints) {
    const bool last = joint.name == base_joints.back().name;
    const std::string child(last ? tree.link(tree.root).name : joint.name);
    if (!last) {  // a mass of zero is no forgotten one
      out.append("<link name=\"").append(child);
      out.append(
          "\"><inertial><mass value=\"0\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" "
          "izz=\"0\"/>");
      out.append("</inertial></link>");
    }
    out.append("<joint name=\"").append(joint.name).append("\" type=\"").append(joint.type);
    out.append("\"><parent link=\"").append(parent).append("\"/><child link=\"").append(child);
    out.append("\"/><axis xyz=\"").append(joint.axis);
    out.append("\"/><limit lower=\"-1e6\" upper=\"1e6\" velocity=\"1e6\" effort=\"1e6\"/></joint>");
    parent = child;
  }
  return out;
}

std::string detail::with_floating_joints(std::string_view xml, const std::string& source) {
  std::string out(xml);
  const std::string joints = floating_joints(UrdfDocument(xml, source));
  return out.insert(xml.rfind("</"), joints);
}

UrdfOptions same_part(const Robot& robot) {
  const bool floating = robot.base_joints > 0;
  UrdfOptions out{.base = floating ? "" : robot.base,
                  .tip = {},
                  .floating = floating,
                  .followers = false,
                  .dependent = dependent_joints(robot),
                  .gravity = robot.chain.gravity};
  for (const Joint& joint : robot.joints) {
    out.moving.push_back(joint.name);
  }
  for (const Chain::Dependent& dependent : robot.chain.dependents) {
    out.moving.push_back(dependent.joint);
  }
  return out;
}

Robot parse_urdf(std::string_view text, const std::string& source, const UrdfOptions& asked) {
  UrdfOptions options = with_base_joints(asked);
  for (const FourBar& bar : options.four_bars) {
    for (const std::string& joint : {bar.coupler, bar.rocker}) {
      options.dependent.push_back({.joint = joint, .of = {{bar.crank, 1.0}}});
    }
  }
  if (options.floating && !options.base.empty()) {
    throw InputError(source + ": base is given for a floating base, which is the root of the tree");
  }
  const std::string xml = options.floating ? detail::with_floating_joints(text, source) : std::string(text);
  const detail::UrdfDocument document(xml, source);
  const detail::CheckedUrdf checked = detail::checked_urdf(document, options);
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(checked.xml);
  if (!model) {
    throw InputError(source + ": urdfdom refuses this URDF");
  }
  Robot robot = [&] {
    try {
      const Robot tree = robot_from(lumped_tree(kdl_tree(*model), checked), options.gravity);
      return with_dependents(tree, with_four_bars(tree, options.four_bars, checked.dependent));
    } catch (const InputError& e) {
      throw InputError(source + ": " + e.what());
    }
  }();
  robot.name = model->getName();
  robot.base = checked.base;
  for (Joint& joint : robot.joints) {
    take_limits_and_friction(joint, *model->getJoint(joint.name));
  }
  if (options.floating) {
    free_base(robot);
  }
  for (Finding& warning : robot.warnings) {
    warning.text.insert(0, source + ": ");
  }
  robot.warnings.insert(robot.warnings.begin(), checked.warnings.begin(), checked.warnings.end());
  return robot;
}

Robot read_urdf(const std::filesystem::path& path, const UrdfOptions& options) {
  refuse_larger(path, robot_limit);
  return parse_urdf(read_input(path).bytes(), path.string(), options);
}

}  // namespace rivid
