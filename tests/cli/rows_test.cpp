// rivid_identify --write-rows: the rows of a fit, as they are read back.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <sstream>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class WriteRows : public rivid::test::IdentifyTool {};

TEST_F(WriteRows, TheEstimateFollowsFromThem) {
  const Json result = result_of({"scara.toml", "--write-rows", "rows.csv"});
  std::istringstream lines(folder().read("rows.csv"));
  std::string header;
  std::getline(lines, header);
  EXPECT_TRUE(header.starts_with("t,log,joint,Y,prediction,residual,weight,leverage,W:ZZ1R,")) << header;
  constexpr Eigen::Index leading = 8;
  const auto b = static_cast<Eigen::Index>(result["parameters"].size());
  std::vector<double> cells;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) {
      cells.push_back(std::stod(cell));
    }
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto count = static_cast<Eigen::Index>(cells.size()) / (leading + b);
  ASSERT_EQ(count * (leading + b), static_cast<Eigen::Index>(cells.size()));
  ASSERT_EQ(count, result["fit"]["rows"]);
  const Eigen::Map<const RowMajor> table(cells.data(), count, leading + b);
  const Eigen::VectorXd weight = table.col(6);
  const Eigen::MatrixXd W = weight.asDiagonal() * table.rightCols(b);
  const Eigen::VectorXd chi = W.colPivHouseholderQr().solve(weight.cwiseProduct(table.col(3)));
  for (Eigen::Index k = 0; k < b; ++k) {
    const double value = result["parameters"][static_cast<std::size_t>(k)]["value"];
    const double sigma = result["parameters"][static_cast<std::size_t>(k)]["sigma"];
    // Another factorisation of rows whose condition is some hundred.
    EXPECT_NEAR(chi[k], value, 1e-9 * sigma) << k;
  }
  EXPECT_EQ((table.col(3) - table.col(4) - table.col(5)).cwiseAbs().maxCoeff(), 0.0);
  // The trace of the hat matrix is its rank.
  EXPECT_NEAR(table.col(7).sum(), static_cast<double>(b), 1e-9);
  EXPECT_GT(table.col(7).minCoeff(), 0.0);
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
