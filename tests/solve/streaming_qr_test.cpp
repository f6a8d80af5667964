#include "rivid/solve/streaming_qr.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "rivid/error.hpp"
#include "support/complaint.hpp"
#include "support/random_matrix.hpp"

namespace rivid {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

using test::random_matrix;

// R is unique but for the signs of its rows.
Matrix without_signs(const Matrix& R) { return R.diagonal().cwiseSign().asDiagonal() * R; }

struct Problem {
  Matrix W = random_matrix(3000, 17, 11);
  Vector Y = random_matrix(3000, 1, 12);
};

void add_in_blocks(StreamingQr& qr, const Problem& p, Index block) {
  for (Index first = 0; first < p.W.rows(); first += block) {
    const Index count = std::min(block, p.W.rows() - first);
    qr.add(p.W.middleRows(first, count), p.Y.segment(first, count));
  }
}

void expect_same(const StreamingQr& a, const StreamingQr& b) {
  EXPECT_EQ(a.rows(), b.rows());
  EXPECT_EQ(a.R(), b.R());
  EXPECT_EQ(a.qty(), b.qty());
  EXPECT_EQ(a.unreachable_norm(), b.unreachable_norm());
  EXPECT_EQ(a.column_sums(), b.column_sums());
  EXPECT_EQ(a.y_sum(), b.y_sum());
}

TEST(StreamingQr, IsTheFactorisationOfAllRows) {
  const Problem p;
  const Matrix R = without_signs(
      Matrix(Eigen::HouseholderQR<Matrix>(p.W).matrixQR().topRows(17).triangularView<Eigen::Upper>()));
  StreamingQr qr(17);
  qr.add(p.W, p.Y);
  EXPECT_EQ(qr.rows(), 3000);
  EXPECT_LT((without_signs(qr.R()) - R).norm(), 1e4 * epsilon * R.norm());
  EXPECT_LT((qr.R().transpose() * qr.qty() - p.W.transpose() * p.Y).norm(),
            1e4 * epsilon * R.norm() * p.Y.norm());
  EXPECT_NEAR(qr.y_norm(), p.Y.norm(), 1e4 * epsilon * p.Y.norm());
  EXPECT_NEAR(qr.y_sum(), p.Y.sum(), 1e4 * epsilon * p.Y.norm());
  EXPECT_LT((qr.column_sums().transpose() - p.W.colwise().sum()).norm(), 1e4 * epsilon * R.norm());
}

TEST(StreamingQr, IsTheSameBitForBitWhateverTheBlocks) {
  const Problem p;
  StreamingQr whole(17);
  whole.add(p.W, p.Y);
  for (const Index block : {1, 7, 100, 511, 512, 513, 1100}) {
    SCOPED_TRACE("blocks of " + std::to_string(block));
    StreamingQr qr(17);
    add_in_blocks(qr, p, block);
    expect_same(qr, whole);
  }
}

TEST(StreamingQr, GoesOnAfterItWasRead) {
  const Problem p;
  StreamingQr whole(17);
  whole.add(p.W, p.Y);
  StreamingQr qr(17);
  for (Index first = 0; first < 3000; first += 600) {
    qr.add(p.W.middleRows(first, 600), p.Y.segment(first, 600));
    EXPECT_TRUE(qr.R().allFinite());
    EXPECT_NEAR(qr.y_norm(), p.Y.head(first + 600).norm(), 1e4 * epsilon * p.Y.norm());
  }
  EXPECT_LT((without_signs(qr.R()) - without_signs(whole.R())).norm(), 1e4 * epsilon * whole.R().norm());
}

TEST(StreamingQr, IsReadBySeveralThreadsAtOnce) {
  const Problem p;
  StreamingQr whole(17);
  whole.add(p.W, p.Y);
  StreamingQr qr(17);
  qr.add(p.W, p.Y);
  {
    const std::jthread other([&] { EXPECT_EQ(qr.R(), whole.R()); });
    EXPECT_EQ(qr.qty(), whole.qty());
  }
}

TEST(StreamingQr, IsCopiedAndMovedWithTheRowsThatWait) {
  const Problem p;
  StreamingQr qr(17);
  qr.add(p.W.topRows(700), p.Y.head(700));
  StreamingQr copy(3);
  copy = qr;
  expect_same(copy, qr);
  qr.add(p.W.bottomRows(2300), p.Y.tail(2300));
  EXPECT_EQ(copy.rows(), 700);
  copy.add(p.W.bottomRows(2300), p.Y.tail(2300));
  expect_same(copy, qr);

  StreamingQr waiting(17);
  waiting.add(p.W.topRows(100), p.Y.head(100));
  StreamingQr direct(17);
  direct.add(p.W.topRows(100), p.Y.head(100));
  const StreamingQr moved = std::move(waiting);
  expect_same(moved, direct);
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

TEST(StreamingQr, MergesWithItselfAsIfAllRowsCameTwice) {
  const Problem p;
  StreamingQr qr(17);
  qr.add(p.W, p.Y);
  const Matrix R = without_signs(qr.R());
  const double rest = qr.unreachable_norm();
  qr.merge(qr);
  EXPECT_EQ(qr.rows(), 6000);
  EXPECT_LT((without_signs(qr.R()) - std::sqrt(2.0) * R).norm(), 1e4 * epsilon * R.norm());
  EXPECT_NEAR(qr.unreachable_norm(), std::sqrt(2.0) * rest, 1e4 * epsilon * rest);
}

// ((a b) c) = (a (b c)), and an accumulator without rows is the unit.
TEST(StreamingQr, MergesAssociativelyWithManyCarriedColumns) {
  const Matrix W = random_matrix(900, 6, 16);
  const Matrix C = random_matrix(900, 9, 17);
  const auto part = [&](Index first, Index count) {
    StreamingQr qr(6, 9);
    qr.add(W.middleRows(first, count), C.middleRows(first, count));
    return qr;
  };
  StreamingQr left = part(0, 300);
  left.merge(part(300, 4));
  left.merge(StreamingQr(6, 9));
  left.merge(part(304, 596));
  StreamingQr tail = part(300, 4);
  tail.merge(part(304, 596));
  StreamingQr right = part(0, 300);
  right.merge(tail);
  const StreamingQr whole = part(0, 900);
  for (const StreamingQr* const qr : {&left, &right}) {
    EXPECT_EQ(qr->rows(), 900);
    EXPECT_LT((without_signs(qr->R()) - without_signs(whole.R())).norm(), 1e4 * epsilon * W.norm());
    EXPECT_LT((qr->R().transpose() * qr->qt_carried() - W.transpose() * C).norm(),
              1e4 * epsilon * W.norm() * C.norm());
    EXPECT_LT((qr->unreachable_norms() - whole.unreachable_norms()).norm(), 1e4 * epsilon * C.norm());
    EXPECT_LT((qr->column_sums() - whole.column_sums()).norm(), 1e4 * epsilon * W.norm());
  }
}

TEST(StreamingQr, OfNoColumnsIsTheNormOfY) {
  StreamingQr qr(0);
  qr.add(Matrix::Zero(2, 0), Vector{{3.0, 4.0}});
  StreamingQr other(0);
  other.add(Matrix::Zero(1, 0), Vector{{12.0}});
  qr.merge(other);
  EXPECT_DOUBLE_EQ(qr.unreachable_norm(), 13.0);
  EXPECT_DOUBLE_EQ(qr.y_sum(), 19.0);
}

TEST(StreamingQr, WithoutRowsIsZero) {
  const StreamingQr qr(3, 2);
  EXPECT_TRUE(qr.R().isZero(0.0));
  EXPECT_TRUE(qr.qt_carried().isZero(0.0));
  EXPECT_EQ(qr.y_norm(), 0.0);
}

std::string message(StreamingQr& qr, const Matrix& W, const Matrix& Y) {
  return test::complaint_of([&] { qr.add(W, Y); });
}

TEST(StreamingQr, RefusesEntriesThatAreNotFiniteAndKeepsWhatItHad) {
  const Problem p;
  StreamingQr expected(17);
  expected.add(p.W.topRows(30), p.Y.head(30));
  for (const Index rows : {100, 3000}) {
    StreamingQr qr(17);
    qr.add(p.W.topRows(30), p.Y.head(30));
    Matrix W = p.W.topRows(rows);
    Vector Y = p.Y.head(rows);
    W(rows - 1, 16) = std::nan("");
    EXPECT_EQ(message(qr, W, Y),
              "StreamingQr::add: row " + std::to_string(rows - 1) +
                  " of these rows, column 16 of W, is nan; entries must be finite and at most "
                  "1e+150");
    Y[2] = -std::numeric_limits<double>::infinity();
    EXPECT_EQ(message(qr, W, Y),
              "StreamingQr::add: row 2 of these rows, Y, is -inf; entries must be finite and at most 1e+150");
    expect_same(qr, expected);
  }
  StreamingQr joint(1, 2);
  EXPECT_EQ(
      message(joint, Matrix::Ones(1, 1), Matrix{{1.0, 1e200}}),
      "StreamingQr::add: row 0 of these rows, column 1 of Y, is 1e+200; entries must be finite and at most "
      "1e+150");
}

TEST(StreamingQr, KeepsItsAccuracyAtTheEndsOfTheScale) {
  const Problem p;
  StreamingQr plain(17);
  plain.add(p.W, p.Y);
  for (const double scale : {1e-149, 1e149}) {
    StreamingQr qr(17);
    qr.add(scale * p.W, p.Y / scale);
    EXPECT_LT((qr.R() / scale - Matrix(plain.R())).norm(), 1e4 * epsilon * plain.R().norm());
    EXPECT_NEAR(qr.unreachable_norm() * scale, plain.unreachable_norm(), 1e4 * epsilon * p.Y.norm());
    StreamingQr merged = qr;
    merged.merge(qr);
    EXPECT_LT((merged.R().colwise().norm() / scale - std::sqrt(2.0) * plain.R().colwise().norm()).norm(),
              1e4 * epsilon * plain.R().norm());
  }
}

TEST(StreamingQr, RefusesRowsOfAnotherWidth) {
  StreamingQr qr(5);
  EXPECT_THROW(qr.add(Matrix::Zero(3, 4), Vector::Zero(3)), InputError);
  EXPECT_THROW(qr.add(Matrix::Zero(3, 5), Vector::Zero(2)), InputError);
  EXPECT_THROW(qr.merge(StreamingQr(4)), InputError);
  EXPECT_THROW(qr.merge(StreamingQr(5, 2)), InputError);
  EXPECT_THROW(StreamingQr(-1), InputError);
  EXPECT_THROW(StreamingQr(5, 0), InputError);
  EXPECT_EQ(message(qr, Matrix::Zero(3, 4), Vector::Zero(2)),
            "StreamingQr::add: W is (3 x 4), Y is (2 x 1); W must have 5 columns, Y 1 column and as many "
            "rows as W");
}

TEST(StreamingQr, RefusesParametersOfAnotherSizeAndToBeReadWhenItHasMoved) {
  StreamingQr qr(3);
  qr.add(Matrix::Identity(3, 3), Vector::Ones(3));
  EXPECT_EQ(test::complaint_of([&] { return qr.residual_norm(Vector::Zero(300)); }),
            "StreamingQr::residual_norm: chi has 300 values, must have 3, one a column");
  EXPECT_EQ(test::complaint_of([&] { return qr.residual_sum(Vector::Zero(1)); }),
            "StreamingQr::residual_sum: chi has 1 value, must have 3, one a column");
  const StreamingQr other(std::move(qr));
  EXPECT_EQ(other.rows(), 3);
  EXPECT_EQ(test::complaint_of([&] { return qr.R(); }),
            "StreamingQr: its rows have been moved to another one; assign a new one to it");
  qr = StreamingQr(2);
  EXPECT_EQ(qr.R().cols(), 2);
}

TEST(StreamingQr, TakesRowsThatWereWrittenInPlace) {
  const Matrix WY = test::random_matrix(1500, 9, 20);
  StreamingQr added(8);
  added.add(WY.leftCols(8), WY.rightCols(1));
  StreamingQr written(8);
  for (Index first = 0; first < WY.rows();) {
    const RowsRoom room = written.room();
    const Index count = std::min<Index>({room.rows, 100, WY.rows() - first});
    for (Index c = 0; c < 9; ++c) {
      std::copy_n(WY.col(c).data() + first, count, room.target.data + c * room.target.ld);
    }
    written.commit(count);
    first += count;
  }
  EXPECT_EQ(written.rows(), 1500);
  EXPECT_EQ(written.R(), added.R());
  EXPECT_EQ(written.qty(), added.qty());
  EXPECT_TRUE(written.finite());
  EXPECT_EQ(written.room(StreamingQr::most_rows).rows, StreamingQr::most_rows);
  EXPECT_THROW((void)written.room(StreamingQr::most_rows + 1), InputError);
  EXPECT_THROW(written.commit(StreamingQr::most_rows + 1), InputError);
}

TEST(StreamingQr, TellsWhereRowsInPlaceWereNotFinite) {
  for (const double bad : {std::numeric_limits<double>::infinity(), std::nan(""), 1e200}) {
    for (const Index column : {0, 1, 2}) {
      StreamingQr qr(2);
      const RowsRoom room = qr.room();
      for (Index c = 0; c < 3; ++c) {
        room.target.data[c * room.target.ld] = c == column ? bad : 1.0;
      }
      qr.commit(1);
      EXPECT_FALSE(qr.finite()) << bad << " in column " << column;
    }
  }
}

}  // namespace
}  // namespace rivid
