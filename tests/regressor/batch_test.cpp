#include "rivid/regressor/batch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "rivid/model/mdh.hpp"
#include "support/allocations.hpp"
#include "support/complaint.hpp"
#include "support/regressor_oracle.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Operations in another order, some of them fused, and other sines; every joint adds its own.
double rounding(Index joints) {
  return static_cast<double>(std::max<Index>(4, joints)) * std::numeric_limits<double>::epsilon();
}

std::vector<Simd> sets() {
  std::vector<Simd> out;
  for (const Simd simd : {Simd::baseline, Simd::avx2, Simd::avx512}) {
    if (supported(simd)) {
      out.push_back(simd);
    }
  }
  return out;
}

std::vector<double> row_of(const Matrix& x, Index k) {
  const Vector row = x.row(k);
  return {row.begin(), row.end()};
}

// One sample after the other.
std::vector<Matrix> one_by_one(const Robot& robot, const std::vector<StandardParameter>& parameters,
                               const Motion& motion) {
  const RegressorColumns columns(robot, parameters);
  RegressorWorkspace<double> workspace(columns);
  std::vector<Matrix> out;
  for (Index i = 0; i < robot.size(); ++i) {
    out.emplace_back(motion.samples(),
                     static_cast<Index>(columns.of_joint(static_cast<std::size_t>(i)).size()));
  }
  for (Index k = 0; k < motion.samples(); ++k) {
    const std::vector<double> q = row_of(motion.q, k);
    const std::vector<double> qd = row_of(motion.qd, k);
    const std::vector<double> qdd = row_of(motion.qdd, k);
    columns.rows(State<double>{q, qd, qdd}, workspace,
                 [&](std::size_t i, Index c, double value) { out[i](k, c) = value; });
  }
  return out;
}

// The same by the oracle.
std::vector<Matrix> by_oracle(const Robot& robot, const std::vector<StandardParameter>& parameters,
                              const Motion& motion) {
  const RegressorColumns columns(robot, parameters);
  std::vector<Matrix> out;
  for (std::size_t i = 0; i < columns.joints(); ++i) {
    out.emplace_back(motion.samples(), static_cast<Index>(columns.of_joint(i).size()));
  }
  for (Index k = 0; k < motion.samples(); ++k) {
    const std::vector<double> q = row_of(motion.q, k);
    const std::vector<double> qd = row_of(motion.qd, k);
    const std::vector<double> qdd = row_of(motion.qdd, k);
    const auto rows = test::regressor_oracle(robot, parameters, State<double>{q, qd, qdd});
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t c = 0; c < columns.of_joint(i).size(); ++c) {
        out[i](k, static_cast<Index>(c)) = rows[i][static_cast<std::size_t>(columns.of_joint(i)[c])];
      }
    }
  }
  return out;
}

double largest(const std::vector<Matrix>& W) {
  double out = 0.0;
  for (const Matrix& x : W) {
    out = std::max(out, x.cwiseAbs().maxCoeff());
  }
  return out;
}

void expect_all_sets_agree(const Robot& robot, const std::vector<StandardParameter>& parameters,
                           const Motion& motion) {
  const std::vector<Matrix> expected = by_oracle(robot, parameters, motion);
  const double tolerance = rounding(robot.size()) * largest(expected);
  const std::vector<Matrix> single = one_by_one(robot, parameters, motion);
  for (std::size_t i = 0; i < single.size(); ++i) {
    EXPECT_LE((single[i] - expected[i]).cwiseAbs().maxCoeff(), tolerance) << "one sample, joint " << i + 1;
  }
  for (const Simd simd : sets()) {
    const RegressorBatch batch(robot, parameters, {.simd = simd});
    RegressorBlock block(batch, motion.samples());
    batch.fill(motion, 0, motion.samples(), block);
    for (std::size_t i = 0; i < batch.joints(); ++i) {
      EXPECT_LE((block.W(i) - expected[i]).cwiseAbs().maxCoeff(), tolerance)
          << name(simd) << ", joint " << i + 1;
    }
  }
}

TEST(RegressorBatch, IsTheRegressorOfEachSampleByEveryInstructionSet) {
  for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 30}) {
    const auto seed = static_cast<std::uint64_t>(1000 + n);
    SCOPED_TRACE(std::to_string(n) + " joints, seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    Robot robot = test::random_robot(n, random);
    robot.joints.front().friction = Friction::asymmetric;
    const Motion motion = test::random_motion(21, n, random);
    expect_all_sets_agree(robot, robot.standard_parameters(), motion);
    expect_all_sets_agree(robot, base_parameters(robot).columns(), motion);
  }
}

TEST(RegressorBatch, IsTheRegressorOfEachSampleUnderEveryFrictionLaw) {
  for (const FrictionRow& law : friction_rows) {
    for (const double sign_speed : {0.0, 0.6}) {
      SCOPED_TRACE(std::string(law.name) + ", sign_speed " + std::to_string(sign_speed));
      std::mt19937_64 random(1040);
      Robot robot = test::random_robot(3, random);
      for (Joint& joint : robot.joints) {
        joint.friction = law.law;
        joint.sign_speed = sign_speed;
      }
      Motion motion = test::random_motion(21, 3, random);
      motion.qd.row(5).setZero();
      expect_all_sets_agree(robot, robot.standard_parameters(), motion);
      // Each column is that of its kind.
      const std::vector<StandardParameter> parameters = robot.standard_parameters();
      const std::vector<Matrix> W = one_by_one(robot, parameters, motion);
      const RegressorColumns columns(robot, parameters);
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t c = 0; c < columns.of_joint(j).size(); ++c) {
          const StandardParameter& p = parameters[static_cast<std::size_t>(columns.of_joint(j)[c])];
          for (Index k = 0; k < 21 && is_friction(p.kind); ++k) {
            EXPECT_EQ(W[j](k, static_cast<Index>(c)),
                      friction_entry(p.kind, motion.qd(k, static_cast<Index>(j)), sign_speed))
                << p.name();
          }
        }
      }
    }
  }
}

TEST(RegressorBatch, SmoothsTheSignsOfAJointThatAsksForIt) {
  std::mt19937_64 random(1050);
  Robot robot = test::random_robot(3, random);
  robot.joints[0].friction = Friction::symmetric;
  robot.joints[1].friction = Friction::asymmetric;
  robot.joints[2].friction = Friction::symmetric;
  robot.joints[0].sign_speed = 0.5;
  robot.joints[1].sign_speed = 0.8;
  Motion motion = test::random_motion(21, 3, random);
  motion.qd(4, 0) = motion.qd(4, 1) = motion.qd(4, 2) = 0.0;
  const BaseParameters base = base_parameters(robot);
  expect_all_sets_agree(robot, base.columns(), motion);
  const Matrix W = observation(robot, base, motion).dense();
  const auto column = [&](const char* name, Index joint) {
    for (Index c = 0; c < base.size(); ++c) {
      if (base.parameters[static_cast<std::size_t>(c)].name == name) {
        return Vector(W.col(c).segment(21 * joint, 21));
      }
    }
    return Vector();
  };
  const Vector one = (motion.qd.col(0).array() / 0.5).tanh();
  const Vector two = (motion.qd.col(1).array() / 0.8).tanh();
  EXPECT_LE((column("Fc1", 0) - one).cwiseAbs().maxCoeff(), rounding(3));
  EXPECT_LE((column("Fc+2", 1) - two.cwiseMax(0.0)).cwiseAbs().maxCoeff(), rounding(3));
  EXPECT_LE((column("Fc-2", 1) - two.cwiseMin(0.0)).cwiseAbs().maxCoeff(), rounding(3));
  EXPECT_EQ(column("Fc3", 2), motion.qd.col(2).cwiseSign());
}

// Every turn between neighbours, every pattern of offsets, with and without an angle about the joint's axis.
TEST(RegressorBatch, KnowsEveryGeometryThatItTakesAShortWayFor) {
  constexpr double quarter = std::numbers::pi / 2;
  std::mt19937_64 random(1100);
  for (const double alpha : {0.0, quarter, -quarter, 2.0 * quarter, 0.3}) {
    for (unsigned offsets = 0; offsets < 8; ++offsets) {
      for (const double theta : {0.0, quarter, -0.7}) {
        for (const JointType type : {JointType::revolute, JointType::prismatic}) {
          SCOPED_TRACE("alpha " + std::to_string(alpha) + ", offsets " + std::to_string(offsets) +
                       ", theta " + std::to_string(theta));
          const std::array<MdhRow, 4> table = {
              MdhRow{.alpha = 0.2}, MdhRow{.type = type, .alpha = alpha, .theta = theta},
              MdhRow{.alpha = -alpha, .theta = theta}, MdhRow{.alpha = alpha}};
          Robot robot = robot_from(table);
          for (Chain::Link& link : robot.chain.links) {
            for (int k = 0; k < 3; ++k) {
              link.p[k] = (offsets >> k & 1U) != 0U ? 0.1 + 0.2 * k : 0.0;
            }
          }
          const Motion motion = test::random_motion(8, 4, random);
          expect_all_sets_agree(robot, robot.standard_parameters(), motion);
          expect_all_sets_agree(robot, base_parameters(robot).columns(), motion);
        }
      }
    }
  }
}

TEST(RegressorBatch, DoesNotDependOnWhereABatchEnds) {
  std::mt19937_64 random(1200);
  const Robot robot = test::random_robot(4, random);
  const Motion motion = test::random_motion(40, 4, random);
  const BaseParameters base = base_parameters(robot);
  for (const Simd simd : sets()) {
    const RegressorBatch batch(robot, base.columns(), {.simd = simd});
    RegressorBlock whole(batch, 40);
    batch.fill(motion, 0, 40, whole);
    RegressorBlock part(batch, 17);
    for (Index count = 0; count <= 17; ++count) {
      for (const Index first : {Index{0}, Index{3}, 40 - count}) {
        batch.fill(motion, first, count, part);
        ASSERT_EQ(part.rows(), count);
        for (std::size_t i = 0; i < batch.joints(); ++i) {
          EXPECT_TRUE(part.W(i) == whole.W(i).middleRows(first, count))
              << name(simd) << ", " << count << " samples from " << first;
        }
      }
    }
  }
}

TEST(Observation, IsTheSameBitByBitWhateverTheNumberOfThreads) {
  std::mt19937_64 random(1300);
  const Robot robot = test::random_robot(3, random);
  const BaseParameters base = base_parameters(robot);
  for (const Index count : {0, 1, 63, 64, 65, 1000}) {
    const Motion motion = test::random_motion(count, 3, random);
    const Matrix one = observation(robot, base, motion).dense();
    for (const int threads : {2, 3, 7}) {
      EXPECT_TRUE(observation(robot, base, motion, {.threads = threads}).dense() == one)
          << count << " samples, " << threads << " threads";
    }
  }
}

TEST(RegressorBatch, AllocatesNothingForASample) {
  std::mt19937_64 random(1400);
  const Robot robot = test::random_robot(6, random);
  const BaseParameters base = base_parameters(robot);
  const Motion motion = test::random_motion(21, 6, random);
  const RegressorBatch batch(robot, base.columns());
  RegressorBlock block(batch, 21);
  const RegressorColumns columns(robot, base.columns());
  RegressorWorkspace<double> workspace(columns);
  const std::vector<double> q(6, 0.3);
  double sum = 0.0;

  const long before = test::allocations;
  batch.fill(motion, 0, 21, block);
  columns.rows(State<double>{q, q, q}, workspace, [&](std::size_t, Index, double value) { sum += value; });
  EXPECT_EQ(test::allocations, before);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(RegressorBatch, SaysWhatItCanNotUse) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  const auto message = [](auto&& call) { return test::complaint_of(call); };
  EXPECT_EQ(message([&] { const RegressorBatch batch(robot, base.columns(), {.threads = 0}); }),
            "RegressorBatch: threads is 0, must be at least 1");
  std::vector<StandardParameter> twice = base.columns();
  twice.push_back(twice.front());
  EXPECT_EQ(message([&] { const RegressorBatch batch(robot, twice); }),
            "RegressorColumns: ZZ1 occurs twice, must occur once");
  const RegressorBatch batch(robot, base.columns());
  RegressorBlock block(batch, 4);
  std::mt19937_64 random(1500);
  const Motion motion = test::random_motion(10, 2, random);
  EXPECT_EQ(message([&] { batch.fill(motion, 0, 5, block); }),
            "RegressorBatch::fill: 5 samples of 2 joints do not fit a block for 4 samples of 2 joints");
  EXPECT_EQ(message([&] { batch.fill(motion, 8, 4, block); }),
            "RegressorBatch::fill: samples 8 to 12 are asked for, the motion has 10");
}

}  // namespace
}  // namespace rivid
