#pragma once

#include <vector>

#include "rivid/identify/payload.hpp"

namespace rivid::detail {

// What is known of unknowns θ beforehand, as normal equations: JᵀΩJ and JᵀΩρ of measurements of them.
struct Known {
  Matrix A;
  Vector a;
};

// An arm that was identified before, as a measurement of its parameters:
//
//   χ̂ = χ + Σ_j G_j (1 − 1/r_j) + e,   cov e = C,
//
// G_j the slopes of χ̂ with the gains: weighted least squares are linear in the torques, and those of joint j
// are 1/r_j times what it was estimated from.
class ArmPrior {
 public:
  // places    of each parameter of the arm among the unknowns
  // gains_at  where r begins; −1 where gains are exact
  ArmPrior(const IdentifiedArm& arm, std::vector<Index> places, Index gains_at);

  void add_to(Known& known, const Vector& theta) const;
  [[nodiscard]] Index size() const { return chi_.size(); }

 private:
  Vector chi_;
  Matrix information_;  // C⁻¹
  Matrix slopes_;       // G
  std::vector<Index> places_;
  Index gains_at_;
};

}  // namespace rivid::detail
