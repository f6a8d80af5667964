#include "identify/rows/position_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "identify/rows/exact_rows.hpp"
#include "signal/window_decimator.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using detail::PositionNoise;
using detail::RowBand;

constexpr double f_m = 500.0;
constexpr Index samples = 20000;

// A motion of 0.7 Hz.
Vector motion() {
  return Vector::NullaryExpr(
      samples, [](Index k) { return std::sin(2.0 * std::numbers::pi * 0.7 * static_cast<double>(k) / f_m); });
}

Vector white(double deviation, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, deviation);
  return Vector::NullaryExpr(samples, [&] { return normal(random); });
}

// Rows of noise alone, as the decimation makes them: Σ_m h_m x[k + m].
Vector windowed(const Eigen::Ref<const Vector>& x, Index n_d) {
  const Vector h = detail::decimation_window(n_d);
  Vector out((x.size() - h.size()) / n_d + 1);
  for (Index k = 0; k < out.size(); ++k) {
    out[k] = h.dot(x.segment(k * n_d, h.size()));
  }
  return out;
}

double variance(const Vector& x) { return x.squaredNorm() / static_cast<double>(x.size()); }

TEST(PositionNoise, IsThatOfTheRowsWhateverTheWindow) {
  const Vector noise = white(1e-4, 1);
  const PositionNoise found(motion() + noise, f_m);
  EXPECT_NEAR(found.deviation(), 1e-4, 0.05e-4);
  const Motion alone = detail::averaged_motion(noise, f_m);
  for (const int n_d : {1, 4, 10, 25}) {
    const auto expected = found.in(RowBand({.rows = RowScheme::exact, .decimation = {n_d}}, f_m));
    const double acceleration = expected.acceleration / variance(windowed(alone.qdd.col(0), n_d));
    const double velocity = expected.velocity / variance(windowed(alone.qd.col(0), n_d));
    // Rows of a window are samples / n_d.
    const double scatter = 5.0 * std::sqrt(2.0 * n_d / static_cast<double>(samples)) + 0.05;
    EXPECT_GT(acceleration, 1.0 - scatter) << n_d;
    EXPECT_GT(velocity, 1.0 - scatter) << n_d;
    // The octave of the valley, which long windows pass, has some of the motion in it.
    const double above = n_d <= 4 ? scatter : 3.0;
    EXPECT_LT(acceleration, 1.0 + above) << n_d;
    EXPECT_LT(velocity, 1.0 + above) << n_d;
  }
}

TEST(PositionNoise, OfAFilterIsThatBehindIt) {
  const Vector noise = white(1e-4, 2);
  const PositionNoise found(motion() + noise, f_m);
  const Filter filter = butterworth(2, 80.0, f_m);
  const Matrix velocity = central_difference(zero_phase(noise, filter), f_m);
  EXPECT_NEAR(found.in(RowBand(filter, f_m)).velocity / variance(velocity.col(0)), 1.0, 0.1);
}

// Below one step of the encoder a second most neighbours are equal, and their differences show no noise at
// all.
TEST(PositionNoise, SeesTheStepsOfAnEncoderThatAreRare) {
  constexpr double quantum = 2e-3;
  const Vector slow = 0.05 * motion();
  const Vector q = slow.unaryExpr([](double x) { return quantum * std::round(x / quantum); });
  const PositionNoise found(q, f_m);
  EXPECT_GT(found.deviation(), 0.3 * quantum / std::sqrt(12.0));
  EXPECT_LT(found.deviation(), 3.0 * quantum / std::sqrt(12.0));
}

TEST(PositionNoise, LeavesTheMotionAlone) {
  const Vector q = motion() + white(1e-5, 3);
  const PositionNoise found(q, f_m);
  EXPECT_GT(found.valley(), 2.0);
  const double acceleration = std::pow(2.0 * std::numbers::pi * 0.7, 4) * 0.5;
  EXPECT_NEAR(found.motion(), acceleration, 0.1 * acceleration);
}

// Raw velocities of a slow joint with a noisy encoder change their sign at every other sample.
TEST(MotionMask, KeepsTheStretchesOfAMotionWhoseSamplesAreNoisy) {
  const Robot robot = test::scara();
  Matrix q(samples, 2);
  q << motion() + white(2e-3, 4), motion() + white(2e-3, 5);
  const auto masks = detail::motion_masks(robot, q, q, f_m, {.rows = RowScheme::exact});
  const Vector v = central_difference(motion(), f_m);
  Index kept = 0;
  for (Index k = 0; k < samples; ++k) {
    const int direction = masks[0].direction[static_cast<std::size_t>(k)];
    kept += direction != 0 ? 1 : 0;
    if (direction != 0 && k > 50 && k < samples - 50) {
      EXPECT_EQ(direction > 0, v[k] > 0.0) << k;
    }
  }
  EXPECT_TRUE(masks[0].smoothed);
  EXPECT_GT(static_cast<double>(kept), 0.8 * static_cast<double>(samples));
}

TEST(MotionMask, GivesNoRowsToAJointThatOnlyFlickers) {
  const Robot robot = test::scara();
  constexpr double quantum = 1e-4;
  Matrix q(samples, 2);
  q.col(0) = motion();
  // Creeps over three steps of its encoder.
  q.col(1) = Vector::NullaryExpr(samples, [](Index k) {
    return quantum * std::round(3.0 * static_cast<double>(k) / static_cast<double>(samples));
  });
  const auto masks = detail::motion_masks(robot, q, q, f_m, {.rows = RowScheme::exact});
  for (const std::int8_t direction : masks[1].direction) {
    EXPECT_EQ(direction, 0);
  }
}

}  // namespace
}  // namespace rivid
