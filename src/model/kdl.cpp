#include "rivid/model/kdl.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <ranges>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "model/urdf_document.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

constexpr double axis_tolerance = 1e-9;      // rad, and m for an axis that should pass through a point
constexpr double rotation_tolerance = 1e-6;  // frames written with few digits are still rotations

Eigen::Vector3d eigen(const KDL::Vector& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Isometry3d eigen(const KDL::Frame& frame) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.translation() = eigen(frame.p);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      out(row, column) = frame.M(row, column);
    }
  }
  return out;
}

KDL::Vector kdl_vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Rotation kdl_rotation(const Eigen::Matrix3d& R) {
  return {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)};
}

KDL::RotationalInertia rotational(const Eigen::Matrix3d& I) {
  return KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
}

Inertial inertial_of(const KDL::RigidBodyInertia& body) {
  // KDL shows the first moments h only divided by the mass; the angular momentum h × v of a translation shows
  // them as they are, also where the mass is zero.
  const KDL::Vector hx = (body * KDL::Twist(KDL::Vector(1, 0, 0), KDL::Vector::Zero())).torque;
  const KDL::Vector hy = (body * KDL::Twist(KDL::Vector(0, 1, 0), KDL::Vector::Zero())).torque;
  const KDL::RotationalInertia I = body.getRotationalInertia();
  Inertial out;
  out << I.data[0], I.data[1], I.data[2], I.data[4], I.data[5], I.data[8], hy.z(), -hx.z(), hx.y(),
      body.getMass();
  return out;
}

KDL::RigidBodyInertia rigid_body(const Inertial& inertial) {
  const Eigen::Matrix3d I = detail::symmetric_tensor(inertial.data());
  const Eigen::Vector3d h = inertial.segment<3>(6);
  const double m = inertial[9];
  const auto about_com = [&](double mass, const Eigen::Vector3d& com) -> Eigen::Matrix3d {
    return I - mass * (com.squaredNorm() * Eigen::Matrix3d::Identity() - com * com.transpose());
  };
  if (h.isZero(0.0) || (m > 0.0 && 2.0 * h.squaredNorm() <= m * I.trace())) {
    const Eigen::Vector3d com = h.isZero(0.0) ? Eigen::Vector3d::Zero() : Eigen::Vector3d(h / m);
    return KDL::RigidBodyInertia(m, kdl_vector(com), rotational(about_com(m, com)));
  }
  // No physical body has these parameters, and h / m may not exist: a unit mass carries h, and a body at the
  // origin the rest of the mass.
  return KDL::RigidBodyInertia(1.0, kdl_vector(h), rotational(about_com(1.0, h))) +
         KDL::RigidBodyInertia(m - 1.0, KDL::Vector::Zero(), KDL::RotationalInertia::Zero());
}

// The frame of the standard parameters of a moving link.
struct LinkFrame {
  Eigen::Isometry3d in_root = Eigen::Isometry3d::Identity();  // in the segment's root at q = 0
  Eigen::Isometry3d tip = Eigen::Isometry3d::Identity();      // the segment's tip in the link frame
  std::array<int, 3> axes = {0, 1, 2};
  std::array<int, 3> signs = {1, 1, 1};
  std::string warning;
};

// Lays z of frame j along `axis` of the link frame by renaming axes; false if `axis` is none of ±x, ±y, ±z.
bool rename_axes(LinkFrame& frame, const Eigen::Vector3d& axis) {
  Index along = 0;
  axis.cwiseAbs().maxCoeff(&along);
  Eigen::Vector3d rest = axis;
  rest[along] = 0.0;
  if (rest.norm() > axis_tolerance) {
    return false;
  }
  const auto z = static_cast<std::size_t>(along);
  const std::size_t x = (z + 1) % 3;
  const std::size_t y = (z + 2) % 3;
  frame.axes[x] = 0;
  frame.axes[y] = 1;
  frame.axes[z] = 2;
  frame.signs[y] = frame.signs[z] = axis[along] < 0.0 ? -1 : 1;
  return true;
}

// A rotation whose z axis is the given unit vector.
Eigen::Matrix3d with_z_along(const Eigen::Vector3d& axis) {
  Index least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d x = (Eigen::Vector3d::Unit(least) - axis[least] * axis).normalized();
  Eigen::Matrix3d R;
  R << x, axis.cross(x), axis;
  return R;
}

std::string text(const Eigen::Vector3d& v) {
  std::ostringstream out;
  for (Index i = 0; i < 3; ++i) {
    out << (i == 0 ? "(" : ", ");
    if (std::isnan(v[i])) {
      out << "nan";  // the stream would print its sign as well
    } else {
      out << v[i];
    }
  }
  out << ')';
  return out.str();
}

LinkFrame link_frame(const Eigen::Isometry3d& tip, const Eigen::Vector3d& origin, const Eigen::Vector3d& axis,
                     JointType type, const std::string& who) {
  const double distance = (tip.translation() - origin).cross(axis).norm();
  LinkFrame frame;
  if (type == JointType::prismatic || distance <= axis_tolerance) {
    frame.in_root = tip;
  } else {
    frame.in_root.translation() = origin;
    frame.tip = frame.in_root.inverse() * tip;
    frame.warning = who +
                    "the tip of its segment is off the joint's axis; the parameters of its link are given " +
                    "in a frame at the joint's origin with the axes of the segment's root";
  }
  const Eigen::Vector3d local_axis = (frame.in_root.linear().transpose() * axis).normalized();
  if (!rename_axes(frame, local_axis)) {
    const Eigen::Matrix3d R = with_z_along(local_axis);
    frame.in_root.linear() = frame.in_root.linear() * R;
    frame.tip = Eigen::Isometry3d(R.transpose()) * frame.tip;
    frame.warning = who + "its axis " + text(local_axis) +
                    " is oblique in the link frame; the parameters of its " +
                    "link are given in a frame with the same origin that is turned to have z along the axis";
  }
  return frame;
}

std::string name_or(const std::string& name, const char* fallback, std::size_t number) {
  return name.empty() || name == "NoName" ? fallback + std::to_string(number) : name;
}

Eigen::Isometry3d checked_tip(const KDL::Segment& segment, const std::string& who) {
  Eigen::Isometry3d tip = eigen(segment.getFrameToTip());
  const Eigen::Matrix3d R = tip.linear();
  const bool is_rotation = (R.transpose() * R).isIdentity(rotation_tolerance) && R.determinant() > 0.0;
  if (!is_rotation || !tip.translation().allFinite()) {
    throw InputError(who + "the frame of its tip is not a finite rotation and translation");
  }
  return tip;
}

// Unit vector of a moving joint, in the segment's root.
Eigen::Vector3d checked_axis(const KDL::Joint& joint, JointType type, const std::string& who) {
  const Eigen::Vector3d axis = eigen(joint.JointAxis());
  const Eigen::Vector3d origin = eigen(joint.JointOrigin());
  if (!axis.allFinite() || std::abs(axis.norm() - 1.0) > rotation_tolerance || !origin.allFinite()) {
    throw InputError(who + "its axis is " + text(axis) + " at " + text(origin) +
                     ", must be finite and of unit length (KDL turns an axis of zeros into nan)");
  }
  // KDL does not show the scale, but the twist at unit velocity carries it.
  const KDL::Twist twist = joint.twist(1.0);
  const double scale = eigen(type == JointType::revolute ? twist.rot : twist.vel).dot(axis);
  if (std::abs(scale - 1.0) > rotation_tolerance) {
    throw InputError(who + "its scale is " + std::to_string(scale) +
                     ", must be 1; give a gear as gear_ratio and turn a negative axis round");
  }
  return axis;
}

bool is_revolute(KDL::Joint::JointType type) {
  return type == KDL::Joint::RotAxis || type == KDL::Joint::RotX || type == KDL::Joint::RotY ||
         type == KDL::Joint::RotZ;
}

// Adds segments to a robot, each behind one that has been added.
class RobotBuilder {
 public:
  // Where what hangs on a segment begins.
  struct Place {
    int link = -1;                                           // the last moving link, −1 for the base
    Eigen::Isometry3d root = Eigen::Isometry3d::Identity();  // of the next segment in that link
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();      // of its frame j in the link frame
  };

  explicit RobotBuilder(const Eigen::Vector3d& gravity) { robot_.chain.gravity = gravity; }

  Place add(const KDL::Segment& segment, Place place);

  [[nodiscard]] Robot robot() && {
    if (!robot_.chain.branches()) {
      robot_.chain.parents.clear();
    }
    if (const auto fault = robot_.complaint()) {
      throw InputError("robot_from: " + *fault);
    }
    return std::move(robot_);
  }

 private:
  Robot robot_;
};

RobotBuilder::Place RobotBuilder::add(const KDL::Segment& segment, Place place) {
  const KDL::Joint& kdl_joint = segment.getJoint();
  const std::string segment_who = "robot_from: segment \"" + segment.getName() + "\": ";
  const Inertial inertial = inertial_of(segment.getInertia());
  if (!inertial.allFinite()) {
    throw InputError(segment_who + "its inertia is not finite");
  }

  if (kdl_joint.getType() == KDL::Joint::Fixed) {
    place.root = place.root * checked_tip(segment, segment_who);
    if (place.link >= 0) {
      robot_.inertials[static_cast<std::size_t>(place.link)] +=
          transformed(inertial, place.root.linear(), place.root.translation());
    }
    return place;
  }

  Joint joint;
  joint.name = name_or(kdl_joint.getName(), "joint_", robot_.joints.size() + 1);
  joint.link = name_or(segment.getName(), "link_", robot_.joints.size() + 1);
  joint.type = is_revolute(kdl_joint.getType()) ? JointType::revolute : JointType::prismatic;
  joint.Ia = kdl_joint.getInertia();
  joint.Fv = kdl_joint.getDamping();
  const std::string who = "joint \"" + joint.name + "\": ";
  const Eigen::Vector3d axis = checked_axis(kdl_joint, joint.type, "robot_from: " + who);
  if (!std::isfinite(joint.Ia) || !std::isfinite(joint.Fv)) {
    throw InputError("robot_from: " + who + "its inertia or damping is not finite");
  }
  if (kdl_joint.getStiffness() != 0.0) {
    robot_.warnings.push_back(
        Finding{"robot_doubt", {}, who + "its stiffness is ignored: joints are rigid here"});
  }

  // After the axis, since an axis of zeros spoils the tip as well.
  const Eigen::Isometry3d tip = checked_tip(segment, segment_who);
  const LinkFrame frame = link_frame(tip, eigen(kdl_joint.JointOrigin()), axis, joint.type, who);
  if (!frame.warning.empty()) {
    robot_.warnings.push_back(Finding{"robot_doubt", {}, frame.warning});
  }
  Chain::Link link;
  link.type = joint.type;
  link.axes = frame.axes;
  link.signs = frame.signs;
  const Eigen::Isometry3d pose = place.root * frame.in_root;
  link.R = place.axes.transpose() * pose.linear() * link_axes(link);
  link.p = place.axes.transpose() * pose.translation();

  robot_.chain.links.push_back(link);
  robot_.chain.parents.push_back(place.link);
  robot_.joints.push_back(joint);
  robot_.inertials.push_back(transformed(inertial, frame.tip.linear(), frame.tip.translation()));
  return {static_cast<int>(robot_.joints.size()) - 1, frame.tip, link_axes(link)};
}

}  // namespace

Robot robot_from(const KDL::Chain& chain, const Eigen::Vector3d& gravity) {
  RobotBuilder builder(gravity);
  RobotBuilder::Place place;
  for (unsigned int s = 0; s < chain.getNrOfSegments(); ++s) {
    place = builder.add(chain.getSegment(s), place);
  }
  return std::move(builder).robot();
}

Robot robot_from(const KDL::Tree& tree, const Eigen::Vector3d& gravity) {
  RobotBuilder builder(gravity);
  std::vector<std::pair<KDL::SegmentMap::const_iterator, RobotBuilder::Place>> open;
  const auto open_behind = [&](const KDL::TreeElement& element, const RobotBuilder::Place& place) {
    for (const auto& child : element.children | std::views::reverse) {
      open.emplace_back(child, place);
    }
  };
  open_behind(tree.getRootSegment()->second, {});
  while (!open.empty()) {
    const auto [segment, place] = open.back();
    open.pop_back();
    open_behind(segment->second, builder.add(segment->second.segment, place));
  }
  return std::move(builder).robot();
}

KDL::Chain kdl_chain(const Robot& robot, const Eigen::Ref<const Vector>& chi_st) {
  if (const auto fault = robot.complaint()) {
    throw InputError("kdl_chain: " + *fault);
  }
  require_chain("kdl_chain", robot.chain);
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  if (chi_st.size() != static_cast<Index>(parameters.size())) {
    throw InputError("kdl_chain: chi_st has " + std::to_string(chi_st.size()) + " values, the robot has " +
                     std::to_string(parameters.size()) + " standard parameters");
  }
  struct Values {
    Inertial inertial = Inertial::Zero();
    double Ia = 0.0;
    double Fv = 0.0;
  };
  std::vector<Values> values(robot.joints.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    Values& link = values[static_cast<std::size_t>(parameters[i].joint)];
    const double value = chi_st[static_cast<Index>(i)];
    const auto kind = static_cast<Index>(parameters[i].kind);
    if (kind < inertial_count) {
      link.inertial[kind] = value;
    } else if (parameters[i].kind == ParameterKind::Ia) {
      link.Ia = value;
    } else if (parameters[i].kind == ParameterKind::Fv) {
      link.Fv = value;
    }
  }

  KDL::Chain out;
  Eigen::Matrix3d previous = Eigen::Matrix3d::Identity();
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Chain::Link& link = robot.chain.links[j];
    const Eigen::Matrix3d axes = link_axes(link);
    const KDL::Vector origin = kdl_vector(previous * link.p);
    const KDL::Vector axis = kdl_vector(previous * link.R.col(2));
    const auto type = link.type == JointType::revolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
    const KDL::Joint joint(robot.joints[j].name, origin, axis, type, 1.0, 0.0, values[j].Ia, values[j].Fv);
    const KDL::Frame tip(kdl_rotation(previous * link.R * axes.transpose()), origin);
    out.addSegment(KDL::Segment(robot.joints[j].link, joint, tip, rigid_body(values[j].inertial)));
    previous = axes;
  }
  return out;
}

KDL::Chain kdl_chain(const Robot& robot) { return kdl_chain(robot, robot.chi_st()); }

}  // namespace rivid
