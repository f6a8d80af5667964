// What blocks of time say of deviations, in closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "identify/infer/covariance.hpp"
#include "identify/rows/time_blocks.hpp"
#include "rivid/solve/inference.hpp"

namespace rivid::detail {
namespace {

constexpr Index G = 10;
constexpr Index parameters = 3;
constexpr double tolerance = 1e-12;  // another order of a dozen operations on numbers of order one

// Sums of blocks whose parameters are means of equally many rows each: no block leans on another. Row i of s
// has the sums of a parameter's residuals, which add up to zero.
struct Means {
  Matrix s = Matrix(parameters, G);
  Matrix bread = Matrix::Identity(parameters, parameters) / 50.0;
  std::vector<BlockSums> blocks;
  Uncertainty uncertainty;

  Means() {
    for (Index g = 0; g < G; ++g) {
      const double sign = g % 2 == 0 ? 1.0 : -1.0;
      s.col(g) << sign, 2.0 * sign, (g < 2 ? 3.0 * sign : 0.0);
      blocks.push_back({Matrix::Identity(parameters, parameters) * 50.0 / G, s.col(g)});
    }
    uncertainty.C = 1e-4 * Matrix::Identity(parameters, parameters);
    uncertainty.C(0, 1) = uncertainty.C(1, 0) = 2e-5;
    uncertainty.report.quantile_975 = 1.9;
  }
  // Σ (s / 50)² is the influence of all blocks; an estimate without one moves by G / (G − 1) times as much,
  // and counts with the power 1.5 of four that both have together.
  [[nodiscard]] Vector variances() const {
    return (s / 50.0).rowwise().squaredNorm() * std::sqrt(static_cast<double>(G) / (G - 1.0));
  }
};

TEST(ScaleToBlocks, TakesTheJackknifeOfAllParametersAndOfEach) {
  Means means;
  const Matrix before = means.uncertainty.C;
  const Vector ratio = means.variances() / 1e-4;
  // In the order of the parameters 1, 4 and 1.8 times a common factor: the third one is the median.
  const double median = std::pow(1.0 - 2.0 / 81.0, 3);
  EXPECT_NEAR(median, 0.926981, 1e-3);  // of χ² with nine degrees of freedom over nine, by SciPy
  const double all = ratio[2] / median;
  scale_to_blocks(means.blocks, means.bread, means.uncertainty);
  for (Index i = 0; i < parameters; ++i) {
    for (Index k = 0; k < parameters; ++k) {
      const auto scale = [&](Index at) {
        return std::sqrt((9.0 * all + (G - 1.0) * ratio[at]) / (9.0 + G - 1.0));
      };
      EXPECT_NEAR(means.uncertainty.C(i, k) / 1e-4, before(i, k) / 1e-4 * scale(i) * scale(k),
                  1e2 * tolerance);
    }
    EXPECT_NEAR(means.uncertainty.plain_sigma[i], 1e-2, tolerance);
  }
  EXPECT_EQ(means.uncertainty.report.kind, CovarianceKind::blocks);
  EXPECT_EQ(means.uncertainty.report.blocks, G);
  EXPECT_NEAR(means.uncertainty.report.block_ratio, std::sqrt(all), 1e2 * tolerance);
  EXPECT_DOUBLE_EQ(means.uncertainty.report.quantile_975, student_quantile_975(9.0 + G - 1.0));
}

// Of two parameters the ratio lies between both.
TEST(ScaleToBlocks, TakesTheMiddleOfAnEvenNumber) {
  Means means;
  const Vector ratio = means.variances() / 1e-4;
  std::vector<BlockSums> two;
  for (const BlockSums& block : means.blocks) {
    two.push_back({block.ZW.topLeftCorner(2, 2), block.Z_rho.head(2)});
  }
  means.uncertainty.C = Matrix(means.uncertainty.C.topLeftCorner(2, 2));
  scale_to_blocks(two, means.bread.topLeftCorner(2, 2), means.uncertainty);
  const double all = 0.5 * (ratio[0] + ratio[1]) / std::pow(1.0 - 2.0 / 81.0, 3);
  EXPECT_NEAR(means.uncertainty.report.block_ratio, std::sqrt(all), 1e2 * tolerance);
}

TEST(ScaleToBlocks, KeepsAWiderQuantile) {
  Means means;
  means.uncertainty.report.quantile_975 = 2.5;
  scale_to_blocks(means.blocks, means.bread, means.uncertainty);
  EXPECT_EQ(means.uncertainty.report.quantile_975, 2.5);
}

TEST(ScaleToBlocks, LeavesTheCovarianceOfFewBlocks) {
  Means means;
  means.blocks.resize(3);
  const Matrix before = means.uncertainty.C;
  scale_to_blocks(means.blocks, means.bread, means.uncertainty);
  EXPECT_EQ(means.uncertainty.C, before);
}

TEST(TimeBlocks, AreAsLongInEachLog) {
  // 30 s at 100 Hz and 60 s at 10 Hz.
  const TimeBlocks blocks({{3000, 100.0}, {600, 10.0}}, 9);
  EXPECT_EQ(blocks.count(), 9);
  EXPECT_EQ(blocks.count(0), 3);
  EXPECT_EQ(blocks.first(1), 3);
  EXPECT_EQ(blocks.of(0, 999), 0);
  EXPECT_EQ(blocks.of(0, 1000), 1);
  EXPECT_EQ(blocks.of(0, 2999), 2);
  EXPECT_EQ(blocks.of(1, 0), 3);
  EXPECT_EQ(blocks.of(1, 100), 4);
  EXPECT_EQ(blocks.of(1, 599), 8);
}

TEST(TimeBlocks, DivideTheRowsThatAreThere) {
  const TimeBlocks blocks({{100, 1.0}}, 4);
  std::vector<std::vector<Index>> found;
  const std::vector<Index> samples = {3, 24, 25, 80, 99};  // none in the third block
  blocks.divide(0, samples,
                [&](Index block, Index first, Index count) { found.push_back({block, first, count}); });
  EXPECT_EQ(found, (std::vector<std::vector<Index>>{{0, 0, 2}, {1, 2, 1}, {3, 3, 2}}));
}

}  // namespace
}  // namespace rivid::detail
