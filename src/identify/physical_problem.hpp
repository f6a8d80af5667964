#pragma once

#include <string>
#include <vector>

#include "identify/barrier.hpp"
#include "rivid/identify/physical.hpp"

namespace rivid::detail {

// The problem of physical() with its start.
struct PhysicalProblem {
  BarrierProblem barrier;
  double offset = 0.0;  // that makes the prior zero at the robot description
  Vector start;         // strictly inside
  std::vector<std::string> notes;
};

[[nodiscard]] PhysicalProblem physical_problem(const Robot& robot, const BaseParameters& base,
                                               const Vector& chi, const Matrix& root,
                                               const Physical& options);

// Friction that brakes and rotors without negative inertia, the coupled ones first.
[[nodiscard]] std::vector<LinearBound> sign_bounds(const Robot& robot, const BaseParameters& base);

// Masses within their bounds and strictly so, as near to `masses` as is simple.
[[nodiscard]] Vector masses_within(const Robot& robot, const Physical& options, Vector masses);

}  // namespace rivid::detail
