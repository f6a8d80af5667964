#include "rivid/regressor/regressor.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <functional>
#include <limits>
#include <memory>
#include <unsupported/Eigen/AutoDiff>

#include "rivid/regressor/base.hpp"
#include "rivid/regressor/pack.hpp"
#include "support/regressor_oracle.hpp"
#include "support/robots.hpp"

namespace symbolic {

// A term of q, q̇ and q̈ that is written down now and reckoned later, as the numbers of computer algebra do.
class Term {
 public:
  using State = rivid::State<double>;
  Term(double value = 0.0) : value_([value](const State&) { return value; }) {}
  explicit Term(std::function<double(const State&)> value) : value_(std::move(value)) {}
  [[nodiscard]] double at(const State& state) const { return value_(state); }

 private:
  std::function<double(const State&)> value_;
};

template <typename Operation>
Term joined(const Operation& operation, const Term& a, const Term& b) {
  return Term([=](const Term::State& s) { return operation(a.at(s), b.at(s)); });
}
Term operator+(const Term& a, const Term& b) { return joined(std::plus<>(), a, b); }
Term operator-(const Term& a, const Term& b) { return joined(std::minus<>(), a, b); }
Term operator*(const Term& a, const Term& b) { return joined(std::multiplies<>(), a, b); }
Term operator/(const Term& a, const Term& b) { return joined(std::divides<>(), a, b); }
Term operator-(const Term& a) { return Term(0.0) - a; }
Term sin(const Term& a) {
  return Term([=](const Term::State& s) { return std::sin(a.at(s)); });
}
Term cos(const Term& a) {
  return Term([=](const Term::State& s) { return std::cos(a.at(s)); });
}
Term exp(const Term& a) {
  return Term([=](const Term::State& s) { return std::exp(a.at(s)); });
}
Term sqrt(const Term& a) {
  return Term([=](const Term::State& s) { return std::sqrt(a.at(s)); });
}
Term tanh(const Term& a) {
  return Term([=](const Term::State& s) { return std::tanh(a.at(s)); });
}

// What no if can ask for: it has no value yet.
struct Condition {
  Term positive;
};
Condition is_positive(const Term& a) { return {a}; }
Term select(const Condition& condition, const Term& a, const Term& b) {
  return Term([=](const Term::State& s) { return condition.positive.at(s) > 0.0 ? a.at(s) : b.at(s); });
}

}  // namespace symbolic

namespace rivid {
namespace {

// All rows of the regressor of one state, (n × b), for any Scalar.
template <typename Scalar>
struct Rows {
  std::vector<std::vector<Scalar>> W;

  Rows(const RegressorColumns& columns, const std::vector<Scalar>& q, const std::vector<Scalar>& qd,
       const std::vector<Scalar>& qdd) {
    RegressorWorkspace<Scalar> workspace(columns);
    for (std::size_t i = 0; i < q.size(); ++i) {
      W.emplace_back(columns.of_joint(i).size());
    }
    columns.rows(State<Scalar>{q, qd, qdd}, workspace, [&](std::size_t i, Index c, const Scalar& value) {
      W[i][static_cast<std::size_t>(c)] = value;
    });
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
    const Rows<Pack> all(columns, packs(motion.q), packs(motion.qd), packs(motion.qdd));
    for (Index k = 0; k < 8; ++k) {
      const Rows<double> one(columns, row_of<double>(motion.q, k), row_of<double>(motion.qd, k),
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

// The oracle turns by products of matrices, the regressor by angles that it adds up beforehand.
TEST(Regressor, IsThatOfTheOracle) {
  on_random_robots([](const Robot& robot, const RegressorColumns& columns, const Motion& motion) {
    for (Index k = 0; k < motion.samples(); ++k) {
      const auto q = row_of<double>(motion.q, k);
      const auto qd = row_of<double>(motion.qd, k);
      const auto qdd = row_of<double>(motion.qdd, k);
      const Rows<double> one(columns, q, qd, qdd);
      const auto expected = test::regressor_oracle<double>(robot, robot.standard_parameters(), {q, qd, qdd});
      const double tolerance = 2.0 * rounding(robot.size()) * largest(one);
      for (std::size_t i = 0; i < one.W.size(); ++i) {
        for (std::size_t c = 0; c < one.W[i].size(); ++c) {
          const auto column = static_cast<std::size_t>(columns.of_joint(i)[c]);
          EXPECT_NEAR(one.W[i][c], expected[i][column], tolerance);
        }
      }
    }
  });
}

// Two joints of each kind under every friction law, sharp and smooth: selections by a number that has none.
TEST(Regressor, OfTermsAndOfComplexNumbersIsThatOfTheirValues) {
  for (const FrictionRow& law : friction_rows) {
    std::mt19937_64 random(910);
    Robot robot = test::random_robot(3, random);
    for (std::size_t j = 0; j < 3; ++j) {
      robot.joints[j].friction = law.law;
      robot.joints[j].sign_speed = j == 0 ? 0.5 : 0.0;
    }
    const RegressorColumns columns(robot, robot.standard_parameters());
    std::vector<symbolic::Term> q, qd, qdd;
    for (std::size_t j = 0; j < 3; ++j) {
      q.emplace_back([j](const State<double>& s) { return s.q[j]; });
      qd.emplace_back([j](const State<double>& s) { return s.qd[j]; });
      qdd.emplace_back([j](const State<double>& s) { return s.qdd[j]; });
    }
    const Rows<symbolic::Term> terms(columns, q, qd, qdd);
    const Motion motion = test::random_motion(2, 3, random);
    for (Index k = 0; k < 2; ++k) {
      const auto at_q = row_of<double>(motion.q, k);
      const auto at_qd = row_of<double>(motion.qd, k);
      const auto at_qdd = row_of<double>(motion.qdd, k);
      using Complex = std::complex<double>;
      const Rows<double> one(columns, at_q, at_qd, at_qdd);
      const Rows<Complex> real(columns, row_of<Complex>(motion.q, k), row_of<Complex>(motion.qd, k),
                               row_of<Complex>(motion.qdd, k));
      const double tolerance = 16.0 * rounding(3) * largest(one);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t c = 0; c < one.W[i].size(); ++c) {
          EXPECT_NEAR(terms.W[i][c].at({at_q, at_qd, at_qdd}), one.W[i][c], tolerance) << law.name;
          EXPECT_NEAR(real.W[i][c].real(), one.W[i][c], tolerance) << law.name;
        }
      }
    }
  }
}

TEST(Regressor, HasTheDerivativesOfAComplexStep) {
  std::mt19937_64 random(920);
  const Robot robot = test::random_robot(5, random);
  const RegressorColumns columns(robot, robot.standard_parameters());
  const Motion motion = test::random_motion(1, 5, random);
  using Complex = std::complex<double>;
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 1, 1>>;
  constexpr double step = 1e-30;  // no difference is taken: nothing cancels
  for (std::size_t d = 0; d < 5; ++d) {
    std::vector<Complex> qd = row_of<Complex>(motion.qd, 0);
    std::vector<Dual> dual = row_of<Dual>(motion.qd, 0);
    qd[d] += Complex(0.0, step);
    dual[d].derivatives()[0] = 1.0;
    const Rows<Complex> moved(columns, row_of<Complex>(motion.q, 0), qd, row_of<Complex>(motion.qdd, 0));
    const Rows<Dual> expected(columns, row_of<Dual>(motion.q, 0), dual, row_of<Dual>(motion.qdd, 0));
    for (std::size_t i = 0; i < 5; ++i) {
      for (std::size_t c = 0; c < moved.W[i].size(); ++c) {
        EXPECT_NEAR(moved.W[i][c].imag() / step, expected.W[i][c].derivatives()[0], 1e-12);
      }
    }
  }
}

TEST(Regressor, InSinglePrecisionIsTheSameToItsRounding) {
  on_random_robots([](const Robot& /*robot*/, const RegressorColumns& columns, const Motion& motion) {
    const Rows<float> single(columns, row_of<float>(motion.q, 0), row_of<float>(motion.qd, 0),
                             row_of<float>(motion.qdd, 0));
    const Rows<double> one(columns, row_of<double>(motion.q, 0), row_of<double>(motion.qd, 0),
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
  const Rows<Dual> dual(columns, seeded(motion.q, 0), seeded(motion.qd, n), seeded(motion.qdd, 2 * n));
  constexpr double step = 1e-5;
  // Truncation step² and rounding ε / step, of entries and third derivatives below 1e3.
  constexpr double tolerance = 1e3 * (step * step + 2.3e-16 / step);
  for (int d = 0; d < inputs; ++d) {
    const auto moved = [&](double by) {
      Motion m = motion;
      Matrix& x = d < n ? m.q : d < 2 * n ? m.qd : m.qdd;
      x(0, d % n) += by;
      return Rows<double>(columns, row_of<double>(m.q, 0), row_of<double>(m.qd, 0), row_of<double>(m.qdd, 0));
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
