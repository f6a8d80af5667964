#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rivid/finding.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// A convex body of a link: all points within a radius of the convex hull of some.
struct Hull {
  std::string link;         ///< that it is fixed to
  Eigen::Matrix3Xd points;  ///< in the link's frame, one a column [m]
  double radius = 0.0;      ///< [m]
  bool is_assumed =
      false;  ///< the link has no shape: origins of its frames, and the radius is anyone's guess
};

/// Bodies of the links of a robot.
struct CollisionModel {
  std::vector<Hull> hulls;                    ///< of each link one or more
  std::vector<std::filesystem::path> meshes;  ///< files that were read
  std::vector<Finding> findings;              ///< what is not as the description says
};

/// Largest file of a mesh [bytes].
inline constexpr std::uintmax_t mesh_limit = std::uintmax_t{64} << 20U;

/// The `<collision>` of a URDF, each as one convex body: boxes, cylinders, spheres, and the convex hull of a
/// mesh (STL, OBJ, DAE). What moves with a link of the robot, as a tool behind fixed joints or a branch held
/// at q = 0, is part of that link. A hull of many points is one of at most 128, and a radius that encloses
/// all others; a cylinder is a prism with a radius of 0.5 % of its own that encloses it.
///
/// The file of a mesh is looked for beside the URDF, and in its folders above where it is "package://…". One
/// that is not found is a finding. A link without shape has the origins of its frames.
///
/// @param urdf   as given to read_urdf()
/// @param robot  what that made of it
/// @throws InputError  with file and line: as read_urdf(); a shape without size; a mesh that is no STL, OBJ
///                     or DAE, has no finite points or is larger than mesh_limit
[[nodiscard]] CollisionModel read_collision(const std::filesystem::path& urdf, const Robot& robot);

}  // namespace rivid
