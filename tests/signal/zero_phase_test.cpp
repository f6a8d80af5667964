#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "rivid/error.hpp"
#include "rivid/signal/filter.hpp"
#include "signal/probe.hpp"
#include "support/complaint.hpp"

namespace rivid {
namespace {

using probe::columns;
using probe::series;

constexpr double f_m = 200.0;
constexpr double cutoff_hz = 20.0;
constexpr Convention both[] = {Convention::standard, Convention::matlab};

// Filters of order 8 and less at 0.1 f_m amplify rounding by at most 1e3.
constexpr double rounding = 1e-13;

// What the padding of Convention::standard leaves of the start of a pass, in both passes, per unit of the
// jump.
constexpr double forgotten = 1e-5;

TEST(ZeroPhase, LeavesAConstantAlone) {
  for (const Convention convention : both) {
    for (int order = 1; order <= 8; ++order) {
      const Matrix x = Matrix::Constant(300, 3, -1.7);
      EXPECT_LT((zero_phase(x, f_m, cutoff_hz, order, convention) - x).cwiseAbs().maxCoeff(), rounding)
          << "order " << order;
    }
  }
}

TEST(ZeroPhase, LeavesAConstantAloneAtAVeryLowCutoff) {
  // (f_m / (π cutoff))² ε: what 1 + a1 + a2 loses.
  const Matrix x = Matrix::Constant(20000, 1, 2.5);
  EXPECT_LT((zero_phase(x, 1000.0, 0.1) - x).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(ZeroPhase, LeavesAStraightLineAlone) {
  const double slope = 0.01;
  const Vector line = Vector::LinSpaced(500, 1.0, 1.0 + slope * 499.0);
  for (int order = 1; order <= 8; ++order) {
    const Matrix y = zero_phase(line, f_m, cutoff_hz, order);
    const auto delay = static_cast<double>(settling_samples(butterworth(order, cutoff_hz, f_m)));
    EXPECT_LT((y - line).cwiseAbs().maxCoeff(), forgotten * slope * delay) << "order " << order;
    EXPECT_LT((y - line).middleRows(200, 100).cwiseAbs().maxCoeff(), 10.0 * rounding) << "order " << order;
  }
}

TEST(ZeroPhase, IsLinear) {
  const Vector x = series(400);
  const Vector y = series(400, 1000);
  for (const Convention convention : both) {
    const Matrix together = zero_phase(3.0 * x - 0.5 * y, f_m, cutoff_hz, 4, convention);
    const Matrix apart = 3.0 * zero_phase(x, f_m, cutoff_hz, 4, convention) -
                         0.5 * zero_phase(y, f_m, cutoff_hz, 4, convention);
    EXPECT_LT((together - apart).cwiseAbs().maxCoeff(), rounding);
  }
}

TEST(ZeroPhase, AnswersAnImpulseSymmetrically) {
  const Index middle = 400;
  Vector impulse = Vector::Zero(2 * middle + 1);
  impulse[middle] = 1.0;
  for (int order = 1; order <= 8; ++order) {
    const Vector h = zero_phase(impulse, f_m, cutoff_hz, order);
    EXPECT_LT((h - h.reverse()).cwiseAbs().maxCoeff(), rounding) << "order " << order;
    EXPECT_EQ(h.maxCoeff(), h[middle]) << "order " << order;
  }
}

TEST(ZeroPhase, GivesTheReversedSeriesReversed) {
  const Vector x = series(600);
  const Matrix forth = zero_phase(x, f_m, cutoff_hz);
  const Matrix back = zero_phase(x.reverse(), f_m, cutoff_hz);
  EXPECT_LT((forth - back.colwise().reverse()).cwiseAbs().maxCoeff(), forgotten);
  EXPECT_LT((forth - back.colwise().reverse()).middleRows(150, 300).cwiseAbs().maxCoeff(), rounding);
}

TEST(ZeroPhase, ScalesAToneByTheSquaredGainAndDoesNotShiftIt) {
  for (const double f : {2.0, 15.0, 20.0, 33.0}) {
    Vector tone(1000);
    for (Index k = 0; k < tone.size(); ++k) {
      tone[k] = std::sin(2.0 * std::numbers::pi * f * static_cast<double>(k) / f_m);
    }
    const Matrix y = zero_phase(tone, f_m, cutoff_hz, 4);
    const double squared = std::pow(gain(butterworth(4, cutoff_hz, f_m), f, f_m), 2);
    EXPECT_LT((y - squared * tone).middleRows(400, 200).cwiseAbs().maxCoeff(), 10.0 * rounding) << f << " Hz";
  }
}

TEST(ZeroPhase, FiltersAColumnAlikeWhateverStandsBesideIt) {
  for (Index count = 1; count <= 19; ++count) {
    const Matrix x = columns(200, count);
    const Matrix y = zero_phase(x, f_m, cutoff_hz);
    ASSERT_EQ(y.rows(), x.rows());
    ASSERT_EQ(y.cols(), x.cols());
    for (Index c = 0; c < count; ++c) {
      EXPECT_LT((y.col(c) - zero_phase(x.col(c), f_m, cutoff_hz)).cwiseAbs().maxCoeff(), rounding)
          << "column " << c << " of " << count;
    }
  }
}

TEST(ZeroPhase, LetsAValueThatIsNotFiniteSpoilItsOwnColumnOnly) {
  Matrix x = columns(200, 3);
  x(50, 1) = std::numeric_limits<double>::quiet_NaN();
  const Matrix y = zero_phase(x, f_m, cutoff_hz);
  EXPECT_TRUE(y.col(0).allFinite());
  EXPECT_FALSE(y.col(1).allFinite());
  EXPECT_TRUE(y.col(2).allFinite());
}

TEST(ZeroPhase, ComesToRestExactlyInAStandstill) {
  // Not in subnormal numbers, which would cost thirty times as much.
  for (const double f : {1.0, 20.0, 70.0}) {
    Vector x = series(100000);
    x.tail(99000).setZero();
    EXPECT_EQ(zero_phase(x, f_m, f).bottomRows(40000), Matrix::Zero(40000, 1)) << f << " Hz";
  }
}

TEST(ZeroPhase, OfNoSectionIsTheIdentity) {
  const Matrix x = columns(5, 2);
  EXPECT_EQ(zero_phase(x, Filter{}), x);
}

TEST(ZeroPhase, TakesABlockOfALargerMatrix) {
  const Matrix x = columns(300, 4);
  const Matrix block = x.block(20, 1, 200, 2);
  EXPECT_EQ(zero_phase(x.block(20, 1, 200, 2), f_m, cutoff_hz), zero_phase(block, f_m, cutoff_hz));
}

TEST(ZeroPhase, OfBothConventionsAgreesOnceTheSpoiledSamplesAreDropped) {
  const Vector x = series(600);
  const Filter filter = butterworth(4, cutoff_hz, f_m);
  const Index spoiled = settling_samples(filter);
  const Matrix difference =
      zero_phase(x, filter, Convention::standard) - zero_phase(x, filter, Convention::matlab);
  const double at_the_ends = difference.cwiseAbs().maxCoeff();
  EXPECT_GT(at_the_ends, 1e-3);
  EXPECT_LT(difference.middleRows(spoiled, 600 - 2 * spoiled).cwiseAbs().maxCoeff(), 5e-3 * at_the_ends);
}

TEST(ZeroPhase, RefusesASeriesThatIsTooShort) {
  for (const Convention convention : both) {
    const std::string said =
        test::complaint_of([&] { return zero_phase(series(12), f_m, cutoff_hz, 4, convention); });
    EXPECT_EQ(said, "zero_phase: x has 12 samples, must have more than 12 = 3 times the order of the filter");
    EXPECT_EQ(zero_phase(series(13), f_m, cutoff_hz, 4, convention).rows(), 13);
  }
}

TEST(ZeroPhase, SaysWhenTheCutoffLiesBeyondNyquist) {
  EXPECT_EQ(test::complaint_of([] { return zero_phase(series(100), 200.0, 150.0); }),
            "butterworth: cutoff_hz is 150 Hz, must lie between 0 and f_m / 2 = 100 Hz");
}

}  // namespace
}  // namespace rivid
