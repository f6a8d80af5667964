#include "identify/estimate/robust.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "dense.hpp"
#include "ranges.hpp"

namespace rivid::detail {

namespace {

// Scale of the residuals that weights are made of next. Never zero: rows that fit to rounding have the
// rounding error of Y.
double scale_of(ReweightedJoint& joint) {
  if (joint.residuals.empty()) {
    return 1.0;
  }
  const double rounding = std::numeric_limits<double>::epsilon() *
                              std::sqrt(joint.y_squares / static_cast<double>(joint.residuals.size())) +
                          std::numeric_limits<double>::min();
  return std::max(robust_scale(joint.residuals), rounding);
}

double all_rows(std::span<const RobustSums> sums) {
  return static_cast<double>(sum_of(sums, &RobustSums::rows));
}

}  // namespace

Reweighting::Reweighting(const Robust& options, Vector chi, std::size_t joints)
    : options_(options), chi_(std::move(chi)), joints_(joints) {
  // The bisquare loss has several minima; Huber's leads to a good one.
  loss_.loss = options.kind == RobustKind::huber ? options.loss() : Robust{}.loss();
  // Residuals in units of that have the weight 1.
  loss_.scales.assign(joints, std::numeric_limits<double>::infinity());
  next_scales_ = loss_.scales;
}

void Reweighting::settle(const std::function<void()>& make_rows, const std::function<Solution()>& solve) {
  if (!begun_) {
    pass(make_rows);
    begun_ = true;
  }
  settled_ = settle_with_loss(make_rows, solve);
  if (settled_ && loss_.loss.kind != options_.kind) {
    loss_.loss = options_.loss();
    settled_ = settle_with_loss(make_rows, solve);
  }
}

bool Reweighting::settle_with_loss(const std::function<void()>& make_rows,
                                   const std::function<Solution()>& solve) {
  for (int round = 0; round < options_.max_rounds; ++round) {
    pass(make_rows);
    ++rounds_;
    Solution found = solve();
    if (!found.chi.allFinite()) {
      return false;
    }
    const double step = ((found.chi - chi_).array() / found.sigma.array()).abs().maxCoeff();
    chi_ = std::move(found.chi);
    if (step <= options_.tolerance) {
      return true;
    }
  }
  return false;
}

void Reweighting::pass(const std::function<void()>& make_rows) {
  loss_.scales = next_scales_;
  for (ReweightedJoint& joint : joints_) {
    joint = {};
  }
  make_rows();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    next_scales_[j] = scale_of(joints_[j]);
  }
}

std::vector<RobustSums> Reweighting::sums() const { return made_of(joints_, &ReweightedJoint::sums); }

std::vector<double> Reweighting::weights() const {
  return made_of(loss_.scales, [&](double scale) { return 1.0 / scale; });
}

ReweightedSink::ReweightedSink(RowSink& to, const RobustLoss& loss, double scale, Vector chi, bool with_V,
                               std::vector<Index> from_V, ReweightedJoint& joint)
    : to_(to),
      loss_(loss),
      scale_(scale),
      chi_(std::move(chi)),
      W_at_(with_V ? chi_.size() : 0),
      from_V_(std::move(from_V)),
      joint_(joint) {}

void ReweightedSink::commit(std::span<const Index> samples) {
  const auto count = static_cast<Index>(samples.size());
  const Index own = chi_.size();
  using Rows = Eigen::Map<Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;
  Rows rows(room_.target.data, count, W_at_ + own + 1, Eigen::OuterStride<>(room_.target.ld));
  for (const Index c : from_V_) {
    rows.col(W_at_ + c) = rows.col(c);
  }
  const auto Y = rows.col(W_at_ + own);
  const Vector rho = Y - rows.middleCols(W_at_, own) * chi_;
  joint_.y_squares += Y.squaredNorm();
  joint_.residuals.insert(joint_.residuals.end(), rho.begin(), rho.end());
  Vector root(count);
  RobustSums& sums = joint_.sums;
  for (Index k = 0; k < count; ++k) {
    const double u = rho[k] / scale_;
    const double weight = loss_.weight(u);
    const double slope = loss_.slope(u);
    root[k] = std::sqrt(weight);
    sums.psi_squares += weight * u * weight * u;
    sums.slopes += slope;
    sums.slope_squares += slope * slope;
    sums.below_one += weight < 1.0 ? 1 : 0;
    sums.below_half += weight < 0.5 ? 1 : 0;
    sums.rejected += weight == 0.0 ? 1 : 0;
  }
  sums.rows += count;
  rows.array().colwise() *= root.array();
  to_.commit(samples);
}

ReweightedSinks::ReweightedSinks(std::span<RowSink* const> to, Reweighting* by,
                                 std::span<const RowGroup> columns,
                                 std::span<const std::vector<Index>> from_V)
    : sinks_(to.begin(), to.end()) {
  if (by == nullptr) {
    return;
  }
  reweighted_.reserve(to.size());
  for (std::size_t j = 0; j < to.size(); ++j) {
    sinks_[j] = &reweighted_.emplace_back(*to[j], by->loss_.loss, by->loss_.scales[j],
                                          by->chi_(columns[j].columns), !from_V.empty(),
                                          from_V.empty() ? std::vector<Index>() : from_V[j], by->joints_[j]);
  }
}

RobustInformation robust_information(std::span<const RobustSums> sums, const RowLoss& loss,
                                     std::span<const double> weights, Index b) {
  RobustInformation out;
  const double all = all_rows(sums);
  const double share = static_cast<double>(b) / all;
  double squares = 0.0;
  double slopes = 0.0;
  for (std::size_t j = 0; j < sums.size(); ++j) {
    const RobustSums& joint = sums[j];
    if (joint.rows == 0) {
      out.bread.push_back(weights[j]);
      out.meat.push_back(weights[j]);
      continue;
    }
    const auto rows = static_cast<double>(joint.rows);
    const double slope = joint.slopes / rows;
    const double variance = joint.slope_squares / rows - slope * slope;
    // The parameters take their share of the residuals, and what they take depends on the slopes of the
    // others: [Huber 1981], (6.2) and (6.5).
    const double correction = 1.0 + share * variance / (slope * slope);
    const double psi_square = correction * correction * joint.psi_squares / (rows * (1.0 - share));
    const double error = weights[j] * loss.scales[j];
    out.bread.push_back(weights[j] * std::sqrt(slope));
    out.meat.push_back(weights[j] * error * std::sqrt(psi_square));
    squares += rows * error * error * psi_square;
    slopes += joint.slopes;
  }
  out.sigma = std::sqrt(squares / slopes);
  return out;
}

Matrix bread_from_slopes(const Matrix& curvature, const Matrix& bread) {
  return solve(bread * curvature, bread);
}

double robust_deviation(std::span<const RobustSums> sums, const RowLoss& loss,
                        std::span<const double> weights) {
  double squares = 0.0;
  for (std::size_t j = 0; j < sums.size(); ++j) {
    squares += static_cast<double>(sums[j].rows) * std::pow(weights[j] * loss.scales[j], 2);
  }
  return std::sqrt(squares / all_rows(sums));
}

}  // namespace rivid::detail
