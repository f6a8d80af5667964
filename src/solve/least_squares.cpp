#include "rivid/solve/least_squares.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "solve/rank.hpp"

namespace rivid {

namespace {

using detail::column_scaled;
using detail::ColumnScaled;
using detail::rank_tolerance;
using detail::tied_columns;

double largest_eigenvalue(const Matrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(symmetric, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[symmetric.rows() - 1];
}

Index total_rows(std::span<const RowGroup> groups) {
  return std::accumulate(groups.begin(), groups.end(), Index{0},
                         [](Index sum, const RowGroup& g) { return sum + g.qr.rows(); });
}

}  // namespace

StreamingQr combined(std::span<const RowGroup> groups, Index columns, std::span<const double> weights) {
  StreamingQr out(columns);
  Matrix rows;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const StreamingQr& qr = groups[g].qr;
    rows.setZero(qr.columns(), columns + 1);
    for (Index c = 0; c < qr.columns(); ++c) {
      rows.col(groups[g].columns[static_cast<std::size_t>(c)]).head(c + 1) =
          weights[g] * qr.R().col(c).head(c + 1);
    }
    rows.col(columns) = weights[g] * qr.qty();
    out.add(rows.leftCols(columns), rows.rightCols(1));
  }
  return out;
}

LeastSquares least_squares(std::span<const RowGroup> groups, Index columns, std::span<const double> weights) {
  const StreamingQr all = combined(groups, columns, weights);
  LeastSquares out;
  out.R = all.R();
  const Vector qty = all.qty();
  const ColumnScaled scaled = column_scaled(out.R);
  Eigen::ColPivHouseholderQR<Matrix> pivoted(scaled.R);
  pivoted.setThreshold(rank_tolerance(total_rows(groups), columns));
  out.rank = pivoted.rank();
  out.smallest_pivot = std::abs(pivoted.matrixR()(columns - 1, columns - 1));
  if (out.rank == columns) {
    const auto R = out.R.triangularView<Eigen::Upper>();
    out.chi = R.solve(qty);
    const Matrix inverse = R.solve(Matrix::Identity(columns, columns));
    out.unit_covariance = inverse * inverse.transpose();
    // Both extremes as largest values, which keep their digits when squared; a third of the time of an SVD.
    out.condition =
        std::sqrt(largest_eigenvalue(out.R.transpose() * out.R) * largest_eigenvalue(out.unit_covariance));
    return out;
  }
  out.condition = detail::condition_number(out.R);
  // What lies in the null space can not be told; the other entries are unique all the same.
  const Eigen::BDCSVD<Matrix> svd(scaled.R, Eigen::ComputeThinU | Eigen::ComputeFullV);
  const Matrix V = svd.matrixV().leftCols(out.rank);
  const Vector s = svd.singularValues().head(out.rank);
  const Matrix pseudo = scaled.norms.cwiseInverse().asDiagonal() * V * s.cwiseInverse().asDiagonal();
  out.chi = pseudo * (svd.matrixU().leftCols(out.rank).transpose() * qty);
  out.unit_covariance = pseudo * pseudo.transpose();
  out.undetermined = tied_columns(svd.matrixV().rightCols(columns - out.rank));
  for (const std::vector<Index>& set : out.undetermined) {
    for (const Index c : set) {
      out.unit_covariance(c, c) = std::numeric_limits<double>::infinity();
    }
  }
  return out;
}

std::vector<double> group_sigmas(std::span<const RowGroup> groups) {
  std::vector<double> out;
  for (const RowGroup& group : groups) {
    const Index rows = group.qr.rows();
    const ColumnScaled scaled = column_scaled(group.qr.R());
    Eigen::ColPivHouseholderQR<Matrix> pivoted(scaled.R);
    pivoted.setThreshold(rank_tolerance(rows, group.qr.columns()));
    // What the dependent columns' pivots, mere rounding errors, would take of Y belongs to the residual.
    Vector qty = group.qr.qty();
    qty.applyOnTheLeft(pivoted.householderQ().adjoint());
    const double norm = std::hypot(qty.tail(qty.size() - pivoted.rank()).norm(), group.qr.unreachable_norm());
    const auto freedom = static_cast<double>(std::max<Index>(rows - pivoted.rank(), 1));
    const double rounding =
        std::numeric_limits<double>::epsilon() * group.qr.y_norm() + std::numeric_limits<double>::min();
    out.push_back(std::max(norm, rounding) / std::sqrt(freedom));
  }
  return out;
}

Residual residual(std::span<const RowGroup> groups, const Eigen::Ref<const Vector>& chi,
                  std::span<const double> weights) {
  Residual out;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const RowGroup& group = groups[g];
    const Vector own = chi(group.columns);
    out.norm = std::hypot(out.norm, weights[g] * group.qr.residual_norm(own));
    out.y_norm = std::hypot(out.y_norm, weights[g] * group.qr.y_norm());
    out.sum += weights[g] * group.qr.residual_sum(own);
    out.rows += group.qr.rows();
  }
  return out;
}

}  // namespace rivid
