#include "rivid/identify/comparison.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/regressor/base.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr int decimation = 5;

// The SCARA swinging for 20 s at 200 Hz, and torques of its parameters with noise that is correlated over
// some 10 samples.
class Bench {
 public:
  Bench() {
    base_ = base_parameters(robot_);
    chi_ = Vector{{3.5, 0.06, 0.12, 0.25, 0.06, 0.03, 0.6, 0.25}}.head(base_.size());
    constexpr Index samples = 4000;
    log_.source = "swing.csv";
    log_.f_m = 200.0;
    log_.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / log_.f_m);
    log_.q.resize(samples, 2);
    log_.q.col(0) = (2.0 * log_.t.array()).sin() + 0.3 * (7.1 * log_.t.array()).cos();
    log_.q.col(1) = (3.0 * log_.t.array()).cos() + 0.2 * (9.3 * log_.t.array()).sin();
    log_.tau = Matrix::Ones(samples, 2);
    const Rows plain =
        rows(robot_, base_, log_, {.rows = RowScheme::paper, .decimation = {1}, .trim = {{0, 0}}});
    for (std::size_t j = 0; j < 2; ++j) {
      W_.push_back(Matrix::Zero(samples, base_.size()));
      for (std::size_t i = 0; i < plain.samples[j].size(); ++i) {
        for (std::size_t k = 0; k < plain.W.joints[j].columns.size(); ++k) {
          W_[j](plain.samples[j][i], plain.W.joints[j].columns[k]) =
              plain.W.joints[j].W(static_cast<Index>(i), static_cast<Index>(k));
        }
      }
    }
  }

  [[nodiscard]] Log log(std::mt19937_64& random) const {
    std::normal_distribution<double> normal;
    Log out = log_;
    for (Index j = 0; j < 2; ++j) {
      out.tau.col(j) = W_[static_cast<std::size_t>(j)] * chi_;
      double noise = 0.0;
      for (Index t = 0; t < out.samples(); ++t) {
        noise = 0.9 * noise + 0.05 * normal(random);
        out.tau(t, j) += noise;
      }
    }
    return out;
  }

  [[nodiscard]] ComparedModel model(std::string name, const Vector& error) const {
    return {std::move(name), robot_, base_.to_standard(chi_ + error)};
  }

  // A parameter error as an identification makes it, of random direction and so many deviations.
  [[nodiscard]] Vector error(std::mt19937_64& random, double deviations) const {
    std::normal_distribution<double> normal;
    Matrix information = Matrix::Zero(base_.size(), base_.size());
    for (const Matrix& W : W_) {
      information += W.transpose() * W;
    }
    const Vector white = Vector::NullaryExpr(base_.size(), [&] { return normal(random); });
    return deviations * 0.5 * information.llt().matrixU().solve(white);
  }

  [[nodiscard]] const Robot& robot() const { return robot_; }
  [[nodiscard]] static ComparisonOptions options() {
    return {.signal = {.rows = RowScheme::paper, .decimation = {decimation}}};
  }

 private:
  Robot robot_ = test::scara();
  BaseParameters base_;
  Vector chi_;
  Log log_;
  std::vector<Matrix> W_;
};

// A and B err by the same torque to either side of the truth: they predict equally well, whatever a log says.
TEST(Comparison, OfModelsThatPredictEquallyWellIsRarelyDecided) {
  constexpr int pairs = 200;
  constexpr std::uint64_t seed = 20261122;
  std::mt19937_64 random(seed);
  const Bench bench;
  int below_5_percent = 0;
  int decided = 0;
  for (int pair = 0; pair < pairs; ++pair) {
    const Vector error = bench.error(random, 3.0);
    const std::vector<ComparedModel> models = {bench.model("A", error), bench.model("B", -error)};
    const Log log = bench.log(random);
    const Comparison comparison = compare(models, std::span(&log, 1), Bench::options());
    const PairedTest& test = comparison.tests.front();
    ASSERT_TRUE(std::isfinite(test.p)) << "seed " << seed << ", pair " << pair;
    below_5_percent += test.p < 0.05 ? 1 : 0;
    decided += test.better ? 1 : 0;
  }
  RecordProperty("p_below_5_percent", below_5_percent);
  RecordProperty("called_better", decided);
  std::cout << below_5_percent << " of " << pairs << " with p < 0.05, " << decided << " called better\n";
  EXPECT_LE(decided, pairs / 20);
  // Within four standard errors of a test that keeps its level.
  EXPECT_LE(below_5_percent, 0.05 * pairs + 4.0 * std::sqrt(0.05 * 0.95 * pairs));
}

TEST(Comparison, FindsTheModelThatPredictsBetter) {
  constexpr int pairs = 20;
  constexpr std::uint64_t seed = 7;
  std::mt19937_64 random(seed);
  const Bench bench;
  int found = 0;
  for (int pair = 0; pair < pairs; ++pair) {
    const std::vector<ComparedModel> models = {bench.model("worse", bench.error(random, 40.0)),
                                               bench.model("truth", Vector::Zero(8))};
    const Log log = bench.log(random);
    const Comparison comparison = compare(models, std::span(&log, 1), Bench::options());
    EXPECT_LT(comparison.models[1].relative_error, comparison.models[0].relative_error);
    found += comparison.tests.front().better == std::size_t{1} ? 1 : 0;
    EXPECT_NE(comparison.tests.front().better, std::size_t{0});
  }
  EXPECT_GE(found, pairs - 1) << "seed " << seed;
}

// A motor that both joints turn has no rows where it reverses, and the other robot has no such motor.
TEST(Comparison, JudgesModelsOfOtherRowsOnThoseOfAll) {
  std::mt19937_64 random(5);
  const Bench bench;
  const ComparedModel plain = bench.model("plain", bench.error(random, 10.0));
  ComparedModel coupled{"coupled", bench.robot(), {}};
  coupled.robot.couplings = {{.motor = 1,
                              .joints = {0},
                              .ratios = {1.0},
                              .inertia = Coupling::Inertia::none,
                              .viscous = false,
                              .terms = Coupling::Terms::all}};
  coupled.chi_st = coupled.robot.chi_st();
  const std::vector<ComparedModel> models = {plain, coupled};
  const Log log = bench.log(random);
  const ComparisonOptions options{.signal = {.decimation = {decimation}}};
  const Comparison comparison = compare(models, std::span(&log, 1), options);
  std::vector<Prediction> predictions;
  for (const ComparedModel& model : models) {
    Identification result;
    result.base = base_parameters(model.robot);
    result.chi = result.base.from_standard(model.chi_st);
    result.estimation.signal = options.signal;
    predictions.push_back(predict(model.robot, result, log));
  }
  Index rows = 0;
  for (std::size_t j = 0; j < 2; ++j) {
    const std::vector<Index>& common = predictions[1].joints[j].rows;
    const JointPrediction& joint = predictions[0].joints[j];
    ASSERT_LT(common.size(), joint.rows.size());
    double squares = 0.0;
    double measured = 0.0;
    for (std::size_t i = 0; i < joint.rows.size(); ++i) {
      if (std::ranges::binary_search(common, joint.rows[i])) {
        squares += std::pow(joint.residual[static_cast<Index>(i)], 2);
        measured += std::pow(joint.fitted.measured[static_cast<Index>(i)], 2);
        ++rows;
      }
    }
    // The same sums in another order.
    EXPECT_NEAR(comparison.models[0].joints[j], std::sqrt(squares / measured), 1e-12) << j;
  }
  EXPECT_EQ(comparison.rows, rows);
}

TEST(Comparison, HasTheErrorsOfAValidation) {
  std::mt19937_64 random(3);
  const Bench bench;
  const ComparedModel model = bench.model("A", bench.error(random, 10.0));
  const std::vector<Log> logs = {bench.log(random)};
  Identification result;
  result.base = base_parameters(bench.robot());
  result.chi = result.base.from_standard(model.chi_st);
  result.estimation.signal = Bench::options().signal;
  const Fit fit = validate(bench.robot(), result, logs.front()).fit;
  const Comparison comparison = compare(std::span(&model, 1), logs, Bench::options());
  ASSERT_EQ(comparison.models.size(), 1U);
  EXPECT_TRUE(comparison.tests.empty());
  EXPECT_EQ(comparison.rows, fit.rows);
  // Sums of some thousand squares in another order.
  constexpr double rounding = 1e-12;
  EXPECT_NEAR(comparison.models[0].relative_error, fit.relative_error, rounding * fit.relative_error);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_NEAR(comparison.models[0].joints[j], fit.joints[j].relative_error,
                rounding * fit.joints[j].relative_error);
  }
  // Over time the joint with the larger error: its squares are those of the fit, its gaps are none.
  const Comparison::Trace& trace = comparison.traces.at(0);
  const std::size_t worst = comparison.models[0].joints[0] > comparison.models[0].joints[1] ? 0 : 1;
  EXPECT_EQ(trace.joint, comparison.joints[worst]);
  const Vector errors = trace.errors.col(0).array().isNaN().select(0.0, trace.errors.col(0));
  EXPECT_EQ((trace.errors.array() == trace.errors.array()).count(), fit.joints[worst].rows);
  EXPECT_NEAR(errors.norm(), predict(bench.robot(), result, logs.front()).joints[worst].residual.norm(),
              rounding * errors.norm());
  EXPECT_GT((trace.time.tail(trace.time.size() - 1) - trace.time.head(trace.time.size() - 1)).minCoeff(),
            0.0);
}

TEST(Comparison, OfThreeModelsCorrectsForThreePairs) {
  std::mt19937_64 random(5);
  const Bench bench;
  const std::vector<ComparedModel> models = {bench.model("A", bench.error(random, 3.0)),
                                             bench.model("B", bench.error(random, 3.0)),
                                             bench.model("C", bench.error(random, 3.0))};
  const Log log = bench.log(random);
  const Comparison all = compare(models, std::span(&log, 1), Bench::options());
  const Comparison two = compare(std::span(models).first(2), std::span(&log, 1), Bench::options());
  ASSERT_EQ(all.tests.size(), 3U);
  EXPECT_EQ(all.tests[0].t, two.tests[0].t);
  EXPECT_EQ(all.tests[0].p, std::min(1.0, 3.0 * two.tests[0].p));
}

TEST(Comparison, RefusesModelsOfOtherRobots) {
  std::mt19937_64 random(5);
  const Bench bench;
  std::vector<ComparedModel> models = {bench.model("A", Vector::Zero(8)), bench.model("B", Vector::Zero(8))};
  models[1].robot.joints[1].name = "elbow";
  const Log log = bench.log(random);
  const auto complaint = [&](std::span<const ComparedModel> which, const ComparisonOptions& options) {
    return test::complaint_of([&] { static_cast<void>(compare(which, std::span(&log, 1), options)); });
  };
  EXPECT_EQ(complaint(models, Bench::options()), "compare: B has other joints than A");
  EXPECT_EQ(complaint({}, Bench::options()), "compare: there is no model, or no log to judge it by");
  EXPECT_TRUE(test::says(complaint(models, {.blocks = 2}), "blocks is 2, must be at least 6"));
}

TEST(Comparison, RefusesLogsThatNoErrorIsRelativeTo) {
  std::mt19937_64 random(5);
  const Bench bench;
  const std::vector<ComparedModel> models = {bench.model("A", Vector::Zero(8)),
                                             bench.model("B", bench.error(random, 3.0))};
  ComparisonOptions options = Bench::options();
  options.signal = {.rows = RowScheme::exact, .decimation = {10}};
  const auto complaint = [&](const Log& log) {
    return test::complaint_of([&] { static_cast<void>(compare(models, std::span(&log, 1), options)); });
  };
  Log still = bench.log(random);
  still.q.setZero();
  EXPECT_TRUE(test::says(complaint(still), "there is no row to judge a model by"));
  Log dead = bench.log(random);
  dead.tau.setZero();
  EXPECT_TRUE(test::says(complaint(dead), "by a torque that changes: there is no row to judge a model by"));
  options.signal = {.rows = RowScheme::paper};
  EXPECT_TRUE(test::says(complaint(dead), "the torques are zero in every row"));
}

TEST(PairedTest, IsStudentsTestOfBlockSums) {
  // Twelve blocks of 100 entries, whose sums are 1 … 12; what goes up and down in pairs has no correlation
  // from one to the next.
  Vector series(1200);
  for (Index i = 0; i < series.size(); ++i) {
    series[i] = 0.01 * static_cast<double>(1 + i / 100) + (i % 4 < 2 ? 5.0 : -5.0);
  }
  const PairedTest test = paired_test(std::span(&series, 1), 12);
  EXPECT_EQ(test.blocks, 12);
  // Mean 6.5, variance 13.
  EXPECT_NEAR(test.t, 6.5 / std::sqrt(13.0 / 12.0), 1e-9);
  // SciPy: 2 * scipy.stats.t.sf(6.244997998398398, 11).
  EXPECT_NEAR(test.p, 6.30435e-05, 1e-9);
}

TEST(PairedTest, IsNotDecidedByAShortLog) {
  const Vector series = Vector::LinSpaced(20, -1.0, 1.0);
  EXPECT_TRUE(std::isnan(paired_test(std::span(&series, 1), 12).p));
}

TEST(ParameterChanges, AreInStandardDeviationsOfBothResults) {
  const std::vector<ParameterValue> before = {
      {"ZZ1", "kg·m²", 1.0, 0.03}, {"Fc1", "N·m", 2.0, 0.3}, {"gone", "N", 1.0, 0.1}, {"unknown", "N", 1.0}};
  const std::vector<ParameterValue> after = {
      {"Fc1", "N·m", 4.5, 0.4}, {"ZZ1", "kg·m²", 1.1, 0.04}, {"unknown", "N", 9.0, 0.1}};
  const std::vector<ParameterChange> changes = parameter_changes(before, after);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].name, "Fc1");
  EXPECT_NEAR(changes[0].sigma, 0.5, 1e-15);
  EXPECT_NEAR(changes[0].z, 5.0, 1e-12);
  EXPECT_EQ(changes[1].name, "ZZ1");
  EXPECT_NEAR(changes[1].z, 2.0, 1e-12);
  // Two-sided, two parameters.
  EXPECT_NEAR(changes[1].p, 2.0 * std::erfc(2.0 / std::sqrt(2.0)), 1e-9);
}

}  // namespace
}  // namespace rivid
