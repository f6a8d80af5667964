#include "rivid/signal/filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "rivid/error.hpp"
#include "signal/probe.hpp"
#include "support/complaint.hpp"

namespace rivid {
namespace {

// A product of at most five sections, each a ratio of sums that cancel by at most 1e2 here.
constexpr double rounding = 1e-12;

TEST(Butterworth, HasTheSquaredGainOfItsDefinition) {
  const double f_m = 1000.0;
  const double f_c = 37.0;
  for (int order = 1; order <= 10; ++order) {
    const Filter filter = butterworth(order, f_c, f_m);
    EXPECT_EQ(filter.order, order);
    for (const double f : {0.0, 1.0, 20.0, 37.0, 100.0, 300.0}) {
      const double ratio = std::tan(std::numbers::pi * f / f_m) / std::tan(std::numbers::pi * f_c / f_m);
      EXPECT_NEAR(gain(filter, f, f_m), 1.0 / std::sqrt(1.0 + std::pow(ratio, 2 * order)), rounding)
          << "order " << order << " at " << f << " Hz";
    }
  }
}

TEST(Butterworth, LetsAConstantPassToTheLastDigitAtTheLowestCutoff) {
  for (int order = 1; order <= 8; ++order) {
    EXPECT_NEAR(gain(butterworth(order, 0.01, 1000.0), 0.0, 1000.0), 1.0, 1e-14) << "order " << order;
  }
}

TEST(Butterworth, StopsTheNyquistFrequency) {
  for (int order = 1; order <= 8; ++order) {
    EXPECT_NEAR(gain(butterworth(order, 20.0, 200.0), 100.0, 200.0), 0.0, rounding) << "order " << order;
  }
}

TEST(Butterworth, TakesHalfAsManySectionsAsPoles) {
  EXPECT_EQ(butterworth(4, 20.0, 200.0).sections.size(), 2U);
  EXPECT_EQ(butterworth(5, 20.0, 200.0).sections.size(), 3U);
}

TEST(Butterworth, SaysWhatIsWrongWithItsArguments) {
  EXPECT_EQ(test::complaint_of([] { return butterworth(4, 150.0, 200.0); }),
            "butterworth: cutoff_hz is 150 Hz, must lie between 0 and f_m / 2 = 100 Hz");
  EXPECT_EQ(test::complaint_of([] { return butterworth(4, 100.0, 200.0); }),
            "butterworth: cutoff_hz is 100 Hz, must lie between 0 and f_m / 2 = 100 Hz");
  EXPECT_EQ(test::complaint_of([] { return butterworth(4, -1.0, 200.0); }),
            "butterworth: cutoff_hz is -1 Hz, must lie between 0 and f_m / 2 = 100 Hz");
  EXPECT_EQ(
      test::complaint_of([] { return butterworth(4, std::numeric_limits<double>::quiet_NaN(), 200.0); }),
      "butterworth: cutoff_hz is nan Hz, must lie between 0 and f_m / 2 = 100 Hz");
  EXPECT_EQ(test::complaint_of([] { return butterworth(4, 0.001, 1000.0); }),
            "butterworth: cutoff_hz is 0.001 Hz, must be at least 1e-5 f_m = 0.01 Hz; decimate first");
  EXPECT_EQ(test::complaint_of([] { return butterworth(0, 20.0, 200.0); }),
            "butterworth: order is 0, must lie between 1 and 100");
  EXPECT_EQ(test::complaint_of([] { return butterworth(4, 99.999999, 200.0); }),
            "butterworth: cutoff_hz is 99.999999 Hz, must be at most f_m / 2 - 1e-5 f_m = 99.998 Hz; without "
            "a filter "
            "nothing is lost either");
  EXPECT_EQ(test::complaint_of([] { return butterworth(4, 20.0, 0.0); }),
            "butterworth: f_m is 0 Hz, must be positive and finite");
  EXPECT_EQ(test::complaint_of([] { return butterworth(4, 20.0, std::numeric_limits<double>::infinity()); }),
            "butterworth: f_m is inf Hz, must be positive and finite");
}

TEST(Chebyshev1, StaysWithinItsRippleUpToTheCutoffAndLeavesItThere) {
  const double f_m = 200.0;
  const double f_c = 20.0;
  const double ripple_db = 0.5;
  const double floor = std::pow(10.0, -ripple_db / 20.0);
  for (int order = 1; order <= 9; ++order) {
    const Filter filter = chebyshev1(order, ripple_db, f_c, f_m);
    for (double f = 0.0; f <= f_c; f += 0.1) {
      EXPECT_LE(gain(filter, f, f_m), 1.0 + rounding) << "order " << order << " at " << f << " Hz";
      EXPECT_GE(gain(filter, f, f_m), floor - rounding) << "order " << order << " at " << f << " Hz";
    }
    EXPECT_NEAR(gain(filter, f_c, f_m), floor, rounding) << "order " << order;
    EXPECT_NEAR(gain(filter, 0.0, f_m), order % 2 == 0 ? floor : 1.0, rounding) << "order " << order;
    EXPECT_LT(gain(filter, 1.01 * f_c, f_m), floor) << "order " << order;
  }
}

TEST(Chebyshev1, SaysWhatIsWrongWithItsArguments) {
  EXPECT_EQ(test::complaint_of([] { return chebyshev1(8, 0.0, 20.0, 200.0); }),
            "chebyshev1: ripple_db is 0 dB, must be positive and finite");
  EXPECT_EQ(test::complaint_of([] { return chebyshev1(8, 0.05, 150.0, 200.0); }),
            "chebyshev1: cutoff_hz is 150 Hz, must lie between 0 and f_m / 2 = 100 Hz");
  EXPECT_EQ(test::complaint_of([] { return chebyshev1(-1, 0.05, 20.0, 200.0); }),
            "chebyshev1: order is -1, must lie between 1 and 100");
}

TEST(Gain, OfNoSectionIsOne) { EXPECT_EQ(gain(Filter{}, 12.0, 200.0), 1.0); }

TEST(SettlingSamples, IsTheFirstPowerOfASinglePoleBelowTheLevel) {
  const Filter filter = butterworth(1, 5.0, 200.0);
  const double pole = std::abs(filter.sections.front().a1);
  for (const double level : {0.5, 1e-3, 1e-6}) {
    const auto m = static_cast<double>(settling_samples(filter, level));
    EXPECT_LE(std::pow(pole, m), level);
    EXPECT_GT(std::pow(pole, m - 1.0), level);
  }
}

TEST(SettlingSamples, BoundsTheTailOfTheImpulseResponse) {
  // The slowest pair of a Butterworth filter of order 4 may carry a few times the start of the response.
  const Filter filter = butterworth(4, 20.0, 1000.0);
  std::vector<double> h(2000, 0.0);
  h[0] = 1.0;
  for (const SecondOrderSection& s : filter.sections) {
    double z1 = 0.0;
    double z2 = 0.0;
    for (double& x : h) {
      const double y = s.b0 * x + z1;
      z1 = s.b1 * x - s.a1 * y + z2;
      z2 = s.b2 * x - s.a2 * y;
      x = y;
    }
  }
  double peak = 0.0;
  double tail = 0.0;
  const auto m = static_cast<std::size_t>(settling_samples(filter, 1e-3));
  for (std::size_t k = 0; k < h.size(); ++k) {
    (k < m ? peak : tail) = std::max(k < m ? peak : tail, std::abs(h[k]));
  }
  EXPECT_LT(tail, 5e-3 * peak);
  EXPECT_GT(tail, 1e-4 * peak);
}

TEST(SettlingSamples, IsNeverBelowTheOrder) {
  EXPECT_EQ(settling_samples(butterworth(1, 50.0, 200.0)), 1);
  EXPECT_EQ(settling_samples(butterworth(2, 50.0, 200.0), 0.9), 2);
  EXPECT_EQ(settling_samples(Filter{}), 0);
}

TEST(SettlingSamples, GrowsAsTheCutoffFalls) {
  EXPECT_EQ(settling_samples(butterworth(4, 100.0, 1000.0)), 31);
  EXPECT_NEAR(static_cast<double>(settling_samples(butterworth(4, 1.0, 1000.0))), 2873.0, 1.0);
}

TEST(SettlingSamples, RefusesALevelOutsideZeroToOne) {
  EXPECT_EQ(test::complaint_of([] { return settling_samples(Filter{}, 1.0); }),
            "settling_samples: level is 1, must lie between 0 and 1");
  EXPECT_EQ(test::complaint_of([] { return settling_samples(Filter{}, 0.0); }),
            "settling_samples: level is 0, must lie between 0 and 1");
}

}  // namespace
}  // namespace rivid
