#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "identify/infer/infer.hpp"
#include "identify/infer/noise_bias.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/signal/decimate.hpp"

namespace rivid::detail {

namespace {

// Instants that stand for a motion, and what they are drawn by.
constexpr Index drawn_instants = 300;
constexpr unsigned motion_seed = 1805;

// Mean square of the accelerations of each joint, that of the noise left out.
Vector squared_accelerations(std::span<const Log> logs, Index n) {
  Vector out = Vector::Zero(n);
  double samples = 0.0;
  const std::vector<std::vector<PositionNoise>> noise = position_noise(logs);
  for (std::size_t l = 0; l < logs.size(); ++l) {
    const auto own = static_cast<double>(logs[l].samples());
    for (Index j = 0; j < n; ++j) {
      out[j] += own * noise[l][static_cast<std::size_t>(j)].motion();
    }
    samples += own;
  }
  return out / samples;
}

Motion random_motion(std::span<const Log> logs, Index n) {
  const SquaredVelocities v = squared_velocities(logs, n);
  const Vector qd = (v.sums / std::max(v.count, 1.0)).cwiseSqrt();
  const Vector qdd = squared_accelerations(logs, n).cwiseSqrt();
  Vector low = Vector::Constant(n, std::numeric_limits<double>::infinity());
  Vector high = -low;
  for (const Log& log : logs) {
    low = low.cwiseMin(log.q.colwise().minCoeff().transpose());
    high = high.cwiseMax(log.q.colwise().maxCoeff().transpose());
  }
  std::mt19937_64 random(motion_seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  Motion out{Matrix(drawn_instants, n), Matrix(drawn_instants, n), Matrix(drawn_instants, n)};
  for (Index k = 0; k < drawn_instants; ++k) {
    for (Index j = 0; j < n; ++j) {
      out.q(k, j) = low[j] + uniform(random) * (high[j] - low[j]);
      out.qd(k, j) = qd[j] * normal(random);
      out.qdd(k, j) = qdd[j] * normal(random);
    }
  }
  return out;
}

}  // namespace

TorqueForecast expected_error(std::span<const RowGroup> rows, const Matrix& C, const Fit& fit) {
  TorqueForecast out{.joints = Vector::Constant(std::ssize(rows), std::numeric_limits<double>::quiet_NaN())};
  if (fit.joints.size() != rows.size()) {
    return out;  // of a model that was not fitted to rows of this robot
  }
  double errors = 0.0;
  double torques = 0.0;
  for (std::size_t j = 0; j < rows.size(); ++j) {
    const RowGroup& group = rows[j];
    const Matrix R = group.qr.R();
    const double by_parameters = (R * C(group.columns, group.columns)).cwiseProduct(R).sum();
    const double residual = group.qr.rows() > 0 ? fit.joints[j].sigma_rho : 0.0;
    const double squares = by_parameters + static_cast<double>(group.qr.rows()) * residual * residual;
    const double torque = group.qr.y_norm();
    // Nothing times infinity is no number.
    const double error = std::isfinite(squares) ? squares : std::numeric_limits<double>::infinity();
    out.joints[static_cast<Index>(j)] = std::sqrt(error) / torque;
    errors += error;
    torques += torque * torque;
  }
  out.relative_error = std::sqrt(errors / torques);
  return out;
}

TorqueForecast expected_error(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                              const Vector& chi, const Matrix& C, const Fit& fit) {
  std::vector<RowGroup> rows;
  for (const JointRows& joint : observation(robot, base, random_motion(logs, robot.size())).joints) {
    RowGroup& group = rows.emplace_back(RowGroup{joint.columns, StreamingQr(std::ssize(joint.columns))});
    group.qr.add(joint.W, joint.W * chi(joint.columns));
  }
  return expected_error(rows, C, fit);
}

namespace {

// Sums of squares of what a model leaves of a joint's torques, and of these, decimated alike. Decimation is
// linear: that of two series is that of all columns of W.
class ErrorSink final : public BufferedSink {
 public:
  ErrorSink(Vector chi, int n_d) : BufferedSink(chi.size() + 1), chi_(std::move(chi)) {
    if (n_d > 1) {
      decimator_.emplace(2, n_d);
    }
  }

  void commit(std::span<const Index> samples) override {
    const Index count = std::ssize(samples);
    const auto Y = rows_.col(chi_.size()).head(count);
    Matrix both(count, 2);
    both << Y - rows_.topLeftCorner(count, chi_.size()) * chi_, Y;
    add(decimator_ ? decimator_->add(both) : both);
  }
  // Of the error and of the torque, once all rows are there.
  [[nodiscard]] Eigen::Array2d squares() {
    if (decimator_) {
      add(decimator_->finish());
    }
    return squares_;
  }

 private:
  void add(const Matrix& rows) { squares_ += rows.colwise().squaredNorm().transpose().array(); }

  Vector chi_;
  std::optional<StreamingDecimator> decimator_;
  Eigen::Array2d squares_ = {0.0, 0.0};
};

}  // namespace

double reference_error(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                       const Vector& chi, ThreadTeam& team) {
  constexpr double cutoff_hz = 10.0;  // a choice: above the motion of arms, below most noise of accelerations
  constexpr double rows_hz = 50.0;    // five times the cut-off; a choice
  constexpr double of_rate = 0.2;     // at most
  if (!chi.allFinite()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const BaseParameters torques = has_load(robot) ? at_load(base, chi) : base;
  Eigen::Array2d squares = {0.0, 0.0};
  try {
    for (const Log& log : logs) {
      SignalOptions signal;
      signal.rows = RowScheme::paper;
      signal.cutoff_hz = std::min(cutoff_hz, of_rate * log.f_m);
      RowSource rows(robot, torques, log, signal, team);
      const int n_d = static_cast<int>(std::lround(log.f_m / rows_hz));
      JointSinks<ErrorSink> sinks(rows.joints(),
                                  [&](std::size_t j) { return ErrorSink(chi(rows.columns(j)), n_d); });
      rows.send(sinks.sinks());
      for (std::size_t j = 0; j < rows.joints(); ++j) {
        squares += sinks[j].squares();
      }
    }
  } catch (const InputError&) {
    return std::numeric_limits<double>::quiet_NaN();  // too short for the filter
  }
  return std::sqrt(squares[0] / squares[1]);
}

}  // namespace rivid::detail
