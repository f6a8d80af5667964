#include <gtest/gtest.h>

#include <Eigen/Dense>

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

struct DrawnTree {
  explicit DrawnTree(int number)
      : draw(static_cast<std::uint64_t>(900 + number)),
        tree(test::random_tree(draw, 3 + number % 23)),
        robot(test::frictionless(tree)) {
    std::mt19937_64 random(static_cast<std::uint64_t>(number));
    motion = test::random_motion(13, robot.size(), random);
  }

  [[nodiscard]] Matrix torques() const {
    std::vector<std::string> links;
    for (const Joint& joint : robot.joints) {
      links.push_back(joint.link);
    }
    return test::kdl_torques(tree, robot.chain.gravity, links, motion);
  }

  test::RandomChain draw;
  KDL::Tree tree;
  Robot robot;
  Motion motion;
};

constexpr int trees = 40;

double largest(const Matrix& x) { return x.cwiseAbs().maxCoeff(); }

std::span<const double> row(Vector& scratch, const Matrix& x, Index k) {
  scratch = x.row(k);
  return {scratch.data(), static_cast<std::size_t>(scratch.size())};
}

TEST(Tree, DrawnOnesBranchAndSlide) {
  int branching = 0;
  int forks = 0;
  for (int number = 0; number < trees; ++number) {
    const Chain chain = DrawnTree(number).robot.chain;
    branching += chain.branches() ? 1 : 0;
    forks += static_cast<int>(std::ranges::count_if(chain.forks(), [](int fork) { return fork >= 0; }));
  }
  EXPECT_GT(branching, 25);
  EXPECT_GT(forks, 60);
}

TEST(Tree, RegressorTimesParametersIsTheInverseDynamicsOfKdl) {
  for (int number = 0; number < trees; ++number) {
    const DrawnTree drawn(number);
    const Robot& robot = drawn.robot;
    const Matrix expected = drawn.torques();
    const BaseParameters base = base_parameters(robot);
    const Vector batch = observation(robot, base, drawn.motion).dense() * base.from_standard(robot.chi_st());
    EXPECT_LT(largest(batch - expected.reshaped()), tolerance * largest(expected)) << "tree " << number;

    const RegressorColumns columns(robot, robot.standard_parameters());
    RegressorWorkspace<double> workspace(columns);
    const Vector chi_st = robot.chi_st();
    Vector q;
    Vector qd;
    Vector qdd;
    Matrix single = Matrix::Zero(drawn.motion.samples(), robot.size());
    for (Index k = 0; k < drawn.motion.samples(); ++k) {
      columns.rows(State<double>{row(q, drawn.motion.q, k), row(qd, drawn.motion.qd, k),
                                 row(qdd, drawn.motion.qdd, k)},
                   workspace, [&](std::size_t i, Index column, double value) {
                     single(k, static_cast<Index>(i)) +=
                         value * chi_st[columns.of_joint(i)[static_cast<std::size_t>(column)]];
                   });
    }
    EXPECT_LT(largest(single - expected), tolerance * largest(expected)) << "tree " << number;
  }
}

TEST(Tree, RowsHoldColumnsOfTheJointsOwnBranchAlone) {
  const Robot robot = DrawnTree(15).robot;
  const RegressorColumns columns(robot, robot.standard_parameters());
  const std::vector<StandardParameter> standard = robot.standard_parameters();
  for (std::size_t i = 0; i < columns.joints(); ++i) {
    for (const Index c : columns.of_joint(i)) {
      const auto path =
          robot.chain.path(static_cast<std::size_t>(standard[static_cast<std::size_t>(c)].joint));
      EXPECT_TRUE(std::ranges::find(path, i) != path.end());
    }
  }
}

TEST(Tree, BaseParametersAreAsManyAsTheRankOfTheRegressor) {
  for (int number = 0; number < trees; number += 3) {
    const Robot robot = DrawnTree(number).robot;
    std::mt19937_64 random(static_cast<std::uint64_t>(number));
    const Motion motion = test::random_motion(60, robot.size(), random);
    BaseParameters all;
    all.standard = robot.standard_parameters();
    for (const StandardParameter& p : all.standard) {
      all.parameters.push_back({p, p.name(), p.name(), ""});
    }
    const Matrix W = observation(robot, all, motion).dense();
    Eigen::BDCSVD<Matrix> svd(W);
    svd.setThreshold(1e-9);
    EXPECT_EQ(base_parameters(robot).size(), svd.rank()) << "tree " << number;
  }
}

TEST(Tree, MassMatrixAndBiasMakeTheTorquesOfKdlAndTheirInverse) {
  for (int number = 0; number < trees; ++number) {
    const DrawnTree drawn(number);
    const DynamicModel model(drawn.robot, drawn.robot.chi_st());
    const Matrix expected = drawn.torques();
    InverseDynamics inverse(model);
    Dynamics<double> dynamics(model);
    Vector tau(drawn.robot.size());
    for (Index k = 0; k < drawn.motion.samples(); ++k) {
      const Vector q = drawn.motion.q.row(k);
      const Vector qd = drawn.motion.qd.row(k);
      const Vector qdd = drawn.motion.qdd.row(k);
      const Vector wanted = expected.row(k);
      EXPECT_LT(largest(inverse_dynamics(model, q, qd, qdd) - wanted), tolerance * largest(expected));
      inverse.rigid_body(q, qd, qdd, tau);
      EXPECT_LT(largest(tau - wanted), tolerance * largest(expected)) << "tree " << number;
      inverse.gravity(q, tau);
      EXPECT_LT(largest(tau - bias(model, q, Vector::Zero(q.size()))), tolerance * largest(expected));
      const Matrix M = mass_matrix(model, q);
      const Eigen::LDLT<Matrix> factor(M);
      if (factor.isPositive() && factor.rcond() > 1e-9) {
        const Vector found = direct_dynamics(model, q, qd, wanted);
        EXPECT_LT(largest(M * (found - qdd)), 1e-10 * largest(expected)) << "tree " << number;
      }
    }
  }
}

TEST(Tree, PacksOfDynamicsAreThoseOfSingleSamples) {
  for (int number = 0; number < trees; ++number) {
    DrawnTree drawn(number);
    for (Joint& joint : drawn.robot.joints) {
      joint.Ia += 0.5;  // so that M is definite, whatever hangs on the joint
    }
    const DynamicModel model(drawn.robot, drawn.robot.chi_st());
    DynamicsBatch batch(model);
    Matrix qdd(drawn.motion.samples(), drawn.robot.size());
    const Matrix tau = drawn.motion.qdd;
    ASSERT_FALSE(batch.accelerations(drawn.motion.q, drawn.motion.qd, tau, qdd));
    for (Index k = 0; k < drawn.motion.samples(); ++k) {
      const Vector single = direct_dynamics(model, drawn.motion.q.row(k).transpose(),
                                            drawn.motion.qd.row(k).transpose(), tau.row(k).transpose());
      EXPECT_LT(largest(qdd.row(k).transpose() - single), 1e-10 * std::max(1.0, largest(single)));
    }
  }
}

TEST(Tree, DesignInertiasAreDiagonalsOfTheMassMatrix) {
  DrawnTree drawn(15);
  for (Joint& joint : drawn.robot.joints) {
    joint.Ia += 0.5;
  }
  const DynamicModel model(drawn.robot, drawn.robot.chi_st());
  Vector most = Vector::Zero(drawn.robot.size());
  for (Index k = 0; k < drawn.motion.samples(); ++k) {
    most = most.cwiseMax(mass_matrix(model, drawn.motion.q.row(k).transpose()).diagonal());
  }
  const Vector J = design_inertia(model, drawn.motion.q);
  EXPECT_LT(largest(J - most), 1e-12 * largest(most));
}

TEST(Tree, OrderIsDepthFirst) {
  Robot robot = DrawnTree(15).robot;
  ASSERT_TRUE(robot.chain.branches());
  EXPECT_FALSE(robot.complaint());
  robot.chain.parents.back() = static_cast<int>(robot.size()) + 3;
  ASSERT_TRUE(robot.complaint());
  EXPECT_NE(robot.complaint()->find("depth first"), std::string::npos);
  robot.chain.parents.pop_back();
  EXPECT_NE(robot.complaint()->find("one a link"), std::string::npos);
}

TEST(Tree, WhatKnowsChainsAloneSaysSo) {
  const Robot robot = DrawnTree(15).robot;
  EXPECT_TRUE(test::says(test::complaint_of([&] { return kdl_chain(robot); }), "the robot branches"));
}

}  // namespace
}  // namespace rivid
