#pragma once

#include <string>
#include <vector>

#include "rivid/finding.hpp"
#include "urdf_document.hpp"
#include "urdf_topology.hpp"

namespace rivid::detail {

/// A limit that the file does not tell is written as this value or beyond.
inline constexpr double urdf_unlimited = 1e300;

/// A URDF of which every number and name has been checked.
struct CheckedUrdf {
  /// The same robot in the few elements that matter here, numbers in plain form, limits complete, joints without
  /// motion of one axis fixed: urdfdom has nothing left to misread or to complain about.
  std::string xml;
  std::string base;
  std::string tip;
  std::vector<Finding> warnings;
};

/// @throws InputError  see read_urdf()
[[nodiscard]] CheckedUrdf checked_urdf(const UrdfDocument& document, const UrdfOptions& options);

}  // namespace rivid::detail
