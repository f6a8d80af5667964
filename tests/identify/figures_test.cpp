#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "identify/figures/friction_curves.hpp"
#include "identify/figures/joint_rows.hpp"
#include "identify/figures/residual_shape.hpp"
#include "report/documents.hpp"
#include "support/random_matrix.hpp"
#include "support/robots.hpp"

namespace rivid::detail {
namespace {

constexpr double pi = std::numbers::pi;

// Rows of one joint with these parts, a log of its own.
Prediction log_of_parts(const Vector& gravity, const Vector& friction, std::vector<Index> rows = {}) {
  Prediction out{.f_m = 100.0, .row_stride = 2};
  JointPrediction& joint = out.joints.emplace_back();
  const Index size = gravity.size();
  if (rows.empty()) {
    for (Index k = 0; k < size; ++k) {
      rows.push_back(2 * k);
    }
  }
  joint.rows = std::move(rows);
  joint.measured = Vector::Zero(100);
  joint.fitted = {.position = Vector::LinSpaced(size, 0.0, 1.0),
                  .velocity = Vector::Constant(size, 0.5),
                  .measured = gravity + friction + Vector::Constant(size, 0.125),
                  .a_priori = gravity,
                  .gravity = gravity,
                  .inertia = Vector::Zero(size),
                  .coriolis = Vector::Zero(size),
                  .friction = friction,
                  .column_rms = Vector::Zero(2)};
  joint.residual = Vector::Constant(size, 0.125);
  return out;
}

TEST(TorqueShares, AreThoseOfTheMeanAbsoluteTorqueOfTheFit) {
  std::vector<Prediction> logs = {log_of_parts(Eigen::Vector2d(3.0, -3.0), Eigen::Vector2d(1.0, 1.0)),
                                  log_of_parts(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(-9.0, 9.0))};
  logs[1].validation = true;
  const TorqueShares shares = torque_shares(logs, 0);
  EXPECT_DOUBLE_EQ(shares.gravity, 0.75);
  EXPECT_DOUBLE_EQ(shares.friction, 0.25);
  EXPECT_DOUBLE_EQ(shares.inertia + shares.coriolis, 0.0);
  logs[1].validation = false;
  EXPECT_DOUBLE_EQ(torque_shares(logs, 0).gravity, 6.0 / 26.0);
  EXPECT_TRUE(std::isnan(torque_shares({}, 0).gravity));
}

TEST(StackedRows, StandOneLogAfterTheOtherAndKnowTheirGaps) {
  const std::vector<Prediction> logs = {
      log_of_parts(Eigen::Vector3d(1.0, 2.0, 3.0), Eigen::Vector3d(0.5, 0.5, 0.5), {0, 2, 8}),
      log_of_parts(Eigen::Vector2d(4.0, 5.0), Eigen::Vector2d(-0.5, -0.5))};
  const StackedRows rows = stacked_rows(logs, 0);
  ASSERT_EQ(rows.time.size(), 5);
  // 100 samples of 100 Hz each.
  const std::vector<double> times = {0.0, 0.02, 0.08, 1.0, 1.02};
  for (std::size_t k = 0; k < times.size(); ++k) {
    EXPECT_DOUBLE_EQ(rows.time[static_cast<Index>(k)], times[k]);
  }
  EXPECT_EQ(rows.begins, (std::vector<Index>{0, 2, 3}));
  EXPECT_DOUBLE_EQ(rows.measured[3], 4.0 - 0.5 + 0.125);
  EXPECT_DOUBLE_EQ(rows.predicted[3], 4.0 - 0.5);
  EXPECT_DOUBLE_EQ(rows.friction[3], -0.5 + 0.125) << "the friction of the model and the residual";
}

TEST(APrioriError, IsRelativeToTheMeasuredTorque) {
  const Prediction log = log_of_parts(Eigen::Vector2d(3.0, 4.0), Eigen::Vector2d(-0.125, -0.125));
  EXPECT_DOUBLE_EQ(a_priori_error(log, 0), 0.0);
  const Prediction other = log_of_parts(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(3.0, 4.0));
  EXPECT_DOUBLE_EQ(a_priori_error(other, 0), 1.0);
}

// τ = Fv q̇ + Fc sign q̇ + off with the variance φᵀ C φ.
TEST(FrictionCurve, IsTheLawWithTheBandOfItsParameters) {
  Robot robot = test::scara();
  robot.joints[1].friction = Friction::symmetric;
  robot.joints[1].Fv = 0.4;
  robot.joints[1].Fc = 0.7;
  Identification result;
  result.base = base_parameters(robot);
  const Index b = result.base.size();
  result.chi = Vector::LinSpaced(b, 1.0, 2.0);
  Matrix half = Matrix::Zero(b, b);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (double& entry : half.reshaped()) {
    entry = normal(random);
  }
  result.C_chi = half * half.transpose();
  result.covariance.quantile_975 = 2.5;
  std::array<Index, 3> at = {};
  for (Index i = 0; i < b; ++i) {
    const std::string& name = result.base.parameters[static_cast<std::size_t>(i)].name;
    at[0] = name == "Fv2" ? i : at[0];
    at[1] = name == "Fc2" ? i : at[1];
    at[2] = name == "off2" ? i : at[2];
  }
  const FrictionCurve curve = friction_law(robot, result, 1, 3.0, 7.0);
  EXPECT_DOUBLE_EQ(curve.velocity[0], -3.0);
  EXPECT_DOUBLE_EQ(curve.velocity[curve.velocity.size() - 1], 3.0);
  for (Index k = 0; k < curve.velocity.size(); ++k) {
    const double v = curve.velocity[k];
    const std::array<double, 3> phi = {v, v < 0.0 ? -1.0 : 1.0, 1.0};
    double torque = 0.0;
    double variance = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      torque += phi[i] * result.chi[at[i]];
      for (std::size_t j = 0; j < 3; ++j) {
        variance += phi[i] * result.C_chi(at[i], at[j]) * phi[j];
      }
    }
    EXPECT_NEAR(curve.torque[k], torque, 1e-12);
    EXPECT_NEAR(curve.a_priori[k], 0.4 * phi[0] + 0.7 * phi[1], 1e-12);
    EXPECT_NEAR(curve.sigma[k], std::sqrt(variance), 1e-10);
    EXPECT_NEAR(curve.half_width[k], 2.5 * std::sqrt(variance), 1e-10);
  }
}

Robot scara_with_load() {
  Robot robot = test::scara();
  robot.joints[1].friction = Friction::load;
  return robot;
}

// Fl2 = 0.25, all else zero.
Identification load_friction_alone(const Robot& robot) {
  Identification result;
  result.base = base_parameters(robot);
  result.chi = Vector::Zero(result.base.size());
  for (Index i = 0; i < result.chi.size(); ++i) {
    result.chi[i] = result.base.parameters[static_cast<std::size_t>(i)].name == "Fl2" ? 0.25 : 0.0;
  }
  return result;
}

TEST(FrictionCurve, ShowsFrictionByLoadAtTheLoadThatIsGiven) {
  const Robot robot = scara_with_load();
  const Identification result = load_friction_alone(robot);
  const FrictionCurve curve = friction_law(robot, result, 1, 3.0, 8.0);
  EXPECT_DOUBLE_EQ(curve.torque[0], -2.0);
  EXPECT_DOUBLE_EQ(curve.torque[curve.torque.size() - 1], 2.0);
}

// Rows belong to the point of the curve that is nearest, on their own side of rest; the load is the mean of
// what is no friction.
TEST(FrictionCurve, HasTheMeansOfTheRows) {
  const Robot robot = scara_with_load();
  const Identification result = load_friction_alone(robot);
  StackedRows rows;
  rows.velocity = Eigen::Vector4d(2.0, 1.99, -0.001, 0.001);
  rows.friction = Eigen::Vector4d(3.0, 5.0, -7.0, 8.0);
  rows.residual = Eigen::Vector4d(0.5, 0.5, -0.5, 0.5);
  rows.predicted = rows.friction - rows.residual + Eigen::Vector4d(4.0, -12.0, 4.0, -12.0);
  const FrictionCurve curve = friction_curve(robot, result, 1, rows);
  EXPECT_EQ(curve.joint, robot.joints[1].name);
  EXPECT_DOUBLE_EQ(curve.load, 8.0);
  EXPECT_DOUBLE_EQ(curve.velocity[121], 2.1);
  EXPECT_DOUBLE_EQ(curve.torque[121], 2.0);
  EXPECT_DOUBLE_EQ(curve.rows.sum(), 4.0);
  Index at = 0;
  (curve.velocity.array() - 2.0).abs().minCoeff(&at);
  EXPECT_DOUBLE_EQ(curve.rows[at], 2.0);
  EXPECT_DOUBLE_EQ(curve.measured[at], 4.0);
  EXPECT_DOUBLE_EQ(curve.measured[60], -7.0);
  EXPECT_DOUBLE_EQ(curve.measured[61], 8.0);
  EXPECT_TRUE(std::isnan(curve.measured[0]));
}

TEST(FrictionCurve, IsATableThatNamesItsJoints) {
  FrictionCurve curve;
  curve.joint = "a, \"b\"";
  curve.velocity = curve.torque = curve.a_priori = curve.measured = curve.rows = Vector::Constant(1, 2.0);
  curve.sigma = curve.half_width = Vector::Constant(1, 0.5);
  EXPECT_EQ(to_csv(std::vector{curve}),
            "joint,velocity,friction,sigma,low_95,high_95,a_priori,measured,rows\n"
            "\"a, \"\"b\"\"\",2,2,0.5,1.5,2.5,2,2,2\n");
}

// Two sinusoids on a grid of times with gaps: their amplitudes come out, and nothing else rises.
TEST(AmplitudeSpectrum, FindsSinusoidsAmongUnevenRows) {
  Vector t(600);
  for (Index k = 0; k < t.size(); ++k) {
    t[k] = 0.05 * static_cast<double>(k + (k > 200 ? 37 : 0) + (k > 450 ? 11 : 0));
  }
  const Vector r =
      0.7 * (2.0 * pi * 3.0 * t.array() + 0.4).sin() + 0.2 * (2.0 * pi * 6.5 * t.array() - 1.0).sin() + 5.0;
  const Spectrum found = amplitude_spectrum(t, r, 10.0, 240);
  ASSERT_EQ(found.frequency.size(), 240);
  EXPECT_DOUBLE_EQ(found.frequency[239], 10.0);
  Index peak = 0;
  found.amplitude.maxCoeff(&peak);
  EXPECT_NEAR(found.frequency[peak], 3.0, 1e-9);
  EXPECT_NEAR(found.amplitude[peak], 0.7, 0.01);
  EXPECT_NEAR(found.amplitude[155], 0.2, 0.03) << "6.5 Hz";
  EXPECT_LT(found.amplitude[220], 0.03) << "9.2 Hz";
}

// Over a position that goes to and fro, a wave of the gear is one line.
TEST(AmplitudeSpectrum, FindsTheOrderOfAWaveOverPosition) {
  const Vector t = Vector::LinSpaced(2000, 0.0, 40.0);
  const Vector turns = (0.7 * t.array()).sin() + 0.3 * (1.9 * t.array()).cos();
  const Vector r = 0.4 * (2.0 * pi * 12.0 * turns.array()).cos();
  const Spectrum found = amplitude_spectrum(turns, r, 40.0, 240);
  Index peak = 0;
  found.amplitude.maxCoeff(&peak);
  EXPECT_NEAR(found.frequency[peak], 12.0, 1e-9);
  EXPECT_NEAR(found.amplitude[peak], 0.4, 0.01);
}

// By definition 1 % of the frequencies of white noise are above, whatever the number of stretches.
TEST(AmplitudeSpectrum, TellsWhatWhiteNoiseStaysBelow) {
  constexpr int runs = 60;
  for (const double length : {20.0, 400.0}) {
    Index above = 0;
    Index all = 0;
    for (int run = 0; run < runs; ++run) {
      std::mt19937_64 random(static_cast<unsigned>(100 + run));
      std::normal_distribution<double> normal(0.0, 3.0);
      const auto rows = static_cast<Index>(20.0 * length);
      const Vector t = Vector::LinSpaced(rows, 0.0, length);
      Vector r(rows);
      for (double& value : r) {
        value = normal(random);
      }
      // Below half the rate, where sine and cosine are of one size.
      const Spectrum found = amplitude_spectrum(t, r, 8.0, 100);
      above += (found.amplitude.array() > found.noise).count();
      all += found.amplitude.size();
    }
    // A binomial of 6000 with p = 0.01 has a deviation of 0.0013.
    EXPECT_NEAR(static_cast<double>(above) / static_cast<double>(all), 0.01, 4.0 * 0.0013) << length;
  }
}

TEST(AmplitudeSpectrum, IsEmptyOfFewRows) {
  EXPECT_EQ(amplitude_spectrum(Vector::LinSpaced(5, 0.0, 1.0), Vector::Ones(5), 2.0, 10).frequency.size(), 0);
}

TEST(Correlation, HasOnesOnItsDiagonalAndNoNumberWhereNothingIsKnown) {
  Matrix C(3, 3);
  C << 4.0, -3.0, 0.0, -3.0, 9.0, 0.0, 0.0, 0.0, std::numeric_limits<double>::infinity();
  const Matrix r = correlation(C);
  EXPECT_DOUBLE_EQ(r(0, 0), 1.0);
  EXPECT_DOUBLE_EQ(r(1, 0), -0.5);
  EXPECT_TRUE(std::isnan(r(2, 1)));
}

TEST(Excitation, IsTheTorqueOfAParameterInDeviationsOfTheResidual) {
  Identification result;
  result.base.parameters.resize(2);
  result.chi = Eigen::Vector2d(-3.0, 0.5);
  result.fit.joints = {{.name = "a", .unit = "N·m", .sigma_rho = 0.5}};
  std::vector<Prediction> logs = {log_of_parts(Vector::Ones(4), Vector::Ones(4)),
                                  log_of_parts(Vector::Ones(12), Vector::Ones(12))};
  logs[0].joints[0].fitted.column_rms = Eigen::Vector2d(2.0, 0.0);
  logs[1].joints[0].fitted.column_rms = Eigen::Vector2d(0.0, 4.0);
  const Vector found = excitation(result, logs);
  EXPECT_DOUBLE_EQ(found[0], 3.0 * std::sqrt(4.0 * 4.0 / 16.0) / 0.5);
  EXPECT_DOUBLE_EQ(found[1], 0.5 * std::sqrt(12.0 * 16.0 / 16.0) / 0.5);
}

// A solid ellipsoid with semi-axes a, b, c has the moments m (b² + c²) / 5, …
TEST(Ellipsoids, HaveTheSemiAxesOfTheBodyInThePostureOfTheRobot) {
  Robot robot = test::scara();
  const Eigen::Vector3d axes(0.3, 0.2, 0.1);
  const double mass = 4.0;
  const auto square = [](double x) { return x * x; };
  const Eigen::Matrix3d I =
      mass / 5.0 *
      Eigen::Vector3d(square(axes[1]) + square(axes[2]), square(axes[0]) + square(axes[2]),
                      square(axes[0]) + square(axes[1]))
          .asDiagonal()
          .toDenseMatrix();
  const Inertial body = inertial_from_com(mass, {0.25, 0.0, 0.05}, I);
  // Link 2 begins half a metre along link 1, which is turned by a right angle.
  const Vector q = Eigen::Vector2d(0.5 * pi, 0.0);
  Skeleton found = skeleton_of(robot, q);
  add_ellipsoids(robot, q, {Inertial::Zero(), body}, "identified", found);
  ASSERT_EQ(found.joints.size(), 3U);
  EXPECT_LT((found.joints[2] - Eigen::Vector3d(0.0, 0.5, 0.0)).norm(), 1e-12);
  ASSERT_EQ(found.ellipsoids.size(), 1U);
  EXPECT_DOUBLE_EQ(found.ellipsoids[0].mass, mass);
  EXPECT_LT((found.ellipsoids[0].centre - Eigen::Vector3d(0.0, 0.75, 0.05)).norm(), 1e-12);
  const Eigen::Matrix3d A = found.ellipsoids[0].axes;
  // Turned by a right angle: the long axis along y.
  const Eigen::Matrix3d expected = Eigen::Vector3d(square(0.2), square(0.3), square(0.1)).asDiagonal();
  EXPECT_LT((A * A.transpose() - expected).norm(), 1e-12);
}

TEST(Ellipsoids, AreNotDrawnOfWhatIsNoBody) {
  const Robot robot = test::scara();
  const Vector q = Vector::Zero(2);
  Inertial impossible = Inertial::Zero();
  impossible[5] = 1.0;  // ZZ alone, with a mass
  impossible[9] = 1.0;
  Skeleton found;
  add_ellipsoids(robot, q, {impossible, Inertial::Zero()}, "identified", found);
  EXPECT_TRUE(found.ellipsoids.empty());
}

TEST(Analysis, TakesEveryFewOfAnyNumberOfRows) {
  EXPECT_EQ(every_few(5, 2), (std::vector<Index>{0, 3}));
  EXPECT_EQ(every_few(3, 7), (std::vector<Index>{0, 1, 2}));
  EXPECT_TRUE(every_few(0, 7).empty());
  EXPECT_TRUE(every_few(0, 0).empty());
}

// Residuals of one joint at these samples, two apart from row to row.
Prediction residuals(const std::vector<Index>& rows, const Vector& residual) {
  Prediction log{.f_m = 100.0, .row_stride = 2};
  log.joints.push_back({.rows = rows, .residual = residual});
  return log;
}

TEST(ResidualShape, AutocorrelationKnowsOfGaps) {
  // + − + − + − + −, the second half 3 rows late: 6 neighbours, 4 pairs over 2 rows, and those over the gap.
  const Prediction log =
      residuals({0, 2, 4, 6, 14, 16, 18, 20}, (Vector(8) << 1, -1, 1, -1, 1, -1, 1, -1).finished());
  const ResidualShape shape = residual_shape(std::span(&log, 1), 0);
  ASSERT_EQ(shape.autocorrelation.size(), 2U);
  EXPECT_DOUBLE_EQ(shape.autocorrelation[0], -6.0 / 8.0);
  EXPECT_DOUBLE_EQ(shape.autocorrelation[1], 4.0 / 8.0);
}

TEST(ResidualShape, HistogramHasEveryRowAndLeavesValidationsOut) {
  constexpr Index rows = 1000;
  std::vector<Index> samples;
  for (Index k = 0; k < rows; ++k) {
    samples.push_back(2 * k);
  }
  Vector residual = test::random_matrix(rows, 1, 5);
  residual[3] = 50.0;
  std::vector<Prediction> logs = {residuals(samples, residual), residuals(samples, residual)};
  logs[1].validation = true;
  const ResidualShape shape = residual_shape(logs, 0);
  EXPECT_EQ(shape.rows, rows);
  EXPECT_EQ(shape.outside, 1);
  double counted = 0.0;
  for (std::size_t k = 0; k < shape.counts.size(); ++k) {
    const double from = shape.first_edge + static_cast<double>(k) * shape.bin;
    const auto inside = (residual.array() >= from && residual.array() < from + shape.bin).count();
    // A value on an edge may round to either side.
    EXPECT_NEAR(shape.counts[k], static_cast<double>(inside), 1.0);
    counted += shape.counts[k];
  }
  EXPECT_EQ(counted, static_cast<double>(rows - 1));
}

}  // namespace
}  // namespace rivid::detail
