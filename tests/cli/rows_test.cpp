// rivid identify --write-rows: the rows of a fit, as they are read back.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <sstream>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The columns of a table that rivid_identify wrote.
struct RowColumns {
  RowMajor cells;
  std::vector<std::string> names;

  explicit RowColumns(const std::string& csv) {
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    std::istringstream header(line);
    for (std::string name; std::getline(header, name, ',');) {
      names.push_back(name);
    }
    std::vector<double> values;
    while (std::getline(lines, line)) {
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) {
        values.push_back(std::stod(cell));
      }
    }
    const auto width = static_cast<Eigen::Index>(names.size());
    cells = Eigen::Map<const RowMajor>(values.data(), std::ssize(values) / width, width);
  }

  [[nodiscard]] Eigen::VectorXd column(std::string_view name) const {
    return cells.col(std::ranges::find(names, name) - names.begin());
  }
  // Those that begin with "W:" or "V:".
  [[nodiscard]] Eigen::MatrixXd matrix(std::string_view begin) const {
    std::vector<Eigen::Index> at;
    for (std::size_t c = 0; c < names.size(); ++c) {
      if (names[c].starts_with(begin)) {
        at.push_back(static_cast<Eigen::Index>(c));
      }
    }
    return cells(Eigen::all, at);
  }
};

class WriteRows : public rivid::test::IdentifyTool {
 protected:
  // Values of a result, a part of whose deviation another estimate may be off by.
  static void expect_estimate(const Eigen::VectorXd& chi, const Json& result, double part) {
    ASSERT_EQ(chi.size(), std::ssize(result["parameters"]));
    for (Eigen::Index k = 0; k < chi.size(); ++k) {
      const Json& parameter = result["parameters"][static_cast<std::size_t>(k)];
      const double sigma = parameter["sigma"];
      EXPECT_NEAR(chi[k], parameter["value"].get<double>(), part * sigma) << parameter["name"];
    }
  }
};

TEST_F(WriteRows, TheEstimateFollowsFromThem) {
  const Json result = result_of({"scara.toml", "--write-rows", "rows.csv"});
  const RowColumns rows(folder().read("rows.csv"));
  const auto b = std::ssize(result["parameters"]);
  ASSERT_EQ(rows.cells.rows(), result["fit"]["rows"]);
  ASSERT_EQ(std::ssize(rows.names), 9 + b);
  const Eigen::VectorXd weight = rows.column("weight");
  const Eigen::MatrixXd W = weight.asDiagonal() * rows.matrix("W:");
  const Eigen::VectorXd Y = rows.column("Y");
  // Another factorisation of rows whose condition is some hundred.
  expect_estimate(W.colPivHouseholderQr().solve(weight.cwiseProduct(Y)), result, 1e-9);
  EXPECT_EQ((Y - rows.column("prediction") - rows.column("residual")).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(rows.column("robust_weight").minCoeff(), 1.0);
  // The trace of the hat matrix is its rank.
  EXPECT_NEAR(rows.column("leverage").sum(), static_cast<double>(b), 1e-9);
  EXPECT_GT(rows.column("leverage").minCoeff(), 0.0);
}

TEST_F(WriteRows, TheRobustEstimateFollowsFromThemAndItsWeights) {
  const Json result = result_of({"scara.toml", "--robust", "bisquare", "--write-rows", "rows.csv"});
  const RowColumns rows(folder().read("rows.csv"));
  const Eigen::VectorXd robust = rows.column("robust_weight");
  EXPECT_LT(robust.minCoeff(), 0.5);
  const Eigen::VectorXd weight = rows.column("weight").cwiseProduct(robust.cwiseSqrt());
  const Eigen::MatrixXd W = weight.asDiagonal() * rows.matrix("W:");
  // Weights and parameters agree to the tolerance of their rounds.
  expect_estimate(W.colPivHouseholderQr().solve(weight.cwiseProduct(rows.column("Y"))), result, 1e-2);
}

TEST_F(WriteRows, TheEstimateByInstrumentsFollowsFromThem) {
  provide("scara_iv.toml");
  ASSERT_EQ(
      identify({"scara_iv.toml", "--set", "method.parameter_tolerance=1e-5", "--write-rows", "rows.csv"})
          .exit_code,
      0);
  const Json result = Json::parse(folder().read("scara_iv_result/result.json"));
  const RowColumns rows(folder().read("rows.csv"));
  const Eigen::VectorXd weight = rows.column("weight").cwiseAbs2();
  const Eigen::MatrixXd W = rows.matrix("W:");
  const Eigen::MatrixXd Vt = rows.matrix("V:").transpose() * weight.asDiagonal();
  ASSERT_EQ(Vt.rows(), W.cols());
  const Eigen::VectorXd Y = rows.column("Y");
  // The instruments are those of the estimate itself, which the last iteration moved a little.
  expect_estimate((Vt * W).partialPivLu().solve(Vt * Y), result, 1e-3);
  // Least squares on these rows is another estimate, by the noise of W.
  const Eigen::MatrixXd Wt = W.transpose() * weight.asDiagonal();
  const Eigen::VectorXd ols = (Wt * W).partialPivLu().solve(Wt * Y);
  const Json& ZZ1R = result["parameters"][0];
  EXPECT_GT(std::abs(ols[0] - ZZ1R["value"].get<double>()), 0.05 * ZZ1R["sigma"].get<double>());
}

TEST_F(WriteRows, AnArchiveIsTheSameOfTheSameRun) {
  ASSERT_EQ(identify({"scara.toml", "--write-rows", "a.npz", "--quiet"}).exit_code, 0);
  ASSERT_EQ(identify({"scara.toml", "--write-rows", "b.npz", "--quiet"}).exit_code, 0);
  EXPECT_EQ(folder().read("a.npz"), folder().read("b.npz"));
  EXPECT_TRUE(folder().read("a.npz").starts_with("PK\x03\x04"));
}

TEST_F(WriteRows, IsRefusedForOtherFormats) {
  expect_refused({"--write-rows: rows.mat must end in .npz or .csv"},
                 {"scara.toml", "--write-rows", "rows.mat"});
  expect_refused({"scara_s2.csv: is an input of this run"}, {"scara.toml", "--write-rows", "scara_s2.csv"});
}

}  // namespace
