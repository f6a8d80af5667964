#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "rivid/model/robot.hpp"

namespace rivid {

/// Which chain of a URDF is the robot.
struct UrdfOptions {
  std::string base;  ///< link that stands still; empty: the root of the tree
  /// Link that the chain ends at; empty: the only link that has a moving joint before it and none behind it.
  std::string tip;
  Eigen::Vector3d gravity = {0.0, 0.0,
                             -9.80665};  ///< acceleration of free fall in the base link's frame [m/s²]
};

/// The serial robot in a URDF file: the chain from `base` to `tip`, its limits, and the a-priori values of
/// its inertial parameters and friction (`<dynamics damping friction>` become Joint::Fv and Joint::Fc).
///
/// Standard parameters are given in the link frames of the URDF, see robot_from(const KDL::Chain&) for
/// oblique axes. Links behind fixed joints are lumped into the link that carries them, and so are branches
/// off the chain, with their moving joints held at q = 0. The file is checked before it is believed: what is
/// wrong is refused, what is only doubtful (a moving link without inertial, a physically inconsistent
/// inertia, joints without limits, moving branches, `<transmission>`) is reported in Robot::warnings.
///
/// @throws InputError  with file and line: not readable, not XML, not a URDF, an unexpanded xacro file; a
///                     number that is none; a negative mass, an inertia that is missing, not positive
///                     semidefinite or without mass; an axis of zeros; floating, planar or mimic joints on
///                     the chain; limits the wrong way round; links and joints that do not make a tree; an
///                     unknown or ambiguous base or tip
[[nodiscard]] Robot read_urdf(const std::filesystem::path& path, const UrdfOptions& options = {});

/// The same from a text.
///
/// @param source  what the text is called in messages, such as a file's name
[[nodiscard]] Robot parse_urdf(std::string_view xml, const std::string& source,
                               const UrdfOptions& options = {});

}  // namespace rivid
