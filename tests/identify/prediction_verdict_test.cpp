// What is said of torques that a model has not seen.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "support/payload_bench.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

class PredictionVerdict : public testing::Test, public test::ScaraStudy {
 protected:
  static bool has(const Identification& found, const std::string& code) {
    return std::ranges::any_of(found.warnings, [&](const Finding& f) { return f.code == code; });
  }
};

// Few rows, so that errors of the parameters are most of the error on a log of twice the motion.
TEST_F(PredictionVerdict, ForecastIsTheErrorThatIsFound) {
  constexpr int runs = 24;
  double found_squares = 0.0;
  double forecast_squares = 0.0;
  double of_residual = 0.0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Log piece = excerpt(log(1.0, seed), 300, 700);
    const Identification found = identify(robot, piece, {.judge = false});
    ASSERT_EQ(found.status, Status::identified) << seed;
    const Validation other = validate(robot, found, log(2.0, 100 + seed));
    found_squares += std::pow(other.fit.relative_error, 2);
    forecast_squares += std::pow(other.forecast.relative_error, 2);
    for (const JointFit& joint : other.fit.joints) {
      const JointFit& own = found.fit.joints[static_cast<std::size_t>(&joint - other.fit.joints.data())];
      const double y = joint.sigma_rho / joint.relative_error;
      of_residual += std::pow(own.sigma_rho / y, 2) / static_cast<double>(other.fit.joints.size());
    }
  }
  EXPECT_GT(forecast_squares, 1.2 * of_residual) << "errors of parameters count in this test";
  // Squares of eight parameters' errors in each of 24 runs: the mean scatters by 10 %, intervals by as much.
  EXPECT_NEAR(std::sqrt(found_squares / forecast_squares), 1.0, 0.3);
}

TEST_F(PredictionVerdict, AValidationWithAnotherArmIsDoubtful) {
  const Log one = log(1.0, 3);
  const std::vector<Log> same = {log(2.0, 4)};
  const Identification good = identify(robot, std::span(&one, 1), Estimation{}, same);
  EXPECT_EQ(good.status, Status::identified) << good.warnings.front().text;
  EXPECT_FALSE(has(good, "prediction_fails"));
  ASSERT_TRUE(good.forecast);
  EXPECT_LT(good.forecast->relative_error, 3.0 * good.fit.relative_error);

  set("MX2", 5.0 * 0.242);
  set("ZZ2", 5.0 * 0.062);
  const std::vector<Log> other = {log(2.0, 4)};
  const Identification bad = identify(robot, std::span(&one, 1), Estimation{}, other);
  EXPECT_EQ(bad.status, Status::doubtful);
  EXPECT_TRUE(has(bad, "prediction_fails"));
}

// Whose logs are so good that a change of a hundredth stands out: no error, since half a per cent is missed.
TEST_F(PredictionVerdict, AValidationThatIsMissedByLittleIsAWarning) {
  encoder_noise = 1e-6;
  disturbance *= 0.01;
  const Log one = log(1.0, 3);
  set("MX2", 1.01 * 0.242);
  const std::vector<Log> other = {log(2.0, 4)};
  const Identification found = identify(robot, std::span(&one, 1), Estimation{}, other);
  EXPECT_EQ(found.status, Status::identified);
  EXPECT_FALSE(has(found, "prediction_fails"));
  EXPECT_TRUE(has(found, "validation_worse"));
}

// Joints that stand in the log of the fit, and bodies that are off by a tenth.
TEST(RankDeficient, IsAnsweredByTheDescriptionWhereTheDataLeaveItOpen) {
  const Robot description = test::six_axis();
  Robot truth = description;
  for (Inertial& inertial : truth.inertials) {
    inertial *= 1.1;
  }
  Log rests = test::log_with_joints_at_rest(truth, Inertial::Zero(), 5, {3, 4});
  const Log moves = test::log_with_joints_at_rest(truth, Inertial::Zero(), 6, {});
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 0.3);  // [N·m]
  rests.tau += Matrix::NullaryExpr(rests.tau.rows(), rests.tau.cols(), [&] { return noise(random); });
  const Identification found =
      identify(description, std::span(&rests, 1), Estimation{}, std::span(&moves, 1));
  ASSERT_EQ(found.status, Status::rank_deficient);
  ASSERT_TRUE(found.physical_answers());
  const Validation& other = found.validation.front();
  EXPECT_LT(other.physical->relative_error, 0.1 * other.fit.relative_error);
  EXPECT_LT(other.physical->relative_error, 0.05);
  const Vector& forecast = other.forecast.joints;
  for (const Index j : {0, 1, 2, 5}) {
    EXPECT_LT(forecast[j], 0.2);
    EXPECT_LT(other.physical->joints[static_cast<std::size_t>(j)].relative_error, 3.0 * forecast[j]);
  }
  // Friction that no row shows is anything.
  EXPECT_TRUE(std::isinf(forecast[3]));
  EXPECT_TRUE(std::isinf(forecast[4]));
}

TEST_F(PredictionVerdict, AValidationOnALogOfTheFitIsAWarning) {
  const std::vector<Log> one = {log(1.0, 3)};
  EXPECT_TRUE(has(identify(robot, one, Estimation{}, one), "validation_log_used"));
}

// The error on rows that no option changes.
TEST_F(PredictionVerdict, ReferenceErrorDoesNotDependOnTheWindow) {
  const Log one = log(1.0, 3);
  const auto with = [&](int n_d) {
    return identify(robot, one, {.method = Wls{}, .signal = {.torque_held = true, .decimation = {n_d}}}).fit;
  };
  const Fit narrow = with(8);
  const Fit wide = with(30);
  EXPECT_GT(narrow.relative_error, 1.3 * wide.relative_error);
  EXPECT_NEAR(narrow.reference_error, wide.reference_error, 0.05 * wide.reference_error);
  EXPECT_NEAR(validate(robot, identify(robot, one, Estimation{}), one).fit.reference_error,
              wide.reference_error, 0.05 * wide.reference_error);
}

TEST_F(PredictionVerdict, ReferenceErrorIsThatOfThePapersRows) {
  const std::vector<Log> two = {log(1.0, 3), log(2.0, 4)};
  const Identification found = identify(robot, two, {.method = Wls{}});
  double errors = 0.0;
  double torques = 0.0;
  for (const Log& one : two) {
    // Of 200 Hz every fourth.
    const Rows rows =
        rivid::rows(robot, base, one, {.rows = RowScheme::paper, .cutoff_hz = 10.0, .decimation = {4}});
    const Matrix W = rows.W.dense();
    Vector Y(W.rows());
    Y << rows.Y[0], rows.Y[1];
    errors += (Y - W * found.chi).squaredNorm();
    torques += Y.squaredNorm();
  }
  EXPECT_NEAR(found.fit.reference_error, std::sqrt(errors / torques), 1e-9 * found.fit.reference_error);
}

// Neighbouring windows of a log that friction of another kind moves by more than chance are within the
// intervals.
TEST_F(PredictionVerdict, WhatNeighbouringWindowsSayIsInTheInterval) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Log one = log(1.0, seed);
    // A torque that the model does not have, faster than rows are long.
    for (Index k = 0; k < one.samples(); ++k) {
      one.v_tau(k, 0) += 0.5 * std::sin(7.0 * one.q(k, 0));
    }
    const Identification found = identify(robot, one, Estimation{});
    ASSERT_TRUE(found.row_choice);
    for (const WindowShift& shift : {found.row_choice->at_half, found.row_choice->at_double}) {
      ASSERT_EQ(shift.beyond_noise.size(), base.size());
      for (Index i = 0; i < base.size(); ++i) {
        const ParameterEstimate& p = found.parameters[static_cast<std::size_t>(i)];
        EXPECT_LE(std::abs(shift.beyond_noise[i]), 3.0 * p.sigma) << seed << ' ' << p.name;
      }
    }
  }
}

}  // namespace
}  // namespace rivid
