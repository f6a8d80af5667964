#include "rivid/online/recursive_identifier.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// A least-squares solution by two factorisations: 10 ε κ, κ below 400 here.
constexpr double same_solution = 1e-12;
constexpr double f_m = 200.0;
constexpr double seconds = 40.0;

struct Case {
  Robot robot;
  OnlineModel model;
  Log log;
};

Robot robot_of(int joints, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Robot robot = test::random_robot(joints, random);
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::symmetric;
  }
  return robot;
}

Case wandering(std::uint64_t seed, double torque_noise) {
  Case out{robot_of(4, seed), {}, {}};
  const Vector chi_st = test::distinct_friction(out.robot);
  out.model = test::known_model(out.robot, chi_st, 1.0);
  const Motion motion = test::Wandering(4, seed).at(test::ticks(seconds, f_m));
  out.log.source = "wandering";
  out.log.f_m = f_m;
  out.log.t = test::ticks(seconds, f_m);
  out.log.q = motion.q;
  out.log.tau = test::torques(DynamicModel(out.robot, chi_st), motion);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, torque_noise);
  out.log.tau = out.log.tau.unaryExpr([&](double x) { return x + noise(random); });
  return out;
}

RecursiveIdentifierOptions plain(const Vector& threshold) {
  RecursiveIdentifierOptions out;
  out.rows = {
      .f_m = f_m, .stride = 8, .torque_held = false, .velocity_threshold = threshold, .velocity_span = 1};
  out.prior = false;
  return out;
}

template <typename Scalar>
void run(RecursiveIdentifier<Scalar>& identifier, const Log& log) {
  for (Index k = 0; k < log.samples(); ++k) {
    identifier.update(log.q.row(k).transpose().cast<Scalar>(), log.tau.row(k).transpose().cast<Scalar>());
  }
  identifier.finish();
}

// All rows of a log in one matrix, [W y], divided by each joint's sigma.
Matrix stacked(const Case& of, const RowStreamOptions& options, const Vector& sigma) {
  RowStream<double> rows(of.robot, of.model.base.columns(), options);
  const Index b = of.model.base.size();
  std::vector<Vector> found;
  for (Index k = 0; k < of.log.samples(); ++k) {
    rows.update(of.log.q.row(k).transpose(), of.log.tau.row(k).transpose());
    rows.for_each_row([&](const RowStream<double>::Row& row) {
      Vector w = Vector::Zero(b + 1);
      const std::vector<Index>& own = rows.columns().of_joint(row.joint);
      for (std::size_t c = 0; c < own.size(); ++c) {
        w[own[c]] = row.values[c];
      }
      w[b] = row.y;
      found.push_back(w / sigma[static_cast<Index>(row.joint)]);
    });
  }
  Matrix out(static_cast<Index>(found.size()), b + 1);
  for (std::size_t i = 0; i < found.size(); ++i) {
    out.row(static_cast<Index>(i)) = found[i].transpose();
  }
  return out;
}

void expect_same(const Vector& found, const Vector& expected, double tolerance) {
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff())
      << found.transpose() << "\nbut should be\n"
      << expected.transpose();
}

TEST(RecursiveIdentifier, IsEigensBatchEstimateOfTheSameRows) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case of = wandering(seed, 0.5);
    of.model.sigma_rho = Eigen::Vector4d(1.0, 0.5, 2.0, 0.3);
    const RecursiveIdentifierOptions options = plain(Vector::Constant(4, 0.02));
    RecursiveIdentifier<double> identifier(of.model, options);
    run(identifier, of.log);
    const Matrix rows = stacked(of, options.rows, of.model.sigma_rho);
    const Index b = of.model.base.size();
    const Eigen::ColPivHouseholderQR<Matrix> qr(rows.leftCols(b));
    const Vector expected = qr.solve(rows.col(b));
    ASSERT_EQ(identifier.rows(), rows.rows());
    expect_same(identifier.chi(), expected, same_solution);
    const Matrix C = (rows.leftCols(b).transpose() * rows.leftCols(b)).inverse();
    for (Index i = 0; i < b; ++i) {
      EXPECT_NEAR(identifier.sigma(i) / std::sqrt(C(i, i)), 1.0, 1e-6);
    }
  }
}

TEST(RecursiveIdentifier, IsTheIdentificationOfTheSameLog) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case of = wandering(seed, 0.2);
    Estimation estimation;
    estimation.method = Ols{};
    estimation.signal.decimation = {8};
    estimation.signal.torque_held = false;
    const Identification batch = identify(of.robot, of.log, estimation);
    Vector threshold(4);
    for (Index j = 0; j < 4; ++j) {
      threshold[j] = batch.fit.joints[static_cast<std::size_t>(j)].velocity_threshold;
    }
    RecursiveIdentifier<double> identifier(of.model, plain(threshold));
    run(identifier, of.log);
    EXPECT_NEAR(static_cast<double>(identifier.rows()), static_cast<double>(batch.fit.rows), 8.0);
    expect_same(identifier.chi(), batch.chi, identifier.rows() == batch.fit.rows ? 1e-9 : 1e-2);
  }
}

TEST(RecursiveIdentifier, FindsTheTruthFromTicksWithoutNoise) {
  Case of = wandering(7, 0.0);
  RecursiveIdentifier<double> identifier(of.model, plain(Vector::Constant(4, 0.02)));
  run(identifier, of.log);
  // Averages over three samples leave a fourth derivative's worth.
  expect_same(identifier.chi(), of.model.chi, 1e-4);
}

TEST(RecursiveIdentifier, BeginsWithWhatTheModelKnows) {
  Case of = wandering(2, 0.5);
  RecursiveIdentifierOptions options = plain(Vector::Constant(4, 0.02));
  options.prior = true;
  RecursiveIdentifier<double> identifier(of.model, options);
  expect_same(identifier.chi(), of.model.chi, 1e-12);
  for (Index i = 0; i < identifier.size(); ++i) {
    EXPECT_NEAR(identifier.sigma(i), std::sqrt(of.model.C_chi(i, i)), 1e-12);
  }
  // With rows: the ridge solution by normal equations of well-scaled numbers.
  run(identifier, of.log);
  const Matrix rows = stacked(of, options.rows, of.model.sigma_rho);
  const Index b = of.model.base.size();
  const Matrix W = rows.leftCols(b);
  const Matrix P = of.model.C_chi.inverse();
  const Vector expected =
      (W.transpose() * W + P).ldlt().solve(W.transpose() * rows.col(b) + P * of.model.chi);
  expect_same(identifier.chi(), expected, 1e-10);
}

TEST(RecursiveIdentifier, ForgetsWithItsTimeConstant) {
  Case of = wandering(3, 0.5);
  RecursiveIdentifierOptions options = plain(Vector::Constant(4, 0.02));
  options.forgetting = 5.0;
  RecursiveIdentifier<double> identifier(of.model, options);
  // Torques twice as large after a while: all parameters double.
  run(identifier, of.log);
  Log doubled = of.log;
  doubled.tau *= 2.0;
  // The motion jumps back to its begin: a tick that is none ends all windows.
  doubled.tau(0, 0) = std::numeric_limits<double>::quiet_NaN();
  run(identifier, doubled);
  RecursiveIdentifier<double> with_memory(of.model, plain(Vector::Constant(4, 0.02)));
  run(with_memory, of.log);
  run(with_memory, doubled);
  // By torques, which show what the motion determines.
  const Matrix W = stacked(of, options.rows, of.model.sigma_rho).leftCols(of.model.base.size());
  const Vector wanted = W * (2.0 * of.model.chi);
  const auto off = [&](RecursiveIdentifier<double>& of_one) {
    return (W * of_one.chi() - wanted).norm() / wanted.norm();
  };
  // All rows count alike: half-way between 1 and 2. Of the last seconds: noise.
  EXPECT_NEAR(off(with_memory), 0.25, 0.01);
  EXPECT_LE(off(identifier), 0.02);
}

TEST(RecursiveIdentifier, MergesPartsAndTheTrianglesOfTheBatch) {
  Case of = wandering(4, 0.5);
  const RecursiveIdentifierOptions options = plain(Vector::Constant(4, 0.02));
  RecursiveIdentifier<double> whole(of.model, options);
  RecursiveIdentifier<double> first(of.model, options);
  RecursiveIdentifier<double> second(of.model, options);
  run(whole, of.log);
  run(first, of.log);
  Log other = of.log;
  other.q = test::Wandering(4, 99).at(of.log.t).q;
  run(second, other);
  Matrix rows = stacked(of, options.rows, of.model.sigma_rho);
  StreamingQr qr(of.model.base.size());
  qr.add(rows.leftCols(of.model.base.size()), rows.rightCols(1));
  RecursiveIdentifier<double> from_qr = second;
  ASSERT_TRUE(from_qr.merge(qr.R(), qr.qty()));
  first.merge(second);
  expect_same(from_qr.chi(), first.chi(), same_solution * 10.0);
  EXPECT_FALSE(from_qr.merge(Matrix::Zero(2, 2), Vector::Zero(2)));
}

TEST(RecursiveIdentifier, NeverAllocatesAndComesBackBitByBit) {
  Case of = wandering(5, 0.5);
  RecursiveIdentifierOptions options = plain(Vector::Constant(4, 0.02));
  options.forgetting = 20.0;
  options.prior = true;
  RecursiveIdentifier<double> identifier(of.model, options);
  RecursiveIdentifier<double> twin = identifier;
  std::vector<std::byte> state(state_size(identifier));
  const Matrix q = of.log.q.transpose();
  const Matrix tau = of.log.tau.transpose();
  const long count = test::allocations_of([&] {
    for (Index k = 0; k < q.cols(); ++k) {
      identifier.update(q.col(k), tau.col(k));
      static_cast<void>(identifier.chi());
      if (k == q.cols() / 2) {
        ASSERT_TRUE(save_state(identifier, state));
      }
    }
  });
  EXPECT_EQ(count, 0);
  ASSERT_TRUE(restore_state(twin, state));
  for (Index k = q.cols() / 2 + 1; k < q.cols(); ++k) {
    twin.update(q.col(k), tau.col(k));
  }
  EXPECT_EQ((identifier.chi() - twin.chi()).cwiseAbs().maxCoeff(), 0.0);
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{8}, std::size_t{16}, state.size() / 2, state.size() - 1}) {
    std::vector<std::byte> damaged = state;
    damaged[at] ^= std::byte{0x10};
    EXPECT_FALSE(restore_state(twin, damaged)) << "byte " << at;
  }
  EXPECT_FALSE(restore_state(twin, std::vector<std::byte>(state.size(), std::byte{0x7f})));
  EXPECT_EQ((identifier.chi() - twin.chi()).cwiseAbs().maxCoeff(), 0.0);
  state.pop_back();
  EXPECT_FALSE(restore_state(twin, state));
}

TEST(RecursiveIdentifier, LeavesOutRowsThatDoNotFit) {
  const Case of = wandering(5, 0.5);
  RecursiveIdentifier<double> identifier(of.model, plain(Vector::Constant(4, 0.02)));
  const std::vector<double> w(identifier.columns().of_joint(0).size() + 1, 1.0);
  identifier.add_row(9, w, 1.0, 1.0);
  identifier.add_row(0, w, 1.0, 1.0);
  identifier.finish();
  EXPECT_EQ(identifier.rows(), 0);
  EXPECT_TRUE(std::isnan(identifier.sigma(99)) && std::isnan(identifier.consistency(4)));
}

TEST(RecursiveIdentifier, PassesOverTicksThatAreNone) {
  Case of = wandering(6, 0.1);
  RecursiveIdentifier<double> identifier(of.model, plain(Vector::Constant(4, 0.02)));
  of.log.tau(1000, 2) = std::numeric_limits<double>::quiet_NaN();
  of.log.q(3000, 1) = std::numeric_limits<double>::infinity();
  run(identifier, of.log);
  EXPECT_TRUE(identifier.chi().allFinite());
  expect_same(identifier.chi(), of.model.chi, 0.02);
}

TEST(RecursiveIdentifier, WorksInSinglePrecision) {
  Case of = wandering(1, 0.1);
  RecursiveIdentifierOptions options = plain(Vector::Constant(4, 0.02));
  options.prior = true;
  RecursiveIdentifier<float> single(of.model, options);
  RecursiveIdentifier<double> twice(of.model, options);
  run(single, of.log);
  run(twice, of.log);
  expect_same(single.chi().cast<double>(), twice.chi(), 2e-2);
}

TEST(RecursiveIdentifier, SaysWhatIsWrong) {
  Case of = wandering(1, 0.1);
  RecursiveIdentifierOptions options;
  options.forgetting = -1.0;
  EXPECT_EQ(test::complaint_of([&] { RecursiveIdentifier<double>(of.model, options); }),
            "RecursiveIdentifier: forgetting is -1 s, must be positive");
  options.forgetting = 1.0;
  options.rows.f_m = 0.0;
  EXPECT_EQ(test::complaint_of([&] { RecursiveIdentifier<double>(of.model, options); }),
            "RecursiveIdentifier: f_m is 0 Hz, must be positive");
  of.model.C_chi(0, 0) = 0.0;
  EXPECT_NE(test::complaint_of([&] { RecursiveIdentifier<double>(of.model, {}); }).find("must be positive"),
            std::string::npos);
}

}  // namespace
}  // namespace rivid
