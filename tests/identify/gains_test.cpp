#include "rivid/identify/gains.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/regressor/base.hpp"
#include "support/complaint.hpp"
#include "support/payload_bench.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using test::Box;
using test::PayloadBench;
using test::six_axis;

Vector six(double a, double b, double c, double d, double e, double f) {
  Vector out(6);
  out << a, b, c, d, e, f;
  return out;
}

// Currents of an arm whose gains are told as 1.
class Currents {
 public:
  explicit Currents(Index samples = 2500, Vector gains = six(1.1, 0.9, 1.05, 0.8, 1.25, 0.5))
      : truth(std::move(gains)), bench(six_axis(), samples) {
    bench.gains = truth.cwiseInverse();
  }

  [[nodiscard]] Log log(const Inertial& load, double sigma, std::uint64_t seed, std::uint64_t motion) const {
    Log out = bench.log(load, sigma, seed, motion);
    out.v_tau.swap(out.tau);
    return out;
  }
  [[nodiscard]] Log unloaded(double sigma, std::uint64_t seed) const {
    return log(Inertial::Zero(), sigma, seed, 1);
  }

  Vector truth;
  PayloadBench bench;
};

GainReport estimated(const Currents& currents, const Log& log, const GainOptions& options) {
  return identify_gains(currents.bench.robot, std::span(&log, 1), {}, {.signal = PayloadBench::signal()},
                        options);
}

void expect_gains(const GainReport& found, const Vector& wanted) {
  ASSERT_TRUE(found.identified) << found.scale;
  for (std::size_t j = 0; j < found.joints.size(); ++j) {
    EXPECT_NEAR(found.joints[j].value, wanted[static_cast<Index>(j)], 1e-5) << j;
    EXPECT_TRUE(found.joints[j].identifiable) << j;
  }
}

TEST(Gains, FollowFromAKnownMass) {
  const Currents currents;
  const Box box;
  const Log without = currents.unloaded(0.0, 1);
  const Log with = currents.log(box.inertial(), 0.0, 2, 2);
  expect_gains(identify_gains(currents.bench.robot, std::span(&without, 1), std::span(&with, 1),
                              {.signal = PayloadBench::signal()}, {.mass = box.mass}),
               currents.truth);
}

TEST(Gains, FollowWhereAJointStands) {
  const Robot robot = PayloadBench(six_axis()).robot;
  const auto log = [&](const Inertial& load, std::uint64_t seed, const std::vector<Index>& at_rest) {
    Log out = test::log_with_joints_at_rest(robot, load, seed, at_rest);
    out.v_tau.swap(out.tau);
    out.v_tau *= 0.8;
    return out;
  };
  const Box box;
  const Log with = log(box.inertial(), 2, {4});
  for (const std::vector<Index>& at_rest : {std::vector<Index>{}, {4}}) {
    const Log without = log(Inertial::Zero(), 1, at_rest);
    const GainReport found =
        identify_gains(robot, std::span(&without, 1), std::span(&with, 1),
                       {.signal = {.torque_held = false, .decimation = {10}}}, {.mass = box.mass});
    ASSERT_TRUE(found.identified) << found.scale;
    EXPECT_NEAR(found.joints[1].value, 1.25, 0.01);
    EXPECT_EQ(found.joints[4].identifiable, at_rest.empty());
  }
}

// Ratios are known ten thousand times better than the scale: what rounding leaves of the covariance is taken
// by identify() all the same.
TEST(Gains, HaveACovarianceWhereTheScaleIsFaint) {
  const Currents currents;
  const Log without = currents.unloaded(1e-3, 1);
  for (const double mass : {1e-2, 1e-3, 1e-4}) {
    const Log with = currents.log(mass * Box().inertial() / Box().mass, 1e-3, 2, 2);
    Estimation estimation{.signal = PayloadBench::signal()};
    const GainReport found = identify_gains(currents.bench.robot, std::span(&without, 1), std::span(&with, 1),
                                            estimation, {.mass = mass});
    estimation.gain_covariance = found.C;
    EXPECT_FALSE(estimation.complaint(currents.bench.robot)) << mass << ": " << found.C;
  }
}

TEST(Gains, HaveTheUnitOfTheCurrent) {
  const Currents currents;
  const Log amperes = currents.unloaded(0.05, 3);
  const std::string known = currents.bench.robot.joints[1].name;
  const GainOptions options{.known = {{known, 0.02}}};
  const GainReport once = estimated(currents, amperes, options);
  Currents other = currents;
  for (Joint& joint : other.bench.robot.joints) {
    joint.drive_gain *= 1000.0;
  }
  Log thousands = amperes;
  thousands.v_tau /= 1000.0;
  const GainReport scaled = estimated(other, thousands, options);
  ASSERT_TRUE(once.identified && scaled.identified);
  for (std::size_t j = 0; j < once.joints.size(); ++j) {
    EXPECT_NEAR(scaled.joints[j].value / once.joints[j].value, 1000.0, 1e-3);
    EXPECT_NEAR(scaled.joints[j].sigma / once.joints[j].sigma, 1000.0, 1e-3);
  }
}

TEST(Gains, FollowFromOneThatIsKnown) {
  const Currents currents(2500, six(1.1, 1.0, 1.05, 0.8, 1.25, 0.5));
  const std::string known = currents.bench.robot.joints[1].name;
  expect_gains(estimated(currents, currents.unloaded(0.0, 1), {.known = {{known, 0.0}}}), currents.truth);
}

TEST(Gains, AreRatiosWithoutAScale) {
  const Currents currents;
  const GainReport found = estimated(currents, currents.unloaded(0.0, 1), {});
  EXPECT_TRUE(test::says(found.scale, "Only ratios"));
  Index reference = -1;
  for (Index j = 0; j < 6; ++j) {
    reference = found.joints[static_cast<std::size_t>(j)].sigma < 1e-3 &&
                        std::abs(found.joints[static_cast<std::size_t>(j)].value - 1.0) < 1e-9
                    ? j
                    : reference;
  }
  ASSERT_GE(reference, 0);
  EXPECT_TRUE(test::says(found.scale, currents.bench.robot.joints[static_cast<std::size_t>(reference)].name));
  expect_gains(found, currents.truth / currents.truth[reference]);
}

TEST(Gains, FollowUnderFrictionByLoad) {
  Currents currents(2500, six(1.1, 1.0, 1.05, 0.8, 1.25, 0.5));
  currents.bench.Fl = Vector::LinSpaced(6, 0.03, 0.12);
  Robot robot = currents.bench.robot;
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::load;
  }
  const Log log = currents.unloaded(0.0, 1);
  expect_gains(identify_gains(robot, std::span(&log, 1), {}, {.signal = PayloadBench::signal()},
                              {.known = {{robot.joints[1].name, 0.0}}}),
               currents.truth);
}

// Two slides at right angles: no parameter is felt by both.
Robot gantry() {
  Robot robot = test::slider();
  robot.chain.links.push_back(robot.chain.links.front());
  robot.joints.push_back(robot.joints.front());
  robot.joints.back().name = "joint_2";
  robot.joints.back().link = "cross_slide";
  robot.chain.gravity.setZero();
  robot.inertials.assign(2, inertial_from_com(5.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()));
  return robot;
}

TEST(Gains, AreNotIdentifiableWhereTheScaleDoesNotReach) {
  PayloadBench bench(gantry());
  bench.gains = Vector::Constant(2, 1.25);
  Log log = bench.log(Inertial::Zero(), 0.1, 1, 1);
  log.v_tau.swap(log.tau);
  const GainReport found = identify_gains(bench.robot, std::span(&log, 1), {},
                                          {.signal = PayloadBench::signal()}, {.known = {{"joint_1", 0.0}}});
  ASSERT_TRUE(found.identified) << found.scale;
  EXPECT_FALSE(found.joints[1].identifiable);
  EXPECT_GT(found.joints[1].sigma, 0.5 * std::abs(found.joints[1].value));
  EXPECT_EQ(with_gains(bench.robot, found).joints[1].drive_gain, bench.robot.joints[1].drive_gain);
  // What is open of the nominal gain is no less than what made the estimate useless.
  EXPECT_NEAR(std::sqrt(found.C(1, 1)), 0.3, 1e-12);
  EXPECT_EQ(found.C(0, 1), 0.0);
  Robot one = bench.robot;
  one.joints.resize(1);
  one.inertials.resize(1);
  one.chain.links.resize(1);
  EXPECT_TRUE(test::says(GainOptions().complaint(one).value_or(""), "one joint alone"));
}

struct Coverage {
  int held = 0;
  int all = 0;

  void add(const std::array<double, 2>& interval, double truth) {
    held += interval[0] <= truth && truth <= interval[1] ? 1 : 0;
    ++all;
  }
  [[nodiscard]] double part() const { return static_cast<double>(held) / all; }
};

// And so do the parameters that follow from them, whose intervals are too short where the gains count as
// exact. The motion shows little of the gain of joint 6.
TEST(Gains, HaveNoBiasAndHoldInTheirIntervals) {
  constexpr int runs = 40;
  constexpr double sigma = 0.01;
  Currents currents(3000, six(1.1, 1.0, 1.05, 0.8, 1.25, 1.0));
  const Vector off = sigma * test::standard_normal(runs, 5);
  const Robot& robot = currents.bench.robot;
  const Estimation estimation{.method = Wls{}, .signal = PayloadBench::signal()};
  const BaseParameters base = base_parameters(robot);
  const Vector chi = base.from_standard(robot.chi_st());
  Coverage of_gains;
  Coverage of_parameters;
  Coverage with_exact_gains;
  Vector errors = Vector::Zero(5);
  Vector counts = Vector::Zero(5);
  for (int run = 0; run < runs; ++run) {
    currents.truth[1] = 1.0 + off[run];
    currents.bench.gains = currents.truth.cwiseInverse();
    const Log log = currents.unloaded(0.1, 700 + static_cast<std::uint64_t>(run));
    const GainReport found =
        identify_gains(robot, std::span(&log, 1), {}, estimation, {.known = {{robot.joints[1].name, sigma}}});
    ASSERT_TRUE(found.identified) << found.scale;
    for (Index j = 0; j < 5; ++j) {
      const GainEstimate& gain = found.joints[static_cast<std::size_t>(j)];
      if (gain.identifiable) {
        of_gains.add(gain.interval_95, currents.truth[j]);
        errors[j] += gain.value / currents.truth[j] - 1.0;
        ++counts[j];
      }
    }
    Estimation with = estimation;
    with.gain_covariance = found.C;
    const Robot calibrated = with_gains(robot, found);
    const Identification carried = identify(calibrated, log, with);
    const Identification exact = identify(calibrated, log, estimation);
    for (Index i = 0; i < base.size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      of_parameters.add(carried.parameters[at].interval_95, chi[i]);
      with_exact_gains.add(exact.parameters[at].interval_95, chi[i]);
    }
  }
  RecordProperty("coverage_of_gains", std::to_string(of_gains.part()));
  RecordProperty("coverage_of_parameters", std::to_string(of_parameters.part()));
  RecordProperty("with_exact_gains", std::to_string(with_exact_gains.part()));
  EXPECT_GE(counts.sum(), 0.9 * 5 * runs);
  const Vector bias = errors.cwiseQuotient(counts.cwiseMax(1.0));
  RecordProperty("largest_bias", std::to_string(bias.cwiseAbs().maxCoeff()));
  EXPECT_LT(bias.cwiseAbs().maxCoeff(), 0.01) << bias.transpose();
  EXPECT_GE(of_gains.part(), 0.92);
  EXPECT_LE(of_gains.part(), 0.985);
  EXPECT_GE(of_parameters.part(), 0.92);
  EXPECT_LE(of_parameters.part(), 0.985);
  EXPECT_LT(with_exact_gains.part(), of_parameters.part());
}

// [A b] of W_j χ + L_j λ − K_j i_j = 0 with a payload λ of known mass: what least squares with the currents
// as regressors is made of. The gains are the columns before the last.
Matrix currents_as_regressors(const Robot& robot, const Log& without, const Log& with, double mass) {
  const BaseParameters base = base_parameters(robot);
  const detail::BodyColumns columns(robot, base);
  const Index b = base.size();
  Matrix out = Matrix::Zero(12 * without.samples(), b + 9 + 6 + 1);
  Index row = 0;
  for (const Log* const log : {&without, &with}) {
    const Rows made = rows(robot, columns.all, *log, PayloadBench::signal());
    for (std::size_t j = 0; j < 6; ++j) {
      const Index count = made.Y[j].size();
      auto of_joint = out.middleRows(row, count);
      Matrix W = Matrix::Zero(count, columns.all.size());
      W(Eigen::all, made.W.joints[j].columns) = made.W.joints[j].W;
      of_joint.leftCols(b) = W.leftCols(b);
      if (log == &with) {
        for (std::size_t k = 0; k < 9; ++k) {
          of_joint.col(b + static_cast<Index>(k)) = W.col(columns.body[k]);
        }
        of_joint.rightCols(1) = -mass * W.col(columns.body[9]);
      }
      of_joint.col(b + 9 + static_cast<Index>(j)) = -made.Y[j];
      row += count;
    }
  }
  return out.topRows(row);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

// Why the currents stand on the left: where they are regressors, their noise shrinks the gains, and total
// least squares, which takes all columns for equally noisy, is not better.
TEST(Gains, AreBiasedByOrdinaryAndTotalLeastSquares) {
  constexpr int runs = 20;
  const Currents currents(1500, six(0.9, 1.12, 0.95, 1.2, 1.0, 0.8));
  const Robot& robot = currents.bench.robot;
  const Box box{.mass = 8.0};
  std::array<std::array<std::vector<double>, 6>, 3> ratios;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const Log without = currents.log(Inertial::Zero(), 0.5, 900 + 2 * run, 1);
    const Log with = currents.log(box.inertial(), 0.5, 901 + 2 * run, 2);
    const Matrix Ab = currents_as_regressors(robot, without, with, box.mass);
    const Matrix N = Ab.transpose() * Ab;
    const Index p = N.rows() - 1;
    const Vector ordinary = N.topLeftCorner(p, p).ldlt().solve(N.col(p).head(p));
    const Vector least = Eigen::SelfAdjointEigenSolver<Matrix>(N).eigenvectors().col(0);
    const GainReport found = identify_gains(robot, std::span(&without, 1), std::span(&with, 1),
                                            {.signal = PayloadBench::signal()}, {.mass = box.mass});
    for (std::size_t j = 0; j < 6; ++j) {
      const Index at = p - 6 + static_cast<Index>(j);
      const double truth = currents.truth[static_cast<Index>(j)];
      ratios[0][j].push_back(found.joints[j].value / truth);
      ratios[1][j].push_back(ordinary[at] / truth);
      ratios[2][j].push_back(-least[at] / least[p] / truth);
    }
  }
  std::array<double, 3> worst = {};
  for (std::size_t way = 0; way < 3; ++way) {
    std::cout << "[ GAINS    ] "
              << std::array{"currents on the left", "ordinary least squares", "total least squares"}[way]
              << ", median of K / K_true:";
    for (const std::vector<double>& ratio : ratios[way]) {
      std::cout << ' ' << median(ratio);
      worst[way] = std::max(worst[way], std::abs(median(ratio) - 1.0));
    }
    std::cout << '\n';
  }
  EXPECT_LT(worst[0], 0.03);
  EXPECT_GT(worst[1], 3.0 * worst[0]);
  EXPECT_GT(worst[2], 3.0 * worst[0]);
}

// δχ / χ = δK / K where all gains err alike.
TEST(Gains, CarryTheirCommonDeviationToEveryParameter) {
  const Currents currents(2500, Vector::Ones(6));
  const Robot& robot = currents.bench.robot;
  const Log log = currents.unloaded(1e-6, 1);
  const Identification found = identify(robot, log,
                                        {.method = Wls{},
                                         .signal = PayloadBench::signal(),
                                         .gain_covariance = 0.02 * 0.02 * Matrix::Ones(6, 6),
                                         .judge = false});
  for (const ParameterEstimate& p : found.parameters) {
    EXPECT_NEAR(p.sigma, 0.02 * std::abs(p.value), 1e-5) << p.name;
  }
}

// Least squares are linear in the torques: what one joint's are scaled by is what the estimate moves by.
TEST(Gains, MoveTheParametersByTheirSlopes) {
  const PayloadBench bench(six_axis());
  const Log log = bench.log(Inertial::Zero(), 0.5, 1, 1);
  const Estimation estimation{.method = Ols{}, .signal = PayloadBench::signal()};
  const Identification found = identify(bench.robot, log, estimation);
  for (Index j = 0; j < 6; ++j) {
    Log scaled = log;
    scaled.tau.col(j) *= 1.1;
    const Vector moved = identify(bench.robot, scaled, estimation).chi - found.chi;
    EXPECT_LT((moved - 0.1 * found.gain_slopes.col(j)).norm(), 1e-9 * found.chi.norm()) << j;
  }
}

TEST(Gains, RefuseWhatCanNotBeEstimated) {
  const Currents currents(500);
  const Log log = currents.unloaded(0.1, 1);
  const auto complaint = [&](const Log& one, const GainOptions& options) {
    return test::complaint_of([&] { static_cast<void>(estimated(currents, one, options)); });
  };
  EXPECT_TRUE(test::says(complaint(log, {.known = {{"elbow", 0.1}}}), "joint \"elbow\""));
  EXPECT_TRUE(test::says(complaint(log, {.known = {{currents.bench.robot.joints[0].name, -0.1}}}),
                         "must not be negative"));
  EXPECT_TRUE(test::says(complaint(log, {.mass = 2.0}), "logs with that payload"));
  Log torques = log;
  torques.tau.swap(torques.v_tau);
  EXPECT_TRUE(test::says(complaint(torques, {}), "name the columns control"));
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           static_cast<void>(
                               identify(currents.bench.robot, log,
                                        {.method = Wls{}, .gain_covariance = Matrix::Ones(2, 2)}));
                         }),
                         "gain_covariance is 2 × 2"));
}

}  // namespace
}  // namespace rivid
