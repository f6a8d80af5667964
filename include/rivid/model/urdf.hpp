#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/model/dependent.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// Which part of a URDF is the robot.
struct UrdfOptions {
  std::string base;  ///< link that stands still; empty: the root of the tree
  /// Link that a chain ends at; empty: the robot is all that moves behind `base`.
  std::string tip;
  /// The joints that move, instead of a tip, and with them those that follow them (mimic); all others are
  /// held at q = 0. Empty: every joint.
  std::vector<std::string> moving = {};
  /// Whether the root of the tree moves freely: the robot then begins with Robot::base_joints.
  bool floating = false;
  bool followers = true;  ///< whether joints that follow those of `moving` need not be named
  /// Joints that follow others beside the mimic joints of the file, or in place of what it says of these.
  std::vector<DependentJoint> dependent = {};
  std::vector<FourBar> four_bars = {};  ///< whose passive joints follow their cranks
  Eigen::Vector3d gravity = {0.0, 0.0,
                             -9.80665};  ///< acceleration of free fall in the base link's frame [m/s²]
};

/// The part of a URDF that a robot is, to read it again. What hangs behind its last moving links is lumped
/// into them, whatever tip it was read with.
[[nodiscard]] UrdfOptions same_part(const Robot& robot);

/// The robot in a URDF file: the chain from `base` to `tip` or a tree, depth first in the order of the file,
/// its limits, and the a-priori values of its inertial parameters and friction (`<dynamics damping friction>`
/// become Joint::Fv and Joint::Fc).
///
/// Standard parameters are given in the link frames of the URDF, see robot_from(const KDL::Chain&) for
/// oblique axes. Links behind fixed joints are lumped into the link that carries them, and so is what hangs
/// on joints that are not part of the robot, which are held at q = 0. A mimic joint whose leader moves is one
/// of Chain::dependents; any other is held. The file is checked before it is believed: what is
/// wrong is refused, what is only doubtful (a moving link without inertial, a physically inconsistent
/// inertia, joints without limits, joints that are held, `<transmission>`) is reported in Robot::warnings.
///
/// @throws InputError  with file and line: not readable, not XML, not a URDF, an unexpanded xacro file; a
///                     number that is none; a negative mass, an inertia that is missing, not positive
///                     semidefinite or without mass; an axis of zeros; floating or planar joints that should
///                     move; what with_dependents() refuses; limits the wrong way round;
///                     links and joints that do not make a tree; an unknown base, tip or joint
[[nodiscard]] Robot read_urdf(const std::filesystem::path& path, const UrdfOptions& options = {});

/// The same from a text.
///
/// @param source  what the text is called in messages, such as a file's name
[[nodiscard]] Robot parse_urdf(std::string_view xml, const std::string& source,
                               const UrdfOptions& options = {});

}  // namespace rivid
