#include "rivid/model/chain.hpp"

#include <algorithm>

namespace rivid {

namespace {

// Row and column of each inertia entry XX XY XZ YY YZ ZZ, and the way back.
constexpr std::array<std::array<int, 2>, 6> tensor_entry = {{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

int tensor_index(int row, int column) {
  const std::array<int, 2> wanted = {std::min(row, column), std::max(row, column)};
  return static_cast<int>(std::find(tensor_entry.begin(), tensor_entry.end(), wanted) - tensor_entry.begin());
}

}  // namespace

InertialColumn inertial_column(const Chain::Link& link, ParameterKind kind) {
  const int k = static_cast<int>(kind);
  const auto axis = [&](int i) { return link.axes[static_cast<std::size_t>(i)]; };
  const auto sign = [&](int i) { return link.signs[static_cast<std::size_t>(i)]; };
  if (k < 6) {
    const auto [row, column] = tensor_entry[static_cast<std::size_t>(k)];
    return {tensor_index(axis(row), axis(column)), sign(row) * sign(column)};
  }
  if (k < 9) {
    return {6 + axis(k - 6), sign(k - 6)};
  }
  return {9, 1};
}

Eigen::Matrix3d link_axes(const Chain::Link& link) {
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    C(static_cast<Index>(k), link.axes[k]) = link.signs[k];
  }
  return C;
}

}  // namespace rivid
