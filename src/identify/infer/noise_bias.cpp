#include "identify/infer/noise_bias.hpp"

#include <algorithm>
#include <cmath>

#include "dense.hpp"
#include "identify/rows/row_source.hpp"
#include "ranges.hpp"
#include "rivid/model/kinds.hpp"
#include "rivid/regressor/batch.hpp"

namespace rivid::detail {

namespace {

// Samples of a log that stand for all.
constexpr Index most_samples = 150;
// Step of a velocity, of which W is quadratic but for friction that is none of the laws' columns left out
// [rad/s | m/s].
constexpr double velocity_step = 1e-3;

class Regressors {
 public:
  Regressors(const Robot& robot, const BaseParameters& base, Index samples)
      : batch_(robot, base.columns()), block_(batch_, std::max<Index>(samples, 1)) {}

  // W of each joint's rows.
  std::vector<Matrix> at(const Motion& motion) {
    batch_.fill(motion, 0, motion.samples(), block_);
    return made_of(batch_.joints(), [&](std::size_t i) { return Matrix(block_.W(i)); });
  }

  [[nodiscard]] const RegressorBatch& batch() const { return batch_; }

 private:
  RegressorBatch batch_;
  RegressorBlock block_;
};

// Dry friction jumps, and the masks of rows keep away from its jumps.
void clear_dry(const BaseParameters& base, const std::vector<Index>& columns, Matrix& W) {
  const std::vector<StandardParameter> parameters = base.columns();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (role(parameters[static_cast<std::size_t>(columns[c])].kind) == Role::dry) {
      W.col(static_cast<Index>(c)).setZero();
    }
  }
}

// Mean over some samples of Σ_j E_j (M⁻¹)_ji for each joint i, where M_ij = E_j χ is the mass matrix.
std::vector<Vector> mean_responses(const std::vector<std::vector<Matrix>>& E,
                                   const std::vector<std::vector<Index>>& columns, const Vector& chi) {
  const std::size_t n = E.size();
  std::vector<Vector> out =
      made_of(n, [&](std::size_t i) { return Vector(Vector::Zero(static_cast<Index>(columns[i].size()))); });
  constexpr Index step = 2;  // every other sample; a choice that halves the time of a mean
  double count = 0.0;
  for (Index k = 0; k < E[0][0].rows(); k += step) {
    Matrix M(n, n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        M(static_cast<Index>(i), static_cast<Index>(j)) = E[j][i].row(k).dot(chi(columns[i]));
      }
    }
    // Early estimates are no robots everywhere.
    const SymmetricEigen eigen = symmetric_eigen(M);
    if (!(eigen.values[0] > 0.0)) {
      continue;
    }
    const Matrix inverse =
        eigen.vectors * eigen.values.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        out[i] += inverse(static_cast<Index>(j), static_cast<Index>(i)) * E[j][i].row(k).transpose();
      }
    }
    ++count;
  }
  for (Vector& response : out) {
    response /= std::max(count, 1.0);
  }
  return out;
}

// Mean of Eᵀ E χ over rows that move.
Vector mean_product(const Matrix& E, const std::vector<Index>& moving, const Vector& chi) {
  const Matrix kept = E(moving, Eigen::all);
  const Vector product = kept * chi;
  Vector out = kept.transpose() * product;
  out /= static_cast<double>(std::max<std::size_t>(moving.size(), 1));
  return out;
}

}  // namespace

Motion some_motion(const Log& log, const SignalOptions& signal) {
  const Index half = std::max<Index>(stride_of(signal), 1);
  const Index count = std::clamp<Index>(log.samples() - 2 * half, 0, most_samples);
  const double rate = log.f_m / static_cast<double>(half);
  Motion out{Matrix(count, log.q.cols()), Matrix(count, log.q.cols()), Matrix(count, log.q.cols())};
  for (Index k = 0; k < count; ++k) {
    const Index at = half + k * (log.samples() - 2 * half) / count;
    out.q.row(k) = log.q.row(at);
    out.qd.row(k) = (log.q.row(at + half) - log.q.row(at - half)) * (0.5 * rate);
    out.qdd.row(k) = (log.q.row(at + half) - 2.0 * log.q.row(at) + log.q.row(at - half)) * (rate * rate);
  }
  return out;
}

std::vector<std::vector<PositionNoise>> position_noise(std::span<const Log> logs) {
  return made_of(logs, [](const Log& log) {
    return made_of(log.q.cols(), [&](Index j) { return PositionNoise(log.q.col(j), log.f_m); });
  });
}

NoiseSensitivity::NoiseSensitivity(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                                   std::span<const SignalOptions> signals, const RowFactors& data,
                                   const Vector& chi)
    : b_(base.size()), chi_(chi) {
  const auto n = static_cast<std::size_t>(robot.size());
  for (const RowGroup& group : data.groups) {
    columns_.push_back(group.columns);
    rows_.push_back(static_cast<double>(group.qr.rows()));
  }
  shares_.assign(n, {});
  for (std::size_t l = 0; l < logs.size(); ++l) {
    Motion motion = some_motion(logs[l], signals[l]);
    motion.qdd.setZero();
    Regressors regressors(robot, base, motion.samples());
    std::vector<std::vector<Index>> moving(n);
    for (std::size_t i = 0; i < n; ++i) {
      moving[i] = places_where(motion.samples(), [&](Index k) {
        return std::abs(motion.qd(k, static_cast<Index>(i))) >= data.thresholds[i];
      });
      shares_[i].push_back(static_cast<double>(moving[i].size()) * static_cast<double>(logs[l].samples()) /
                           static_cast<double>(std::max<Index>(motion.samples(), 1)));
    }
    std::vector<std::vector<Means>>& means = means_.emplace_back(n);
    Motion probe = motion;
    probe.qd.setZero();
    const std::vector<Matrix> at_rest = regressors.at(probe);
    std::vector<std::vector<Matrix>> E;  // [joint of the noise][joint of the row]
    for (std::size_t j = 0; j < n; ++j) {
      const auto column = static_cast<Index>(j);
      probe.qdd.col(column).setOnes();
      std::vector<Matrix> by_acceleration = regressors.at(probe);
      probe.qdd.col(column).setZero();
      Motion faster = motion;
      faster.qd.col(column).array() += velocity_step;
      std::vector<Matrix> by_velocity = regressors.at(faster);
      faster.qd.col(column).array() -= 2.0 * velocity_step;
      const std::vector<Matrix> slower = regressors.at(faster);
      for (std::size_t i = 0; i < n; ++i) {
        by_acceleration[i] -= at_rest[i];
        by_velocity[i] = (by_velocity[i] - slower[i]) / (2.0 * velocity_step);
        clear_dry(base, columns_[i], by_velocity[i]);
        const Vector own = chi(columns_[i]);
        means[i].push_back(
            {mean_product(by_acceleration[i], moving[i], own), mean_product(by_velocity[i], moving[i], own)});
      }
      E.push_back(std::move(by_acceleration));
    }
    responses_.push_back(mean_responses(E, columns_, chi));
  }
  for (std::vector<double>& shares : shares_) {
    const double sum = sum_of(shares, std::identity());
    for (double& share : shares) {
      share /= sum > 0.0 ? sum : 1.0;
    }
  }
}

NoiseSensitivity::Effect NoiseSensitivity::effect(std::span<const std::vector<DerivativeNoise>> noise,
                                                  std::span<const double> weights) const {
  Effect out{Vector::Zero(b_), std::vector<double>(rows_.size(), 0.0)};
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Vector own = chi_(columns_[i]);
    Vector D_chi = Vector::Zero(own.size());
    for (std::size_t l = 0; l < means_.size(); ++l) {
      for (std::size_t j = 0; j < noise[l].size(); ++j) {
        const Means& means = means_[l][i][j];
        D_chi += shares_[i][l] *
                 (noise[l][j].acceleration * means.acceleration + noise[l][j].velocity * means.velocity);
      }
    }
    out.mean_squares[i] = own.dot(D_chi);
    out.D_chi(columns_[i]) += rows_[i] * weights[i] * weights[i] * D_chi;
  }
  return out;
}

Vector NoiseSensitivity::disturbance(std::span<const double> mean_squares,
                                     std::span<const double> weights) const {
  Vector out = Vector::Zero(b_);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    for (std::size_t l = 0; l < responses_.size(); ++l) {
      out(columns_[i]) +=
          shares_[i][l] * rows_[i] * weights[i] * weights[i] * mean_squares[i] * responses_[l][i];
    }
  }
  return out;
}

Vector noise_bias(const EstimationProblem& problem, const Estimate& estimate, const Vector& chi) {
  const std::vector<std::vector<PositionNoise>> noise = position_noise(problem.logs);
  const NoiseSensitivity sensitivity(problem.robot, problem.base, problem.logs, estimate.signals,
                                     problem.data, chi);
  std::vector<std::vector<DerivativeNoise>> in_rows;
  for (std::size_t l = 0; l < noise.size(); ++l) {
    const RowBand band(estimate.signals[l], problem.logs[l].f_m);
    in_rows.push_back(made_of(noise[l], [&](const PositionNoise& one) { return one.in(band); }));
  }
  const Vector D_chi = sensitivity.effect(in_rows, estimate.weights).D_chi;
  return -finite_part(estimate.bread) * D_chi;
}

}  // namespace rivid::detail
