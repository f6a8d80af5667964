// Physically consistent parameters against a conic solver, physical_oracle.py.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "rivid/identify/physical.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/regressor/batch.hpp"
#include "support/robots.hpp"
#include "support/tx40.hpp"

namespace rivid {
namespace {

using Json = nlohmann::json;

// Our tolerance is 1e-6 of one and the cost, the conic solver's 1e-9.
constexpr double same_cost = 1e-5;

Matrix matrix(const Json& rows) {
  Matrix out(std::ssize(rows), std::ssize(rows.front()));
  for (Index i = 0; i < out.rows(); ++i) {
    for (Index j = 0; j < out.cols(); ++j) {
      out(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    }
  }
  return out;
}

// One robot of the file with its estimate.
struct Estimate {
  Robot robot;
  BaseParameters base;
  Matrix root;
  Vector chi;

  explicit Estimate(const Json& data)
      : robot(data["robot"] == "scara" ? test::scara() : test::tx40(Friction::coulomb)) {
    const Matrix inertials = matrix(data["inertials"]);
    for (Index j = 0; j < robot.size(); ++j) {
      robot.inertials[static_cast<std::size_t>(j)] = inertials.row(j);
    }
    base = base_parameters(robot);
    Motion motion;
    motion.q = matrix(data["q"]);
    motion.qd = matrix(data["qd"]);
    motion.qdd = matrix(data["qdd"]);
    const double sigma = data["sigma"];
    const Matrix W = observation(robot, base, motion).dense() / sigma;
    const Vector Y = matrix(data["tau"]).reshaped() / sigma;
    const Eigen::HouseholderQR<Matrix> qr(W);
    chi = qr.solve(Y);
    root = qr.matrixQR().topRows(base.size()).triangularView<Eigen::Upper>();
  }
};

Physical options_of(const Json& test_case, const Robot& robot) {
  Physical out;
  out.prior = test_case["prior"] == "ridge" ? Physical::Prior::ridge : Physical::Prior::log_det;
  out.weight = test_case["weight"];
  if (test_case.contains("masses")) {
    for (const auto& [joint, bounds] : test_case["masses"].items()) {
      out.masses.push_back({robot.joints[std::stoul(joint)].link, bounds[0], bounds[1]});
    }
  }
  if (test_case.contains("total_mass")) {
    out.total_mass = {test_case["total_mass"][0], test_case["total_mass"][1]};
  }
  return out;
}

void expect_physical(const Robot& robot, const BaseParameters& base, const Physical& options,
                     const Vector& chi_st) {
  double total = 0.0;
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const ParameterKind kind = base.standard[i].kind;
    if (kind == ParameterKind::XX) {
      const Inertial inertial = chi_st.segment<inertial_count>(at);
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(pseudo_inertia(inertial));
      EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0) << base.standard[i].name();
      total += inertial[9];
    } else if (kind > ParameterKind::M) {
      EXPECT_GT(chi_st[at], 0.0) << base.standard[i].name();
    } else if (kind == ParameterKind::M) {
      const std::string& link = robot.joints[static_cast<std::size_t>(base.standard[i].joint)].link;
      for (const Physical::MassBounds& bounds : options.masses) {
        if (bounds.link == link) {
          EXPECT_GT(chi_st[at], bounds.least);
          EXPECT_LT(chi_st[at], bounds.most);
        }
      }
    }
  }
  if (options.total_mass) {
    EXPECT_GT(total, (*options.total_mass)[0]);
    EXPECT_LT(total, (*options.total_mass)[1]);
  }
}

// The description, and three vectors that are no robot at all.
std::vector<Vector> starts(const Robot& robot) {
  std::mt19937_64 random(20);
  std::normal_distribution<double> normal;
  std::vector<Vector> out = {Vector()};
  for (const double size : {0.01, 1.0, 100.0}) {
    out.emplace_back(Vector::NullaryExpr(robot.chi_st().size(), [&] { return size * normal(random); }));
  }
  return out;
}

class PhysicalOracle : public testing::Test {
 protected:
  PhysicalOracle() : data_(Json::parse(std::ifstream(RIVID_TEST_DATA "/identify/physical_oracle.json"))) {}
  Json data_;
};

TEST_F(PhysicalOracle, ReachesTheCostOfAConicSolverFromAnyStart) {
  ASSERT_EQ(data_.size(), 2U);
  for (const Json& data : data_) {
    const Estimate estimate(data);
    for (const Json& test_case : data["cases"]) {
      Physical options = options_of(test_case, estimate.robot);
      const double cost = test_case["cost"];
      for (const Vector& start : starts(estimate.robot)) {
        options.start = start;
        const PhysicalParameters found =
            physical(estimate.robot, estimate.base, estimate.chi, estimate.root, options);
        SCOPED_TRACE(data["robot"].get<std::string>() + " " + std::string(name(options.prior)) + " " +
                     std::to_string(options.weight) + " after " + std::to_string(found.steps) + " steps");
        EXPECT_TRUE(found.reached);
        EXPECT_NEAR(found.cost, cost, same_cost * cost);
        EXPECT_LT(found.gap, same_cost * cost);
        expect_physical(estimate.robot, estimate.base, options, found.chi_st);
      }
    }
  }
}

TEST_F(PhysicalOracle, IsPhysicalAfterEveryStep) {
  for (const Json& data : data_) {
    const Estimate estimate(data);
    for (const Json& test_case : data["cases"]) {
      Physical options = options_of(test_case, estimate.robot);
      for (const Vector& start : starts(estimate.robot)) {
        options.start = start;
        for (options.max_steps = 1; options.max_steps < 20; options.max_steps += 3) {
          const PhysicalParameters found =
              physical(estimate.robot, estimate.base, estimate.chi, estimate.root, options);
          EXPECT_LE(found.steps, options.max_steps);
          expect_physical(estimate.robot, estimate.base, options, found.chi_st);
        }
      }
    }
  }
}

}  // namespace
}  // namespace rivid
