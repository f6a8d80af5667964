#include "rivid/solve/instrumental.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdint>

#include "rivid/solve/least_squares.hpp"
#include "support/complaint.hpp"
#include "support/random_matrix.hpp"

namespace {

using rivid::Index;
using rivid::InstrumentalGroup;
using rivid::Matrix;
using rivid::StreamingQr;
using rivid::Vector;

// Two groups, one of which does not touch the first column.
struct Case {
  Matrix V[2];
  Matrix W[2];
  Vector Y[2];
  std::vector<Index> columns[2] = {{0, 1, 2, 3}, {1, 2, 3}};
  std::vector<double> weights = {0.5, 3.0};

  explicit Case(std::uint64_t seed) {
    // Each matrix has a seed of its own.
    std::uint64_t next = 100 * seed;
    for (int g = 0; g < 2; ++g) {
      const auto m = static_cast<Index>(columns[g].size());
      V[g] = rivid::test::random_matrix(40, m, ++next);
      W[g] = V[g] + 0.3 * rivid::test::random_matrix(40, m, ++next);
      Y[g] = rivid::test::random_matrix(40, 1, ++next);
    }
  }

  [[nodiscard]] std::vector<InstrumentalGroup> groups() const {
    std::vector<InstrumentalGroup> out;
    for (int g = 0; g < 2; ++g) {
      const auto m = static_cast<Index>(columns[g].size());
      out.push_back({columns[g], StreamingQr(m, m + 1)});
      Matrix carried(40, m + 1);
      carried << W[g], Y[g];
      out.back().qr.add(V[g], carried);
    }
    return out;
  }

  // Σ weight² Aᵀ B, by columns of all.
  [[nodiscard]] Matrix product(const Matrix* A, const Matrix* B) const {
    Matrix out = Matrix::Zero(4, 4);
    for (int g = 0; g < 2; ++g) {
      const double w = weights[static_cast<std::size_t>(g)];
      const Matrix part = w * w * A[g].transpose() * B[g];
      for (Index i = 0; i < part.rows(); ++i) {
        for (Index k = 0; k < part.cols(); ++k) {
          out(columns[g][static_cast<std::size_t>(i)], columns[g][static_cast<std::size_t>(k)]) += part(i, k);
        }
      }
    }
    return out;
  }
};

TEST(InstrumentalVariables, SolveTheNormalEquationsOfEq27) {
  const Case c(51);
  const auto found = instrumental_variables(c.groups(), 4, c.weights);
  Vector right = Vector::Zero(4);
  for (int g = 0; g < 2; ++g) {
    const double w = c.weights[static_cast<std::size_t>(g)];
    const Vector part = w * w * c.V[g].transpose() * c.Y[g];
    for (Index i = 0; i < part.size(); ++i) {
      right[c.columns[g][static_cast<std::size_t>(i)]] += part[i];
    }
  }
  const Matrix VtW = c.product(c.V, c.W);
  EXPECT_TRUE(found.full_rank());
  EXPECT_LT((found.chi - VtW.inverse() * right).norm(), 1e-12 * found.chi.norm());
  const Matrix covariance = VtW.inverse() * c.product(c.V, c.V) * VtW.transpose().inverse();
  EXPECT_LT((found.unit_covariance - covariance).norm(), 1e-12 * covariance.norm());
}

TEST(InstrumentalVariables, AreLeastSquaresWhereVIsW) {
  Case c(52);
  std::vector<rivid::RowGroup> rows;
  for (int g = 0; g < 2; ++g) {
    c.W[g] = c.V[g];
    rows.push_back({c.columns[g], StreamingQr(static_cast<Index>(c.columns[g].size()))});
    rows.back().qr.add(c.W[g], c.Y[g]);
  }
  const auto found = instrumental_variables(c.groups(), 4, c.weights);
  const auto ls = rivid::least_squares(rows, 4, c.weights);
  EXPECT_LT((found.chi - ls.chi).norm(), 1e-13 * ls.chi.norm());
  EXPECT_LT((found.unit_covariance - ls.unit_covariance).norm(), 1e-13 * ls.unit_covariance.norm());
  EXPECT_NEAR(found.condition_VW, ls.condition, 1e-9 * ls.condition);
}

TEST(InstrumentalVariables, NameWhatTheInstrumentsDoNotMove) {
  Case c(53);
  for (int g = 0; g < 2; ++g) {
    c.V[g].col(c.V[g].cols() - 1).setZero();
  }
  const auto found = instrumental_variables(c.groups(), 4, c.weights);
  EXPECT_EQ(found.rank, 3);
  ASSERT_EQ(found.undetermined.size(), 1U);
  EXPECT_EQ(found.undetermined[0], std::vector<Index>{3});
  EXPECT_TRUE(found.chi.hasNaN());
}

TEST(InstrumentalVariables, RefuseFactorsWithoutWAndY) {
  const Case of(1);
  std::vector<InstrumentalGroup> groups = of.groups();
  groups[1].qr = StreamingQr(3);
  EXPECT_EQ(rivid::test::complaint_of([&] { return instrumental_variables(groups, 4, of.weights); }),
            "instrumental_variables: a factor of 3 columns carries 1, must carry those of W and Y: 4");
  EXPECT_EQ(rivid::test::complaint_of([&] { return instrumental_variables(of.groups(), 0, of.weights); }),
            "instrumental_variables: there are 2 groups and 0 columns, must be one of each at least");
}

}  // namespace
