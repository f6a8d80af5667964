#include "rivid/regressor/pack.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "rivid/model/kinds.hpp"

namespace rivid {
namespace {

using Lanes = std::array<double, Pack::lanes>;

// Errors of sin and cos of a pack, in units in the last place of the true value, over random angles up to
// `range` and over the neighbourhoods of multiples of π/2.
double worst_error(double range, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> angle(-range, range);
  const auto error = [](double value, long double truth) {
    const double magnitude = std::abs(static_cast<double>(truth));
    const double unit = std::nextafter(magnitude, 2.0) - magnitude;
    return std::abs(static_cast<double>(static_cast<long double>(value) - truth)) / unit;
  };
  double worst = 0.0;
  for (int k = 0; k < 100000; ++k) {
    Lanes q{};
    for (double& x : q) {
      x = angle(random);
      if (k % 4 == 0) {
        x = std::round(x / 1.5707963267948966) * 1.5707963267948966;
      }
    }
    Pack s;
    Pack c;
    sin_cos(Pack::load(q.data()), s, c);
    for (int i = 0; i < Pack::lanes; ++i) {
      const auto x = static_cast<long double>(q[static_cast<std::size_t>(i)]);
      worst = std::max({worst, error(s[i], std::sin(x)), error(c[i], std::cos(x))});
    }
  }
  return worst;
}

TEST(Pack, SineAndCosineAreWithinAFewUnitsInTheLastPlace) {
  EXPECT_LT(worst_error(3.2, 1), 1.5);
  EXPECT_LT(worst_error(100.0, 2), 1.5);
  EXPECT_LT(worst_error(1e5, 3), 2.5);
}

TEST(Pack, LeavesAnglesBeyondItsReductionToTheStandardLibrary) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const Lanes q = {1e5 + 1.0, -3e7, 1e300, 0.5, inf, std::nan(""), -0.0, 1e22};
  const Pack s = sin(Pack::load(q.data()));
  const Pack c = cos(Pack::load(q.data()));
  for (const int i : {0, 1, 2, 7}) {
    EXPECT_EQ(s[i], std::sin(q[static_cast<std::size_t>(i)])) << i;
    EXPECT_EQ(c[i], std::cos(q[static_cast<std::size_t>(i)])) << i;
  }
  EXPECT_DOUBLE_EQ(s[3], std::sin(0.5));
  EXPECT_TRUE(std::isnan(s[4]) && std::isnan(c[4]));
  EXPECT_TRUE(std::isnan(s[5]) && std::isnan(c[5]));
  EXPECT_EQ(s[6], 0.0);
  EXPECT_EQ(c[6], 1.0);
}

TEST(Pack, CalculatesLaneByLane) {
  const Lanes a = {1, -2, 3, -4, 5, -6, 7, -8};
  const Lanes b = {8, 7, 6, 5, 4, 3, 2, 1};
  const Pack x = Pack::load(a.data());
  const Pack y = Pack::load(b.data());
  Lanes stored{};
  (x + y).store(stored.data());
  for (int i = 0; i < Pack::lanes; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_EQ(stored[k], a[k] + b[k]);
    EXPECT_EQ((x - y)[i], a[k] - b[k]);
    EXPECT_EQ((x * y)[i], a[k] * b[k]);
    EXPECT_EQ((x / y)[i], a[k] / b[k]);
    EXPECT_EQ((-x)[i], -a[k]);
    EXPECT_EQ(select(x > y, x, y)[i], std::max(a[k], b[k]));
    EXPECT_EQ(select(x < y, x, y)[i], std::min(a[k], b[k]));
    EXPECT_EQ(Pack(2.5)[i], 2.5);
  }
  EXPECT_TRUE(any(x > Pack(6.0)) && !all(x > Pack(6.0)));
  EXPECT_TRUE(all(x > Pack(-9.0)) && !any(x < Pack(-9.0)));
}

TEST(Pack, KnowsEveryFrictionLaw) {
  const Lanes qd = {1.5, -2.0, 0.0, -0.0, 1e-300, -1e-300, 3.0, -4.0};
  for (const KindRow& row : kind_rows) {
    for (const double sign_speed : {0.0, 0.4}) {
      const Pack entry = friction_entry(row.kind, Pack::load(qd.data()), sign_speed);
      for (int i = 0; i < Pack::lanes; ++i) {
        EXPECT_EQ(entry[i], friction_entry(row.kind, qd[static_cast<std::size_t>(i)], sign_speed))
            << row.symbol << ' ' << i;
      }
    }
  }
}

}  // namespace
}  // namespace rivid
