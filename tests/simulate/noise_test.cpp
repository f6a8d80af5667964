#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rivid/simulate/measurement.hpp"

namespace rivid {
namespace {

// Known answers of Philox4x32-10 as its authors publish them: zeros, ones, digits of π.
TEST(CounterNoise, IsPhilox) {
  using Bits = std::array<std::uint32_t, 4>;
  EXPECT_EQ(CounterNoise(0, 0).bits(0), (Bits{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  constexpr std::uint64_t ones = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(CounterNoise(ones, ones).bits(ones), (Bits{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(CounterNoise(0x299f31d0a4093822, 0x0370734413198a2e).bits(0x85a308d3243f6a88),
            (Bits{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// Values by SciPy 1.17, norm.ppf.
TEST(NormalQuantile, IsThatOfSciPy) {
  struct Case {
    double p, x;
  };
  for (const auto [p, x] :
       {Case{1e-300, -37.0470962993612}, Case{1e-13, -7.348796102800677}, Case{0.0001, -3.7190164854556804},
        Case{0.0749, -1.4402382675279635}, Case{0.2, -0.8416212335729142}, Case{0.7, 0.5244005127080407},
        Case{0.92501, 1.4396021182393162}, Case{0.9999, 3.719016485455709}}) {
    EXPECT_NEAR(normal_quantile(p), x, 4e-15 * std::abs(x)) << p;
  }
  EXPECT_EQ(normal_quantile(0.5), 0.0);
  for (const double p : {0.0, 1.0, -0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(std::isnan(normal_quantile(p))) << p;
  }
}

TEST(CounterNoise, GivesTheseBitsOnEveryPlatform) {
  const CounterNoise noise(2001, 7);
  EXPECT_EQ(noise.normal(0), 0x1.86bb07ef0e83dp-1);
  EXPECT_EQ(noise.normal(1), 0x1.91fbd28690c06p-3);
  EXPECT_EQ(noise.normal(2), 0x1.2ca62f9571a5ap-2);
  EXPECT_EQ(noise.normal(3), -0x1.323334decc472p-1);
}

// Four standard errors of each sample moment.
TEST(CounterNoise, HasTheMomentsOfTheNormalDistribution) {
  constexpr Index m = 200'000;
  const Eigen::ArrayXd x = white_noise(11, 0, m, Vector::Ones(1)).col(0);
  const double error = 4.0 / std::sqrt(static_cast<double>(m));
  EXPECT_NEAR(x.mean(), 0.0, error);
  EXPECT_NEAR(x.square().mean(), 1.0, error * std::sqrt(2.0));
  EXPECT_NEAR(x.cube().mean(), 0.0, error * std::sqrt(15.0));
  EXPECT_NEAR(x.square().square().mean(), 3.0, error * std::sqrt(96.0));
  const double lagged = (x.head(m - 1) * x.tail(m - 1)).mean();
  EXPECT_NEAR(lagged, 0.0, error);
}

TEST(WhiteNoise, OfOtherSeedsPurposesAndColumnsIsIndependent) {
  constexpr Index m = 100'000;
  Matrix all(m, 4);
  all << white_noise(1, 0, m, Vector::Ones(2)), white_noise(2, 0, m, Vector::Ones(1)),
      white_noise(1, 1, m, Vector::Ones(1));
  const Matrix correlation = all.transpose() * all / static_cast<double>(m);
  const double error = 4.0 / std::sqrt(static_cast<double>(m));
  EXPECT_LT((correlation - Matrix(correlation.diagonal().asDiagonal())).cwiseAbs().maxCoeff(), error)
      << correlation;
}

TEST(WhiteNoise, OfMoreRowsAndColumnsHasTheSameNumbers) {
  const Vector sigma{{2.0, 0.5, 3.0}};
  const Matrix large = white_noise(5, 3, 100, sigma);
  EXPECT_EQ(white_noise(5, 3, 10, sigma.head(2)), large.topLeftCorner(10, 2));
  EXPECT_EQ(large(7, 1), 0.5 * white_noise(5, 3, 8, Vector::Ones(2))(7, 1));
}

}  // namespace
}  // namespace rivid
