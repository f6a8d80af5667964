#pragma once

#include <string>
#include <vector>

#include "identify/physical/barrier.hpp"
#include "rivid/identify/physical.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

// The problem of physical() with its start.
struct PhysicalProblem {
  BarrierProblem barrier;
  Index data_rows = 0;  // of its first rows; the others are pulls
  double offset = 0.0;  // that makes the prior zero at the robot description
  Vector start;         // strictly inside
  Vector description;   // of the robot, its bodies mended
  std::vector<std::string> notes;
};

[[nodiscard]] PhysicalProblem physical_problem(const Robot& robot, const BaseParameters& base,
                                               const Vector& chi, const Matrix& root,
                                               const Physical& options);

// What is open of base parameters that the prior decided, at the standard parameters x: A H⁻¹ s² P H⁻¹ Aᵀ, of
// bodies and of friction and rotors apart, with P the part of the prior in the curvature H of the cost. How
// far the description is off, s², is what it is off where the data tell [MacKay 1992]. Infinite for friction
// and rotors without a row.
[[nodiscard]] Matrix covariance_of_prior(const PhysicalProblem& problem, const BaseParameters& base,
                                         const Vector& x);

// Friction that brakes and rotors without negative inertia, the coupled ones first.
[[nodiscard]] std::vector<LinearBound> sign_bounds(const Robot& robot, const BaseParameters& base);

// Masses within their bounds and strictly so, as near to `masses` as is simple.
[[nodiscard]] Vector masses_within(const Robot& robot, const Physical& options, Vector masses);

// A body for every link from Robot::first_body() on, whose inertial parameters are given.
struct NominalBodies {
  std::vector<Eigen::Matrix4d> pseudo_inertias;  // positive definite
  std::vector<std::string> notes;                // what was put in where the values belong to no body
};

// The bodies that inertial parameters tell, mended where they tell none:
// - a link without mass gets the mean mass of the others (1 kg without any), half-way to the next joint, with
//   their mean radius of gyration (0.1 m without any);
// - second moments about the centre of mass that are negative, or next to nothing beside the largest, are
//   raised to a tenth of the largest; a point mass becomes a small ball.
[[nodiscard]] NominalBodies nominal_bodies(const Robot& robot, const std::vector<Inertial>& inertials);

}  // namespace rivid::detail
