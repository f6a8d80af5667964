#pragma once

#include <filesystem>

#include "rivid/model/robot.hpp"

namespace rivid::detail {

/// Robot of a modified Denavit-Hartenberg table in a CSV file with the header
/// `joint,type,alpha,a,d,theta` (names may go on: alpha_prev_rad, a_prev_m, d_m, theta_offset_rad), type R or P,
/// angles in radians, lengths in metres.
///
/// @throws InputError with file and line where the table can not be read
[[nodiscard]] Robot read_mdh(const std::filesystem::path& path, const Eigen::Vector3d& gravity);

}  // namespace rivid::detail
