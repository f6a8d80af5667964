// Designed motions: limits, rest, what they tell, and bad input.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "rivid/error.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/identify/covariance.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

Robot arm() {
  Robot robot = read_urdf(RIVID_DATA "/six_axis/six_axis.urdf");
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::coulomb;
  }
  return robot;
}

ExcitationOptions quick() {
  ExcitationOptions out{.duration = 8.0, .starts = 1, .evaluations = 60};
  out.limits.acceleration = Vector::Constant(6, 12.0);
  return out;
}

// One design, for the tests that only look at it.
const Excitation& usual() {
  static const Excitation found = design(arm(), quick());
  return found;
}

std::string message(const Robot& robot, const ExcitationOptions& options) {
  try {
    (void)design(robot, options);
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

// Torques by other code than the design's: the recursion of DynamicModel, sample by sample.
Matrix torques(const Robot& robot, const Motion& motion) {
  InverseDynamics dynamics(DynamicModel(robot, robot.chi_st()));
  Matrix out(motion.samples(), motion.joints());
  Vector tau(motion.joints());
  for (Index k = 0; k < motion.samples(); ++k) {
    dynamics.torque(Vector(motion.q.row(k)), Vector(motion.qd.row(k)), Vector(motion.qdd.row(k)), tau);
    out.row(k) = tau;
  }
  return out;
}

Motion sampled(const Reference& reference, Index samples) {
  const Index n = reference.joints();
  Motion out{.q = Matrix(samples, n), .qd = Matrix(samples, n), .qdd = Matrix(samples, n)};
  Vector q(n);
  Vector qd(n);
  Vector qdd(n);
  for (Index k = 0; k < samples; ++k) {
    reference.at(reference.duration() * static_cast<double>(k) / static_cast<double>(samples - 1), q, qd,
                 qdd);
    out.q.row(k) = q;
    out.qd.row(k) = qd;
    out.qdd.row(k) = qdd;
  }
  return out;
}

// excess  of half the range of each limit
void expect_within_limits(const Robot& robot, const MotionLimits& limits, const Motion& motion,
                          double excess) {
  const MotionBounds bounds = motion_bounds(robot, limits);
  const Matrix tau = torques(robot, motion);
  for (Index j = 0; j < robot.size(); ++j) {
    const double room = excess * 0.5 * (bounds.upper[j] - bounds.lower[j]);
    EXPECT_LE(motion.q.col(j).maxCoeff(), bounds.upper[j] + room);
    EXPECT_GE(motion.q.col(j).minCoeff(), bounds.lower[j] - room);
    EXPECT_LE(motion.qd.col(j).cwiseAbs().maxCoeff(), bounds.velocity[j] * (1.0 + excess));
    EXPECT_LE(motion.qdd.col(j).cwiseAbs().maxCoeff(), bounds.acceleration[j] * (1.0 + excess));
    EXPECT_LE(tau.col(j).cwiseAbs().maxCoeff(), bounds.torque[j] * (1.0 + excess));
  }
}

TEST(Design, KeepsAllLimitsOnTenTimesDenserInstants) {
  const Excitation& found = usual();
  // 4001 samples are played.
  constexpr double excess = 1e-3;  // between them
  expect_within_limits(arm(), quick().limits, sampled(FourierReference(*found.series), 40001), excess);
  for (const LimitUse& use : found.forecast.limits) {
    EXPECT_LE(use.share, 1.0) << use.joint << " " << use.quantity;
  }
  // Some limit is used to the full, or the motion could be larger.
  EXPECT_GE(std::ranges::max(found.forecast.limits, {}, &LimitUse::share).share, 0.99);
}

// Of 200 robots whose links, rotors and friction are each off by up to a half, how many need more torque than
// the whole limits.
int beyond_torque(const Robot& robot, const Vector& torque, const Motion& motion) {
  std::mt19937_64 random(77);
  std::uniform_real_distribution<double> factor(0.5, 1.5);
  int out = 0;
  for (int k = 0; k < 200; ++k) {
    Robot drawn = robot;
    for (Inertial& body : drawn.inertials) {
      body *= factor(random);
    }
    for (Joint& joint : drawn.joints) {
      joint.Ia *= factor(random);
      joint.Fv *= factor(random);
      joint.Fc *= factor(random);
    }
    const Matrix tau = torques(drawn, motion);
    out += (tau.cwiseAbs().colwise().maxCoeff().transpose().array() > torque.array()).any() ? 1 : 0;
  }
  return out;
}

TEST(Design, LeavesRoomForRobotsThatDifferFromTheDescription) {
  const Robot robot = arm();
  ExcitationOptions options = quick();
  options.limits.torque = torques(robot, usual().motion).cwiseAbs().colwise().maxCoeff().transpose();
  const Excitation bold = design(robot, options);
  EXPECT_GE(beyond_torque(robot, options.limits.torque, bold.motion), 20);
  options.limits.prior_spread = 0.5;
  const Excitation careful = design(robot, options);
  EXPECT_LE(beyond_torque(robot, options.limits.torque, careful.motion), 2);
  EXPECT_LT(careful.forecast.log_det, bold.forecast.log_det);
  options.limits.torque *= 0.7;
  options.limits.prior_spread = 0.9;
  EXPECT_TRUE(test::says(message(robot, options), "of its torque in robots that differ by so much"))
      << message(robot, options);
}

// Standard deviations of weighted least squares by code that shares nothing with the design: W of the played
// motion, inverted, without the rows of joints slower than a twentieth of their rms velocity.
Vector deviations(const Motion& motion, const Vector& noise) {
  const BaseParameters base = base_parameters(arm());
  const Observation W = observation(arm(), base, motion);
  Matrix M = Matrix::Zero(base.size(), base.size());
  for (std::size_t j = 0; j < W.joints.size(); ++j) {
    const JointRows& rows = W.joints[j];
    const Vector v = motion.qd.col(static_cast<Index>(j)).cwiseAbs();
    const double slow = 0.05 * v.norm() / std::sqrt(static_cast<double>(v.size()));
    const double s = noise[static_cast<Index>(j)];
    for (Index k = 0; k < v.size(); ++k) {
      if (v[k] > slow) {
        M(rows.columns, rows.columns) += rows.W.row(k).transpose() * rows.W.row(k) / (s * s);
      }
    }
  }
  return M.inverse().diagonal().cwiseSqrt();
}

// Largest of a kind in percent of its value, or of a tenth of the largest of its unit.
double reached_percent(const Excitation& found, const Vector& noise, bool friction) {
  const BaseParameters base = base_parameters(arm());
  const Vector sigma = deviations(found.motion, noise);
  const Vector chi = base.from_standard(arm().chi_st());
  double out = 0.0;
  for (Index i = 0; i < base.size(); ++i) {
    const BaseParameter& own = base.parameters[static_cast<std::size_t>(i)];
    const ParameterKind kind = own.leading.kind;
    if (friction ? kind != ParameterKind::Fv : is_friction(kind)) {
      continue;
    }
    double scale = std::abs(chi[i]);
    for (Index k = 0; k < base.size(); ++k) {
      if (base.parameters[static_cast<std::size_t>(k)].unit == own.unit) {
        scale = std::max(scale, 0.1 * std::abs(chi[k]));
      }
    }
    out = std::max(out, 100.0 * sigma[i] / scale);
  }
  return out;
}

TEST(Design, ReachesStatedStandardDeviationsByRepetition) {
  ExcitationOptions options = quick();
  options.evaluations = 800;
  options.noise.sigma = Vector::LinSpaced(6, 2.0, 0.2);
  options.target = {.mass_percent = 4.0, .Fv_percent = 10.0};
  const Excitation found = design(arm(), options);
  const double masses = reached_percent(found, options.noise.sigma, false);
  const double friction = reached_percent(found, options.noise.sigma, true);
  const double share = std::max(masses / 4.0, friction / 10.0);
  EXPECT_LE(share, 1.0) << masses << " " << friction;
  EXPECT_GE(share, 0.9) << masses << " " << friction;
  // More than one period, each from rest to rest, and all of it within the limits.
  const double period = 2.0 * std::numbers::pi / found.series->omega_f;
  EXPECT_GT(found.series->duration, 1.5 * period);
  EXPECT_LE(period, options.duration + 1e-9);
  EXPECT_LE(found.motion.qd.bottomRows(1).cwiseAbs().maxCoeff(), 1e-9);
  expect_within_limits(arm(), options.limits,
                       sampled(FourierReference(*found.series), found.motion.samples()), 1e-3);
  EXPECT_LE((sampled(FourierReference(*found.series), found.motion.samples()).q - found.motion.q)
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
  options.target.seconds = 0.5 * found.series->duration;
  EXPECT_TRUE(test::says(message(arm(), options), "the target is out of reach in"))
      << message(arm(), options);
  options.curve = CurveKind::spline;
  EXPECT_TRUE(test::says(message(arm(), options), "whose motion can be repeated"));
}

TEST(Design, BeginsAndEndsAtRest) {
  const Excitation& found = usual();
  EXPECT_EQ(found.t[0], 0.0);
  EXPECT_NEAR(found.t[found.t.size() - 1], 8.0, 1e-9);
  for (const Index k : {Index(0), found.t.size() - 1}) {
    EXPECT_LE(found.motion.qd.row(k).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE(found.motion.qdd.row(k).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(Design, OfSplinesKeepsAllLimitsBetweenTheSamples) {
  const Robot robot = arm();
  ExcitationOptions options = quick();
  options.curve = CurveKind::spline;
  options.points = 8;
  options.rate_hz = 100.0;
  const Excitation found = design(robot, options);
  EXPECT_FALSE(found.series);
  const LoggedReference reference(found.t, found.motion.q);
  constexpr Index samples = 8001;
  Motion motion{.q = Matrix(samples, 6), .qd = Matrix(samples, 6), .qdd = Matrix(samples, 6)};
  Vector q(6);
  Vector qd(6);
  Vector qdd(6);
  for (Index k = 0; k < samples; ++k) {
    reference.at(8.0 * static_cast<double>(k) / static_cast<double>(samples - 1), q, qd, qdd);
    motion.q.row(k) = q;
    motion.qd.row(k) = qd;
    motion.qdd.row(k) = qdd;
  }
  // Between the samples the cubic spline of the reference is not quite the one of fifth degree.
  constexpr double excess = 2e-3;
  expect_within_limits(robot, options.limits, motion, excess);
  for (const Index k : {Index(0), found.t.size() - 1}) {
    EXPECT_LE(found.motion.qd.row(k).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE(found.motion.qdd.row(k).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(Design, NamesAJointThatItsFrictionHolds) {
  Robot robot = arm();
  const ExcitationOptions options = quick();
  robot.joints[5].Fc = 1.1 * motion_bounds(robot, options.limits).torque[5];
  EXPECT_NE(message(robot, options).find("joint_6: torque"), std::string::npos) << message(robot, options);
}

TEST(Design, OfTheConditionNumberLowersIt) {
  ExcitationOptions options = quick();
  options.criterion = Criterion::condition;
  const Excitation found = design(arm(), options);
  EXPECT_LE(found.forecast.condition, 0.8 * usual().forecast.condition);
  EXPECT_LE(found.forecast.log_det, usual().forecast.log_det);
}

TEST(Design, TellsMoreThanTheRandomMotionThatItBeganWith) {
  const Excitation& found = usual();
  ASSERT_EQ(found.starts.size(), 1U);
  const double gain = found.starts.front().objective_begin - found.starts.front().objective_end;
  // 58 parameters: their mean deviation falls to a tenth and less.
  EXPECT_GE(gain, 2.0 * 58.0 * std::log(10.0) * 0.5);
}

TEST(Design, OfOneSeedIsTheSameWhateverTheThreads) {
  ExcitationOptions options = quick();
  options.starts = 2;
  options.evaluations = 20;
  const Excitation one = design(arm(), options);
  options.threads = 2;
  const Excitation two = design(arm(), options);
  EXPECT_EQ(one.motion.q, two.motion.q);
  options.seed = 77;
  EXPECT_NE(design(arm(), options).motion.q, one.motion.q);
}

TEST(Design, KeepsJerkLimits) {
  ExcitationOptions options = quick();
  options.limits.jerk = Vector::Constant(6, 30.0);
  const Excitation found = design(arm(), options);
  const double f_m = options.rate_hz;
  const Matrix jerk =
      f_m * (found.motion.qdd.bottomRows(found.t.size() - 1) - found.motion.qdd.topRows(found.t.size() - 1));
  EXPECT_LE(jerk.cwiseAbs().maxCoeff(), 30.0);
}

TEST(Design, KeepsClearOfTheFloorAndOfItself) {
  ExcitationOptions options = quick();
  options.space.half_spaces = {{.name = "floor", .normal = {0, 0, 1}, .offset = -0.2}};
  options.space.boxes = {{.name = "table", .min = {0.4, -0.5, -0.2}, .max = {0.9, 0.5, 0.05}}};
  options.space.clearance = 0.04;
  const Excitation found = design(arm(), options);
  ASSERT_FALSE(found.forecast.clearances.empty());
  for (const ClearanceUse& use : found.forecast.clearances) {
    EXPECT_FALSE(use.distance < use.wanted) << use.first << " " << use.second;
  }
  // The upper arm begins where the base ends.
  EXPECT_EQ(std::ranges::count_if(found.forecast.clearances,
                                  [](const ClearanceUse& use) { return std::isnan(use.wanted); }),
            1);
  // The motion that nobody warned goes through.
  options.starts = 1;
  const Forecast unwarned = forecast(arm(), usual().motion, options.rate_hz, options);
  EXPECT_LT(unwarned.clearances.front().distance, 0.0);
  EXPECT_EQ(unwarned.clearances.front().wanted, 0.04);
}

TEST(Design, RefusesAStartInCollision) {
  ExcitationOptions options = quick();
  options.space.half_spaces = {{.name = "floor", .normal = {0, 0, 1}, .offset = 0.1}};
  options.space.self_collision = false;
  options.start = Vector::Zero(6);
  options.start[1] = 2.0;  // bent down
  options.start[2] = 1.0;
  const std::string said = message(arm(), options);
  EXPECT_NE(said.find("design: the robot can not rest at start within its limits: "), std::string::npos)
      << said;
  EXPECT_NE(said.find(": distance to floor is "), std::string::npos) << said;
}

TEST(Design, BeginsWhereItIsTold) {
  ExcitationOptions options = quick();
  options.start = Vector::Constant(6, 0.2);
  const Excitation found = design(arm(), options);
  EXPECT_LE((found.motion.q.row(0).transpose() - options.start).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LE((found.motion.q.bottomRows(1).transpose() - options.start).cwiseAbs().maxCoeff(), 1e-9);
}

// From the pose of the robot to the motion and on to another pose: one motion by finite differences, within
// all limits on ten times denser instants, and hardly slower than they ask.
TEST(Design, LeadsFromTheRobotsPoseAndOnWithinTheSameLimits) {
  const Robot robot = arm();
  for (const CurveKind curve : {CurveKind::fourier, CurveKind::spline}) {
    ExcitationOptions options = quick();
    options.curve = curve;
    options.rate_hz = 200.0;
    options.evaluations = 20;
    options.lead_from = Vector{{0.5, -0.4, 0.9, -1.0, 0.8, 2.0}};
    options.lead_to = Vector{{-1.0, 0.2, 0.3, 0.0, 0.0, 0.0}};
    options.limits.jerk = Vector::Constant(6, 100.0);
    const Excitation found = design(robot, options);
    const Motion& played = found.motion;
    EXPECT_TRUE(played.q.row(0).transpose().isApprox(options.lead_from, 1e-12));
    EXPECT_TRUE(played.q.bottomRows(1).transpose().isApprox(options.lead_to, 1e-12));
    const double before = found.lead_in.value().durations.sum();
    const double behind = found.lead_out.value().durations.sum();
    EXPECT_NEAR(found.forecast.duration, before + options.duration + behind, 1e-9);
    const std::unique_ptr<const Reference> reference = found.reference();
    const Index intervals = 10 * (played.samples() - 1);
    const Motion dense = sampled(*reference, intervals + 1);
    const double rate = 10.0 * options.rate_hz;
    // Cubic splines through samples are not quite at rest at their ends.
    const double rest = curve == CurveKind::spline ? 0.05 : 1e-6;
    for (Index k = 0; k < played.samples(); ++k) {
      EXPECT_LE((dense.q.row(10 * k) - played.q.row(k)).cwiseAbs().maxCoeff(), 1e-9);
      EXPECT_LE((dense.qdd.row(10 * k) - played.qdd.row(k)).cwiseAbs().maxCoeff(), rest);
    }
    for (const Index end : {Index{0}, intervals}) {
      EXPECT_LE(dense.qd.row(end).cwiseAbs().maxCoeff() + dense.qdd.row(end).cwiseAbs().maxCoeff(), 1e-9);
    }
    // Central differences are off by h² / 6 times the jerk, or by h times its jump.
    const auto difference = [&](const Matrix& x) -> Matrix {
      return 0.5 * rate * (x.bottomRows(intervals - 1) - x.topRows(intervals - 1));
    };
    EXPECT_LE((difference(dense.q) - dense.qd.middleRows(1, intervals - 1)).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_LE((difference(dense.qd) - dense.qdd.middleRows(1, intervals - 1)).cwiseAbs().maxCoeff(), 0.1);
    constexpr double excess = 1e-3;
    expect_within_limits(robot, options.limits, dense, excess);
    const auto at = [&](double t) { return static_cast<Index>(std::lround(t * rate)); };
    for (const auto& [first, rows] :
         {std::pair{Index{0}, at(before)}, std::pair{at(before + options.duration), at(behind)}}) {
      const Matrix qdd = dense.qdd.middleRows(first + 1, rows - 1);
      const double jerk = rate * (qdd.bottomRows(rows - 2) - qdd.topRows(rows - 2)).cwiseAbs().maxCoeff();
      EXPECT_LE(jerk, 100.0 * (1.0 + excess));
      const MotionBounds bounds = motion_bounds(robot, options.limits);
      const Matrix tau = torques(robot, dense).middleRows(first, rows + 1);
      const auto share = [&](const Matrix& x, const Vector& limit) {
        return (x.cwiseAbs().colwise().maxCoeff().transpose().cwiseQuotient(limit)).maxCoeff();
      };
      // Slower by a tenth where torques decide.
      EXPECT_GE(std::max({share(dense.qd.middleRows(first, rows + 1), bounds.velocity),
                          share(qdd, bounds.acceleration), jerk / 100.0, share(tau, bounds.torque)}),
                0.8);
    }
  }
}

TEST(Design, SaysWhyThereIsNoLead) {
  ExcitationOptions options = quick();
  options.evaluations = 5;
  options.lead_from = Vector{{0.0, 0.0, 9.0, 0.0, 0.0, 0.0}};
  EXPECT_TRUE(test::says(message(arm(), options),
                         "design: lead_from: on the straight way joint_3: position is 9 where it may be"))
      << message(arm(), options);
  options.lead_from = Vector::Zero(2);
  EXPECT_TRUE(test::says(message(arm(), options), "lead_from has 2 entries"));
  options.lead_from = {};
  options.lead_to = Vector::Zero(6);
  EXPECT_TRUE(test::says(message(arm(), options), "lead_to goes with lead_from"));
}

TEST(Design, ForSomeParametersTellsMoreOfThem) {
  ExcitationOptions options = quick();
  options.starts = 3;
  const auto sigma = [](const Excitation& found, const std::string& name) {
    return std::ranges::find(found.forecast.parameters, name, &ForecastParameter::name)->sigma;
  };
  const Excitation of_all = design(arm(), options);
  options.criterion = Criterion::parameters;
  options.parameters = {"MX6", "MY6"};
  const Excitation found = design(arm(), options);
  EXPECT_LT(sigma(found, "MX6") * sigma(found, "MY6"), sigma(of_all, "MX6") * sigma(of_all, "MY6"));
}

TEST(Design, KnowsEarlierLogs) {
  ExcitationOptions options = quick();
  options.evaluations = 300;
  const Excitation first = design(arm(), options);
  options.known = first.forecast.information;
  // One start may end in a poorer optimum than the first motion, which one, rounding decides.
  options.starts = 3;
  options.seed = 2;
  const Excitation second = design(arm(), options);
  // The first motion once more would add b log 2.
  const double twice =
      first.forecast.log_det + static_cast<double>(first.forecast.base.size()) * std::log(2.0);
  EXPECT_GT(second.forecast.log_det, twice);
}

TEST(Design, StopsWhenItIsTold) {
  ExcitationOptions options = quick();
  options.evaluations = 100000;
  int asked = 0;
  options.stopped = [&] { return ++asked > 30; };
  const Excitation found = design(arm(), options);
  EXPECT_TRUE(found.stopped);
  EXPECT_LE(found.starts.front().evaluations, 40);
  EXPECT_LE(std::ranges::max(found.forecast.limits, {}, &LimitUse::share).share, 1.0);
}

TEST(Design, BeginsNoStartOnceItIsStopped) {
  ExcitationOptions options = quick();
  options.starts = 1000;
  int asked = 0;
  options.stopped = [&] { return ++asked > 10; };
  const Excitation found = design(arm(), options);
  EXPECT_TRUE(found.stopped);
  EXPECT_EQ(found.starts.size(), 1U);
}

TEST(Design, RefusesAJointThatGravityPins) {
  ExcitationOptions options = quick();
  options.limits.torque = Vector::Constant(6, 100.0);
  options.limits.torque[1] = 0.5;
  options.limits.lower = Vector::Constant(6, 1.0);
  options.limits.upper = Vector::Constant(6, 1.5);
  const std::string said = message(arm(), options);
  EXPECT_NE(
      said.find("design: no pose was found in which the robot can rest within its limits; in the best of "
                "1000 random ones joint_2: torque is "),
      std::string::npos)
      << said;
}

TEST(Design, RefusesAStartBeyondTheLimits) {
  ExcitationOptions options = quick();
  options.start = Vector::Zero(6);
  options.start[4] = 3.0;
  EXPECT_EQ(
      message(arm(), options),
      "design: the robot can not rest at start within its limits: joint_5: position is 3 where it may be "
      "2.219");
}

TEST(Design, RefusesOptionsByName) {
  ExcitationOptions options = quick();
  options.harmonics = 1;
  EXPECT_EQ(message(arm(), options), "design: harmonics is 1, must lie between 2 and 50");
  options = quick();
  options.criterion = Criterion::parameters;
  EXPECT_EQ(message(arm(), options), "design: criterion = \"parameters\" must say for which");
  options.parameters = {"MX7"};
  EXPECT_NE(message(arm(), options).find("design: the robot has no base parameter \"MX7\"; did you mean"),
            std::string::npos);
  options = quick();
  options.noise.sigma = Vector::Constant(2, 1.0);
  EXPECT_EQ(message(arm(), options), "design: noise must have one positive number for each of the 6 joints");
}

TEST(Forecast, IsOfTheRowsThatIdentificationKeeps) {
  const Robot robot = arm();
  ExcitationOptions options = quick();
  options.noise.sigma = Vector::LinSpaced(6, 1.0, 0.2);
  const Excitation found = design(robot, options);
  Log log;
  log.f_m = options.rate_hz;
  log.t = found.t;
  log.q = found.motion.q;
  log.tau = found.forecast.tau;
  const Vector bound = deviation_bound(robot, log, options.noise.sigma);
  const Vector kept = deviations(found.motion, options.noise.sigma);
  // The bound is of all samples but those at reversals, here one in fifty.
  for (Index i = 0; i < bound.size(); ++i) {
    const double sigma = found.forecast.parameters[static_cast<std::size_t>(i)].sigma;
    EXPECT_NEAR(sigma, kept[i], 1e-6 * kept[i]);
    EXPECT_GE(sigma, 0.98 * bound[i]);
  }
}

TEST(Forecast, NamesWhatAMotionDoesNotShow) {
  const Robot robot = arm();
  Motion motion = sampled(FourierReference(*usual().series), 2001);
  motion.q.col(5).setConstant(0.3);
  motion.qd.col(5).setZero();
  motion.qdd.col(5).setZero();
  const Forecast found = forecast(robot, motion, 250.0, quick());
  EXPECT_TRUE(std::isinf(found.log_det));
  const auto prospect = [&](const std::string& name) {
    return std::ranges::find(found.parameters, name, &ForecastParameter::name)->prospect;
  };
  EXPECT_EQ(prospect("Fv6"), ForecastParameter::Prospect::unseen);
  EXPECT_EQ(prospect("Fc6"), ForecastParameter::Prospect::unseen);
  EXPECT_NE(prospect("Fv1"), ForecastParameter::Prospect::unseen);
}

TEST(Forecast, TellsHowEstimatesHoldTogether) {
  const Robot robot = arm();
  const Forecast found = forecast(robot, sampled(FourierReference(*usual().series), 2001), 250.0, quick());
  const Matrix C = found.information.inverse();
  constexpr double tolerance = 1e-6;  // of inverses of other algorithms, by the condition of the information
  for (std::size_t i = 0; i < found.parameters.size(); ++i) {
    const ForecastParameter& p = found.parameters[i];
    const auto at = static_cast<Index>(i);
    EXPECT_NEAR(p.sigma_alone * std::sqrt(found.information(at, at)), 1.0, tolerance);
    double most = 0.0;
    for (Index k = 0; k < C.rows(); ++k) {
      const double r = C(at, k) / std::sqrt(C(at, at) * C(k, k));
      most = k != at && std::abs(r) > std::abs(most) ? r : most;
    }
    EXPECT_NEAR(p.correlation, most, tolerance) << p.name;
  }
  // Each sample counts with the information that it adds; all of them determine as many parameters as there
  // are.
  EXPECT_NEAR(found.leverage.sum(), static_cast<double>(found.parameters.size()), tolerance * 1e2);
}

TEST(Forecast, FallsWithTheRootOfTheRateOfIndependentErrors) {
  const Robot robot = arm();
  ExcitationOptions options = quick();
  const Motion motion = sampled(FourierReference(*usual().series), 2001);
  const double fine = forecast(robot, motion, 250.0, options).parameters.front().sigma;
  options.noise.rate_hz = 25.0;
  const double coarse = forecast(robot, motion, 250.0, options).parameters.front().sigma;
  EXPECT_NEAR(coarse / fine, std::sqrt(10.0), 1e-9);
}

}  // namespace
}  // namespace rivid
