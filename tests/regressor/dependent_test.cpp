// Joints that follow others, q_all = G q + q0, against torques of the whole tree that KDL computes.

#include "rivid/model/dependent.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "rivid/online/momentum.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics_batch.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/random_tree.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Same quantity by another algorithm, relative to the largest torque.
constexpr double tolerance = 1e-12;

double largest(const Matrix& x) { return x.cwiseAbs().maxCoeff(); }

// A tree of KDL, the robot whose joints partly follow others, and the same dependence as matrices.
struct Following {
  Following(KDL::Tree of, const std::function<std::vector<DependentJoint>(const Robot&)>& dependents,
            std::uint64_t seed)
      : tree(std::move(of)), whole(test::frictionless(tree)), described(dependents(whole)) {
    robot = with_dependents(whole, described);
    const auto all = whole.size();
    G = Matrix::Zero(all, robot.size());
    q0 = Vector::Zero(all);
    const auto place = [](const Robot& of_robot, const std::string& name) {
      return std::ranges::find(of_robot.joints, name, &Joint::name) - of_robot.joints.begin();
    };
    for (Index j = 0; j < robot.size(); ++j) {
      G(place(whole, robot.joints[static_cast<std::size_t>(j)].name), j) = 1.0;
    }
    for (const DependentJoint& each : described) {
      const Index row = place(whole, each.joint);
      q0[row] = each.offset;
      whole.joints[static_cast<std::size_t>(row)].Ia = 0.0;
      for (const auto& [name, factor] : each.of) {
        G(row, place(robot, name)) = factor;
      }
    }
    std::mt19937_64 random(seed);
    motion = test::random_motion(70, robot.size(), random);
  }

  // Gᵀ τ_all, without rotors of joints that have no motor.
  [[nodiscard]] Matrix folded(const Motion& of) const {
    std::vector<std::string> links;
    for (const Joint& joint : whole.joints) {
      links.push_back(joint.link);
    }
    const Motion all = {(of.q * G.transpose()).rowwise() + q0.transpose(), of.qd * G.transpose(),
                        of.qdd * G.transpose()};
    Matrix tau = test::kdl_torques(tree, robot.chain.gravity, links, all);
    const Robot as_drawn = test::frictionless(tree);
    for (Index j = 0; j < whole.size(); ++j) {
      const auto at = static_cast<std::size_t>(j);
      tau.col(j) -= (as_drawn.joints[at].Ia - whole.joints[at].Ia) * all.qdd.col(j);
    }
    return tau * G;
  }

  KDL::Tree tree;
  Robot whole;
  std::vector<DependentJoint> described;
  Robot robot;
  Matrix G;
  Vector q0;
  Motion motion;
};

// Up to half of the joints follow one to three of the others.
Following drawn(int number) {
  test::RandomChain draw(static_cast<std::uint64_t>(1700 + number));
  return {test::random_tree(draw, 4 + number % 17),
          [&](const Robot& whole) {
            std::vector<DependentJoint> out;
            const int n = static_cast<int>(whole.size());
            std::vector<bool> follows(static_cast<std::size_t>(n), false);
            for (int k = 0; k < std::max(1, n / 2); ++k) {
              follows[static_cast<std::size_t>(draw.integer(0, n - 1))] = true;
            }
            follows[static_cast<std::size_t>(draw.integer(0, n - 1))] = false;
            std::vector<std::string> leaders;
            for (int j = 0; j < n; ++j) {
              if (!follows[static_cast<std::size_t>(j)]) {
                leaders.push_back(whole.joints[static_cast<std::size_t>(j)].name);
              }
            }
            for (int j = 0; j < n; ++j) {
              if (!follows[static_cast<std::size_t>(j)]) {
                continue;
              }
              DependentJoint& joint = out.emplace_back();
              joint.joint = whole.joints[static_cast<std::size_t>(j)].name;
              joint.offset = draw.uniform(-1.0, 1.0);
              for (int terms = draw.integer(1, 3); terms > 0; --terms) {
                joint.of[leaders[static_cast<std::size_t>(
                    draw.integer(0, static_cast<int>(leaders.size()) - 1))]] = draw.uniform(-2.0, 2.0);
              }
            }
            return out;
          },
          static_cast<std::uint64_t>(number)};
}

constexpr int trees = 30;

TEST(Dependent, DrawnOnesFollowInManyWays) {
  std::size_t followers = 0;
  std::size_t carried = 0;  // joints on links of followers
  for (int number = 0; number < trees; ++number) {
    const Following f = drawn(number);
    followers += f.robot.chain.dependents.size();
    for (std::size_t j = 0; j < f.robot.joints.size(); ++j) {
      carried += f.robot.chain.parent(j) >= static_cast<int>(f.robot.size()) ? 1U : 0U;
    }
  }
  EXPECT_GT(followers, 60U);
  EXPECT_GT(carried, 20U);
}

TEST(Dependent, RegressorTimesParametersIsTheFoldedInverseDynamicsOfKdl) {
  for (int number = 0; number < trees; ++number) {
    const Following f = drawn(number);
    const Matrix expected = f.folded(f.motion);
    const Vector chi_st = f.robot.chi_st();
    const BaseParameters base = base_parameters(f.robot);
    const Vector batch = observation(f.robot, base, f.motion).dense() * base.from_standard(chi_st);
    EXPECT_LT(largest(batch - expected.reshaped()), tolerance * largest(expected)) << "tree " << number;

    const RegressorColumns columns(f.robot, f.robot.standard_parameters());
    RegressorWorkspace<double> workspace(columns);
    Matrix single = Matrix::Zero(f.motion.samples(), f.robot.size());
    for (Index k = 0; k < f.motion.samples(); ++k) {
      const std::array<Vector, 3> x = {f.motion.q.row(k), f.motion.qd.row(k), f.motion.qdd.row(k)};
      const auto n = static_cast<std::size_t>(f.robot.size());
      columns.rows(State<double>{{x[0].data(), n}, {x[1].data(), n}, {x[2].data(), n}}, workspace,
                   [&](std::size_t i, Index column, double value) {
                     single(k, static_cast<Index>(i)) +=
                         value * chi_st[columns.of_joint(i)[static_cast<std::size_t>(column)]];
                   });
    }
    EXPECT_LT(largest(single - expected), tolerance * largest(expected)) << "tree " << number;
  }
}

TEST(Dependent, BaseParametersAreAsManyAsTheRankOfTheFoldedRegressor) {
  for (int number = 0; number < trees; number += 3) {
    const Following f = drawn(number);
    BaseParameters all;
    all.standard = f.robot.standard_parameters();
    for (const StandardParameter& p : all.standard) {
      all.parameters.push_back({p, p.name(), p.name(), ""});
    }
    std::mt19937_64 random(static_cast<std::uint64_t>(number));
    const Matrix W = observation(f.robot, all, test::random_motion(300, f.robot.size(), random)).dense();
    Eigen::BDCSVD<Matrix> svd(W);
    svd.setThreshold(1e-9);
    EXPECT_EQ(base_parameters(f.robot).size(), svd.rank()) << "tree " << number;
  }
}

TEST(Dependent, DynamicsMakeTheFoldedTorquesOfKdl) {
  for (int number = 0; number < trees; ++number) {
    const Following f = drawn(number);
    const Matrix expected = f.folded(f.motion);
    const DynamicModel model(f.robot, f.robot.chi_st());
    InverseDynamics inverse(model);
    const Index n = f.robot.size();
    Vector tau(n);
    for (Index k = 0; k < 5; ++k) {
      const Vector q = f.motion.q.row(k);
      const Vector qd = f.motion.qd.row(k);
      const Vector qdd = f.motion.qdd.row(k);
      const Vector wanted = expected.row(k);
      EXPECT_LT(largest(inverse_dynamics(model, q, qd, qdd) - wanted), tolerance * largest(expected))
          << "tree " << number;
      inverse.rigid_body(q, qd, qdd, tau);
      EXPECT_LT(largest(tau - wanted), tolerance * largest(expected)) << "tree " << number;

      // M from unit accelerations, N from none; of KDL.
      const Matrix at = q.transpose().replicate(n + 1, 1);
      Matrix units = Matrix::Zero(n + 1, n);
      units.topRows(n).setIdentity();
      const Matrix still = f.folded({at, Matrix::Zero(n + 1, n), units});
      const Matrix M = (still.topRows(n).rowwise() - still.row(n)).transpose();
      EXPECT_LT(largest(mass_matrix(model, q) - M), tolerance * largest(still)) << "tree " << number;
      const Vector N = f.folded({q.transpose(), qd.transpose(), Matrix::Zero(1, n)}).transpose();
      EXPECT_LT(largest(bias(model, q, qd) - N), tolerance * largest(expected)) << "tree " << number;
      inverse.gravity(q, tau);
      EXPECT_LT(largest(tau - still.row(n).transpose()), tolerance * largest(still)) << "tree " << number;
      Matrix of_controller(n, n);
      inverse.M(q, of_controller);
      EXPECT_LT(largest(of_controller - M), tolerance * largest(still)) << "tree " << number;
    }
  }
}

TEST(Dependent, BatchesOfDynamicsAreThoseOfSingleSamplesAndDesignInertiasTheDiagonals) {
  for (int number = 0; number < trees; number += 4) {
    Following f = drawn(number);
    for (Joint& joint : f.robot.joints) {
      joint.Ia += 0.5;  // so that M is definite, whatever hangs on the joint
    }
    const DynamicModel model(f.robot, f.robot.chi_st());
    Matrix qdd(f.motion.samples(), f.robot.size());
    const Matrix tau = f.motion.qdd;
    ASSERT_FALSE(DynamicsBatch(model).accelerations(f.motion.q, f.motion.qd, tau, qdd));
    Vector most = Vector::Zero(f.robot.size());
    for (Index k = 0; k < f.motion.samples(); ++k) {
      const Vector q = f.motion.q.row(k);
      const Vector single = direct_dynamics(model, q, f.motion.qd.row(k).transpose(), tau.row(k).transpose());
      EXPECT_LT(largest(qdd.row(k).transpose() - single), 1e-10 * std::max(1.0, largest(single)));
      most = most.cwiseMax(mass_matrix(model, q).diagonal());
    }
    EXPECT_LT(largest(design_inertia(model, f.motion.q) - most), tolerance * largest(most));
  }
}

// A palletiser's linkage in the plane of a column that turns: the shoulder moves the lower arm, the crank
// beside it a lever; forearm and rod close the parallelogram, which is cut where they meet.
struct Parallelogram {
  static constexpr double a = 0.8;  // lower arm and rod
  static constexpr double b = 0.3;  // lever and rear end of the forearm

  static Following following() {
    test::RandomChain draw(77);
    KDL::Tree tree("base");
    const auto add = [&](const std::string& name, KDL::Joint::JointType type, const KDL::Vector& at,
                         const std::string& on) {
      const KDL::Frame tip(at);
      const KDL::Vector axis = type == KDL::Joint::RotZ ? KDL::Vector(0, 0, 1) : KDL::Vector(0, 1, 0);
      tree.addSegment(
          KDL::Segment(name + "_link", KDL::Joint(name, at, axis, KDL::Joint::RotAxis), tip, draw.body()),
          on);
    };
    using enum KDL::Joint::JointType;
    add("turn", RotZ, {0, 0, 0.3}, "base");
    add("shoulder", RotY, {0.1, 0, 0.2}, "turn_link");
    add("elbow", RotY, {0, 0.05, a}, "shoulder_link");
    add("crank", RotY, {0.1, 0.1, 0.2}, "turn_link");
    add("rod", RotY, {-b, 0, 0}, "crank_link");
    return {tree,
            [](const Robot&) {
              return std::vector<DependentJoint>{
                  {.joint = "elbow", .of = {{"crank", 1.0}, {"shoulder", -1.0}}},
                  {.joint = "rod", .of = {{"shoulder", 1.0}, {"crank", -1.0}}}};
            },
            7};
  }

  // Where rod and forearm meet must not move: J q̇ = 0, of turn, shoulder, elbow, crank and rod; in the plane.
  // At the angles θ about y the lower arm points along (sin θ, cos θ), lever and rear end of the forearm
  // along (−cos θ, sin θ).
  static Matrix J(const Vector& q) {
    const auto up = [](double angle) {
      return Eigen::Vector2d(a * std::cos(angle), -a * std::sin(angle));  // slope of the lower arm's end
    };
    const auto back = [](double angle) {
      return Eigen::Vector2d(b * std::sin(angle), b * std::cos(angle));  // of the lever's
    };
    Matrix out = Matrix::Zero(2, 5);
    out.col(1) = up(q[1]) + back(q[1] + q[2]);
    out.col(2) = back(q[1] + q[2]);
    out.col(3) = -back(q[3]) - up(q[3] + q[4]);
    out.col(4) = -up(q[3] + q[4]);
    return out;
  }
};

TEST(Dependent, ParallelogramIsTheCutTreeWithForcesThatCloseIt) {
  const Following f = Parallelogram::following();
  ASSERT_EQ(f.robot.size(), 3);
  std::vector<std::string> links;
  for (const Joint& joint : f.whole.joints) {
    links.push_back(joint.link);
  }
  ASSERT_EQ(links[1], "shoulder_link");
  ASSERT_EQ(links[4], "rod_link");
  const Motion all = {f.motion.q * f.G.transpose(), f.motion.qd * f.G.transpose(),
                      f.motion.qdd * f.G.transpose()};
  const Matrix cut = test::kdl_torques(f.tree, f.robot.chain.gravity, links, all);
  const DynamicModel model(f.robot, f.robot.chi_st());
  const std::array<Index, 3> driven = {0, 1, 3};
  for (Index k = 0; k < f.motion.samples(); ++k) {
    const Matrix J = Parallelogram::J(all.q.row(k).transpose());
    EXPECT_LT((J * all.qd.row(k).transpose()).norm(), 1e-12);
    // τ of the driven joints and forces at the cut: Sᵀ τ + Jᵀ λ = τ_cut.
    Matrix A = Matrix::Zero(5, 5);
    for (Index j = 0; j < 3; ++j) {
      A(driven[static_cast<std::size_t>(j)], j) = 1.0;
    }
    A.rightCols(2) = J.transpose();
    const Vector solved = A.fullPivLu().solve(cut.row(k).transpose());
    const Vector found = inverse_dynamics(model, f.motion.q.row(k).transpose(),
                                          f.motion.qd.row(k).transpose(), f.motion.qdd.row(k).transpose());
    if (A.fullPivLu().rcond() > 1e-6) {  // off its singular postures
      EXPECT_LT(largest(found - solved.head(3)), 1e-9 * largest(cut)) << "sample " << k;
    }
  }
}

TEST(Dependent, WhatFollowsChainsOrJointsThatMoveByThemselvesSaysSo) {
  const Robot robot = Parallelogram::following().robot;
  const DynamicModel model(robot, robot.chi_st());
  const auto says = [](const std::string& message) {
    return test::says(message, "joint \"elbow\" depends on others, every joint must move by itself");
  };
  EXPECT_TRUE(says(test::complaint_of([&] { return kdl_chain(robot); })));
  EXPECT_TRUE(says(test::complaint_of([&] { return detail::Momentum<double>(model).size(); })));
}

TEST(Dependent, FaultsOfTheChainAreFound) {
  const Robot robot = Parallelogram::following().robot;
  ASSERT_FALSE(robot.complaint());
  const auto complaint = [&](const auto& spoil) {
    Robot other = robot;
    spoil(other);
    return other.complaint().value_or("");
  };
  EXPECT_EQ(complaint([](Robot& r) { r.chain.dependents[0].terms[0].factor = 0.0; }),
            "dependent joint \"elbow\": a factor is 0, must be finite and not zero");
  EXPECT_EQ(complaint([](Robot& r) { r.chain.dependents[1].terms[0].joint = 3; }),
            "dependent joint \"rod\": it follows joint 4 of 3");
  EXPECT_EQ(complaint([](Robot& r) { r.chain.dependents[1].terms.clear(); }),
            "dependent joint \"rod\": it follows no joint");
  EXPECT_EQ(complaint([](Robot& r) { r.chain.parents[3] = 3; }), "parents lead round in a cycle");
  EXPECT_EQ(complaint([](Robot& r) { r.chain.parents[3] = 9; }), "a link is carried by link 10 of 5");
}

}  // namespace
}  // namespace rivid
