#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "rivid/model/parameters.hpp"

namespace rivid {

/// Geometry of a serial chain as the kernels read it.
///
/// Frame j is fixed to link j, its origin lies on the axis of joint j and its z axis along it: a revolute joint
/// turns frame j about z, a prismatic one moves it along z. A URDF whose joint axis is x, y or a negative axis is
/// brought to this form by renaming axes, see Link::axes.
struct Chain {
  struct Link {
    JointType type = JointType::revolute;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< orientation of frame j in frame j−1 at q_j = 0
    Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< origin of frame j in frame j−1 at q_j = 0 [m]
    /// The user's link frame has the origin of frame j and its axes, renamed: component k of a vector in the link
    /// frame is signs[k] times component axes[k] in frame j. Standard parameters are given in the link frame.
    std::array<int, 3> axes = {0, 1, 2};
    std::array<int, 3> signs = {1, 1, 1};
  };

  std::vector<Link> links;                         ///< links 1…n, base to tip
  Eigen::Vector3d gravity = {0.0, 0.0, -9.80665};  ///< acceleration of free fall in the base frame [m/s²]

  [[nodiscard]] Index joints() const { return static_cast<Index>(links.size()); }
};

/// Where one inertial parameter of the link frame stands among the columns of frame j.
struct InertialColumn {
  int index = 0;  ///< 0…9: XX XY XZ YY YZ ZZ MX MY MZ M of frame j
  int sign = 1;
};

/// Column of frame j that belongs to the link-frame parameter `kind` (one of the ten inertial ones).
[[nodiscard]] InertialColumn inertial_column(const Chain::Link& link, ParameterKind kind);

/// Orientation of frame j in the user's link frame, a signed permutation: v_link = link_axes(link) v_j.
[[nodiscard]] Eigen::Matrix3d link_axes(const Chain::Link& link);

#ifdef RIVID_DEFINITIONS

namespace detail {

// Row and column of each inertia entry XX XY XZ YY YZ ZZ, and the way back.
inline constexpr std::array<std::array<int, 2>, 6> tensor_entry = {
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

inline int tensor_index(int row, int column) {
  const std::array<int, 2> wanted = {std::min(row, column), std::max(row, column)};
  return static_cast<int>(std::find(tensor_entry.begin(), tensor_entry.end(), wanted) - tensor_entry.begin());
}

}  // namespace detail

RIVID_INLINE InertialColumn inertial_column(const Chain::Link& link, ParameterKind kind) {
  const int k = static_cast<int>(kind);
  const auto axis = [&](int i) { return link.axes[static_cast<std::size_t>(i)]; };
  const auto sign = [&](int i) { return link.signs[static_cast<std::size_t>(i)]; };
  if (k < 6) {
    const auto [row, column] = detail::tensor_entry[static_cast<std::size_t>(k)];
    return {detail::tensor_index(axis(row), axis(column)), sign(row) * sign(column)};
  }
  if (k < 9) {
    return {6 + axis(k - 6), sign(k - 6)};
  }
  return {9, 1};
}

RIVID_INLINE Eigen::Matrix3d link_axes(const Chain::Link& link) {
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    C(static_cast<Index>(k), link.axes[k]) = link.signs[k];
  }
  return C;
}

#endif

}  // namespace rivid
