#include "rivid/model/urdf.hpp"

#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <kdl/tree.hpp>
#include <limits>
#include <set>
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

}  // namespace

UrdfOptions same_part(const Robot& robot) {
  UrdfOptions out{.base = robot.base,
                  .tip = {},
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

Robot parse_urdf(std::string_view xml, const std::string& source, const UrdfOptions& options) {
  const detail::UrdfDocument document(xml, source);
  const detail::CheckedUrdf checked = detail::checked_urdf(document, options);
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(checked.xml);
  if (!model) {
    throw InputError(source + ": urdfdom refuses this URDF");
  }
  Robot robot = [&] {
    try {
      return with_dependents(robot_from(lumped_tree(kdl_tree(*model), checked), options.gravity),
                             checked.dependent);
    } catch (const InputError& e) {
      throw InputError(source + ": " + e.what());
    }
  }();
  robot.name = model->getName();
  robot.base = checked.base;
  for (Joint& joint : robot.joints) {
    take_limits_and_friction(joint, *model->getJoint(joint.name));
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
