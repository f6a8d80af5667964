#include "rivid/identify/covariance.hpp"
#include "rivid/identify/rows.hpp"

namespace rivid {

Vector deviation_bound(const Robot& robot, const Log& log, const Vector& sigma) {
  const BaseParameters base = base_parameters(robot);
  const RowFactors rows = factors(robot, base, log, {.rows = RowScheme::exact});
  const Vector inverse = sigma.cwiseInverse();
  const std::vector<double> weights(inverse.begin(), inverse.end());
  return least_squares(rows.groups, base.size(), weights).unit_covariance.diagonal().cwiseSqrt();
}

}  // namespace rivid
