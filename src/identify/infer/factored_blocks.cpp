#include "identify/infer/factored_blocks.hpp"

#include <algorithm>

#include "identify/rows/factors.hpp"

namespace rivid::detail {

namespace {

constexpr Index fewest_blocks = 10;

// Adds what the factor of a joint's rows [W Y] or [V | W Y] gives, with Z = V or W:
// Zᵀ W = R_ZZᵀ (Q_Zᵀ W) and Zᵀ (Y − W χ) = R_ZZᵀ (Q_Zᵀ Y − Q_Zᵀ W χ).
void add_to(BlockSums& sums, const std::vector<Index>& columns, const StreamingQr& qr, const Matrix& QtW,
            const Estimate& estimate, double weight) {
  const Matrix R = qr.R();
  sums.ZW(columns, columns) += weight * (R.transpose() * QtW);
  sums.Z_rho(columns) += weight * (R.transpose() * (qr.qty() - QtW * estimate.chi(columns)));
}

}  // namespace

std::vector<BlockSums> block_sums(const LogFactors& factors, const Estimate& estimate) {
  const Index b = estimate.chi.size();
  const Index most = std::clamp(factors.logs, fewest_blocks, LogFactors::most_blocks);
  std::vector<BlockSums> out;
  const auto sum_up = [&](const auto& blocks, const auto& QtW) {
    for (const auto& block : fewer_blocks(blocks, most)) {
      BlockSums& sums = out.emplace_back(Matrix::Zero(b, b), Vector::Zero(b), Index{0});
      for (std::size_t j = 0; j < block.size(); ++j) {
        add_to(sums, block[j].columns, block[j].qr, QtW(block[j].qr), estimate,
               estimate.weights[j] * estimate.weights[j]);
      }
    }
  };
  if (estimate.instruments) {
    sum_up(estimate.instruments->blocks,
           [](const StreamingQr& qr) { return Matrix(qr.qt_carried().leftCols(qr.columns())); });
  } else {
    sum_up(factors.blocks, [](const StreamingQr& qr) { return Matrix(qr.R()); });
  }
  return out;
}

}  // namespace rivid::detail
