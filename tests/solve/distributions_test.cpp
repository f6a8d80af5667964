#include <gtest/gtest.h>
#include <math.h>  // signgam, which <cmath> need not declare

#include <cmath>
#include <limits>

#include "rivid/solve/inference.hpp"
#include "solve/statistics_oracle.hpp"

namespace rivid {
namespace {

// Both sides sum series whose terms cancel little.
constexpr double same = 1e-11;

TEST(Distributions, ChiSquareTailIsThatOfSciPy) {
  const auto rows = test::statistics_oracle("chi_square");
  ASSERT_EQ(rows.size(), 25U);
  for (const auto& row : rows) {
    EXPECT_NEAR(chi_square_tail(row[0], row[1]), row[2], same * row[2] + 1e-15) << row[0] << ", " << row[1];
  }
}

TEST(Distributions, FTailIsThatOfSciPy) {
  const auto rows = test::statistics_oracle("f");
  ASSERT_EQ(rows.size(), 45U);
  for (const auto& row : rows) {
    EXPECT_NEAR(f_tail(row[0], row[1], row[2]), row[3], same * row[3] + 1e-15)
        << row[0] << ", " << row[1] << ", " << row[2];
  }
}

// Where std::lgamma() writes the sign of Γ.
TEST(Distributions, LeaveAloneWhatAllThreadsShare) {
  constexpr int untouched = 7;
  signgam = untouched;
  EXPECT_GT(chi_square_tail(3.0, 5.0), 0.0);
  EXPECT_GT(f_tail(3.0, 5.0, 7.0), 0.0);
  EXPECT_EQ(signgam, untouched);
}

TEST(Distributions, NothingLiesBelowZero) {
  EXPECT_EQ(chi_square_tail(0.0, 3.0), 1.0);
  EXPECT_EQ(f_tail(-1.0, 3.0, 4.0), 1.0);
}

TEST(Distributions, HaveNoNumberOutsideOfTheirDomain) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const double freedom : {0.0, -1.0, nan, inf, 1e18}) {
    EXPECT_TRUE(std::isnan(chi_square_tail(1.0, freedom))) << freedom;
    EXPECT_TRUE(std::isnan(f_tail(1.0, freedom, 3.0))) << freedom;
    EXPECT_TRUE(std::isnan(f_tail(1.0, 3.0, freedom))) << freedom;
  }
  EXPECT_TRUE(std::isnan(f_tail(1.0, 1e18, 1e18)));
  EXPECT_TRUE(std::isnan(chi_square_tail(nan, 3.0)));
  EXPECT_TRUE(std::isnan(f_tail(nan, 3.0, 4.0)));
  EXPECT_TRUE(std::isnan(student_quantile_975(0.0)));
  EXPECT_TRUE(std::isnan(student_quantile_975(nan)));
}

}  // namespace
}  // namespace rivid
