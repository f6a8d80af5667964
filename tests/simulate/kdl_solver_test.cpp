#include "rivid/simulate/kdl_solver.hpp"

#include <gtest/gtest.h>

#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "rivid/model/kdl.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/random_chain.hpp"

namespace rivid {
namespace {

// Another algorithm, the same quantity.
constexpr double tolerance = 1e-12;

KDL::JntArray joint_array(const Vector& x) {
  KDL::JntArray out(static_cast<unsigned>(x.size()));
  for (Index j = 0; j < x.size(); ++j) {
    out(static_cast<unsigned>(j)) = x[j];
  }
  return out;
}

TEST(IdentifiedIdSolver, IsKdlsOwnWithFrictionOnTop) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomChain draw(seed);
    const KDL::Chain chain = draw.chain();
    Robot robot = robot_from(chain, {1.0, -2.0, -9.0});
    for (Joint& joint : robot.joints) {
      joint.friction = Friction::coulomb;
      joint.Fv = 0.7;
      joint.Fc = 1.3;
    }
    const DynamicModel model(robot, robot.chi_st());
    IdentifiedIdSolver ours(chain, model);
    KDL::ChainIdSolver_RNE theirs(chain, KDL::Vector(1.0, -2.0, -9.0));
    const Index n = robot.size();
    const Vector q = draw.positions(n);
    const Vector qd = draw.positions(n);
    const Vector qdd = draw.positions(n);
    KDL::Wrenches f_ext;
    for (unsigned i = 0; i < chain.getNrOfSegments(); ++i) {
      f_ext.emplace_back(draw.vector(20.0), draw.vector(5.0));
    }
    KDL::JntArray found(static_cast<unsigned>(n));
    KDL::JntArray expected(static_cast<unsigned>(n));
    KDL::ChainIdSolver& interface = ours;
    ASSERT_EQ(interface.CartToJnt(joint_array(q), joint_array(qd), joint_array(qdd), f_ext, found), 0);
    ASSERT_EQ(theirs.CartToJnt(joint_array(q), joint_array(qd), joint_array(qdd), f_ext, expected), 0);
    double scale = 100.0;
    for (unsigned j = 0; j < static_cast<unsigned>(n); ++j) {
      scale = std::max(scale, std::abs(expected(j)));
    }
    for (Index j = 0; j < n; ++j) {
      const double friction = 0.7 * qd[j] + 1.3 * sign(qd[j]);
      EXPECT_NEAR(found(static_cast<unsigned>(j)), expected(static_cast<unsigned>(j)) + friction,
                  tolerance * scale);
    }
  }
}

TEST(IdentifiedIdSolver, RefusesWhatDoesNotFit) {
  test::RandomChain draw(1);
  const KDL::Chain chain = draw.chain();
  const Robot robot = robot_from(chain);
  const DynamicModel model(robot, robot.chi_st());
  IdentifiedIdSolver solver(chain, model);
  KDL::JntArray wrong(static_cast<unsigned>(robot.size()) + 1);
  EXPECT_EQ(solver.CartToJnt(wrong, wrong, wrong, KDL::Wrenches(chain.getNrOfSegments()), wrong),
            KDL::SolverI::E_SIZE_MISMATCH);
  EXPECT_TRUE(test::says(test::complaint_of([&] { IdentifiedIdSolver(KDL::Chain(), model); }),
                         "IdentifiedIdSolver: the chain has 0 moving joints, the model"));
}

}  // namespace
}  // namespace rivid
