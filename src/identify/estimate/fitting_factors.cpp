#include "identify/estimate/fitting_factors.hpp"

#include <algorithm>

#include "identify/rows/factors.hpp"

namespace rivid::detail {

namespace {

Index carries_torque(Index /*own*/) { return 1; }

Index carries_rows(Index own) { return own + 1; }

}  // namespace

bool fit(const LogFactors& factors, std::span<const std::vector<Index>> columns) {
  const auto are = [&](const std::vector<RowGroup>& groups) {
    return are_of(groups, columns, carries_torque);
  };
  return are(factors.rows.groups) && (factors.rows.undecimated.empty() || are(factors.rows.undecimated)) &&
         std::ranges::all_of(factors.blocks, are) && factors.rows.left_out.size() == columns.size() &&
         factors.rows.thresholds.size() == columns.size() &&
         factors.velocities.sums.size() == std::ssize(columns);
}

bool fit(const LoopFactors& factors, std::span<const std::vector<Index>> columns) {
  const auto are = [&](const std::vector<InstrumentalGroup>& groups) {
    return are_of(groups, columns, carries_rows);
  };
  const Index n = std::ssize(columns);
  const auto sizes = [&](const auto& numbers, Index width) {
    return numbers.size() == 0 || (numbers.rows() == n && numbers.cols() == width);
  };
  const LoopSums& sums = factors.sums;
  return (factors.groups.empty() || are(factors.groups)) &&
         (factors.used.empty() || are_of(factors.used, columns, carries_torque)) &&
         std::ranges::all_of(factors.blocks, are) && sizes(factors.mean_speeds, 1) &&
         sizes(factors.mean_squares, 1) && sizes(factors.J, 1) && sizes(sums.off_measured, 3) &&
         sizes(sums.measured, 3) && sizes(sums.off_reference, 3) && sizes(sums.reference, 3) &&
         sizes(sums.tracking, 1) && sizes(sums.missed, 1) && sizes(sums.control, 1) && sizes(sums.moving, 1);
}

}  // namespace rivid::detail
