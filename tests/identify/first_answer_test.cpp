// What is chosen where nothing is said: rows, method, intervals.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/simulate/measurement.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

class FirstAnswer : public testing::Test, public test::ScaraStudy {
 protected:
  [[nodiscard]] double z(const Identification& found, Index i) const {
    return (found.chi[i] - truth[i]) / found.parameters[static_cast<std::size_t>(i)].sigma;
  }
};

TEST_F(FirstAnswer, RefusesALogOfAnotherRobot) {
  Log one = log(1.0, 1);
  for (Matrix* const each : {&one.q, &one.tau, &one.v_tau, &one.q_r}) {
    each->conservativeResize(Eigen::NoChange, std::min<Index>(each->cols(), 1));
  }
  try {
    static_cast<void>(identify(robot, one, Estimation{}));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("position has 1 columns"), std::string::npos) << error.what();
  }
}

// The mean error of least squares with rows that are too short, in σ.
TEST_F(FirstAnswer, NoiseBiasIsForetoldAsItIsSeen) {
  constexpr int runs = 20;
  const Index at = index("ZZ1R");
  for (const int n_d : {4, 6}) {
    const Estimation short_rows{.method = Wls{}, .signal = {.torque_held = true, .decimation = {n_d}}};
    double seen = 0.0;
    double foretold = 0.0;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      const Identification found = identify(robot, log(2.0, seed), short_rows);
      const ParameterEstimate& p = found.parameters[static_cast<std::size_t>(at)];
      seen += (p.value - truth[at]) / truth[at] / runs;
      foretold += p.noise_bias * p.sigma / p.value / runs;
      EXPECT_TRUE(
          std::ranges::any_of(found.warnings, [](const Finding& f) { return f.code == "noise_bias"; }));
    }
    EXPECT_LT(foretold, -0.005) << n_d;
    EXPECT_NEAR(foretold / seen, 1.0, 0.2) << n_d;
  }
}

TEST_F(FirstAnswer, HoldsTheTruthWhateverTheEncoder) {
  constexpr int runs = 15;
  for (const double noise : {2e-6, 2e-5, 1e-4}) {
    encoder_noise = noise;
    int inside = 0;
    int previous = 0;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      const Identification found = identify(robot, log(1.0, seed), Estimation{});
      ASSERT_EQ(found.status, Status::identified);
      ASSERT_TRUE(found.row_choice);
      EXPECT_TRUE(found.row_choice->torque_held) << "the controller holds its signals";
      EXPECT_LT(std::abs(found.row_choice->foretold.largest), 0.3);
      for (Index i = 0; i < base.size(); ++i) {
        inside += std::abs(z(found, i)) < found.covariance.quantile_975 ? 1 : 0;
        EXPECT_LT(std::abs(z(found, i)), 5.0)
            << noise << ' ' << seed << ' ' << base.parameters[static_cast<std::size_t>(i)].name;
      }
      previous = found.row_choice->decimation;
    }
    // Four deviations of as many independent intervals.
    EXPECT_NEAR(inside / (8.0 * runs), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / (8.0 * runs))) << noise;
    EXPECT_GE(previous, noise > 1e-5 ? 15 : 5) << noise;
  }
}

TEST_F(FirstAnswer, TakesInstrumentsWhereControllerAndReferenceAreKnown) {
  const Log one = log(1.0, 3);
  const Iv known = std::get<Iv>(iv().method);
  const Identification by_iv = identify(robot, one, {.method = Auto{known}});
  EXPECT_EQ(by_iv.method, "iv");
  ASSERT_TRUE(by_iv.method_choice);
  EXPECT_EQ(by_iv.method_choice->least_squares.size(), base.size());
  const Identification wls = identify(robot, one, Estimation{});
  EXPECT_EQ(wls.method, "wls");
  EXPECT_NE(wls.method_choice->reason.find("no controller is given"), std::string::npos);
  EXPECT_LT((by_iv.method_choice->least_squares - wls.chi).norm(), 1e-6 * wls.chi.norm());
  Log without = one;
  without.q_r.resize(0, 0);
  const Identification no_reference = identify(robot, without, {.method = Auto{known}});
  EXPECT_EQ(no_reference.method, "wls");
  EXPECT_NE(no_reference.method_choice->reason.find("no reference was logged"), std::string::npos);
}

TEST_F(FirstAnswer, IsNotSpoiledByAShortLogBesideALongOne) {
  const std::vector<Log> both = {log(1.0, 5), excerpt(log(1.0, 6), 400, 120)};
  const Identification alone = identify(robot, both[0], Estimation{});
  const Identification found = identify(robot, both, Estimation{});
  EXPECT_GE(found.row_choice->decimation, alone.row_choice->decimation / 2);
  for (Index i = 0; i < base.size(); ++i) {
    EXPECT_LT(std::abs(z(found, i)), 5.0);
  }
}

// The rows of a long log are chosen by a part of it: not by one that stands still.
TEST_F(FirstAnswer, IsNotSpoiledByAPauseThatIsLongerThanTheMotion) {
  const Log moving = log(1.0, 5);
  constexpr Index pause = 60'000;
  const auto held = [&](const Matrix& signal, double noise, std::uint64_t stream) {
    Matrix out(moving.samples() + pause, signal.cols());
    out.topRows(moving.samples()) = signal;
    out.bottomRows(pause) = signal.bottomRows(1).replicate(pause, 1) +
                            white_noise(5, stream, pause, Vector::Constant(signal.cols(), noise));
    return out;
  };
  Log paused = moving;
  paused.t = Vector::LinSpaced(moving.samples() + pause, 0.0,
                               static_cast<double>(moving.samples() + pause - 1) / moving.f_m);
  paused.q = held(moving.q, encoder_noise, 21);
  paused.v_tau = held(moving.v_tau, 0.0, 22);
  paused.q_r = held(moving.q_r, 0.0, 23);
  const Identification alone = identify(robot, moving, Estimation{});
  const Identification found = identify(robot, paused, Estimation{});
  ASSERT_EQ(found.status, Status::identified) << (found.warnings.empty() ? "" : found.warnings.front().text);
  EXPECT_GE(found.row_choice->decimation, alone.row_choice->decimation / 2);
  EXPECT_LE(found.row_choice->decimation, alone.row_choice->decimation * 2);
  for (Index i = 0; i < base.size(); ++i) {
    EXPECT_LT(std::abs(z(found, i)), 5.0);
  }
}

// Its noise would ask for rows ten times as long, which leave the other joint too few.
TEST_F(FirstAnswer, AJointThatStandsHasNoVoteOnTheRows) {
  Log one = log(1.0, 5);
  const int both = identify(robot, one, {.judge = false}).row_choice->decimation;
  constexpr double noise = 1e-3;
  one.q.col(1) = white_noise(5, 31, one.samples(), Vector::Constant(1, noise));
  const Identification found = identify(robot, one, {.judge = false});
  ASSERT_TRUE(found.row_choice);
  EXPECT_LE(found.row_choice->decimation, 2 * both);
}

TEST_F(FirstAnswer, LeavesWhatWasAskedForAlone) {
  const Log one = log(1.0, 4);
  for (const SignalOptions& signal : {SignalOptions{.decimation = {1}}, SignalOptions{.cutoff_hz = 20.0},
                                      SignalOptions{.rows = RowScheme::paper}}) {
    const Identification found = identify(robot, one, {.method = Wls{}, .signal = signal});
    EXPECT_FALSE(found.row_choice);
    EXPECT_EQ(found.estimation.signal.decimation, signal.decimation);
  }
}

// A disturbance that lasts half a second is partly absorbed by the parameters: residuals show too little of
// it.
TEST_F(FirstAnswer, BlocksKnowErrorsThatLast) {
  constexpr int runs = 40;
  constexpr double memory = 0.99;
  Vector hac = Vector::Zero(8);
  Vector blocks = Vector::Zero(8);
  Vector squares = Vector::Zero(8);
  double scales = 0.0;  // mean of the squared ratio of both deviations, and of the reported one
  double reported = 0.0;
  encoder_noise = 2e-6;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    Log one = log(1.0, seed);
    const Matrix steps = white_noise(seed, 9, one.samples(), Vector(Eigen::Vector2d(0.05, 0.012)));
    Eigen::RowVector2d lasting = Eigen::RowVector2d::Zero();
    for (Index k = 0; k < one.samples(); ++k) {
      lasting = memory * lasting + steps.row(k);
      one.v_tau.row(k) += lasting;
    }
    const Identification found = identify(
        robot, one, {.method = Wls{}, .signal = {.torque_held = true, .decimation = {20}}, .judge = false});
    EXPECT_EQ(found.covariance.kind, CovarianceKind::blocks);
    EXPECT_EQ(found.covariance.blocks, 10);
    for (Index i = 0; i < 8; ++i) {
      const ParameterEstimate& p = found.parameters[static_cast<std::size_t>(i)];
      hac[i] += p.plain_sigma * p.plain_sigma / runs;
      blocks[i] += p.sigma * p.sigma / runs;
      squares[i] += std::pow(found.chi[i] - truth[i], 2) / runs;
      scales += std::pow(p.sigma / p.plain_sigma, 2) / (8 * runs);
    }
    reported += std::pow(found.covariance.block_ratio, 2) / runs;
  }
  const double by_hac = (hac.cwiseQuotient(squares)).cwiseSqrt().mean();
  const double by_blocks = (blocks.cwiseQuotient(squares)).cwiseSqrt().mean();
  EXPECT_LT(by_hac, 0.95);
  EXPECT_GT(by_blocks, by_hac);
  EXPECT_NEAR(by_blocks, 1.0, 0.25);
  EXPECT_GT(reported, 1.2);
  EXPECT_NEAR(scales / reported, 1.0, 0.15);
}

}  // namespace
}  // namespace rivid
