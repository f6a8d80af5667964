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
  Matrix columns;         // of its effect, as far as they are told from others, (rows × freedom)
  Vector shift;           // of the parameters χ̂ by it, (b)
};

// The score test of each alternative that explains anything, with a covariance of its scores by blocks of
// time.
//
// untested  those that explain something in too few blocks to tell by, for whoever asks
[[nodiscard]] std::vector<AlternativeTest> tests(const ProbedRows& rows,
                                                 std::span<const Alternative> alternatives,
                                                 std::vector<std::size_t>* untested = nullptr);

// Whether two halves of the motion, each with parameters of its own, say the same of an alternative: each
// explains by the value of the other what it explains by its own, and both agree within their deviations.
[[nodiscard]] bool replicates(const ProbedRows& rows, const Alternative& alternative);

}  // namespace rivid::detail
