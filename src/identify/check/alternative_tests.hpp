#pragma once

#include <span>
#include <vector>

#include "identify/check/alternatives.hpp"

namespace rivid::detail {

// What speaks for an alternative.
struct AlternativeTest {
  std::size_t of = 0;      // place among the alternatives
  Vector estimate;         // of its parameters, (k)
  Vector sigma;            // (k)
  double statistic = 0.0;  // F
  double freedom = 0.0;    // its parameters that the rows can tell from others
  double p = 1.0;
  double held_out = 0.0;  // part of the sum of squares that goes with it, on blocks of time that took no part
  Matrix directions;      // combinations of its parameters that the rows show, (k × freedom)
  Vector shift;           // of the parameters χ̂ by it, (b)
};

// The score test of each alternative that explains anything, with a covariance of its scores by blocks of
// time.
[[nodiscard]] std::vector<AlternativeTest> tests(const ProbedRows& rows,
                                                 std::span<const Alternative> alternatives);

}  // namespace rivid::detail
