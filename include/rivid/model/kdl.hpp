#pragma once

#include <kdl/chain.hpp>
#include <kdl/tree.hpp>

#include "rivid/model/robot.hpp"

namespace rivid {

/// The robot that a KDL chain describes.
///
/// A fixed segment is lumped into the moving link before it; before the first moving joint only its transform
/// counts. The standard parameters of a moving link are given in
///   - the tip frame of its segment, where the joint's axis passes through its origin (always so for a URDF
///     and for a prismatic joint) and is ±x, ±y or ±z of it;
///   - a frame at that origin that is turned to have z along the axis, where the axis is oblique in the tip
///     frame;
///   - the joint's frame (origin at the joint's origin, axes of the segment's root at q = 0), where a
///     revolute axis misses the tip, as in Denavit-Hartenberg segments; turned as above if the axis is
///     oblique there too.
/// Robot::warnings says where it is not the first. An axis within 1e-9 rad of a coordinate axis counts as
/// that axis. The joint's inertia becomes Joint::Ia and its damping Joint::Fv; its stiffness is ignored with
/// a warning; its offset needs no care, since KDL itself takes it out of the segment's pose. Names that KDL
/// leaves at "NoName" become "joint_1", "link_1", …
///
/// @param chain    any chain of fixed, rotational and translational joints; KDL keeps poses inside its
///                 joints, so no other thread may use it meanwhile
/// @param gravity  acceleration of free fall in the chain's base frame [m/s²]
/// @throws InputError  no moving joint; an axis that is zero or not a number; a frame or inertia that is not
///                     finite; a scale other than 1
[[nodiscard]] Robot robot_from(const KDL::Chain& chain,
                               const Eigen::Vector3d& gravity = {0.0, 0.0, -9.80665});

/// The robot that a KDL tree describes, which stands on its root: the same, branch by branch, depth first in
/// the order in which segments were added to each other.
[[nodiscard]] Robot robot_from(const KDL::Tree& tree, const Eigen::Vector3d& gravity = {0.0, 0.0, -9.80665});

/// The robot as a KDL chain, one segment a joint, whose tip frames are the link frames of the standard
/// parameters; the inverse of robot_from().
///
/// KDL's solvers know rotor inertia but no friction: Ia and Fv are handed over as inertia and damping of the
/// joint. Coulomb friction, offset and the couplings of motors have no place in KDL, and its recursive
/// Newton-Euler ignores the damping.
///
/// @param chi_st  values of Robot::standard_parameters(), (N_s) [SI, joint side]; any values, a body without
///                mass may have first moments
/// @throws InputError  the robot's complaint(), a robot that branches, or a wrong number of values
[[nodiscard]] KDL::Chain kdl_chain(const Robot& robot, const Eigen::Ref<const Vector>& chi_st);

/// The same with the robot's a-priori values.
[[nodiscard]] KDL::Chain kdl_chain(const Robot& robot);

}  // namespace rivid
