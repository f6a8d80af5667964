#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

namespace rivid::detail {

/// Where a mesh is that a URDF in `folder` names: there, or of a package in one of the folders above.
[[nodiscard]] std::optional<std::filesystem::path> found_mesh(const std::string& name,
                                                              const std::filesystem::path& folder);

/// The points that the surface of a mesh passes through, one a column, in the unit of the file; of DAE in
/// metres, placed as its scene says, without a turn by its `up_axis` as ROS does.
///
/// @throws InputError  with the file: not readable, larger than mesh_limit, no STL, OBJ or DAE, without
///                     points
[[nodiscard]] Eigen::Matrix3Xd read_mesh(const std::filesystem::path& path);

}  // namespace rivid::detail
