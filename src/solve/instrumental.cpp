#include "rivid/solve/instrumental.hpp"

#include <limits>

#include "dense.hpp"
#include "solve/rank.hpp"

namespace rivid {

InstrumentalVariables instrumental_variables(std::span<const InstrumentalGroup> groups, Index columns,
                                             std::span<const double> weights) {
  // Below its triangle V is zero, so what W and Y have there takes no part in Vᵀ W and Vᵀ Y.
  StreamingQr all(columns, columns + 1);
  Matrix V;
  Matrix WY;
  Index rows = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const StreamingQr& qr = groups[g].qr;
    const Index m = qr.columns();
    V.setZero(m, columns);
    WY.setZero(m, columns + 1);
    for (Index c = 0; c < m; ++c) {
      const Index to = groups[g].columns[static_cast<std::size_t>(c)];
      V.col(to).head(c + 1) = weights[g] * qr.R().col(c).head(c + 1);
      WY.col(to) = weights[g] * qr.qt_carried().col(c);
    }
    WY.col(columns) = weights[g] * qr.qty();
    all.add(V, WY);
    rows += qr.rows();
  }

  InstrumentalVariables out;
  out.R_VV = all.R();
  out.R_VW = all.qt_carried().leftCols(columns);
  out.condition_V = detail::condition_number(out.R_VV);
  out.condition_VW = detail::condition_number(out.R_VW);
  const detail::ColumnScaled scaled = detail::column_scaled(out.R_VW);
  const detail::PivotedQr pivoted(scaled.R, detail::rank_tolerance(rows, columns));
  out.rank = pivoted.rank();
  out.smallest_pivot = pivoted.last_pivot();
  if (out.rank == columns) {
    out.chi = scaled.norms.cwiseInverse().asDiagonal() * pivoted.solve(all.qty());
    const Matrix inverse =
        scaled.norms.cwiseInverse().asDiagonal() * pivoted.solve(Matrix::Identity(columns, columns));
    out.unit_covariance = inverse * inverse.transpose();
    return out;
  }
  out.chi = Vector::Constant(columns, std::numeric_limits<double>::quiet_NaN());
  out.unit_covariance = Matrix::Constant(columns, columns, std::numeric_limits<double>::infinity());
  // A joint that never moves, a direction that never turns shows in V itself.
  const detail::ColumnScaled V_scaled = detail::column_scaled(out.R_VV);
  const detail::Svd of_V = detail::svd(V_scaled.R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector& singular = of_V.values;
  const double noise = detail::rank_tolerance(rows, columns) * singular[0];
  const Index missing = (singular.array() <= noise).count();
  if (missing > 0) {
    out.undetermined = detail::tied_columns(of_V.V.rightCols(missing));
    return out;
  }
  const detail::Svd of_VW = detail::svd(scaled.R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  out.undetermined = detail::tied_columns(of_VW.V.rightCols(columns - out.rank));
  return out;
}

}  // namespace rivid
