// Thresholds, deviations and noise of the on-line estimators against formulas and simulations of their own.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/row_noise.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double f_m = 200.0;

// Mean and deviation of the largest |x| of a second, x white noise of deviation one behind a low-pass.
std::pair<double, double> largest_of_seconds(double keep, int seconds) {
  std::mt19937_64 random(71);
  std::normal_distribution<double> normal(0.0, std::sqrt(1.0 - keep * keep));
  double x = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (int second = 0; second < seconds; ++second) {
    double largest = 0.0;
    for (int k = 0; k < static_cast<int>(f_m); ++k) {
      x = keep * x + normal(random);
      largest = std::max(largest, std::abs(x));
    }
    sum += largest;
    squares += largest * largest;
  }
  const double mean = sum / seconds;
  return {mean, std::sqrt(squares / seconds - mean * mean)};
}

TEST(ContactObserver, HasTheLevelsOfGumbelsDistribution) {
  constexpr Index joints = 3;
  constexpr double seconds = 4000.0;
  std::mt19937_64 random(72);
  Robot robot = test::random_robot(joints, random);
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
  }
  const Vector chi_st = robot.chi_st();
  const DynamicModel model(robot, chi_st);
  const ContactObserverOptions options{.f_m = f_m};
  ContactObserver<double> observer(ModelData(model), options);
  const Vector q = Vector::LinSpaced(joints, -0.5, 0.7);
  const Vector none = Vector::Zero(joints);
  InverseDynamics dynamics{model};
  Vector at_rest(joints);
  dynamics.torque(q, none, none, at_rest);
  std::normal_distribution<double> noise(0.0, 0.4);
  for (int k = 0; k < static_cast<int>(seconds * f_m); ++k) {
    const Vector tau = at_rest + Vector::NullaryExpr(joints, [&] { return noise(random); });
    observer.update(q, none, tau, ContactObserver<double>::Mode::learn);
  }
  const auto [mean, deviation] = largest_of_seconds(std::exp(-options.bandwidth / f_m), 20000);
  const double beta = std::sqrt(6.0) / std::numbers::pi * deviation;
  const double level =
      mean + beta * (std::log(3600.0 * joints / options.alarms_per_hour) - std::numbers::egamma);
  // β is known to 1 / √(2 · 2000) of it at worst: half of the seconds may have been left behind.
  const double tolerance = 4.0 * (level - mean) / std::sqrt(2.0 * 0.5 * seconds);
  for (Index j = 0; j < joints; ++j) {
    EXPECT_NEAR(observer.level(j), level, tolerance);
  }
}

// Mean of a function of the variance that 200 rows measure, by the midpoint rule.
template <typename Function>
double mean_by_variance(const Function& f) {
  constexpr double rows = 200.0;
  constexpr double ds = 1e-4;
  double mean = 0.0;
  for (double s = 0.5 * ds; s < 3.0; s += ds) {
    const double log_density = 0.5 * rows * std::log(0.5 * rows) - std::lgamma(0.5 * rows) +
                               (0.5 * rows - 1.0) * std::log(s) - 0.5 * rows * s;
    mean += ds * std::exp(log_density) * f(s);
  }
  return mean;
}

TEST(LoadChange, IsFoundBeyondTheTailOfFByRowsThatVariancesRemember) {
  detail::LoadChange::Options options;
  options.per_second = 25.0;
  options.hours_to_false_alarm = 2.0;
  detail::LoadChange change(options);
  detail::RowNoise noise(Vector{{1.0}}, Vector{{0.1}},
                         1e9);  // rows so far apart that their errors are independent
  std::normal_distribution<double> normal;
  std::mt19937_64 random(3);
  for (int k = 0; k < 20; ++k) {  // until the noise is known
    noise.take(0, normal(random));
  }
  constexpr double u = 9.0;
  detail::LoadChange::Signatures l;
  l.fill({0.0, 0.0, 0.0, 1.0});
  change.take(l, u, noise, 0);
  change.step();
  // χ² of the only row beside what is known of the mass; at the begin the test counts as one and a half times
  // its mean.
  const double chi_square = u * u / (1.0 + 1.0 / (options.mass * options.mass));
  const double threshold = chi_square / (1.5 * change.suspicion());
  const double p = 1.0 / (3600.0 * options.hours_to_false_alarm * options.per_second *
                          static_cast<double>(detail::LoadChange::onsets));
  // P(χ²₄ > threshold s)
  const double tail = mean_by_variance([&](double s) {
    const double x = threshold * s;
    return std::exp(-0.5 * x) * (1.0 + 0.5 * x);
  });
  EXPECT_NEAR(tail / p, 1.0, 1e-6);
}

// Its likelihood ratio exceeds A with a probability of 1/A at most, at any time after a step; every third is
// tried.
TEST(LoadChange, IsAReleaseBeyondThatLikelihoodRatio) {
  const detail::LoadChange::Options options;
  detail::RowNoise noise(Vector{{1.0}}, Vector{{0.1}}, 1e9);
  for (int k = 0; k < 20; ++k) {
    noise.take(0, k % 2 == 0 ? 1.0 : -1.0);
  }
  const auto suspicion_of = [&](double u) {
    detail::LoadChange change(options);
    for (int k = 0; k < 3; ++k) {
      static_cast<void>(change.restart({0.0, 0.0, 0.0, -2.0}));
    }
    detail::LoadChange::Signatures l;
    l.fill({0.0, 0.0, 0.0, 1.0});
    for (int row = 0; row < 6; ++row) {
      change.take(l, u, noise, 0);
    }
    change.step();
    return 1.5 * change.suspicion();
  };
  constexpr double ratio = 6 * 2.0 * 2.0;  // twice its logarithm
  const double threshold = ratio / suspicion_of(-2.0);
  const double tail = mean_by_variance([&](double s) { return std::exp(-0.5 * threshold * s); });
  EXPECT_NEAR(tail * 3600.0 * options.hours_to_false_alarm * options.per_second / 3.0, 1.0, 1e-6);
  EXPECT_LT(suspicion_of(2.0), 0.8 * suspicion_of(-2.0)) << "a pick-up is no release";
}

// Each step that is tried is about twice as long ago as the next, and none too long.
TEST(LoadChange, TriesStepsOfAllAges) {
  detail::LoadChange change({});
  std::array<int, detail::LoadChange::onsets> ages{};
  int largest = 0;
  for (int step = 1; step <= 4000; ++step) {
    change.step();
    for (int& age : ages) {
      ++age;
    }
    if (const auto onset = change.restart()) {
      ages[*onset] = 0;
    }
    std::array<int, detail::LoadChange::onsets> sorted = ages;
    std::ranges::sort(sorted);
    for (std::size_t m = 1; m < sorted.size() && step > 400; ++m) {
      EXPECT_LE(sorted[m], 5 * (sorted[m - 1] + 3)) << step;
    }
    largest = step > 400 ? std::max(largest, sorted.back()) : 0;
    EXPECT_LE(sorted.back(), 4 * 40 + 3) << step;
  }
  EXPECT_GE(largest, 3 * 40);
}

TEST(RowNoise, BeginsWithErrorsThatAreAlike) {
  constexpr double step = 0.1;
  const detail::RowNoise noise(Vector{{0.5}}, Vector{{0.1}}, step);
  // Errors of a model at the begin: alike for half a second.
  const auto correlation = [&](int k) { return std::exp(-k * step / 0.5); };
  double long_run = 1.0;
  for (int k = 1; k <= 10; ++k) {
    long_run += 2.0 * (1.0 - k / 11.0) * correlation(k);
  }
  EXPECT_NEAR(noise.sigma(0), 0.5 * std::sqrt(long_run), 1e-12);
}

TEST(FrictionMonitor, TellsADriftInTheDeviationsOfBoth) {
  constexpr Index joints = 3;
  std::mt19937_64 random(73);
  Robot robot = test::random_robot(joints, random);
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::symmetric;
    joint.Fc = 4.0;
    joint.Fv = 2.0;
  }
  const Vector chi_st = robot.chi_st();
  const OnlineModel model = test::known_model(robot, chi_st, 0.2);
  FrictionMonitor<double> monitor(model, {.rows = {.f_m = f_m, .stride = 5, .torque_held = false}});
  InverseDynamics dynamics{DynamicModel(robot, chi_st)};
  const Motion motion = test::Wandering(joints, 5, 0.5, 1.2).at(test::ticks(20.0, f_m));
  Vector tau(joints);
  for (Index k = 0; k < motion.samples(); ++k) {
    dynamics.torque(motion.q.row(k).transpose(), motion.qd.row(k).transpose(), motion.qdd.row(k).transpose(),
                    tau);
    monitor.update(motion.q.row(k).transpose(), 1.1 * tau);
  }
  monitor.finish();
  double largest = 0.0;
  for (std::size_t i = 0; i < monitor.coefficients().size(); ++i) {
    const auto at = static_cast<Index>(i);
    const auto& c = monitor.coefficients()[i];
    const double expected =
        (monitor.value(at) - c.identified) / std::hypot(monitor.sigma(at), c.identified_sigma);
    EXPECT_NEAR(monitor.drift(at), expected, 1e-12 * (1.0 + std::abs(expected)));
    largest = std::max(largest, std::abs(expected));
  }
  EXPECT_GT(largest, 1.0);
}

}  // namespace
}  // namespace rivid
