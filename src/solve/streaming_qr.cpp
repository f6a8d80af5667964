#include "rivid/solve/streaming_qr.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <string>

#include "rivid/error.hpp"

namespace rivid {

namespace {

// Blocks of this many rows stay in the second-level cache beside the triangle and keep the cost of passing over
// the triangle small.
constexpr Index block_rows = 512;

}  // namespace

StreamingQr::StreamingQr(Index columns)
    : triangle_(Matrix::Zero(columns + 1, columns + 1)), column_sums_(Vector::Zero(columns)) {}

void StreamingQr::reduce(Matrix& stacked) {
  const Eigen::HouseholderQR<Eigen::Ref<Matrix>> qr(stacked);
  triangle_ = stacked.topRows(triangle_.rows()).triangularView<Eigen::Upper>();
}

void StreamingQr::add(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Vector>& Y) {
  if (W.cols() != columns() || Y.size() != W.rows()) {
    throw InputError("StreamingQr::add: W is (" + std::to_string(W.rows()) + " x " +
                     std::to_string(W.cols()) + "), Y has " + std::to_string(Y.size()) +
                     " entries; W must have " + std::to_string(columns()) +
                     " columns and Y as many entries as W rows");
  }
  const Index b = columns();
  Matrix stacked;
  for (Index first = 0; first < W.rows(); first += block_rows) {
    const Index count = std::min(block_rows, W.rows() - first);
    stacked.resize(b + 1 + count, b + 1);
    stacked.topRows(b + 1) = triangle_;
    stacked.bottomLeftCorner(count, b) = W.middleRows(first, count);
    stacked.col(b).tail(count) = Y.segment(first, count);
    reduce(stacked);
  }
  column_sums_ += W.colwise().sum().transpose();
  y_sum_ += Y.sum();
  rows_ += W.rows();
}

void StreamingQr::merge(const StreamingQr& other) {
  if (other.columns() != columns()) {
    throw InputError("StreamingQr::merge: the other factor has " + std::to_string(other.columns()) +
                     " columns, must have " + std::to_string(columns()));
  }
  Matrix stacked(2 * triangle_.rows(), triangle_.cols());
  stacked << triangle_, other.triangle_;
  reduce(stacked);
  column_sums_ += other.column_sums_;
  y_sum_ += other.y_sum_;
  rows_ += other.rows_;
}

double StreamingQr::unreachable_norm() const { return std::abs(triangle_(columns(), columns())); }

double StreamingQr::y_norm() const { return triangle_.col(columns()).norm(); }

double StreamingQr::residual_norm(const Eigen::Ref<const Vector>& chi) const {
  return std::hypot((qty() - R().triangularView<Eigen::Upper>() * chi).norm(), unreachable_norm());
}

double StreamingQr::residual_sum(const Eigen::Ref<const Vector>& chi) const {
  return y_sum_ - column_sums_.dot(chi);
}

}  // namespace rivid
