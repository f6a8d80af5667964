#include "rivid/online/payload_estimator.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <vector>

#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/normal.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double f_m = 500.0;
constexpr Index stride = 12;

struct Scene {
  Robot robot;
  Vector chi_st;
  OnlineModel model;
};

// A random arm of six revolute joints.
Scene six_joints(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Scene out{test::random_robot(6, random), {}, {}};
  out.robot.chain.gravity = {0.0, 0.0, -9.81};
  for (std::size_t j = 0; j < 6; ++j) {
    out.robot.chain.links[j].type = JointType::revolute;
    out.robot.joints[j].type = JointType::revolute;
    out.robot.joints[j].friction = Friction::symmetric;
  }
  out.chi_st = out.robot.chi_st();
  out.model = test::known_model(out.robot, out.chi_st, 0.1);
  out.model.C_chi *= 0.1;
  return out;
}

Inertial brick(double mass) {
  return inertial_from_com(mass, {0.03, -0.05, 0.1}, Eigen::Vector3d(0.02, 0.03, 0.025).asDiagonal());
}

Matrix with_noise(Matrix tau, double sigma, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  test::Normal noise(0.0, sigma);
  for (double& x : tau.reshaped()) {
    x += noise(random);
  }
  return tau;
}

PayloadEstimatorOptions options_of() {
  return {.rows = {.f_m = f_m, .stride = stride, .torque_held = false}};
}

struct Ticks {
  Matrix q, tau;  // a column a tick
};
Ticks run_of(const Scene& scene, const Vector& chi_st, std::uint64_t seed, double seconds,
             double noise = 0.3) {
  const Motion motion = test::Wandering(6, seed, 0.5, 1.2).at(test::ticks(seconds, f_m));
  return {motion.q.transpose(),
          with_noise(test::torques(DynamicModel(scene.robot, chi_st), motion), noise, seed).transpose()};
}

TEST(PayloadEstimator, FindsMassCentreAndInertiaInTheFlangeFrame) {
  const Scene scene = six_joints(3);
  PayloadEstimatorOptions options = options_of();
  options.R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  options.p = {0.0, 0.1, 0.2};
  const Inertial in_flange = brick(4.0);
  const Inertial in_link = transformed(in_flange, options.R, options.p);
  const Ticks run = run_of(scene, test::loaded(scene.robot, scene.chi_st, in_link), 3, 30.0, 0.1);
  PayloadEstimator<double> estimator(scene.model, options);
  for (Index k = 0; k < run.q.cols(); ++k) {
    estimator.update(run.q.col(k), run.tau.col(k));
  }
  estimator.finish();
  const auto& found = estimator.payload();
  EXPECT_TRUE(found.held);
  EXPECT_TRUE(found.good);
  ASSERT_TRUE(found.body);
  EXPECT_LE(std::abs(found.mass - 4.0), 2.0 * found.mass_half_width());
  EXPECT_LE(found.mass_half_width(), 0.1);
  const Eigen::Vector3d com(0.03, -0.05, 0.1);
  for (Index i = 0; i < 3; ++i) {
    EXPECT_LE(std::abs(found.com[i] - com[i]), 4.0 * found.com_sigma[i]);
    EXPECT_LE(std::abs(found.inertia(i, i) - Eigen::Vector3d(0.02, 0.03, 0.025)[i]),
              4.0 * found.inertia_sigma[i]);
  }
  const Vector moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(found.inertia).eigenvalues();
  EXPECT_GE(moments[0], 0.0);
  EXPECT_LE(moments[2], moments[0] + moments[1] + 1e-12);
}

// The same rows with the same prior in one dense system.
TEST(PayloadEstimator, IsEigensSolutionOfTheStackWithItsPrior) {
  const Scene scene = six_joints(5);
  PayloadEstimatorOptions options = options_of();
  options.forgetting = std::numeric_limits<double>::infinity();
  options.friction_change = 0.0;
  options.load_friction = 0.0;
  options.hours_to_false_alarm = 1e12;
  const Ticks run = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(3.0)), 5, 10.0);
  PayloadEstimator<double> estimator(scene.model, options);
  const detail::BodyColumns columns(scene.robot, scene.model.base);
  RowStreamOptions rows_options = options.rows;
  rows_options.velocity_threshold = scene.model.velocity_threshold;
  RowStream<double> stream(scene.robot, columns.all.columns(), rows_options);
  const Index b = scene.model.base.size();
  Matrix A = Matrix::Zero(b + 10, b + 10);
  Vector a = Vector::Zero(b + 10);
  for (Index i = 0; i < 10; ++i) {
    const double scale = 10.0 * (i < 6 ? 0.0225 : i < 9 ? 0.15 : 1.0);
    A(i, i) = 1.0 / (scale * scale);
  }
  A.bottomRightCorner(b, b) = scene.model.C_chi.inverse();
  a.tail(b) = A.bottomRightCorner(b, b) * scene.model.chi;
  for (Index k = 0; k < run.q.cols(); ++k) {
    stream.update(run.q.col(k), run.tau.col(k));
    stream.for_each_row([&](const RowStream<double>::Row& row) {
      Vector w = Vector::Zero(b + 10);
      const std::vector<Index>& own = stream.columns().of_joint(row.joint);
      for (std::size_t c = 0; c < own.size(); ++c) {
        if (own[c] < b) {
          w[10 + own[c]] = row.values[c];
        }
        for (std::size_t i = 0; i < 10; ++i) {
          if (columns.body[i] == own[c]) {
            w[static_cast<Index>(i)] = row.values[c];
          }
        }
      }
      const double weight = 1.0 / estimator.row_sigma(static_cast<Index>(row.joint), row.speed);
      A += weight * weight * w * w.transpose();
      a += weight * weight * row.y * w;
    });
    estimator.update(run.q.col(k), run.tau.col(k));
    estimator.finish();
  }
  const Vector expected = A.ldlt().solve(a);
  // Normal equations of the check cost κ ε.
  EXPECT_LE((estimator.inertial() - expected.head(10)).cwiseAbs().maxCoeff(), 1e-8);
  const Matrix C = A.inverse();
  EXPECT_NEAR(estimator.payload().mass_sigma / std::sqrt(C(9, 9) * estimator.misfit()), 1.0, 1e-6);
}

TEST(PayloadEstimator, SeesPickUpAndReleaseInMotion) {
  const Scene scene = six_joints(7);
  const double seconds = 12.0;
  const Ticks empty = run_of(scene, scene.chi_st, 7, 3.0 * seconds);
  const Ticks full = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(2.0)), 7, 3.0 * seconds);
  PayloadEstimator<double> estimator(scene.model, options_of());
  using Kind = PayloadEstimator<double>::Change::Kind;
  std::vector<double> changes;
  std::vector<Kind> kinds;
  for (Index k = 0; k < empty.q.cols(); ++k) {
    const double t = static_cast<double>(k) / f_m;
    const Ticks& now = t >= seconds && t < 2.0 * seconds ? full : empty;
    if (estimator.update(now.q.col(k), now.tau.col(k))) {
      changes.push_back(t);
      EXPECT_FALSE(estimator.payload().good) << "of the payload before";
    }
    if (k % static_cast<Index>(seconds * f_m) == static_cast<Index>(seconds * f_m) - 1) {
      kinds.push_back(estimator.change().kind);
    }
    if (k + 1 == static_cast<Index>(2.0 * seconds * f_m)) {
      EXPECT_NEAR(estimator.payload().mass, 2.0, 0.2);
      EXPECT_TRUE(estimator.payload().held);
    }
  }
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(kinds, (std::vector<Kind>{Kind::none, Kind::pick_up, Kind::release}));
  EXPECT_LE(changes[0] - seconds, 0.1);
  EXPECT_LE(changes[1] - 2.0 * seconds, 0.1);
  EXPECT_FALSE(estimator.payload().held);
}

// The change that is tested beside any other: what is held is let go.
TEST(PayloadEstimator, ExpectsThatWhatIsHeldIsLetGo) {
  const Scene scene = six_joints(7);
  const Inertial body = brick(2.0);
  const Ticks full = run_of(scene, test::loaded(scene.robot, scene.chi_st, body), 7, 10.0);
  PayloadEstimator<double> estimator(scene.model, options_of());
  estimator.payload_changed();
  for (Index k = 0; k < full.q.cols(); ++k) {
    estimator.update(full.q.col(k), full.tau.col(k));
  }
  for (const auto& sums : std::get<0>(std::get<2>(estimator.state()).state()).sums) {
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(sums.release[k], -body[static_cast<Index>(6 + k)], k < 3 ? 0.02 : 0.1) << k;
    }
  }
}

TEST(PayloadEstimator, TakesFrictionThatHasChangedForNoPayload) {
  const Scene scene = six_joints(9);
  Vector worn = scene.chi_st;
  const std::vector<StandardParameter> all = scene.robot.standard_parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (is_friction(all[i].kind)) {
      worn[static_cast<Index>(i)] *= 1.25;
    }
  }
  const Ticks run = run_of(scene, worn, 9, 30.0);
  PayloadEstimatorOptions options = options_of();
  options.friction_change = 0.2;
  PayloadEstimator<double> estimator(scene.model, options);
  int changes = 0;
  for (Index k = 0; k < run.q.cols(); ++k) {
    changes += estimator.update(run.q.col(k), run.tau.col(k)) ? 1 : 0;
    ASSERT_LE(estimator.payload().mass, 3.5 * estimator.payload().mass_sigma) << "tick " << k;
  }
  EXPECT_EQ(changes, 0);
}

TEST(PayloadEstimator, FrictionThatMayHaveChangedIsInTheMass) {
  const Scene scene = six_joints(3);
  PayloadEstimatorOptions options = options_of();
  const Ticks run = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(4.0)), 3, 2.0);
  options.friction_change = 0.0;
  PayloadEstimator<double> known(scene.model, options);
  options.friction_change = 0.2;
  PayloadEstimator<double> changed(scene.model, options);
  for (Index k = 0; k < run.q.cols(); ++k) {
    known.update(run.q.col(k), run.tau.col(k));
    changed.update(run.q.col(k), run.tau.col(k));
  }
  EXPECT_GE(changed.payload().mass_sigma, 1.1 * known.payload().mass_sigma);
}

TEST(PayloadEstimator, TheGainsUncertaintyIsInTheMass) {
  const Scene scene = six_joints(3);
  PayloadEstimatorOptions options = options_of();
  const Ticks run = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(4.0)), 3, 20.0);
  PayloadEstimator<double> exact(scene.model, options);
  options.gain_sigma = 0.02;
  PayloadEstimator<double> vague(scene.model, options);
  for (Index k = 0; k < run.q.cols(); ++k) {
    exact.update(run.q.col(k), run.tau.col(k));
    vague.update(run.q.col(k), run.tau.col(k));
  }
  const double expected = std::hypot(exact.payload().mass_sigma, 0.02 * exact.payload().mass);
  EXPECT_NEAR(vague.payload().mass_sigma, expected, 1e-9);
}

TEST(PayloadEstimator, NeverAllocatesAndComesBackBitByBit) {
  const Scene scene = six_joints(4);
  const Ticks run = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(1.0)), 4, 8.0);
  PayloadEstimator<double> estimator(scene.model, options_of());
  PayloadEstimator<double> twin = estimator;
  std::vector<std::byte> state(state_size(estimator));
  const Index half = run.q.cols() / 2;
  const long count = test::allocations_of([&] {
    for (Index k = 0; k < run.q.cols(); ++k) {
      estimator.update(run.q.col(k), run.tau.col(k));
      if (k == half) {
        ASSERT_TRUE(save_state(estimator, state));
      }
      if (k % 1000 == 999) {
        estimator.pause();
      }
    }
    estimator.finish();
  });
  EXPECT_EQ(count, 0);
  ASSERT_TRUE(restore_state(twin, state));
  for (Index k = half; k < run.q.cols(); ++k) {
    if (k > half) {
      twin.update(run.q.col(k), run.tau.col(k));
    }
    if (k % 1000 == 999) {
      twin.pause();
    }
  }
  twin.finish();
  EXPECT_EQ((estimator.inertial() - twin.inertial()).cwiseAbs().maxCoeff(), 0.0);
}

// Of an AR(1) process the long-run variance is γ₀ (1 + a) / (1 − a); the lags that are taken hold this part
// of it. The rows alternate between two speeds, at the higher of which they err half as much.
TEST(RowNoise, IsTheDeviationOfSumsOfErrorsThatAreAlikeBySpeed) {
  constexpr double a = 0.6;
  constexpr int lags = 10;
  double expected = 1.0;
  for (int k = 1; k <= lags; ++k) {
    expected += 2.0 * (1.0 - k / (lags + 1.0)) * std::pow(a, k);
  }
  detail::RowNoise noise(Vector::Constant(1, 1.0), Vector::Constant(1, 0.1), 0.025);
  const std::size_t slow = noise.kind(0, -0.15);
  const std::size_t fast = noise.kind(0, 0.5);
  ASSERT_NE(slow, fast);
  EXPECT_FALSE(noise.known(slow));
  std::mt19937_64 random(1);
  test::Normal normal;
  double error = 0.0;
  double mean = 0.0;
  double ratio = 0.0;
  constexpr int count = 40000;
  for (int k = 0; k < count; ++k) {
    error = a * error + std::sqrt(1.0 - a * a) * normal(random);
    const bool is_slow = k % 2 == 0;
    noise.take(is_slow ? slow : fast, (is_slow ? 1.0 : 0.5) * error);
    const double share = k >= count / 2 ? 2.0 / count : 0.0;
    mean += share * noise.sigma(slow) * noise.sigma(slow);
    ratio += share * noise.sigma(fast) / noise.sigma(slow);
  }
  EXPECT_TRUE(noise.known(slow) && noise.known(fast));
  EXPECT_NEAR(mean / expected, 1.0, 0.05);
  EXPECT_NEAR(ratio, 0.5, 0.02);
}

// Joints that never move have no noise of their own, and hide nothing.
TEST(PayloadEstimator, SeesAPickUpWhateverJointsAreAtRest) {
  for (const unsigned still : {1U, 7U, 31U}) {
    SCOPED_TRACE("still joints " + std::to_string(still));
    const Scene scene = six_joints(7);
    constexpr double seconds = 10.0;
    Motion motion = test::Wandering(6, 7, 0.5, 1.2).at(test::ticks(2.0 * seconds, f_m));
    for (Index j = 0; j < 6; ++j) {
      if ((still >> static_cast<unsigned>(j) & 1U) != 0) {
        motion.q.col(j).setConstant(0.3);
        motion.qd.col(j).setZero();
        motion.qdd.col(j).setZero();
      }
    }
    const Matrix q = motion.q.transpose();
    const Vector loaded = test::loaded(scene.robot, scene.chi_st, brick(2.0));
    const Matrix empty =
        with_noise(test::torques(DynamicModel(scene.robot, scene.chi_st), motion), 0.3, 7).transpose();
    const Matrix full =
        with_noise(test::torques(DynamicModel(scene.robot, loaded), motion), 0.3, 8).transpose();
    PayloadEstimator<double> estimator(scene.model, options_of());
    std::vector<double> changes;
    for (Index k = 0; k < q.cols(); ++k) {
      const double t = static_cast<double>(k) / f_m;
      if (estimator.update(q.col(k), (t < seconds ? empty : full).col(k))) {
        changes.push_back(t - seconds);
      }
    }
    ASSERT_EQ(changes.size(), 1U);
    EXPECT_GE(changes[0], 0.0);
    EXPECT_LE(changes[0], 0.3);
    EXPECT_LE(std::abs(estimator.payload().mass - 2.0), 2.0 * estimator.payload().mass_half_width());
  }
}

// Half a second of a force on the last link looks like a load. What lasts is one.
TEST(PayloadEstimator, TakesNoShortTouchForAPayload) {
  const Scene scene = six_joints(3);
  const Ticks empty = run_of(scene, scene.chi_st, 3, 40.0);
  const Ticks full = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(2.0)), 3, 40.0);
  // The torques of gravity on another load, as if it were held for a while.
  const Ticks pushed = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(5.0)), 3, 40.0);
  for (const double longest : {1.0, 0.0}) {
    PayloadEstimatorOptions options = options_of();
    options.longest_touch = longest;
    PayloadEstimator<double> estimator(scene.model, options);
    std::vector<double> changes;
    int touches = 0;
    bool before = false;
    double mass = -1.0;
    for (Index k = 0; k < empty.q.cols(); ++k) {
      const double t = static_cast<double>(k) / f_m;
      const bool touch = t > 10.0 && t < 30.0 && std::fmod(t, 4.0) < 0.5;
      const Matrix& tau = t >= 30.0 ? full.tau : touch ? pushed.tau : empty.tau;
      if (estimator.update(empty.q.col(k), tau.col(k))) {
        changes.push_back(t);
      }
      touches += estimator.touch_found() && !before ? 1 : 0;
      before = estimator.touch_found();
      mass = k == static_cast<Index>(29.9 * f_m) ? estimator.payload().mass : mass;
      EXPECT_FALSE(estimator.touched() && estimator.payload().good);
    }
    if (longest == 0.0) {
      EXPECT_GE(changes.size(), 5U);
      continue;
    }
    EXPECT_EQ(touches, 6) << "five touches, and the load until it is known to be one";
    EXPECT_LE(mass, 0.05);
    ASSERT_EQ(changes.size(), 1U);
    EXPECT_GE(changes[0], 31.0);
    EXPECT_LE(changes[0], 32.0);
    EXPECT_LE(std::abs(estimator.payload().mass - 2.0), 2.0 * estimator.payload().mass_half_width());
  }
}

// As the contact observer says, though no row shows it: nothing is learned, and nothing is good.
TEST(PayloadEstimator, LearnsNothingWhileItIsTouched) {
  const Scene scene = six_joints(3);
  const Ticks run = run_of(scene, test::loaded(scene.robot, scene.chi_st, brick(2.0)), 3, 20.0);
  PayloadEstimator<double> estimator(scene.model, options_of());
  double mass = -1.0;
  for (Index k = 0; k < run.q.cols(); ++k) {
    const bool touched = k >= 5000 && k < 7500;
    estimator.touched(touched);
    EXPECT_FALSE(estimator.update(run.q.col(k), run.tau.col(k)));
    EXPECT_EQ(estimator.touched(), touched);
    mass = k == 5200 ? estimator.payload().mass : mass;  // once what was known before is solved
    if (touched && k > 5200) {
      ASSERT_EQ(estimator.payload().mass, mass);
      ASSERT_FALSE(estimator.payload().good);
    }
  }
  EXPECT_NE(estimator.payload().mass, mass);
  EXPECT_TRUE(estimator.payload().good);
}

// What a change of y makes of the residual of a row, once the estimate has followed it: by dense algebra.
TEST(InformationTriangle, TurnsColumnsBesideYAsItFollowsThem) {
  constexpr Index n = 5;
  constexpr Index beside = 2;
  std::mt19937_64 random(8);
  test::Normal normal;
  detail::InformationTriangle<double> triangle(n, 2, beside);
  Matrix A = Matrix::Zero(n, n);
  Matrix a = Matrix::Zero(n, 1 + beside);
  for (int k = 0; k < 20; ++k) {
    const Vector w = Vector::NullaryExpr(n, [&] { return normal(random); });
    const Vector y = Vector::NullaryExpr(1 + beside, [&] { return normal(random); });
    double* const row = triangle.room();
    std::ranges::copy(w, row);
    std::ranges::copy(y, row + n);
    triangle.commit(k);
    triangle.finish([&](const auto& outcome) {
      if (k < n) {
        return;
      }
      const Eigen::LDLT<Matrix> solver(A);
      const Vector expected = (y - solver.solve(a).transpose() * w) / std::sqrt(1.0 + w.dot(solver.solve(w)));
      EXPECT_NEAR(std::abs(outcome.residual), std::abs(expected[0]), 1e-10);
      for (Index i = 0; i < beside; ++i) {
        EXPECT_NEAR(outcome.beside[i] * outcome.residual, expected[1 + i] * expected[0], 1e-10);
      }
    });
    A += w * w.transpose();
    a += w * y.transpose();
    if (k == 12) {
      triangle.clear_beside(1, 1);
      a.col(2).setZero();
    }
  }
}

// Rows that are watched leave R alone, and make what they alone say of the first unknowns, given the others.
TEST(InformationTriangle, KeepsWhatWatchedRowsSayOfTheFirstUnknowns) {
  constexpr Index n = 5;
  constexpr Index first = 2;
  std::mt19937_64 random(9);
  test::Normal normal;
  detail::InformationTriangle<double> triangle(n, 2, 1);
  detail::InformationTriangle<double> alone(n, 2, 1);
  const auto add = [&](auto& to, const Vector& w) {
    std::ranges::copy(w, to.room());
    to.commit(0);
    to.finish([](const auto& /*outcome*/) {});
  };
  triangle.instead().resize(static_cast<std::size_t>(first * triangle.room_of_row()));
  std::vector<double> before;
  for (int k = 0; k < 30; ++k) {
    const Vector w = Vector::NullaryExpr(n + 2, [&] { return normal(random); });
    if (k == 12) {
      before = triangle.entries();
      triangle.watch(true);
    }
    add(triangle, w);
    if (k >= 12) {
      add(alone, w);
    }
  }
  EXPECT_EQ(triangle.entries(), before);
  for (Index i = 0; i < first; ++i) {
    for (Index c = i; c <= n; ++c) {
      EXPECT_NEAR(triangle.instead()[static_cast<std::size_t>(i * triangle.room_of_row() + c)], alone.R(i, c),
                  1e-12);
    }
  }
}

// Errors twice as large as the noise is known to be are no change, and widen what is said.
TEST(LoadChange, MeasuresErrorsThatLookLikeALoadByThemselves) {
  constexpr double per_second = 40.0;
  detail::RowNoise noise(Vector::Constant(1, 1.0), Vector::Constant(1, 0.1), 1e9);
  std::mt19937_64 random(5);
  test::Normal normal;
  for (int k = 0; k < 1000; ++k) {
    noise.take(0, normal(random));
  }
  for (const double size : {1.0, 1.5}) {
    detail::LoadChange change({.per_second = per_second});
    int found = 0;
    for (int k = 0; k < 8000; ++k) {
      for (int row = 0; row < 6; ++row) {
        detail::LoadChange::Signatures l;
        l.fill({normal(random), normal(random), normal(random), normal(random)});
        change.take(l, size * normal(random), noise, 0);
      }
      change.step();
      static_cast<void>(change.restart());
      found += change.found() ? 1 : 0;
    }
    EXPECT_EQ(found, 0) << size;
    EXPECT_NEAR(change.misfit(), size * size, 0.25 * size * size) << size;
  }
}

TEST(PayloadEstimator, IsNotGoodWhereTheMassIsBelowNothing) {
  const Scene scene = six_joints(3);
  const Ticks run =
      run_of(scene, test::loaded(scene.robot, scene.chi_st, Inertial(-brick(1.0))), 3, 20.0, 0.1);
  PayloadEstimator<double> estimator(scene.model, options_of());
  int good = 0;
  for (Index k = 0; k < run.q.cols(); ++k) {
    estimator.update(run.q.col(k), run.tau.col(k));
    good += k > 2000 && estimator.payload().good ? 1 : 0;
  }
  EXPECT_EQ(good, 0);
  EXPECT_EQ(estimator.payload().mass, 0.0);
}

TEST(PayloadEstimator, BelievesWhatTheControllerSaysOfThePayload) {
  const Scene scene = six_joints(3);
  const Inertial body = brick(2.0);
  const Ticks empty = run_of(scene, scene.chi_st, 3, 10.0);
  const Ticks full = run_of(scene, test::loaded(scene.robot, scene.chi_st, body), 3, 10.0);
  PayloadEstimator<double> estimator(scene.model, options_of());
  for (Index k = 0; k < empty.q.cols(); ++k) {
    EXPECT_FALSE(estimator.update(empty.q.col(k), empty.tau.col(k)));
  }
  ASSERT_TRUE(estimator.payload().good);
  estimator.gripper(false);
  EXPECT_FALSE(estimator.payload().good);
  for (Index k = 0; k < full.q.cols(); ++k) {
    EXPECT_FALSE(estimator.update(full.q.col(k), full.tau.col(k)));
  }
  EXPECT_LE(std::abs(estimator.payload().mass - 2.0), 2.0 * estimator.payload().mass_half_width());
  estimator.gripper(true);  // what was held before is known
  EXPECT_TRUE(estimator.payload().good);
  EXPECT_LE(estimator.payload().mass, 2.0 * estimator.payload().mass_half_width());
  EXPECT_FALSE(estimator.payload_known(-1.0, {0.0, 0.0, 0.0}, 0.1, 0.01));
  const Eigen::Vector3d com(0.03, -0.05, 0.1);
  ASSERT_TRUE(estimator.payload_known(2.0, com, 0.01, 0.002));
  EXPECT_NEAR(estimator.payload().mass, 2.0, 1e-3);
  EXPECT_NEAR(estimator.payload().mass_sigma, 0.01, 1e-3);
  EXPECT_LE((estimator.payload().com - com).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_NEAR(estimator.payload().com_sigma.maxCoeff(), 0.002, 5e-4);
  EXPECT_TRUE(estimator.payload().good);
}

// Nothing moves fast enough for rows: gravity in four poses says it all. Torques at rest err by the friction
// that holds the joints, and by noise.
TEST(PayloadEstimator, WeighsAPayloadInFourPoses) {
  int covered = 0;
  constexpr int runs = 20;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Scene scene = six_joints(3);
    const Vector loaded = test::loaded(scene.robot, scene.chi_st, brick(2.0));
    PayloadEstimator<double> estimator(scene.model, options_of());
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> angle(-2.0, 2.0);
    test::Normal noise(0.0, 0.3);
    for (int pose = 0; pose < 14; ++pose) {
      const bool held = pose >= 10;
      if (pose == 10) {
        estimator.payload_changed();
      }
      const Vector q = Vector::NullaryExpr(6, [&] { return angle(random); });
      const Vector rest = Vector::Zero(6);
      Vector tau = inverse_dynamics(DynamicModel(scene.robot, held ? loaded : scene.chi_st), q, rest, rest);
      for (double& x : tau) {
        x += 0.2 * noise(random);
      }
      for (int k = 0; k < 250; ++k) {
        const Vector measured = tau + Vector::NullaryExpr(6, [&] { return noise(random); });
        estimator.update(q, measured);
      }
    }
    estimator.finish();
    EXPECT_LE(std::abs(estimator.payload().mass - 2.0), 0.1) << "seed " << seed;
    covered += std::abs(estimator.payload().mass - 2.0) <= estimator.payload().mass_half_width() ? 1 : 0;
  }
  EXPECT_GE(covered, 16);  // four binomial deviations below 19 of 20
}

TEST(PayloadEstimator, TellsTheNearestInertiaThatABodyHas) {
  const Eigen::Matrix3d possible = Eigen::Vector3d(0.02, 0.03, 0.04).asDiagonal();
  EXPECT_LE((detail::nearest_inertia<double>(possible) - possible).cwiseAbs().maxCoeff(), 1e-15);
  Eigen::Matrix3d impossible = Eigen::Vector3d(0.01, 0.02, 0.05).asDiagonal();
  impossible(0, 1) = impossible(1, 0) = 0.004;
  const Eigen::Matrix3d found = detail::nearest_inertia<double>(impossible);
  const Vector moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(found).eigenvalues();
  EXPECT_LE(moments[2], moments[0] + moments[1] + 1e-12);
}

TEST(PayloadEstimator, SaysWhatIsWrong) {
  const Scene scene = six_joints(1);
  PayloadEstimatorOptions options = options_of();
  options.mass_scale = 0.0;
  EXPECT_EQ(test::complaint_of([&] { PayloadEstimator<double>(scene.model, options); }),
            "PayloadEstimator: mass_scale is 0, must be positive");
  options = options_of();
  options.R *= 2.0;
  EXPECT_EQ(test::complaint_of([&] { PayloadEstimator<double>(scene.model, options); }),
            "PayloadEstimator: R is no rotation, or p is not finite");
  options = options_of();
  options.R(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(test::complaint_of([&] { PayloadEstimator<double>(scene.model, options); }),
            "PayloadEstimator: R is no rotation, or p is not finite");
  options.R = Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();  // a reflection
  EXPECT_EQ(test::complaint_of([&] { PayloadEstimator<double>(scene.model, options); }),
            "PayloadEstimator: R is no rotation, or p is not finite");
  options = options_of();
  options.length_scale = std::numeric_limits<double>::infinity();
  EXPECT_EQ(test::complaint_of([&] { PayloadEstimator<double>(scene.model, options); }),
            "PayloadEstimator: length_scale is infinite, must be finite");
  options = options_of();
  options.rows.stride = Index{1} << 50;
  EXPECT_TRUE(test::says(test::complaint_of([&] { PayloadEstimator<double>(scene.model, options); }),
                         "must not be negative and at most 1000000"));
  OnlineModel foreign = scene.model;
  foreign.base.parameters.back().leading.joint = 77;
  EXPECT_EQ(test::complaint_of([&] { PayloadEstimator<double>(foreign, options_of()); }),
            "PayloadEstimator: the base parameters are those of another robot than \"" + foreign.robot.name +
                "\", or of other friction laws; take base_parameters(robot)");
}

TEST(PayloadEstimator, TakesAnAbsurdTickForNone) {
  const Scene scene = six_joints(1);
  PayloadEstimator<double> estimator(scene.model, options_of());
  const Motion motion = test::Wandering(6, 5).at(test::ticks(3.0, f_m));
  for (Index k = 0; k < motion.samples(); ++k) {
    const double factor = k == 500 ? 1e160 : 1.0;
    estimator.update(factor * motion.q.row(k).transpose(), Vector::Zero(6));
  }
  EXPECT_TRUE(std::isfinite(estimator.payload().mass));
  EXPECT_TRUE(std::isfinite(estimator.payload().mass_sigma));
  EXPECT_TRUE(std::isnan(estimator.row_sigma(6, 0.1)));
}

}  // namespace
}  // namespace rivid
