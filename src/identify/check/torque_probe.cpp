#include "identify/check/torque_probe.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "dense.hpp"
#include "identify/check/findings.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/solve/streaming_qr.hpp"

namespace rivid::detail {

namespace {

// Samples of all logs that the model is compared with.
constexpr Index probe_samples = 1600;
// A joint with fewer rows of motion than its columns times this tells nothing.
constexpr Index rows_per_column = 3;
constexpr Index poses = 32;
constexpr unsigned probe_seed = 1687;

}  // namespace

TorqueProbe::TorqueProbe(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                         const CheckOptions& options)
    : robot_(robot),
      base_(base),
      samples_of_log_(std::max<Index>(1, probe_samples / static_cast<Index>(logs.size()))) {
  for (const Log& log : logs) {
    add(log, options);
  }
}

Reading TorqueProbe::as_told() const {
  const Index n = robot_.size();
  Reading out{.position = std::vector<Index>(static_cast<std::size_t>(n)),
              .position_scale = Vector::Ones(n),
              .torque = std::vector<Index>(static_cast<std::size_t>(n)),
              .torque_sign = Vector::Ones(n),
              .gravity = robot_.chain.gravity};
  for (Index j = 0; j < n; ++j) {
    out.position[static_cast<std::size_t>(j)] = j;
    out.torque[static_cast<std::size_t>(j)] = j;
  }
  return out;
}

Robot TorqueProbe::robot_with(const Eigen::Vector3d& gravity) const {
  Robot out = robot_;
  out.chain.gravity = gravity;
  return out;
}

void TorqueProbe::add(const Log& log, const CheckOptions& options) {
  SignalOptions signal = options.signal;
  if (!cutoff_serves(log, signal)) {
    signal.cutoff_hz = suitable_cutoff(log);
    signal.order = 4;
  }
  signal.torque_cutoff_hz = 0.0;
  const Filter filter = butterworth(signal.order, signal.cutoff_hz, log.f_m);
  ProbedLog out;
  out.f_m = log.f_m;
  const Matrix q = zero_phase(log.q, filter);
  out.motion = differentiate(q, log.f_m);
  Matrix tau = effort(robot_, log);
  average_torque(tau, signal.held());
  out.tau = zero_phase(tau, filter);
  out.masks = motion_masks(robot_, log.q, q, log.f_m, signal);
  const Index border = std::min(settling_samples(filter) + 2, log.samples() / 4);
  const Index count = log.samples() - 2 * border;
  const Index stride = std::max<Index>(1, count / samples_of_log_);
  for (Index k = border; k < border + count; k += stride) {
    const double t = log.t[k];
    if (!options.signal.window || (t >= (*options.signal.window)[0] && t <= (*options.signal.window)[1])) {
      out.samples.push_back(k);
    }
  }
  probed_.push_back(std::move(out));
}

Motion TorqueProbe::motion_at(const ProbedLog& log, const Reading& reading) const {
  const auto picked = [&](const Matrix& x) {
    Matrix out(static_cast<Index>(log.samples.size()), robot_.size());
    for (Index j = 0; j < robot_.size(); ++j) {
      const Index column = reading.position[static_cast<std::size_t>(j)];
      for (std::size_t k = 0; k < log.samples.size(); ++k) {
        out(static_cast<Index>(k), j) = reading.position_scale[j] * x(log.samples[k], column);
      }
    }
    return out;
  };
  return {picked(log.motion.q), picked(log.motion.qd), picked(log.motion.qdd)};
}

std::vector<Index> TorqueProbe::moving_rows(const ProbedLog& log, Index position_column) const {
  std::vector<Index> out;
  const MotionMask& mask = log.masks[static_cast<std::size_t>(position_column)];
  for (std::size_t k = 0; k < log.samples.size(); ++k) {
    if (mask.direction[static_cast<std::size_t>(log.samples[k])] != 0) {
      out.push_back(static_cast<Index>(k));
    }
  }
  return out;
}

std::vector<JointFactor> TorqueProbe::factors(const Reading& reading) const {
  const Index n = robot_.size();
  const Robot robot = robot_with(reading.gravity);
  std::vector<Observation> W;
  W.reserve(probed_.size());
  for (const ProbedLog& log : probed_) {
    W.push_back(observation(robot, base_, motion_at(log, reading)));
  }
  std::vector<JointFactor> out;
  for (std::size_t j = 0; j < static_cast<std::size_t>(n); ++j) {
    const Index columns = W.front().joints[j].W.cols();
    StreamingQr qr(columns, n);
    Vector sums = Vector::Zero(n);
    Vector squares = Vector::Zero(n);
    for (std::size_t l = 0; l < probed_.size(); ++l) {
      const ProbedLog& log = probed_[l];
      const std::vector<Index> rows = moving_rows(log, reading.position[j]);
      const Matrix of_joint = W[l].joints[j].W(rows, Eigen::all);
      Matrix tau(static_cast<Index>(rows.size()), n);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        tau.row(static_cast<Index>(k)) = log.tau.row(log.samples[static_cast<std::size_t>(rows[k])]);
      }
      sums += tau.colwise().sum().transpose();
      squares += tau.colwise().squaredNorm().transpose();
      qr.add(of_joint, tau);
    }
    const auto count = static_cast<double>(std::max<Index>(qr.rows(), 1));
    out.push_back({.columns = W.front().joints[j].columns,
                   .R = qr.R(),
                   .Z = qr.qt_carried(),
                   .rest = qr.unreachable_norms().cwiseAbs2(),
                   .centred = squares - sums.cwiseAbs2() / count,
                   .rows = qr.rows()});
  }
  return out;
}

ProbeScore TorqueProbe::score(const Reading& reading, const std::vector<JointFactor>& factors) const {
  const Index n = robot_.size();
  const Index b = base_.size();
  const auto usable = [&](std::size_t j) {
    const JointFactor& f = factors[j];
    return f.rows >= rows_per_column * f.R.cols() && f.centred[reading.torque[j]] > 0.0;
  };
  Matrix A = Matrix::Zero(b * n, b);
  Vector y = Vector::Zero(b * n);
  Index row = 0;
  for (std::size_t j = 0; j < factors.size(); ++j) {
    if (!usable(j)) {
      continue;
    }
    const JointFactor& f = factors[j];
    const double weight = 1.0 / std::sqrt(f.centred[reading.torque[j]]);
    for (std::size_t c = 0; c < f.columns.size(); ++c) {
      A.col(f.columns[c]).segment(row, f.R.rows()) = weight * f.R.col(static_cast<Index>(c));
    }
    y.segment(row, f.R.rows()) =
        weight * reading.torque_sign[static_cast<Index>(j)] * f.Z.col(reading.torque[j]);
    row += f.R.rows();
  }
  Vector scale = A.colwise().norm();
  scale = scale.unaryExpr([](double s) { return s > 0.0 ? s : 1.0; });
  const Index rows = std::max<Index>(row, 1);
  ProbeScore out;
  out.chi = scale.cwiseInverse().cwiseProduct(
      minimum_norm_solution(A.topRows(rows) * scale.cwiseInverse().asDiagonal(), y.head(rows), 1e-6));
  out.left = Vector::Constant(n, -1.0);
  out.wrong.assign(factors.size(), 0);
  const Vector M = inertias(out.chi).diagonal();
  double count = 0.0;
  for (std::size_t j = 0; j < factors.size(); ++j) {
    if (!usable(j)) {
      continue;
    }
    const JointFactor& f = factors[j];
    const auto at = static_cast<Index>(j);
    Vector chi(f.R.cols());
    for (std::size_t c = 0; c < f.columns.size(); ++c) {
      chi[static_cast<Index>(c)] = out.chi[f.columns[c]];
    }
    const Vector r = reading.torque_sign[at] * f.Z.col(reading.torque[j]) - f.R * chi;
    out.left[at] = (r.squaredNorm() + f.rest[reading.torque[j]]) / f.centred[reading.torque[j]];
    out.total += out.left[at];
    count += 1.0;
    out.wrong[j] = M[at] < 0.0 && !dissipates(out.chi, at, reading) ? 1 : 0;
  }
  out.total /= std::max(count, 1.0);
  return out;
}

bool TorqueProbe::dissipates(const Vector& chi, Index joint, const Reading& reading) const {
  // Of each function of friction, per unit of its coefficient.
  std::array<double, basis_rows.size()> power_of{};
  for (const ProbedLog& log : probed_) {
    const auto v = log.motion.qd.col(reading.position[static_cast<std::size_t>(joint)]);
    for (const BasisRow& row : basis_rows) {
      if (row.role == Role::viscous || row.role == Role::dry) {
        power_of[static_cast<std::size_t>(row.basis)] +=
            v.unaryExpr([&](double x) { return x * friction_function(row.basis, x, sign(x)); }).mean();
      }
    }
  }
  double power = 0.0;
  for (std::size_t i = 0; i < base_.parameters.size(); ++i) {
    const StandardParameter& p = base_.parameters[i].leading;
    const KindRow& row = about(p.kind);
    if (p.joint == joint && !row.coupled) {
      const double share = row.direction == Direction::both ? 1.0 : 0.5;
      power += share * chi[static_cast<Index>(i)] * power_of[static_cast<std::size_t>(row.basis)];
    }
  }
  return power > 0.0;
}

Matrix TorqueProbe::inertias(const Vector& chi) const {
  const Index n = robot_.size();
  std::mt19937_64 random(probe_seed);
  std::uniform_real_distribution<double> turn(-std::numbers::pi, std::numbers::pi);
  const Matrix q = Matrix::NullaryExpr(poses, n, [&]() { return turn(random); });
  const Robot weightless = robot_with(Eigen::Vector3d::Zero());
  const auto torques = [&](const Matrix& qdd) {
    const Observation W = observation(weightless, base_, {q, Matrix::Zero(poses, n), qdd});
    Vector out(n);
    for (Index i = 0; i < n; ++i) {
      const JointRows& rows = W.joints[static_cast<std::size_t>(i)];
      out[i] = (rows.W * chi(rows.columns)).mean();
    }
    return out;
  };
  const Vector rest = torques(Matrix::Zero(poses, n));
  Matrix M(n, n);
  for (Index k = 0; k < n; ++k) {
    Matrix qdd = Matrix::Zero(poses, n);
    qdd.col(k).setOnes();
    M.col(k) = torques(qdd) - rest;
  }
  return M;
}

Vector TorqueProbe::left_at(const Reading& reading, const std::vector<Index>& shifts) const {
  const auto count = static_cast<Index>(shifts.size());
  const Robot robot = robot_with(reading.gravity);
  Vector out = Vector::Zero(count);
  double joints = 0.0;
  std::vector<Observation> W;
  W.reserve(probed_.size());
  for (const ProbedLog& log : probed_) {
    W.push_back(observation(robot, base_, motion_at(log, reading)));
  }
  for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
    StreamingQr qr(W.front().joints[j].W.cols(), count);
    double sum = 0.0;
    double square = 0.0;
    for (std::size_t l = 0; l < probed_.size(); ++l) {
      const ProbedLog& log = probed_[l];
      const std::vector<Index> rows = moving_rows(log, reading.position[j]);
      Matrix tau(static_cast<Index>(rows.size()), count);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const Index sample = log.samples[static_cast<std::size_t>(rows[k])];
        for (Index s = 0; s < count; ++s) {
          const Index shifted =
              std::clamp<Index>(sample + shifts[static_cast<std::size_t>(s)], 0, log.tau.rows() - 1);
          tau(static_cast<Index>(k), s) = log.tau(shifted, reading.torque[j]);
        }
        sum += log.tau(sample, reading.torque[j]);
        square += std::pow(log.tau(sample, reading.torque[j]), 2);
      }
      qr.add(W[l].joints[j].W(rows, Eigen::all), tau);
    }
    const double centred = square - sum * sum / static_cast<double>(std::max<Index>(qr.rows(), 1));
    if (qr.rows() >= rows_per_column * qr.columns() && centred > 0.0) {
      out += qr.unreachable_norms().cwiseAbs2() / centred;
      joints += 1.0;
    }
  }
  return out / std::max(joints, 1.0);
}

}  // namespace rivid::detail
