// The lag that a result tells of its torques: logs whose torques were shifted on purpose, and logs that are
// as they should be. The truth is the shift.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include "rivid/data/adjust.hpp"
#include "rivid/identify/identification.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

constexpr double moves = 2.0;  // of the study, times
const SignalOptions signal = {.torque_held = true, .cutoff_hz = 0.0, .decimation = {10}};

TorqueLag lag_of(const Identification& result) {
  if (!result.diagnostics || !result.diagnostics->torque_lag) {
    ADD_FAILURE() << "no lag is told";
    return {};
  }
  return *result.diagnostics->torque_lag;
}

// What a result warns of its lag, if it does.
std::string warning(const Identification& result) {
  const auto found = std::ranges::find(result.warnings, "torque_lag", &Finding::code);
  return found == result.warnings.end() ? "" : found->text;
}

class Lag : public testing::Test {
 protected:
  [[nodiscard]] Identification wls(const Log& log, const SignalOptions& options) const {
    return identify(study_.robot, log,
                    {.method = Wls{}, .signal = options, .covariance = {.kind = CovarianceKind::hac}});
  }
  [[nodiscard]] Identification iv(const Log& log, const SignalOptions& options) const {
    Estimation method = study_.iv();
    method.signal = options;
    method.covariance.kind = CovarianceKind::hac;
    return identify(study_.robot, log, method);
  }
  [[nodiscard]] const test::ScaraStudy& study() const { return study_; }

 private:
  test::ScaraStudy study_;
};

TEST_F(Lag, IsThatOfTorquesThatWereShifted) {
  for (const double lag : {-1.0, -0.5, 0.5, 1.0, 2.0}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Log log = shift_torque(study().log(moves, seed), -lag);
      for (const TorqueLag& found : {lag_of(wls(log, signal)), lag_of(iv(log, signal))}) {
        EXPECT_NEAR(found.samples, lag, 3.0 * found.sigma) << "seed " << seed;
        EXPECT_LT(found.sigma, 0.15 + 0.15 * std::abs(lag)) << "seed " << seed;
        EXPECT_GT(found.largest_shift, 2.0) << "seed " << seed;
      }
    }
  }
}

// Of logs that are as they are told to be, and of the same where a torque that is held is told to be
// momentary.
TEST_F(Lag, HasADeviationThatHoldsAndWarnsOfHalfASample) {
  constexpr int runs = 40;
  SignalOptions momentary = signal;
  momentary.torque_held = false;
  for (const bool instrumental : {false, true}) {
    const auto identified = [&](const Log& log, const SignalOptions& options) {
      return instrumental ? iv(log, options) : wls(log, options);
    };
    double sum = 0.0;
    double squares = 0.0;
    int half_a_sample = 0;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      const Log log = study().log(moves, seed);
      const Identification good = identified(log, signal);
      EXPECT_EQ(warning(good), "") << "seed " << seed;
      const TorqueLag lag = lag_of(good);
      sum += lag.samples / lag.sigma;
      squares += std::pow(lag.samples / lag.sigma, 2);
      const std::string told = warning(identified(log, momentary));
      half_a_sample += told.find("[signal] torque_held = true") != std::string::npos ? 1 : 0;
    }
    // Least squares is a little biased by the noise that is fed back.
    EXPECT_NEAR(sum / runs, 0.0, instrumental ? 0.35 : 0.7);
    EXPECT_NEAR(std::sqrt(squares / runs), 1.0, 0.35);
    std::cout << (instrumental ? "IV " : "WLS ") << half_a_sample << " of " << runs << " are warned of\n";
    EXPECT_GE(half_a_sample, 20);
  }
}

// Rows of the paper's have a bias of their own, and an M-estimate leaves other errors.
TEST_F(Lag, IsNotToldWhereItIsNotTheMatter) {
  const Log log = study().log(moves, 1);
  const Identification paper = wls(log, test::ScaraStudy::filtered());
  ASSERT_TRUE(paper.diagnostics);
  EXPECT_FALSE(paper.diagnostics->torque_lag);
  const Identification robust = identify(
      study().robot, log, {.method = Wls{}, .signal = signal, .robust = Robust{.kind = RobustKind::huber}});
  ASSERT_TRUE(robust.diagnostics);
  EXPECT_FALSE(robust.diagnostics->torque_lag);
}

}  // namespace
}  // namespace rivid
