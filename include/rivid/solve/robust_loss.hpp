#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "rivid/fields.hpp"

namespace rivid {

/// Losses that outliers do not dominate.
enum class RobustKind {
  huber,    ///< [Huber 1964]: squares near zero, magnitudes beyond; convex, so there is one minimum
  bisquare  ///< [Beaton 1974]: gross outliers do not count at all; there may be several minima
};

template <>
inline constexpr std::array names_of<RobustKind> = std::to_array<std::string_view>({"huber", "bisquare"});

/// Tuning constant with which an estimate has 95 % efficiency under normal errors: 1.345, or 4.685.
[[nodiscard]] double default_tuning(RobustKind kind);

/// A loss of a residual u in units of its scale, by what an M-estimate Σ ψ(u_t) W_t = 0 takes from it.
struct RobustLoss {
  RobustKind kind = RobustKind::huber;
  double tuning = 1.345;

  /// ψ(u) / u, between 0 and 1: the weight of a row in a least-squares fit that has the same solution.
  /// Huber's is min(1, c/|u|), the bisquare's (1 − (u/c)²)² within c.
  [[nodiscard]] double weight(double u) const;
  /// ψ'(u).
  [[nodiscard]] double slope(double u) const;
};

/// Standard deviation of normal errors, from the median of their magnitudes: half of the errors may be
/// anything at all.
///
///   s = median |ρ| / 0.6745
///
/// @param rho  errors around zero, which come back in another order; at least one
/// @throws InputError  where there is none
[[nodiscard]] double robust_scale(std::span<double> rho);

}  // namespace rivid
