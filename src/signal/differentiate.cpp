#include <cmath>
#include <string>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/text.hpp"

namespace rivid {

Matrix central_difference(const Eigen::Ref<const Matrix>& x, double f_m) {
  const Index n_m = x.rows();
  if (n_m < 2) {
    throw InputError("central_difference: x has " + counted(n_m, "sample") + ", must have at least 2");
  }
  if (!std::isfinite(f_m) || f_m <= 0.0) {
    throw InputError("central_difference: f_m is " + number(f_m, 6) + " Hz, must be positive and finite");
  }
  Matrix xd(n_m, x.cols());
  xd.row(0) = (x.row(1) - x.row(0)) * f_m;
  xd.middleRows(1, n_m - 2) = (x.bottomRows(n_m - 2) - x.topRows(n_m - 2)) * (0.5 * f_m);
  xd.row(n_m - 1) = (x.row(n_m - 1) - x.row(n_m - 2)) * f_m;
  return xd;
}

Motion differentiate(const Eigen::Ref<const Matrix>& q, double f_m) {
  Matrix qd = central_difference(q, f_m);
  Matrix qdd = central_difference(qd, f_m);
  return {.q = q, .qd = std::move(qd), .qdd = std::move(qdd)};
}

}  // namespace rivid
