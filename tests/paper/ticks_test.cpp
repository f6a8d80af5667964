#include "paper_study/ticks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace rivid::study {
namespace {

TEST(RoundTicks, AreMultiplesOfOneTwoOrFive) {
  EXPECT_EQ(round_ticks(0.0, 1.0), (std::vector<double>{0.0, 0.2, 0.4, 2 * 0.2 + 0.2, 0.8, 1.0}));
  EXPECT_EQ(round_ticks(-4.0, 4.0), (std::vector<double>{-4.0, -2.0, 0.0, 2.0, 4.0}));
  EXPECT_EQ(round_ticks(88.0, 99.0), (std::vector<double>{88.0, 90.0, 92.0, 94.0, 96.0, 98.0, 100.0}));
}

TEST(RoundTicks, KeepTheLeastStep) {
  EXPECT_EQ(round_ticks(0.0, 2.0, 1.0), (std::vector<double>{0.0, 1.0, 2.0}));
}

TEST(RoundTicks, CoverAnyRangeWithFourToEleven) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_real_distribution<double> decade(-6.0, 6.0);
  for (int k = 0; k < 1000; ++k) {
    const double low = mantissa(random) * std::pow(10.0, decade(random));
    const double high = low + std::abs(mantissa(random)) * std::pow(10.0, decade(random));
    const std::vector<double> ticks = round_ticks(low, high);
    ASSERT_GE(ticks.size(), 2U) << low << " to " << high;
    const double step = ticks[1] - ticks[0];
    constexpr double rounding = 1e-6;  // of a step: a multiple missed by 1e-9 counts as met
    EXPECT_LE(ticks.front(), low + rounding * step);
    EXPECT_GE(ticks.back(), high - rounding * step);
    EXPECT_GT(ticks.front(), low - (1.0 + rounding) * step);
    EXPECT_LT(ticks.back(), high + (1.0 + rounding) * step);
    EXPECT_GE(ticks.size(), 4U);
    EXPECT_LE(ticks.size(), 11U);
  }
}

}  // namespace
}  // namespace rivid::study
