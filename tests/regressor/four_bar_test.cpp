// Four-bar linkages: their angles against a loop that Newton's method closes, and their torques against those of
// the whole tree by KDL, folded by the slopes of that loop.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/AutoDiff>

#include "rivid/model/dependent.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/random_tree.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using Eigen::Vector2d;

// Axes and the closing point with all joints at 0.
struct Axes {
  Vector2d coupler = {0.1, 0.3};
  Vector2d closing = {0.55, 0.45};
  Vector2d rocker = {0.5, 0.02};
};

Vector2d turned(double angle, const Vector2d& v) { return Eigen::Rotation2Dd(angle) * v; }

// The coupler's and the rocker's joint where the crank's is at q; the coupler's axis points the other way.
Vector2d closed(const Axes& axes, double q) {
  Vector2d x = Vector2d::Zero();
  const auto steps = static_cast<int>(std::ceil(std::abs(q) / 0.02));
  for (int k = 1; k <= std::max(steps, 1); ++k) {
    const double at = q * k / std::max(steps, 1);
    for (int i = 0; i < 30; ++i) {
      const Vector2d bar = turned(at - x[0], axes.closing - axes.coupler);
      const Vector2d rock = turned(x[1], axes.closing - axes.rocker);
      const Vector2d gap = turned(at, axes.coupler) + bar - axes.rocker - rock;
      Eigen::Matrix2d J;
      J << bar.y(), rock.y(), -bar.x(), -rock.x();  // by each of the two angles
      x -= J.inverse() * gap;
    }
  }
  return x;
}

// Value, slope and curvature of closed(), by differences of sixth order.
Eigen::Matrix<double, 2, 3> loop(const Axes& axes, double q) {
  constexpr double h = 4e-3;
  constexpr std::array first = {-1.0 / 60, 3.0 / 20, -3.0 / 4, 0.0, 3.0 / 4, -3.0 / 20, 1.0 / 60};
  constexpr std::array second = {1.0 / 90, -3.0 / 20, 3.0 / 2, -49.0 / 18, 3.0 / 2, -3.0 / 20, 1.0 / 90};
  Eigen::Matrix<double, 2, 3> out = Eigen::Matrix<double, 2, 3>::Zero();
  out.col(0) = closed(axes, q);
  for (int k = -3; k <= 3; ++k) {
    const Vector2d x = closed(axes, q + k * h);
    out.col(1) += first[static_cast<std::size_t>(k + 3)] / h * x;
    out.col(2) += second[static_cast<std::size_t>(k + 3)] / (h * h) * x;
  }
  return out;
}

// A waist that carries the linkage; a wrist hangs on the coupler.
KDL::Tree linkage_tree(const Axes& axes) {
  std::mt19937_64 random(7);
  const auto body = [&] {
    const Inertial x = test::random_inertial(random);
    // XX XY XZ YY YZ ZZ about the origin, MX MY MZ, M.
    const Eigen::Vector3d c = x.segment<3>(6) / x[9];
    const Eigen::Matrix3d point = x[9] * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    return KDL::RigidBodyInertia(
        x[9], KDL::Vector(c.x(), c.y(), c.z()),
        KDL::RotationalInertia(x[0] - point(0, 0), x[3] - point(1, 1), x[5] - point(2, 2), x[1] - point(0, 1),
                               x[2] - point(0, 2), x[4] - point(1, 2)));
  };
  const auto frame = [](const Vector2d& p) { return KDL::Frame(KDL::Vector(p.x(), p.y(), 0.0)); };
  const auto turning = [](const std::string& name, const KDL::Vector& axis) {
    return KDL::Joint(name, KDL::Vector::Zero(), axis, KDL::Joint::RotAxis);
  };
  const KDL::Vector z(0, 0, 1);
  KDL::Tree out("base");
  out.addSegment(
      KDL::Segment{"torso", turning("waist", {1, 0, 0}), KDL::Frame(KDL::Vector(0.0, 0.2, 0.1)), body()},
      "base");
  out.addSegment(KDL::Segment{"crank_link", turning("crank", z), frame(axes.coupler), body()}, "torso");
  out.addSegment(
      KDL::Segment{"coupler_link", turning("coupler", -z), frame(axes.closing - axes.coupler), body()},
      "crank_link");
  out.addSegment(
      KDL::Segment{"hand", turning("wrist", {0, 1, 0}), KDL::Frame(KDL::Vector(0.1, 0.0, 0.0)), body()},
      "coupler_link");
  out.addSegment(KDL::Segment{"post", KDL::Joint("post", KDL::Joint::Fixed), frame(axes.rocker)}, "torso");
  out.addSegment(KDL::Segment{"rocker_link", turning("rocker", z), frame(axes.closing - axes.rocker), body()},
                 "post");
  return out;
}

FourBar four_bar(const Axes& axes) {
  const Vector2d at = axes.closing - axes.rocker;
  return {.crank = "crank", .coupler = "coupler", .rocker = "rocker", .at = {at.x(), at.y(), 0.0}};
}

Robot linkage(const Axes& axes) {
  const Robot whole = test::frictionless(linkage_tree(axes));
  return with_dependents(whole, with_four_bars(whole, std::vector<FourBar>{four_bar(axes)}));
}

std::pair<FourBarAngle, FourBarAngle> coupler_and_rocker(const Robot& robot) {
  return {robot.chain.dependents[0].four_bar.value(), robot.chain.dependents[1].four_bar.value()};
}

TEST(FourBar, AnglesSlopesAndCurvaturesAreThoseOfTheClosedLoop) {
  // Open and crossed; of the second the crank goes round.
  for (const Axes& axes :
       {Axes{}, Axes{.coupler = {0.06, 0.1}, .closing = {0.55, 0.45}, .rocker = {0.5, 0.02}},
        Axes{.coupler = {0.1, 0.3}, .closing = {0.55, -0.3}, .rocker = {0.5, 0.02}}}) {
    const auto [coupler, rocker] = coupler_and_rocker(linkage(axes));
    EXPECT_LT(coupler.least, -0.1);
    EXPECT_GT(coupler.most, 0.1);
    for (const double part : {0.1, 0.4, 0.5, 0.6, 0.9}) {
      const double q = coupler.least + part * (coupler.most - coupler.least);
      const Eigen::Matrix<double, 2, 3> expected = loop(axes, q);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto column = static_cast<Index>(k);
        EXPECT_NEAR(coupler.at(q)[k], expected(0, column), 1e-9) << q << ' ' << k;
        EXPECT_NEAR(rocker.at(q)[k], expected(1, column), 1e-9) << q << ' ' << k;
      }
    }
  }
}

TEST(FourBar, DerivativesByComplexStepAndDualNumbersAreItsSlopes) {
  const auto [coupler, rocker] = coupler_and_rocker(linkage({}));
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 1, 1>>;
  for (const FourBarAngle& angle : {coupler, rocker}) {
    const auto [x, slope, curvature] = angle.at(0.3);
    const auto complex = angle.at(std::complex<double>(0.3, 1e-30));
    EXPECT_NEAR(complex[0].real(), x, 1e-14);
    EXPECT_NEAR(complex[0].imag() / 1e-30, slope, 1e-13);
    EXPECT_NEAR(complex[1].imag() / 1e-30, curvature, 1e-12);
    const auto dual = angle.at(Dual(0.3, Dual::DerType::Ones()));
    EXPECT_NEAR(dual[0].derivatives()[0], slope, 1e-13);
    EXPECT_NEAR(dual[1].derivatives()[0], curvature, 1e-12);
  }
}

// The ground is the shortest link: all others go round with the crank, without a jump.
TEST(FourBar, GoesRoundWhereItCan) {
  const auto [coupler, rocker] =
      coupler_and_rocker(linkage({.coupler = {0.0, 0.5}, .closing = {0.45, 0.7}, .rocker = {0.1, 0.0}}));
  EXPECT_TRUE(rocker.turns);
  EXPECT_GT(rocker.most - rocker.least, 6.2);
  for (double q = -7.0; q < 7.0; q += 0.01) {
    EXPECT_NEAR(rocker.at(q + 0.01)[0], rocker.at(q)[0] + 0.005 * (rocker.at(q)[1] + rocker.at(q + 0.01)[1]),
                1e-3);
    EXPECT_NEAR(coupler.at(q + 0.01)[0],
                coupler.at(q)[0] + 0.005 * (coupler.at(q)[1] + coupler.at(q + 0.01)[1]), 1e-3);
  }
  EXPECT_NEAR(rocker.at(1.0 + 2.0 * std::numbers::pi)[0], rocker.at(1.0)[0] + 2.0 * std::numbers::pi, 1e-9);
}

TEST(FourBar, TorquesAreThoseOfTheTreeByTheSlopesOfTheLoop) {
  const Axes axes;
  const KDL::Tree tree = linkage_tree(axes);
  const Robot whole = test::frictionless(tree);
  Robot robot = linkage(axes);
  ASSERT_EQ(robot.size(), 3);  // waist, crank, wrist
  std::mt19937_64 random(3);
  Motion motion = test::random_motion(150, 3, random);
  motion.q.col(1) = (0.3 * motion.q.col(1)).cwiseMax(-0.4).cwiseMin(0.5);
  const auto place = [&](const Robot& of, const std::string& name) {
    return std::ranges::find(of.joints, name, &Joint::name) - of.joints.begin();
  };
  const Index n = whole.size();
  Motion all{Matrix::Zero(motion.samples(), n), Matrix::Zero(motion.samples(), n),
             Matrix::Zero(motion.samples(), n)};
  std::vector<Matrix> G(static_cast<std::size_t>(motion.samples()), Matrix::Zero(n, 3));
  for (Index k = 0; k < motion.samples(); ++k) {
    Matrix& slopes = G[static_cast<std::size_t>(k)];
    for (Index j = 0; j < 3; ++j) {
      const Index at = place(whole, robot.joints[static_cast<std::size_t>(j)].name);
      slopes(at, j) = 1.0;
      all.q(k, at) = motion.q(k, j);
      all.qd(k, at) = motion.qd(k, j);
      all.qdd(k, at) = motion.qdd(k, j);
    }
    const Eigen::Matrix<double, 2, 3> of_loop = loop(axes, motion.q(k, 1));
    for (Index i = 0; i < 2; ++i) {
      const Index at = place(whole, i == 0 ? "coupler" : "rocker");
      slopes(at, 1) = of_loop(i, 1);
      all.q(k, at) = of_loop(i, 0);
      all.qd(k, at) = of_loop(i, 1) * motion.qd(k, 1);
      all.qdd(k, at) = of_loop(i, 1) * motion.qdd(k, 1) + of_loop(i, 2) * std::pow(motion.qd(k, 1), 2);
    }
  }
  std::vector<std::string> links;
  for (const Joint& joint : whole.joints) {
    links.push_back(joint.link);
  }
  const Matrix of_tree = test::kdl_torques(tree, robot.chain.gravity, links, all);
  Matrix expected(motion.samples(), 3);
  for (Index k = 0; k < motion.samples(); ++k) {
    expected.row(k) = of_tree.row(k) * G[static_cast<std::size_t>(k)];
  }
  const double tolerance = 1e-9 * expected.cwiseAbs().maxCoeff();

  const BaseParameters base = base_parameters(robot);
  const Vector chi = base.from_standard(robot.chi_st());
  const Vector batch = observation(robot, base, motion).dense() * chi;
  EXPECT_LT((batch - expected.reshaped()).cwiseAbs().maxCoeff(), tolerance);
  const DynamicModel model(robot, robot.chi_st());
  InverseDynamics inverse(model);
  Dynamics<double> direct(model);
  for (Index k = 0; k < motion.samples(); ++k) {
    const Vector q = motion.q.row(k);
    const Vector qd = motion.qd.row(k);
    const Vector qdd = motion.qdd.row(k);
    Vector tau(3);
    inverse.torque(q, qd, qdd, tau);
    EXPECT_LT((tau - expected.row(k).transpose()).cwiseAbs().maxCoeff(), tolerance);
    inverse.gravity(q, tau);
    Vector still(3);
    inverse.torque(q, Vector::Zero(3), Vector::Zero(3), still);
    EXPECT_LT((tau - still).cwiseAbs().maxCoeff(), tolerance);
    ASSERT_TRUE(direct.set_state({q.data(), 3}, {qd.data(), 3}));
    Vector x = expected.row(k).transpose() - Vector::Map(direct.N().data(), 3);
    direct.solve({x.data(), 3});
    EXPECT_LT((x - qdd).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(FourBar, FaultsNameTheLinkage) {
  const auto refusal = [](const Axes& axes, const std::function<void(FourBar&)>& spoil) {
    const Robot whole = test::frictionless(linkage_tree(axes));
    FourBar bar = four_bar(axes);
    spoil(bar);
    return test::complaint_of(
        [&] { return with_dependents(whole, with_four_bars(whole, std::vector<FourBar>{bar})); });
  };
  EXPECT_TRUE(test::says(refusal({}, [](FourBar& bar) { bar.rocker = "rokcer"; }),
                         "no joint of the robot is called \"rokcer\""));
  EXPECT_TRUE(test::says(refusal({}, [](FourBar& bar) { bar.coupler = "wrist"; }), "not parallel"));
  EXPECT_TRUE(test::says(refusal({}, [](FourBar& bar) { std::swap(bar.coupler, bar.rocker); }),
                         "the coupler must hang on the crank"));
  EXPECT_TRUE(test::says(
      refusal({.coupler = {0.1, 0.3}, .closing = {0.9, -0.26}, .rocker = {0.5, 0.02}}, [](FourBar&) {}),
      "in one line there"));
  const Robot whole = test::frictionless(linkage_tree({}));
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           return with_dependents(
                               whole, with_four_bars(whole, std::vector<FourBar>{four_bar({})},
                                                     {{.joint = "wrist", .of = {{"rocker", 1.0}}}}));
                         }),
                         "it follows \"rocker\", a passive joint of a four-bar linkage"));
}

}  // namespace
}  // namespace rivid
