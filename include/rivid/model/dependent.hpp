#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// A joint that follows others, as a description names them:
///
///   q = offset + Σ factor q_k
///
/// A mimic joint of a URDF is one. A parallelogram is a tree whose loop is cut at one joint: its passive
/// joints are such sums of the driven ones, and no parameter of the loop is lost.
struct DependentJoint {
  std::string joint;
  std::map<std::string, double> of = {};  ///< factors by the names of the joints that it follows
  double offset = 0.0;                    ///< [rad | m]
  /// How it follows the joints of `of`, in the order of their names, where it is no sum of them: the only one
  /// in a four-bar linkage, see with_four_bars(), or by a table, see spline_through().
  std::optional<Curve> curve = {};

  template <typename D = DependentJoint>
  static constexpr auto fields() {
    constexpr std::string_view named =
        "must name a joint and those that it follows: { joint = \"joint_3\", of = { joint_2 = -1 } }";
    return std::tuple(
        Field{"joint", &D::joint, "joint that follows others", {.required = named}},
        Field{"of",
              &D::of,
              "factors of the joints that it follows: `{ joint_2 = -1, joint_3 = 1 }`",
              {.otherwise = "those of `table`", .unit = "unit of the joint per unit of the other"}},
        Field{"offset", &D::offset, "position where the others are at 0", {.unit = "rad or m"}},
        Field{"table",
              Key<std::filesystem::path>(),
              "instead of a sum: text file with positions of the joint and of one to three others",
              {.otherwise = "–", .unit = "rad or m"}},
        Field{"columns",
              Key<std::vector<std::string>>(),
              "of `table`: columns of the joint, then of those of `of` in the order of their names",
              {.otherwise = "the names of the joints"}});
  }
};

/// A planar four-bar linkage that the tree of the robot has cut at the axis between coupler and rocker.
/// Lengths and angles are those of the description: the crank turns the joint `crank`, the coupler hangs on
/// the crank, and the rocker on what carries the crank. The passive joints of coupler and rocker follow the
/// crank.
struct FourBar {
  std::string crank, coupler, rocker;            ///< joints, revolute, of parallel axes
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< closing point in the frame of the rocker's link [m]

  template <typename B = FourBar>
  static constexpr auto fields() {
    constexpr std::string_view named =
        "must name crank, coupler, rocker and at: { crank = \"joint_2\", coupler = \"link_a\", rocker = "
        "\"link_b\", at = [0.1, 0, 0] }";
    return std::tuple(
        Field{"crank", &B::crank, "driven joint", {.required = named}},
        Field{"coupler", &B::coupler, "passive joint that hangs on the crank", {.required = named}},
        Field{"rocker", &B::rocker, "passive joint beside the crank", {.required = named}},
        Field{"at",
              &B::at,
              "where coupler and rocker are joined, with all joints at 0, in the frame of the rocker's link",
              {.unit = "m", .required = named}});
  }
};

/// The spline through points, by least squares. Where there are none it goes on smoothly.
///
/// @param q   positions of the joints that are followed, (points × d)
/// @param of  the positions that they lead to, (points)
/// @throws InputError  no numbers; few points; none, or more than JointSpline::most_joints to follow; a joint
///                     that does not move; points that are on no such spline to a hundredth of their range
[[nodiscard]] JointSpline spline_through(const Eigen::Ref<const Matrix>& q,
                                         const Eigen::Ref<const Vector>& of);

/// The passive joints of linkages, of which `dependents` may name some, as joints that follow their cranks.
///
/// @param robot  before with_dependents()
/// @throws InputError  a joint that is none of the robot, is not revolute or out of place; axes that are not
///                     parallel; a linkage that can not be closed where its crank's joint is at 0, or
///                     is stretched there
[[nodiscard]] std::vector<DependentJoint> with_four_bars(const Robot& robot,
                                                         std::span<const FourBar> four_bars,
                                                         std::vector<DependentJoint> dependents = {});

/// The same robot with these joints as Chain::dependents: its joints are the others, and torques,
/// positions and options are of these alone. One that follows a dependent joint follows what that one
/// follows. Friction, rotor inertia and limits of a dependent joint are no part of the robot.
///
/// @throws InputError  a joint that is named twice, is none of the robot or, in the end, follows itself; a
///                     factor of zero; no joint left
[[nodiscard]] Robot with_dependents(Robot robot, std::span<const DependentJoint> dependents);

/// The dependent joints of a robot by their names.
[[nodiscard]] std::vector<DependentJoint> dependent_joints(const Robot& robot);

}  // namespace rivid
