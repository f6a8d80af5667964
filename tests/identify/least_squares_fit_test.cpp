#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "rivid/identify/identification.hpp"
#include "rivid/report/text.hpp"
#include "rivid/signal/filter.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

const Vector truth{{3.44, 0.03, 0.82, 0.062, 0.242, 0.014, 0.013, 0.137}};

// A log of the SCARA on a smooth path whose torques are exactly those of the model on the differentiated
// positions, plus noise, on joint 2 `ratio` times that of joint 1.
Log scara_log(double torque_noise, std::uint64_t seed, double phase = 0.0, double ratio = 0.1) {
  const Robot robot = test::scara();
  Log log;
  log.source = "made.csv";
  log.f_m = 200.0;
  log.t = Vector::LinSpaced(2001, 0.0, 10.0);
  log.q.resize(2001, 2);
  log.q.col(0) = (2.0 * log.t.array() + phase).sin() + 0.5 * (5.3 * log.t.array()).sin();
  log.q.col(1) = (3.1 * log.t.array() + phase).cos() + 0.7 * (7.7 * log.t.array()).sin();
  const Observation W = observation(robot, base_parameters(robot), differentiate(log.q, log.f_m));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  log.tau = (W.dense() * truth).reshaped(2001, 2);
  log.tau += Matrix::NullaryExpr(
      2001, 2, [&](Index, Index j) { return (j == 0 ? 1.0 : ratio) * torque_noise * normal(random); });
  return log;
}

template <typename Method>
class LeastSquaresFit : public ::testing::Test {
 public:
  static Identification identified(const Log& log) {
    return identify(
        test::scara(), log,
        {.method = Method{}, .signal = {.rows = RowScheme::paper, .trim = {{2, 2}}}, .judge = false});
  }
};
using Methods = ::testing::Types<Ols, Wls>;
TYPED_TEST_SUITE(LeastSquaresFit, Methods);

TYPED_TEST(LeastSquaresFit, ReturnsTheTruthFromNoiseFreeData) {
  const Identification found = this->identified(scara_log(0.0, 1));
  EXPECT_EQ(found.status, Status::identified);
  EXPECT_LT((found.chi - truth).norm(), 1e-11);
  EXPECT_LT(found.fit.relative_error, 1e-12);
}

TYPED_TEST(LeastSquaresFit, ScalesParametersAndDeviationsWithTheTorque) {
  Log log = scara_log(0.1, 2);
  const Identification once = this->identified(log);
  log.tau *= 3.0;
  const Identification thrice = this->identified(log);
  for (std::size_t i = 0; i < once.parameters.size(); ++i) {
    EXPECT_NEAR(thrice.parameters[i].value, 3.0 * once.parameters[i].value, 1e-9);
    EXPECT_NEAR(thrice.parameters[i].sigma, 3.0 * once.parameters[i].sigma, 1e-9);
  }
  EXPECT_NEAR(thrice.fit.relative_error, once.fit.relative_error, 1e-12);
}

TYPED_TEST(LeastSquaresFit, OfTwoHalvesOfALogIsThatOfTheWhole) {
  const Log log = scara_log(0.1, 3);
  // The differences reach over two samples, which each half brings along and trims.
  const std::vector<Log> halves = {excerpt(log, 0, 1002), excerpt(log, 998, 1003)};
  const Identification whole = this->identified(log);
  const Identification split = identify(
      test::scara(), halves, {.method = TypeParam{}, .signal = {.rows = RowScheme::paper, .trim = {{2, 2}}}});
  EXPECT_EQ(split.fit.rows, whole.fit.rows);
  EXPECT_LT((split.chi - whole.chi).norm(), 1e-10);
  EXPECT_NEAR(split.fit.error_norm, whole.fit.error_norm, 1e-10);
}

// (17)–(19) with white noise of the same deviation on all rows, which is what they assume: 95 % of the
// intervals hold the truth, and the estimates scatter as their deviations say, within four deviations of 200
// runs.
TYPED_TEST(LeastSquaresFit, HasIntervalsThatHoldTheTruthAsOftenAsTheySay) {
  constexpr int runs = 200;
  int inside = 0;
  Vector squares = Vector::Zero(8);
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(1000 + run);
    const Identification found = this->identified(scara_log(0.05, seed, 0.0, 1.0));
    for (std::size_t i = 0; i < 8; ++i) {
      const ParameterEstimate& p = found.parameters[i];
      const double true_value = truth[static_cast<Index>(i)];
      inside += static_cast<int>(p.interval_95[0] <= true_value && true_value <= p.interval_95[1]);
      squares[static_cast<Index>(i)] += std::pow((p.value - true_value) / p.sigma, 2) / runs;
    }
  }
  const double coverage = static_cast<double>(inside) / (8.0 * runs);
  // The eight intervals of a run are correlated: they count as one.
  EXPECT_NEAR(coverage, 0.95, 4.0 * std::sqrt(0.95 * 0.05 / runs));
  for (const double square : squares) {
    EXPECT_NEAR(square, 1.0, 4.0 * std::sqrt(2.0 / runs));
  }
}

// (17) divides by r − b: of 56 rows for 8 parameters a division by r would give 0.86 of the variance.
TEST(Ols, EstimatesTheVarianceOfTheNoiseWithoutBias) {
  constexpr int runs = 400;
  constexpr double noise = 0.05;
  double mean = 0.0;
  Index freedom = 0;
  for (int run = 0; run < runs; ++run) {
    const Log log = excerpt(scara_log(noise, static_cast<std::uint64_t>(5000 + run), 0.0, 1.0), 400, 32);
    const Identification found = LeastSquaresFit<Ols>::identified(log);
    ASSERT_EQ(found.status, Status::identified);
    freedom = found.fit.rows - found.base.size();
    mean += std::pow(found.fit.sigma_rho / noise, 2) / runs;
  }
  EXPECT_EQ(freedom, 48);
  EXPECT_NEAR(mean, 1.0, 4.0 * std::sqrt(2.0 / static_cast<double>(freedom) / runs));
}

TEST(Wls, BeatsOlsWhereJointsHaveUnequalNoise) {
  const Log log = scara_log(0.3, 7);
  const Robot robot = test::scara();
  // One deviation for all rows is what classical deviations of OLS suffer from.
  const SignalOptions signal = {.rows = RowScheme::paper, .trim = {{2, 2}}};
  const CovarianceOptions classical = {.kind = CovarianceKind::classical};
  const Identification ols =
      identify(robot, log, {.method = Ols{}, .signal = signal, .covariance = classical});
  const Identification wls =
      identify(robot, log, {.method = Wls{}, .signal = signal, .covariance = classical});
  EXPECT_LT(wls.parameters[7].sigma, 0.5 * ols.parameters[7].sigma) << "Fc2 is seen by the quiet joint alone";
  EXPECT_NEAR(wls.fit.sigma_rho, 1.0, 0.05) << "weighted rows have unit deviation";
  EXPECT_NEAR(1.0 / wls.weights[0], 0.3, 0.03);
  EXPECT_NEAR(1.0 / wls.weights[1], 0.03, 0.003);
  EXPECT_GE(wls.fit.error_norm, ols.fit.error_norm) << "OLS has the smallest unweighted error";
}

TEST(Ols, ReportsTheFitOfEachJoint) {
  const Identification found =
      identify(test::scara(), scara_log(0.3, 8),
               {.method = Ols{}, .signal = {.rows = RowScheme::paper, .trim = {{2, 2}}}});
  ASSERT_EQ(found.fit.joints.size(), 2U);
  EXPECT_EQ(found.fit.rows, 2 * 1997);
  EXPECT_EQ(found.fit.joints[0].name, "joint_1");
  EXPECT_NEAR(found.fit.joints[0].sigma_rho, 0.3, 0.02);
  EXPECT_NEAR(found.fit.joints[1].sigma_rho, 0.03, 0.002);
  EXPECT_GE(found.fit.joints[0].centred_relative_error, found.fit.joints[0].relative_error);
  EXPECT_NEAR(std::hypot(0.3, 0.03) * std::sqrt(1997.0), found.fit.error_norm, 1.0);
}

TEST(Estimation, IsKeptInTheResultWithoutItsProgress) {
  int calls = 0;
  const Identification found = identify(test::scara(), scara_log(0.3, 8),
                                        {.method = Wls{},
                                         .signal = {.rows = RowScheme::paper, .trim = {{2, 2}}},
                                         .threads = 2,
                                         .progress = [&](std::string_view, double) { ++calls; }});
  EXPECT_GT(calls, 0);
  EXPECT_EQ(name(found.estimation.method), "wls");
  EXPECT_EQ(title(found.estimation.method), "IDIM-WLS");
  EXPECT_EQ(found.estimation.signal.trim, (std::array<Index, 2>{2, 2}));
  EXPECT_EQ(found.estimation.threads, 2);
  EXPECT_FALSE(found.estimation.progress);
}

TEST(Estimation, RefusesWhatCanNotBeMeantWhateverTheMethod) {
  for (const Method& method : {Method(Ols{}), Method(Wls{})}) {
    Estimation estimation{.method = method};
    EXPECT_FALSE(estimation.complaint(test::scara()));
    estimation.threads = 0;
    EXPECT_EQ(estimation.complaint(test::scara()), "threads is 0, must be at least 1");
    estimation = {.method = method, .signal = {.order = 0}};
    EXPECT_EQ(estimation.complaint(test::scara()), "order is 0, must lie between 1 and 20");
    estimation = {.method = method, .physical = Physical{.weight = 0.0}};
    EXPECT_EQ(estimation.complaint(test::scara()), "physical: weight is 0, must be positive");
  }
  EXPECT_TRUE(Estimation{.method = Iv{}}.complaint(test::scara()).value().starts_with("control is not set"));
}

TEST(Ols, NamesWhatALogCanNotTell) {
  Log log = scara_log(0.1, 9);
  log.q.col(1).setConstant(0.4);  // joint 2 never moves: ZZ2, MX2, MY2 act like ZZ1R, no friction of joint 2
  const Identification found =
      identify(test::scara(), log, {.method = Ols{}, .signal = {.rows = RowScheme::paper, .trim = {{2, 2}}}});
  EXPECT_EQ(found.status, Status::rank_deficient);
  ASSERT_FALSE(found.reasons.empty());
  EXPECT_NE(found.reasons.front().find("Fv2 and Fc2 are not excited by these data"), std::string::npos)
      << found.reasons.front();
  EXPECT_TRUE(std::isnan(found.parameters[7].value));
  EXPECT_TRUE(std::isfinite(found.parameters[1].value)) << "Fv1 is seen all the same";
  std::ostringstream table;
  table << found;
  EXPECT_NE(table.str().find("rank_deficient"), std::string::npos);
  EXPECT_NE(table.str().find("not determined"), std::string::npos);
}

TEST(Ols, RefusesFewerRowsThanParameters) {
  Log log = excerpt(scara_log(0.1, 10), 0, 8);
  EXPECT_EQ(test::complaint_of([&] {
              return identify(test::scara(), log,
                              {.method = Ols{}, .signal = {.rows = RowScheme::paper, .trim = {{2, 2}}}});
            }),
            "identify(IDIM-OLS): 8 rows for 8 base parameters; more rows than parameters are needed");
}

TEST(Validate, TellsTheErrorOfTheModelOnAnotherLog) {
  const Robot robot = test::scara();
  const SignalOptions signal{.rows = RowScheme::paper, .trim = {{2, 2}}};
  const Identification found = identify(robot, scara_log(0.3, 11), {.method = Ols{}, .signal = signal});
  const Validation other = validate(robot, found, scara_log(0.3, 12, 1.0));
  EXPECT_EQ(other.file, "made.csv");
  EXPECT_NEAR(other.fit.joints[0].sigma_rho, 0.3, 0.02);
  EXPECT_LT(other.fit.relative_error, 0.1);
}

}  // namespace
}  // namespace rivid
