// Four-bar linkages and tables: their angles against a loop that Newton's method closes, or a function, and
// their torques against those of the whole tree by KDL, folded by the slopes of that loop or function.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <complex>
#include <functional>
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
  const auto of = [&](std::size_t k) {
    return std::get<FourBarAngle>(robot.chain.dependents[k].curve.value());
  };
  return {of(0), of(1)};
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

// What coupler and rocker do at a state of waist, crank and wrist.
struct Followed {
  Vector2d x;
  Eigen::Matrix<double, 2, 3> slopes;
  Vector2d curved;  // q̇ᵀ (∂²x/∂q²) q̇
};
using Follows = std::function<Followed(const Eigen::Vector3d& q, const Eigen::Vector3d& qd)>;

// Of the crank between -0.4 and 0.5.
Motion motion_of_three() {
  std::mt19937_64 random(3);
  Motion motion = test::random_motion(150, 3, random);
  motion.q.col(1) = (0.3 * motion.q.col(1)).cwiseMax(-0.4).cwiseMin(0.5);
  return motion;
}

void expect_torques(const Robot& robot, const Motion& motion, const Follows& follows) {
  const KDL::Tree tree = linkage_tree({});
  const Robot whole = test::frictionless(tree);
  ASSERT_EQ(robot.size(), 3);  // waist, crank, wrist
  const auto place = [&](const std::string& name) {
    return std::ranges::find(whole.joints, name, &Joint::name) - whole.joints.begin();
  };
  const Index n = whole.size();
  Motion all{Matrix::Zero(motion.samples(), n), Matrix::Zero(motion.samples(), n),
             Matrix::Zero(motion.samples(), n)};
  std::vector<Matrix> G(static_cast<std::size_t>(motion.samples()), Matrix::Zero(n, 3));
  for (Index k = 0; k < motion.samples(); ++k) {
    Matrix& slopes = G[static_cast<std::size_t>(k)];
    for (Index j = 0; j < 3; ++j) {
      const Index at = place(robot.joints[static_cast<std::size_t>(j)].name);
      slopes(at, j) = 1.0;
      all.q(k, at) = motion.q(k, j);
      all.qd(k, at) = motion.qd(k, j);
      all.qdd(k, at) = motion.qdd(k, j);
    }
    const Followed is = follows(motion.q.row(k), motion.qd.row(k));
    for (Index i = 0; i < 2; ++i) {
      const Index at = place(i == 0 ? "coupler" : "rocker");
      slopes.row(at) = is.slopes.row(i);
      all.q(k, at) = is.x[i];
      all.qd(k, at) = is.slopes.row(i).dot(motion.qd.row(k));
      all.qdd(k, at) = is.slopes.row(i).dot(motion.qdd.row(k)) + is.curved[i];
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

TEST(FourBar, TorquesAreThoseOfTheTreeByTheSlopesOfTheLoop) {
  expect_torques(linkage({}), motion_of_three(), [](const Eigen::Vector3d& q, const Eigen::Vector3d& qd) {
    const Eigen::Matrix<double, 2, 3> of_loop = loop({}, q[1]);
    Followed out{of_loop.col(0), Eigen::Matrix<double, 2, 3>::Zero(), of_loop.col(2) * qd[1] * qd[1]};
    out.slopes.col(1) = of_loop.col(1);
    return out;
  });
}

// Cubics, which the spline is to all digits: the coupler follows crank c and wrist w, the rocker all three.
Followed cubics(const Eigen::Vector3d& q, const Eigen::Vector3d& qd) {
  const double a = q[0];
  const double c = q[1];
  const double w = q[2];
  Followed out;
  out.x = {0.1 + 0.5 * c - 0.3 * w + 0.4 * c * w - 0.2 * c * c * w + 0.1 * w * w * w,
           0.7 * a * c * w - 0.3 * a + 0.2 * c * c};
  out.slopes << 0.0, 0.5 + 0.4 * w - 0.4 * c * w, -0.3 + 0.4 * c - 0.2 * c * c + 0.3 * w * w,
      0.7 * c * w - 0.3, 0.7 * a * w + 0.4 * c, 0.7 * a * c;
  Eigen::Matrix3d of_coupler;
  of_coupler << 0.0, 0.0, 0.0, 0.0, -0.4 * w, 0.4 - 0.4 * c, 0.0, 0.4 - 0.4 * c, 0.6 * w;
  Eigen::Matrix3d of_rocker;
  of_rocker << 0.0, 0.7 * w, 0.7 * c, 0.7 * w, 0.4, 0.7 * a, 0.7 * c, 0.7 * a, 0.0;
  out.curved = {qd.dot(of_coupler * qd), qd.dot(of_rocker * qd)};
  return out;
}

TEST(JointSpline, TorquesAreThoseOfTheTreeByTheSlopesOfTheFunction) {
  // Points of a grid; names in their order: crank, waist, wrist.
  constexpr int grid = 9;
  const auto at = [](int k) { return -3.2 + 6.4 * k / (grid - 1); };
  Matrix q(grid * grid * grid, 3);
  Matrix x(q.rows(), 2);
  for (int k = 0; k < q.rows(); ++k) {
    q.row(k) << at(k % grid), at(k / grid % grid), at(k / grid / grid);
    x.row(k) = cubics({q(k, 1), q(k, 0), q(k, 2)}, Eigen::Vector3d::Zero()).x;
  }
  const std::vector<DependentJoint> dependents = {{.joint = "coupler",
                                                   .of = {{"crank", 1.0}, {"wrist", 1.0}},
                                                   .curve = spline_through(q(Eigen::all, {0, 2}), x.col(0))},
                                                  {.joint = "rocker",
                                                   .of = {{"waist", 1.0}, {"crank", 1.0}, {"wrist", 1.0}},
                                                   .curve = spline_through(q, x.col(1))}};
  const Robot robot = with_dependents(test::frictionless(linkage_tree({})), dependents);
  EXPECT_EQ(robot.chain.reach(0)[1], 3.2);
  expect_torques(robot, motion_of_three(), cubics);
}

TEST(JointSpline, FollowsAFunctionToTheFourthPowerOfItsPieces) {
  const auto off = [](Index points) {
    const Vector q = Vector::LinSpaced(points, -1.0, 2.0);
    const JointSpline spline = spline_through(q, (2.0 * q).array().sin().matrix());
    Eigen::Array3d worst = Eigen::Array3d::Zero();  // of value, slope and curvature
    for (double at = -1.0; at < 2.0; at += 0.0013) {
      Eigen::Array3d x;
      spline.at(&at, x.data());
      x -= Eigen::Array3d(std::sin(2.0 * at), 2.0 * std::cos(2.0 * at), -4.0 * std::sin(2.0 * at));
      worst = worst.max(x.abs());
    }
    return worst;
  };
  // 37 and 57 pieces of h: (2 h)⁴ / 384 of an interpolating spline.
  EXPECT_LT(off(60)[0], 0.01 * std::pow(6.0 / 37.0, 4));
  const Eigen::Array3d better = off(60) / off(90);
  for (int k = 0; k < 3; ++k) {
    EXPECT_GT(better[k], 0.7 * std::pow(57.0 / 37.0, 4 - k)) << k;
  }
}

TEST(JointSpline, DerivativesByComplexStepAndDualNumbersAreItsSlopes) {
  Matrix q(400, 2);
  for (int k = 0; k < 400; ++k) {
    q.row(k) << 0.1 * (k % 20), 0.2 * (k / 20);
  }
  const JointSpline spline =
      spline_through(q, (q.col(0).array().sin() * (0.5 * q.col(1)).array().cos()).matrix());
  const std::array<double, 2> at = {0.77, 1.3};
  std::array<double, 7> x{};
  spline.at(at.data(), x.data());
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 1, 1>>;
  for (std::size_t a = 0; a < 2; ++a) {
    std::array<std::complex<double>, 2> z = {at[0], at[1]};
    std::array<std::complex<double>, 7> by_step;
    z[a] += std::complex<double>(0.0, 1e-30);
    spline.at(z.data(), by_step.data());
    std::array<Dual, 2> d = {Dual(at[0], Dual::DerType::Zero()), Dual(at[1], Dual::DerType::Zero())};
    std::array<Dual, 7> by_dual;
    d[a].derivatives().setOnes();
    spline.at(d.data(), by_dual.data());
    for (std::size_t v = 0; v < 3; ++v) {
      const double slope = v == 0 ? x[1 + a] : x[3 + 2 * (v - 1) + a];
      EXPECT_NEAR(by_step[v].imag() / 1e-30, slope, 1e-12);
      EXPECT_NEAR(by_dual[v].derivatives()[0], slope, 1e-12);
    }
  }
  EXPECT_NEAR(x[0], std::sin(0.77) * std::cos(0.65), 1e-5);
  EXPECT_NEAR(x[4], -0.5 * std::cos(0.77) * std::sin(0.65), 1e-2);
}

TEST(JointSpline, FaultsSayWhatIsMissing) {
  const Vector q = Vector::LinSpaced(50, 0.0, 1.0);
  const auto refusal = [](const Matrix& of, const Vector& x) {
    return test::complaint_of([&] { return spline_through(of, x); });
  };
  EXPECT_TRUE(test::says(refusal(Matrix::Zero(50, 1), q), "has 1 position of a joint that is followed"));
  EXPECT_TRUE(test::says(refusal(Matrix(50, 4), q), "one to 3 joints"));
  EXPECT_TRUE(
      test::says(refusal(q, (1e3 * q).array().sin().matrix()), "the joint does not follow those alone"));
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
