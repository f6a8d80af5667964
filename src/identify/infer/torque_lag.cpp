#include <algorithm>
#include <cmath>

#include "identify/infer/covariance.hpp"
#include "identify/infer/scores.hpp"
#include "ranges.hpp"
#include "rivid/solve/inference.hpp"

namespace rivid::detail {

LagSums::LagSums(Index own, Index stride, Index intervals, double samples_per_interval)
    : PD(Vector::Zero(intervals)),
      P_rho(Vector::Zero(intervals)),
      WP(Vector::Zero(own)),
      ZD(Matrix::Zero(intervals, own)),
      stride_(stride),
      samples_per_interval_(samples_per_interval),
      samples_(lead, none) {}

bool LagSums::beside(Index i, Index before, Index after) const {
  return samples_[static_cast<std::size_t>(i + after)] - samples_[static_cast<std::size_t>(i - before)] ==
         (before + after) * stride_;
}

double LagSums::rate(const Eigen::Ref<const Vector>& x, Index i) const {
  if (beside(i, 2, 2)) {
    return (8.0 * (x[i + 1] - x[i - 1]) - (x[i + 2] - x[i - 2])) / 12.0;
  }
  if (beside(i, 1, 1)) {
    return 0.5 * (x[i + 1] - x[i - 1]);
  }
  if (beside(i, 0, 2)) {
    return 0.5 * (4.0 * x[i + 1] - 3.0 * x[i] - x[i + 2]);
  }
  if (beside(i, 2, 0)) {
    return 0.5 * (3.0 * x[i] - 4.0 * x[i - 1] + x[i - 2]);
  }
  return 0.0;
}

double LagSums::slope(const Eigen::Ref<const Vector>& x, Index i) const {
  return beside(i, 2, 2) ? 0.1 * (x[i + 1] - x[i - 1]) + 0.2 * (x[i + 2] - x[i - 2]) : 0.0;
}

void LagSums::add(const Eigen::Ref<const Matrix>& Z, const Eigen::Ref<const Matrix>& W,
                  const Eigen::Ref<const Vector>& Y, const Eigen::Ref<const Vector>& rho,
                  const Eigen::Ref<const Vector>& chi, std::span<const Index> samples) {
  const auto count = static_cast<Index>(samples.size());
  samples_.resize(lead);
  samples_.insert(samples_.end(), samples.begin(), samples.end());
  const Vector fitted = Z * chi;
  Vector P(count);
  Vector D(count);
  std::vector<Index> interval(samples.size(), 0);
  for (Index k = 0; k < count; ++k) {
    const Index i = k + 2;
    D[k] = rate(Y, i) / static_cast<double>(stride_);
    P[k] = slope(fitted, i) / static_cast<double>(stride_);
    if (D[k] != 0.0 || P[k] != 0.0) {
      Index& at = interval[static_cast<std::size_t>(k)];
      at = TimeIntervals::of(samples_[static_cast<std::size_t>(i)], samples_per_interval_);
      P_rho[at] += P[k] * rho[i];
      PD[at] += P[k] * D[k];
    }
  }
  WP.noalias() += W.middleRows(2, count).transpose() * P;
  for (Index c = 0; c < Z.cols(); ++c) {
    for (Index k = 0; k < count; ++k) {
      ZD(interval[static_cast<std::size_t>(k)], c) += Z(k + 2, c) * D[k];
    }
  }
  samples_.erase(samples_.begin(), samples_.end() - lead);
}

std::optional<TorqueLag> torque_lag(const BaseParameters& base, const Scores& scores,
                                    const CovarianceOptions& options, const Matrix& bread,
                                    const Vector& sigma) {
  const RateSums& rates = scores.rates;
  const Index all = rates.WP.cols();
  Vector PD = Vector::Zero(all);
  Vector P_rho = Vector::Zero(all);
  for (std::size_t l = 0; l < rates.PD.size(); ++l) {
    PD += rates.PD[l].colwise().sum().transpose();
    P_rho += rates.P_rho[l].colwise().sum().transpose();
  }
  const std::vector<Index> joints = places_where(all, [&](Index j) { return PD[j] > 0.0; });
  const auto n = static_cast<Index>(joints.size());
  if (n == 0) {
    return std::nullopt;
  }
  // What is left of the rates beside the parameters.
  const Matrix reached = bread.transpose() * rates.WP(Eigen::all, joints);
  Matrix H = -reached.transpose() * rates.ZD(Eigen::all, joints);
  H.diagonal() += PD(joints);
  const Vector left = P_rho(joints);
  const double curvature = H.sum();
  TorqueLag out;
  out.samples = -left.sum() / curvature;
  // The errors are what is left without the lag.
  std::vector<Matrix> series;
  for (std::size_t l = 0; l < rates.PD.size(); ++l) {
    const Matrix own = rates.P_rho[l] + out.samples * rates.PD[l];
    series.emplace_back(own(Eigen::all, joints) -
                        (scores.series.front()[l] + out.samples * rates.ZD_by_time[l]) * reached);
  }
  const Matrix S = long_run_covariance(series, lag_of(series, scores.interval, options));
  // Widened to the scatter of the joints, where they do not agree on one lag.
  const Vector rest = left + H.rowwise().sum() * out.samples;
  const double scatter =
      n > 1 ? rest.squaredNorm() * static_cast<double>(n) / static_cast<double>(n - 1) : 0.0;
  out.sigma = std::sqrt(std::max(S.sum(), scatter)) / std::abs(curvature);
  if (!std::isfinite(out.samples) || !std::isfinite(out.sigma)) {
    return std::nullopt;
  }
  const Vector shift = bread * rates.ZD.rowwise().sum() * out.samples;
  Index at = 0;
  out.largest_shift = shift.cwiseQuotient(sigma)
                          .unaryExpr([](double x) { return std::isfinite(x) ? std::abs(x) : 0.0; })
                          .maxCoeff(&at);
  out.parameter = base.parameters[static_cast<std::size_t>(at)].name;
  return out;
}

}  // namespace rivid::detail
