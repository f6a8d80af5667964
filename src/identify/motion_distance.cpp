#include "identify/motion_distance.hpp"

#include <array>
#include <limits>
#include <utility>

namespace rivid::detail {

MotionDistance::MotionDistance(Index n) : difference_(Matrix::Zero(n, 3)), whole_(Matrix::Zero(n, 3)) {}

void MotionDistance::add(const Motion& a, const Motion& b) {
  const std::array<std::pair<const Matrix*, const Matrix*>, 3> parts = {
      {{&a.q, &b.q}, {&a.qd, &b.qd}, {&a.qdd, &b.qdd}}};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto c = static_cast<Index>(i);
    difference_.col(c) += (*parts[i].first - *parts[i].second).colwise().squaredNorm().transpose();
    whole_.col(c) += parts[i].second->colwise().squaredNorm().transpose();
  }
}

MotionError MotionDistance::error() const {
  const Matrix ratio =
      (whole_.array() > 0.0)
          .select((difference_.array() / whole_.array()).sqrt(), std::numeric_limits<double>::quiet_NaN());
  return {ratio.col(0), ratio.col(1), ratio.col(2)};
}

}  // namespace rivid::detail
