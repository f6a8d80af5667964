#include "rivid/solve/streaming_qr.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <random>

#include "rivid/error.hpp"

namespace rivid {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

Matrix random_matrix(Index rows, Index columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(rows, columns, [&] { return normal(random); });
}

// R is unique but for the signs of its rows.
Matrix without_signs(const Matrix& R) { return R.diagonal().cwiseSign().asDiagonal() * R; }

struct Problem {
  Matrix W = random_matrix(3000, 17, 11);
  Vector Y = random_matrix(3000, 1, 12);
};

TEST(StreamingQr, IsTheFactorisationOfAllRowsWhateverTheBlocks) {
  const Problem p;
  const Matrix R = without_signs(
      Matrix(Eigen::HouseholderQR<Matrix>(p.W).matrixQR().topRows(17).triangularView<Eigen::Upper>()));
  for (const Index block : {1, 7, 100, 512, 3000}) {
    StreamingQr qr(17);
    for (Index first = 0; first < p.W.rows(); first += block) {
      const Index count = std::min(block, p.W.rows() - first);
      qr.add(p.W.middleRows(first, count), p.Y.segment(first, count));
    }
    EXPECT_EQ(qr.rows(), 3000);
    EXPECT_LT((without_signs(qr.R()) - R).norm(), 1e4 * epsilon * R.norm()) << "blocks of " << block;
    EXPECT_NEAR(qr.y_norm(), p.Y.norm(), 1e4 * epsilon * p.Y.norm());
    EXPECT_NEAR(qr.y_sum(), p.Y.sum(), 1e4 * epsilon * p.Y.norm());
  }
}

TEST(StreamingQr, MergesInAnyOrderToTheSame) {
  const Problem p;
  const auto part = [&](Index first, Index count) {
    StreamingQr qr(17);
    qr.add(p.W.middleRows(first, count), p.Y.segment(first, count));
    return qr;
  };
  StreamingQr left = part(0, 1000);
  left.merge(part(1000, 500));
  left.merge(part(1500, 1500));
  StreamingQr right = part(1000, 500);
  right.merge(part(1500, 1500));
  right.merge(part(0, 1000));
  EXPECT_LT((without_signs(left.R()) - without_signs(right.R())).norm(), 1e4 * epsilon * left.R().norm());
  EXPECT_EQ(left.rows(), right.rows());
  EXPECT_NEAR(left.unreachable_norm(), right.unreachable_norm(), 1e4 * epsilon * p.Y.norm());
}

TEST(StreamingQr, KnowsTheResidualOfAnyParametersWithoutTheRows) {
  const Problem p;
  StreamingQr qr(17);
  qr.add(p.W, p.Y);
  const Vector chi = random_matrix(17, 1, 13);
  const Vector rho = p.Y - p.W * chi;
  EXPECT_NEAR(qr.residual_norm(chi), rho.norm(), 1e4 * epsilon * rho.norm());
  EXPECT_NEAR(qr.residual_sum(chi), rho.sum(), 1e4 * epsilon * rho.norm());
}

TEST(StreamingQr, TakesFewerRowsThanColumns) {
  StreamingQr qr(5);
  const Matrix W = random_matrix(2, 5, 14);
  const Vector Y = random_matrix(2, 1, 15);
  qr.add(W, Y);
  EXPECT_NEAR((qr.R().transpose() * qr.R() - W.transpose() * W).norm(), 0.0, 1e-14);
}

TEST(StreamingQr, RefusesRowsOfAnotherWidth) {
  StreamingQr qr(5);
  EXPECT_THROW(qr.add(Matrix::Zero(3, 4), Vector::Zero(3)), InputError);
  EXPECT_THROW(qr.add(Matrix::Zero(3, 5), Vector::Zero(2)), InputError);
  EXPECT_THROW(qr.merge(StreamingQr(4)), InputError);
}

}  // namespace
}  // namespace rivid
