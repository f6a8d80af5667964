#pragma once

#include <utility>
#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

// Σ coefficient x[index] > bound.
struct LinearBound {
  std::vector<std::pair<Index, double>> terms;
  double bound = 0.0;

  [[nodiscard]] double slack(const Vector& x) const;
};

// A convex problem over the standard parameters x of a robot:
//
//   min ½ ‖target − rows x‖² + linearᵀ x − log_weight Σ_j log det P_j(x),   P_j(x) ≻ 0, bounds
//
// with the pseudo-inertias P_j of its links. It has an answer where `rows` and the logarithms leave no
// direction free.
struct BarrierProblem {
  Matrix rows;
  Vector target;
  Vector linear;
  double log_weight = 0.0;
  std::vector<Index> bodies;  // where the ten inertial parameters of each link begin in x
  std::vector<LinearBound> bounds;

  // Parameter of the barrier: four for a body, one for a bound.
  [[nodiscard]] double complexity() const;
  [[nodiscard]] double cost(const Vector& x) const;
  // Whether x is strictly inside.
  [[nodiscard]] bool inside(const Vector& x) const;
};

struct BarrierSolution {
  Vector x;             // strictly inside
  int steps = 0;        // of Newton's method
  double gap = 0.0;     // that the cost is above the least one at most
  bool reached = true;  // whether the gap is as small as was asked for
};

// Newton's method on the logarithmic barrier, whose weight falls until gap ≤ tolerance (1 + cost + offset).
// All iterates are inside. Along a step the barrier is a sum of logarithms of eigenvalues, so the line search
// is exact, and the way from any start is short.
//
// start   strictly inside
// offset  added to the problem's cost to give one that is not negative
[[nodiscard]] BarrierSolution minimise(const BarrierProblem& problem, const Vector& start, double offset,
                                       double tolerance, int max_steps);

// Columns svec(L⁻¹ E_i L⁻ᵀ) of the ten inertial parameters, P = L Lᵀ and E_i the pseudo-inertia of parameter
// i alone: for a change p of the parameters ‖G p‖ is that of P in units of P itself. svec puts the diagonal
// first, and the others times √2.
using BodyMatrix = Eigen::Matrix<double, 10, 10>;
[[nodiscard]] BodyMatrix whitened_parameters(const Eigen::Matrix4d& P);

// svec of the identity.
[[nodiscard]] Eigen::Matrix<double, 10, 1> identity_moments();

}  // namespace rivid::detail
