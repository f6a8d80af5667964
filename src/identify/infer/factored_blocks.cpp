#include "identify/infer/factored_blocks.hpp"

#include <algorithm>

#include "identify/rows/factors.hpp"

namespace rivid::detail {

namespace {

constexpr Index fewest_blocks = 10;

}  // namespace

std::vector<BlockSums> block_sums(const LogFactors& factors, const Estimate& estimate) {
  const Index b = estimate.chi.size();
  const Index most = std::clamp(factors.logs, fewest_blocks, LogFactors::most_blocks);
  std::vector<BlockSums> out;
  for (const std::vector<RowGroup>& block : fewer_blocks(factors.blocks, most)) {
    BlockSums& sums = out.emplace_back(Matrix::Zero(b, b), Vector::Zero(b));
    for (std::size_t j = 0; j < block.size(); ++j) {
      const std::vector<Index>& columns = block[j].columns;
      const StreamingQr& qr = block[j].qr;
      const Matrix R = qr.R();
      const double w = estimate.weights[j] * estimate.weights[j];
      // Of Wᵀ W = Rᵀ R and Wᵀ (Y − W χ) = Rᵀ (Qᵀ Y − R χ).
      sums.ZW(columns, columns) += w * (R.transpose() * R);
      sums.Z_rho(columns) += w * (R.transpose() * (qr.qty() - R * estimate.chi(columns)));
    }
  }
  return out;
}

}  // namespace rivid::detail
