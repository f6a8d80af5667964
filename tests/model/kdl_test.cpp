#include "rivid/model/kdl.hpp"

#include <gtest/gtest.h>

#include <kdl/chaindynparam.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <limits>

#include "support/chain_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/random_chain.hpp"

namespace rivid {
namespace {

constexpr double same_quantity = 1e-12;  // another algorithm for the same quantity, times its scale
constexpr std::uint64_t seeds = 200;

KDL::JntArray joint_array(const Vector& q) {
  KDL::JntArray out(static_cast<unsigned int>(q.size()));
  for (Index i = 0; i < q.size(); ++i) {
    out(static_cast<unsigned int>(i)) = q[i];
  }
  return out;
}

Vector vector(const KDL::JntArray& q) {
  Vector out(q.rows());
  for (unsigned int i = 0; i < q.rows(); ++i) {
    out[i] = q(i);
  }
  return out;
}

Eigen::Isometry3d isometry(const KDL::Frame& frame) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    out(row, 3) = frame.p(row);
    for (int column = 0; column < 3; ++column) {
      out(row, column) = frame.M(row, column);
    }
  }
  return out;
}

// Poses of the tips of the moving segments.
std::vector<Eigen::Isometry3d> tips(const KDL::Chain& chain, const Vector& q) {
  KDL::ChainFkSolverPos_recursive solver(chain);
  std::vector<Eigen::Isometry3d> out;
  for (unsigned int s = 0; s < chain.getNrOfSegments(); ++s) {
    if (chain.getSegment(s).getJoint().getType() != KDL::Joint::Fixed) {
      KDL::Frame frame;
      EXPECT_GE(solver.JntToCart(joint_array(q), frame, static_cast<int>(s) + 1), 0);
      out.push_back(isometry(frame));
    }
  }
  return out;
}

bool is_told_in_the_tip_frame(const Robot& robot, std::size_t j) {
  for (const Finding& warning : robot.warnings) {
    if (warning.text.find("joint \"" + robot.joints[j].name + "\"") != std::string::npos) {
      return false;
    }
  }
  return true;
}

std::string refusal(const KDL::Chain& chain, const Eigen::Vector3d& gravity = {0.0, 0.0, -9.81}) {
  return test::complaint_of([&] { return robot_from(chain, gravity); });
}

KDL::Chain one_segment(const KDL::Joint& joint, const KDL::Frame& tip = KDL::Frame::Identity()) {
  KDL::Chain chain;
  chain.addSegment(KDL::Segment("arm", joint, tip));
  return chain;
}

TEST(RobotFromKdl, MovesEveryLinkAsKdlDoes) {
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomChain random(seed);
    const KDL::Chain chain = random.chain();
    const Robot robot = robot_from(chain);
    ASSERT_EQ(robot.size(), static_cast<Index>(chain.getNrOfJoints()));
    const Vector zero = Vector::Zero(robot.size());
    const auto tips_at_zero = tips(chain, zero);
    const auto frames_at_zero = test::forward_kinematics(robot.chain, zero);
    for (int sample = 0; sample < 5; ++sample) {
      const Vector q = random.positions(robot.size());
      const auto frames = test::forward_kinematics(robot.chain, q);
      const auto wanted = tips(chain, q);
      for (std::size_t j = 0; j < frames.size(); ++j) {
        // KDL's tip is fixed to our frame j; where nothing is warned of it is the link frame itself.
        Eigen::Matrix4d tip_in_frame = (frames_at_zero[j].inverse() * tips_at_zero[j]).matrix();
        if (is_told_in_the_tip_frame(robot, j)) {
          tip_in_frame.setIdentity();
          tip_in_frame.topLeftCorner<3, 3>() = link_axes(robot.chain.links[j]).transpose();
        }
        const double scale = 1.0 + wanted[j].translation().norm();
        EXPECT_LE((frames[j].matrix() * tip_in_frame - wanted[j].matrix()).norm(), same_quantity * scale)
            << "joint " << j;
      }
    }
  }
}

TEST(RobotFromKdl, GivesTheMassMatrixAndGravityTorqueOfKdl) {
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomChain random(seed);
    const KDL::Chain chain = random.chain();
    const Eigen::Vector3d gravity(1.0, -2.0, -9.0);
    const Robot robot = robot_from(chain, gravity);
    KDL::ChainDynParam kdl(chain, KDL::Vector(gravity.x(), gravity.y(), gravity.z()));
    for (int sample = 0; sample < 3; ++sample) {
      const Vector q = random.positions(robot.size());
      KDL::JntSpaceInertiaMatrix mass(static_cast<int>(chain.getNrOfJoints()));
      KDL::JntArray torque(chain.getNrOfJoints());
      ASSERT_GE(kdl.JntToMass(joint_array(q), mass), 0);
      ASSERT_GE(kdl.JntToGravity(joint_array(q), torque), 0);
      const test::EnergyTerms ours = test::energy_terms(robot, q);
      double scale = 1.0;
      double difference = 0.0;
      for (unsigned int a = 0; a < mass.rows(); ++a) {
        for (unsigned int b = 0; b < mass.columns(); ++b) {
          scale = std::max(scale, std::abs(mass(a, b)));
          difference = std::max(difference, std::abs(ours.M(a, b) - mass(a, b)));
        }
      }
      EXPECT_LE(difference, same_quantity * scale);
      const Vector wanted = vector(torque);
      EXPECT_LE((ours.gravity_torque - wanted).norm(), same_quantity * (scale + wanted.norm()));
    }
  }
}

TEST(KdlChain, IsTheRobotAgainWhenReadBack) {
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomChain random(seed);
    const Robot robot = robot_from(random.chain());
    const Robot again = robot_from(kdl_chain(robot));
    ASSERT_EQ(again.size(), robot.size());
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      EXPECT_EQ(again.joints[j].name, robot.joints[j].name);
      EXPECT_EQ(again.joints[j].link, robot.joints[j].link);
      EXPECT_EQ(again.joints[j].type, robot.joints[j].type);
      EXPECT_EQ(again.joints[j].Ia, robot.joints[j].Ia);
      EXPECT_EQ(again.chain.links[j].axes, robot.chain.links[j].axes);
      EXPECT_EQ(again.chain.links[j].signs, robot.chain.links[j].signs);
      EXPECT_LE((again.chain.links[j].R - robot.chain.links[j].R).norm(), same_quantity);
      EXPECT_LE((again.chain.links[j].p - robot.chain.links[j].p).norm(), same_quantity);
      EXPECT_LE((again.inertials[j] - robot.inertials[j]).norm(), same_quantity * robot.inertials[j].norm());
    }
  }
}

TEST(KdlChain, TakesValuesThatNoBodyHas) {
  test::RandomChain random(7);
  Robot robot = robot_from(random.chain());
  const Vector chi_st = random.positions(static_cast<Index>(robot.standard_parameters().size()));
  for (const double mass : {-1.0, 0.0, 1e-30, 1e-3, 1.0, 1e6}) {
    SCOPED_TRACE("mass " + std::to_string(mass));
    Vector chi = chi_st;
    chi[9] = mass;
    const Robot again = robot_from(kdl_chain(robot, chi));
    EXPECT_LE((again.inertials[0] - chi.head<10>()).norm(), same_quantity * chi.head<10>().norm());
  }
}

TEST(KdlChain, CarriesTheParametersIntoNewtonEuler) {
  // At rest with unit accelerations, recursive Newton-Euler shows the columns of M and the gravity torque.
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomChain random(seed);
    const Robot robot = robot_from(random.chain());
    const KDL::Chain chain = kdl_chain(robot);
    const auto n = chain.getNrOfJoints();
    KDL::ChainIdSolver_RNE solver(
        chain, KDL::Vector(robot.chain.gravity.x(), robot.chain.gravity.y(), robot.chain.gravity.z()));
    const Vector q = random.positions(robot.size());
    const test::EnergyTerms ours = test::energy_terms(robot, q);
    const KDL::Wrenches no_forces(chain.getNrOfSegments(), KDL::Wrench::Zero());
    for (Index i = 0; i < robot.size(); ++i) {
      KDL::JntArray torque(n);
      ASSERT_GE(solver.CartToJnt(joint_array(q), joint_array(Vector::Zero(robot.size())),
                                 joint_array(Vector::Unit(robot.size(), i)), no_forces, torque),
                0);
      const Vector wanted = vector(torque);
      const double scale = 1.0 + wanted.norm() + ours.M.norm();
      EXPECT_LE((ours.M.col(i) + ours.gravity_torque - wanted).norm(), same_quantity * scale);
    }
  }
}

TEST(KdlChain, RefusesAWrongNumberOfValues) {
  const Robot robot = robot_from(one_segment(KDL::Joint("elbow", KDL::Joint::RotZ)));
  EXPECT_EQ(test::complaint_of([&] { return kdl_chain(robot, Vector::Zero(13)); }),
            "kdl_chain: chi_st has 13 values, the robot has 14 standard parameters");
}

TEST(RobotFromKdl, RenamesCoordinateAxesInsteadOfTurningTheLinkFrame) {
  const std::array<KDL::Vector, 6> axes = {KDL::Vector(1, 0, 0),  KDL::Vector(0, 1, 0),
                                           KDL::Vector(0, 0, 1),  KDL::Vector(-1, 0, 0),
                                           KDL::Vector(0, -1, 0), KDL::Vector(0, 0, -1)};
  const KDL::RigidBodyInertia body(2.0, KDL::Vector(0.1, 0.2, 0.3),
                                   KDL::RotationalInertia(0.4, 0.5, 0.6, 0.01, 0.02, 0.03));
  const Inertial told = inertial_from_com(
      2.0, {0.1, 0.2, 0.3}, Eigen::Matrix3d{{0.4, 0.01, 0.02}, {0.01, 0.5, 0.03}, {0.02, 0.03, 0.6}});
  for (const KDL::Vector& axis : axes) {
    KDL::Chain chain;
    chain.addSegment(KDL::Segment("arm", KDL::Joint("elbow", KDL::Vector::Zero(), axis, KDL::Joint::RotAxis),
                                  KDL::Frame::Identity(), body));
    const Robot robot = robot_from(chain);
    EXPECT_TRUE(robot.warnings.empty());
    EXPECT_TRUE(robot.inertials[0].isApprox(told, same_quantity));
    const Eigen::Matrix3d C = link_axes(robot.chain.links[0]);
    EXPECT_DOUBLE_EQ(C.determinant(), 1.0);
    EXPECT_EQ(C.col(2), Eigen::Vector3d(axis.x(), axis.y(), axis.z()));
    EXPECT_EQ(robot.chain.links[0].R, C);
    EXPECT_TRUE(test::in_frame(robot.chain.links[0], told)
                    .isApprox(transformed(told, C.transpose(), Eigen::Vector3d::Zero()), same_quantity));
  }
}

TEST(RobotFromKdl, WarnsOfAnObliqueAxis) {
  const Robot robot = robot_from(
      one_segment(KDL::Joint("elbow", KDL::Vector::Zero(), KDL::Vector(3, 0, 4), KDL::Joint::RotAxis)));
  ASSERT_EQ(robot.warnings.size(), 1U);
  EXPECT_EQ(
      robot.warnings[0].text,
      "joint \"elbow\": its axis (0.6, 0, 0.8) is oblique in the link frame; the parameters of its link are "
      "given in a frame with the same origin that is turned to have z along the axis");
}

TEST(RobotFromKdl, TellsTheParametersOfADenavitHartenbergSegmentAtTheJoint) {
  const KDL::Frame tip = KDL::Frame::DH(0.4, 0.3, 0.1, 0.0);
  const KDL::RigidBodyInertia at_joint(2.0, KDL::Vector(0.1, 0.2, 0.3),
                                       KDL::RotationalInertia(0.4, 0.5, 0.6));
  KDL::Chain chain;
  chain.addSegment(KDL::Segment("arm", KDL::Joint("elbow", KDL::Joint::RotZ), tip, tip.Inverse() * at_joint));
  const Robot robot = robot_from(chain);
  const Inertial told = inertial_from_com(2.0, {0.1, 0.2, 0.3}, Eigen::Vector3d(0.4, 0.5, 0.6).asDiagonal());
  EXPECT_TRUE(robot.inertials[0].isApprox(told, same_quantity));
  ASSERT_EQ(robot.warnings.size(), 1U);
  EXPECT_EQ(
      robot.warnings[0].text,
      "joint \"elbow\": the tip of its segment is off the joint's axis; the parameters of its link are given "
      "in a frame at the joint's origin with the axes of the segment's root");
}

TEST(RobotFromKdl, LumpsFixedSegmentsIntoTheLinkBeforeThem) {
  test::RandomChain random(11);
  const KDL::Segment first = random.segment("1", false);
  const KDL::Frame flange(random.rotation(), random.vector(0.4));
  const KDL::RigidBodyInertia tool = random.body();
  const KDL::Segment second = random.segment("2", false);

  KDL::Chain split;
  split.addSegment(
      KDL::Segment("stand", KDL::Joint("bolts"), KDL::Frame(KDL::Vector(0, 0, 1)), random.body()));
  split.addSegment(first);
  split.addSegment(KDL::Segment("tool", KDL::Joint("flange"), flange, tool));
  split.addSegment(second);
  const Robot robot = robot_from(split);

  ASSERT_EQ(robot.size(), 2);
  KDL::Segment merged = first;
  merged.setInertia(first.getInertia() + flange * tool);
  KDL::Chain alone;
  alone.addSegment(merged);
  const Robot wanted = robot_from(alone);
  EXPECT_TRUE(robot.inertials[0].isApprox(wanted.inertials[0], same_quantity));
  EXPECT_TRUE(
      robot.chain.links[0].p.isApprox(wanted.chain.links[0].p + Eigen::Vector3d::UnitZ(), same_quantity));
}

TEST(RobotFromKdl, NamesWhatKdlLeavesWithoutAName) {
  KDL::Chain chain;
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ)));
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::TransX)));
  const Robot robot = robot_from(chain);
  EXPECT_EQ(robot.joints[0].name, "joint_1");
  EXPECT_EQ(robot.joints[0].link, "link_1");
  EXPECT_EQ(robot.joints[1].name, "joint_2");
  EXPECT_EQ(robot.joints[1].type, JointType::prismatic);
}

TEST(RobotFromKdl, TakesInertiaAndDampingOfTheJointAndWarnsOfItsStiffness) {
  const Robot robot = robot_from(one_segment(KDL::Joint("elbow", KDL::Joint::RotZ, 1.0, 0.0, 0.3, 0.2, 0.1)));
  EXPECT_EQ(robot.joints[0].Ia, 0.3);
  EXPECT_EQ(robot.joints[0].Fv, 0.2);
  ASSERT_EQ(robot.warnings.size(), 1U);
  EXPECT_EQ(robot.warnings[0].text, "joint \"elbow\": its stiffness is ignored: joints are rigid here");
}

TEST(RobotFromKdl, NeedsNoCareForTheOffsetOfAJoint) {
  for (const auto type : {KDL::Joint::RotY, KDL::Joint::TransY}) {
    const KDL::Chain chain =
        one_segment(KDL::Joint("elbow", type, 1.0, 0.5), KDL::Frame(KDL::Rotation::RotX(0.3)));
    const Robot robot = robot_from(chain);
    const Vector q = Vector::Constant(1, 0.7);
    const Eigen::Isometry3d tip = tips(chain, q)[0];
    const Eigen::Isometry3d tip_at_zero = tips(chain, Vector::Zero(1))[0];
    const Eigen::Isometry3d moved = test::forward_kinematics(robot.chain, q)[0];
    const Eigen::Isometry3d rest = test::forward_kinematics(robot.chain, Vector::Zero(1))[0];
    EXPECT_LE(((moved * rest.inverse() * tip_at_zero).matrix() - tip.matrix()).norm(), same_quantity);
  }
}

TEST(RobotFromKdl, RefusesAChainWithoutAMovingJoint) {
  EXPECT_EQ(refusal(KDL::Chain()), "robot_from: the robot has no moving joint");
  EXPECT_EQ(refusal(one_segment(KDL::Joint("weld"))), "robot_from: the robot has no moving joint");
}

TEST(RobotFromKdl, RefusesAnAxisOfZeros) {
  EXPECT_EQ(
      refusal(
          one_segment(KDL::Joint("elbow", KDL::Vector::Zero(), KDL::Vector::Zero(), KDL::Joint::RotAxis))),
      "robot_from: joint \"elbow\": its axis is (nan, nan, nan) at (0, 0, 0), must be finite and of unit "
      "length (KDL turns an axis of zeros into nan)");
}

TEST(RobotFromKdl, RefusesAScaleOtherThanOne) {
  EXPECT_EQ(
      refusal(one_segment(KDL::Joint("elbow", KDL::Joint::RotZ, -2.0))),
      "robot_from: joint \"elbow\": its scale is -2.000000, must be 1; give a gear as gear_ratio and turn a "
      "negative axis round");
}

TEST(RobotFromKdl, RefusesWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(one_segment(KDL::Joint("elbow", KDL::Joint::RotZ), KDL::Frame(KDL::Vector(nan, 0, 0)))),
            "robot_from: segment \"arm\": the frame of its tip is not a finite rotation and translation");
  EXPECT_EQ(refusal(one_segment(KDL::Joint("elbow", KDL::Joint::RotZ, 1.0, 0.0, nan))),
            "robot_from: joint \"elbow\": its inertia or damping is not finite");
  KDL::Chain heavy;
  heavy.addSegment(KDL::Segment("arm", KDL::Joint("elbow", KDL::Joint::RotZ), KDL::Frame::Identity(),
                                KDL::RigidBodyInertia(nan)));
  EXPECT_EQ(refusal(heavy), "robot_from: segment \"arm\": its inertia is not finite");
  EXPECT_EQ(refusal(one_segment(KDL::Joint("elbow", KDL::Joint::RotZ)), {nan, 0.0, 0.0}),
            "robot_from: gravity must be finite");
}

}  // namespace
}  // namespace rivid
