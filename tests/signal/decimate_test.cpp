#include "rivid/signal/decimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/signal/filter.hpp"
#include "signal/probe.hpp"
#include "support/complaint.hpp"

namespace rivid {
namespace {

using probe::columns;
using probe::series;

constexpr Convention both[] = {Convention::standard, Convention::matlab};

// The narrowest filter here, 0.4 / 20 of f_m, amplifies rounding by some 1e4.
constexpr double rounding = 1e-11;

TEST(KeptSamples, FollowMatlabsFormula) {
  for (Index n_m = 1; n_m <= 60; ++n_m) {
    for (int n_d = 1; n_d <= 25; ++n_d) {
      const Index n_out = (n_m + n_d - 1) / n_d;
      const Index first = n_d - (n_d * n_out - n_m);
      const std::vector<Index> kept = kept_samples(n_m, n_d, Convention::matlab);
      ASSERT_EQ(static_cast<Index>(kept.size()), n_out) << n_m << " by " << n_d;
      for (Index i = 0; i < n_out; ++i) {
        EXPECT_EQ(kept[static_cast<std::size_t>(i)], first + i * n_d - 1) << n_m << " by " << n_d;
      }
      EXPECT_EQ(kept.back(), n_m - 1) << n_m << " by " << n_d;
    }
  }
}

TEST(KeptSamples, BeginWithTheFirstOneWhateverTheLength) {
  EXPECT_EQ(kept_samples(9, 4), (std::vector<Index>{0, 4, 8}));
  EXPECT_EQ(kept_samples(8, 4), (std::vector<Index>{0, 4}));
  EXPECT_EQ(kept_samples(8, 4, Convention::matlab), (std::vector<Index>{3, 7}));
}

TEST(KeptSamples, OfStagesAreThoseOfTheirProduct) {
  for (const Convention convention : both) {
    for (Index n_m = 1; n_m <= 80; ++n_m) {
      EXPECT_EQ(kept_samples(n_m, {3, 4}, convention), kept_samples(n_m, 12, convention)) << n_m;
      EXPECT_EQ(kept_samples(n_m, {2, 3, 5}, convention), kept_samples(n_m, 30, convention)) << n_m;
    }
    EXPECT_EQ(kept_samples(7, std::vector<int>{}, convention), kept_samples(7, 1, convention));
  }
}

TEST(KeptSamples, OfAnEmptySeriesAreNone) {
  for (const Convention convention : both) {
    EXPECT_TRUE(kept_samples(0, 5, convention).empty());
  }
}

TEST(DecimationFilter, EndsItsPassBandAtEightTenthsOfTheNewNyquistFrequency) {
  const double f_m = 1000.0;
  for (const int n_d : {2, 10, 20, 50, 100}) {
    const double cutoff_hz = 0.8 * f_m / (2.0 * n_d);
    const double down = std::pow(10.0, -0.05 / 20.0);
    const Filter matlab = decimation_filter(n_d, Convention::matlab);
    const Filter standard = decimation_filter(n_d);
    EXPECT_NEAR(gain(matlab, 0.0, f_m), down, rounding);
    EXPECT_NEAR(gain(matlab, cutoff_hz, f_m), down, rounding);
    EXPECT_NEAR(gain(standard, 0.0, f_m), 1.0, rounding);
    EXPECT_NEAR(gain(standard, cutoff_hz, f_m), 1.0, rounding);
    EXPECT_LT(gain(standard, 0.5 * f_m / n_d, f_m), 0.15);
    EXPECT_EQ(standard.order, 8);
  }
}

// Convention::standard has other ends, see streaming_decimator_test.cpp.
TEST(Decimate, IsTheZeroPhaseFilterAtTheKeptSamplesByMatlabsConvention) {
  const Matrix x = columns(700, 11);
  const Matrix whole = zero_phase(x, decimation_filter(10, Convention::matlab), Convention::matlab);
  const Matrix few = decimate(x, 10, Convention::matlab);
  const std::vector<Index> kept = kept_samples(700, 10, Convention::matlab);
  ASSERT_EQ(few.rows(), static_cast<Index>(kept.size()));
  for (Index i = 0; i < few.rows(); ++i) {
    EXPECT_EQ(few.row(i), whole.row(kept[static_cast<std::size_t>(i)])) << "row " << i;
  }
}

TEST(Decimate, ByOneIsTheIdentity) {
  const Matrix x = columns(9, 3);
  for (const Convention convention : both) {
    EXPECT_EQ(decimate(x, 1, convention), x);
    EXPECT_EQ(decimate(x, {1, 1}, convention), x);
  }
}

TEST(Decimate, KeepsYEqualToWChi) {
  const Matrix W = columns(2000, 8);
  const Vector chi = (Vector(8) << 3.44, 0.03, 0.82, 0.062, 0.121, 0.007, 0.013, 0.137).finished();
  for (const Convention convention : both) {
    const Matrix Y = decimate(W * chi, 20, convention);
    EXPECT_LT((Y - decimate(W, 20, convention) * chi).cwiseAbs().maxCoeff(), rounding);
  }
}

TEST(Decimate, LeavesAConstantAloneAndMatlabShrinksIt) {
  for (const int n_d : {2, 5, 20}) {
    const Matrix ones = Matrix::Ones(4000, 1);
    const double shrunk = std::pow(10.0, -2.0 * 0.05 / 20.0);
    EXPECT_LT((decimate(ones, n_d).array() - 1.0).abs().maxCoeff(), rounding) << n_d;
    EXPECT_LT((decimate(ones, n_d, Convention::matlab).array() - shrunk).abs().maxCoeff(), rounding) << n_d;
  }
}

TEST(Decimate, InStagesRunsOneAfterTheOther) {
  const Matrix x = columns(3000, 2);
  for (const Convention convention : both) {
    EXPECT_EQ(decimate(x, {10, 5}, convention), decimate(decimate(x, 10, convention), 5, convention));
  }
}

TEST(Decimate, SaysWhatIsWrongWithItsArguments) {
  EXPECT_EQ(test::complaint_of([] { return decimate(series(100), 0); }),
            "decimate: n_d is 0, must be at least 1");
  EXPECT_EQ(test::complaint_of([] { return decimate(series(24), 10, Convention::matlab); }),
            "decimate: x has 24 samples, must have more than 24 = 3 times the order of the filter");
  EXPECT_EQ(test::complaint_of([] { return decimate(series(100), {10, 10}, Convention::matlab); }),
            "decimate: x has 10 samples, must have more than 24 = 3 times the order of the filter");
  EXPECT_EQ(test::complaint_of([] { return kept_samples(100, -3); }),
            "kept_samples: n_d is -3, must be at least 1");
  EXPECT_EQ(test::complaint_of([] { return decimation_filter(0); }),
            "decimation_filter: n_d is 0, must be at least 1");
}

}  // namespace
}  // namespace rivid
