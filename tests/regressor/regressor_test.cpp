#include "rivid/regressor/regressor.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <unsupported/Eigen/AutoDiff>

#include "rivid/regressor/base.hpp"
#include "rivid/regressor/columns.hpp"
#include "rivid/regressor/pack.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// All rows of the regressor of one state, (n × b), for any Scalar.
template <typename Scalar>
struct Rows {
  std::vector<std::vector<Scalar>> W;

  Rows(const Robot& robot, const RegressorColumns& columns, const std::vector<Scalar>& q,
       const std::vector<Scalar>& qd, const std::vector<Scalar>& qdd) {
    RegressorWorkspace<Scalar> workspace(robot.chain);
    for (std::size_t i = 0; i < q.size(); ++i) {
      W.emplace_back(columns.of_joint(i).size());
    }
    columns.rows(
        robot.chain, State<Scalar>{q, qd, qdd}, workspace,
        [&](std::size_t i, Index c, const Scalar& value) { W[i][static_cast<std::size_t>(c)] = value; });
  }
};

template <typename Scalar>
std::vector<Scalar> row_of(const Matrix& x, Index k) {
  std::vector<Scalar> out;
  for (Index j = 0; j < x.cols(); ++j) {
    out.emplace_back(static_cast<Scalar>(x(k, j)));
  }
  return out;
}

double largest(const Rows<double>& rows) {
  double out = 0.0;
  for (const auto& row : rows.W) {
    for (const double x : row) {
      out = std::max(out, std::abs(x));
    }
  }
  return out;
}

template <typename Check>
void on_random_robots(Check&& check) {
  for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 30}) {
    const auto seed = static_cast<std::uint64_t>(800 + n);
    SCOPED_TRACE(std::to_string(n) + " joints, seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    Robot robot = test::random_robot(n, random);
    robot.joints.front().friction = Friction::asymmetric;
    const RegressorColumns columns(robot, robot.standard_parameters());
    check(robot, columns, test::random_motion(8, n, random));
  }
}

// The sines of a pack and of the standard library differ in the last place, and every joint adds its own.
double rounding(Index joints) {
  return static_cast<double>(std::max<Index>(4, joints)) * std::numeric_limits<double>::epsilon();
}

TEST(Regressor, OfAPackIsInEachLaneThatOfOneSample) {
  on_random_robots([](const Robot& robot, const RegressorColumns& columns, const Motion& motion) {
    const auto packs = [](const Matrix& x) {
      std::vector<Pack> out;
      for (Index j = 0; j < x.cols(); ++j) {
        out.push_back(Pack::load(x.col(j).data()));
      }
      return out;
    };
    const Rows<Pack> all(robot, columns, packs(motion.q), packs(motion.qd), packs(motion.qdd));
    for (Index k = 0; k < 8; ++k) {
      const Rows<double> one(robot, columns, row_of<double>(motion.q, k), row_of<double>(motion.qd, k),
                             row_of<double>(motion.qdd, k));
      const double tolerance = rounding(robot.size()) * largest(one);
      for (std::size_t i = 0; i < one.W.size(); ++i) {
        for (std::size_t c = 0; c < one.W[i].size(); ++c) {
          EXPECT_NEAR(all.W[i][c][static_cast<int>(k)], one.W[i][c], tolerance);
        }
      }
    }
  });
}

TEST(Regressor, InSinglePrecisionIsTheSameToItsRounding) {
  on_random_robots([](const Robot& robot, const RegressorColumns& columns, const Motion& motion) {
    const Rows<float> single(robot, columns, row_of<float>(motion.q, 0), row_of<float>(motion.qd, 0),
                             row_of<float>(motion.qdd, 0));
    const Rows<double> one(robot, columns, row_of<double>(motion.q, 0), row_of<double>(motion.qd, 0),
                           row_of<double>(motion.qdd, 0));
    // The state itself is rounded, and its error grows with every joint.
    const double tolerance = 64.0 * static_cast<double>(std::numeric_limits<float>::epsilon()) * largest(one);
    for (std::size_t i = 0; i < one.W.size(); ++i) {
      for (std::size_t c = 0; c < one.W[i].size(); ++c) {
        EXPECT_NEAR(static_cast<double>(single.W[i][c]), one.W[i][c], tolerance);
      }
    }
  });
}

TEST(Regressor, HasTheDerivativesOfCentralDifferences) {
  constexpr int n = 5;
  constexpr int inputs = 3 * n;
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, inputs, 1>>;
  std::mt19937_64 random(900);
  Robot robot = test::random_robot(n, random);
  robot.chain.links[1].type = JointType::prismatic;
  robot.joints[1].type = JointType::prismatic;
  robot.joints.back().friction = Friction::asymmetric;
  const RegressorColumns columns(robot, robot.standard_parameters());
  const Motion motion = test::random_motion(1, n, random);

  const auto seeded = [&](const Matrix& x, int first) {
    std::vector<Dual> out;
    for (int j = 0; j < n; ++j) {
      out.emplace_back(x(0, j), inputs, first + j);
    }
    return out;
  };
  const Rows<Dual> dual(robot, columns, seeded(motion.q, 0), seeded(motion.qd, n), seeded(motion.qdd, 2 * n));
  constexpr double step = 1e-5;
  // Truncation step² and rounding ε / step, of entries and third derivatives below 1e3.
  constexpr double tolerance = 1e3 * (step * step + 2.3e-16 / step);
  for (int d = 0; d < inputs; ++d) {
    const auto moved = [&](double by) {
      Motion m = motion;
      Matrix& x = d < n ? m.q : d < 2 * n ? m.qd : m.qdd;
      x(0, d % n) += by;
      return Rows<double>(robot, columns, row_of<double>(m.q, 0), row_of<double>(m.qd, 0),
                          row_of<double>(m.qdd, 0));
    };
    const Rows<double> forward = moved(step);
    const Rows<double> back = moved(-step);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t c = 0; c < dual.W[i].size(); ++c) {
        const auto& derivatives = dual.W[i][c].derivatives();
        EXPECT_NEAR(derivatives[d], (forward.W[i][c] - back.W[i][c]) / (2.0 * step), tolerance)
            << "input " << d << ", row " << i << ", column " << c;
      }
    }
  }
}

}  // namespace
}  // namespace rivid
