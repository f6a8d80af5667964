#include "identify/check/torque_probe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "dense.hpp"
#include "identify/check/checks.hpp"
#include "identify/rows/position_noise.hpp"
#include "identify/rows/row_source.hpp"
#include "ranges.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "signal/window_decimator.hpp"

namespace rivid::detail {

namespace {

// Samples of all logs that the model is compared with.
constexpr Index probe_samples = 1600;
// Of which each joint has this part at least, as far as it moves.
constexpr Index fewest_part = 6;
// A joint with fewer rows of motion than its columns times this is not tested.
constexpr Index rows_per_column = 3;
// A torque of which so much is left (squared) tells no sign of its joint.
constexpr double mostly_noise = 0.5;
// Samples at each end of a piece of log that its differences and averages spoil.
constexpr Index settled = 2;
// Windows are made wider until noise is this part of each joint's mean square acceleration, or a log holds so
// few of them.
constexpr double little_noise = 0.01;
constexpr Index noise_samples = 2000;   // in the middle of a joint's motion, for its noise
constexpr Index least_windows = 40;     // of the shortest log; a choice: fewer leave too few rows to compare
constexpr Index steps_of_motion = 200;  // of a log; any number that resolves where its motion is
// Of the instants one in so many serves for a first look.
constexpr Index some_step = 4;
// Of a log where joints have their turns, every other one makes a half.
constexpr Index stretches_by_turns = 40;
constexpr Index poses = 32;            // of which inertias are a mean; a choice
constexpr unsigned probe_seed = 1687;  // any: it only makes results repeat

// The sample before which half of the squares of a joint's steps are made: no pause, however long, holds it.
Index middle_of_motion(const Eigen::Ref<const Vector>& q) {
  const Index step = std::max<Index>(q.size() / steps_of_motion, 1);
  std::vector<double> done = {0.0};
  for (Index k = step; k < q.size(); k += step) {
    done.push_back(done.back() + std::pow(q[k] - q[k - step], 2));
  }
  return step * (std::ranges::lower_bound(done, 0.5 * done.back()) - done.begin());
}

// Samples that the windows are apart if they stand half over each other: as in the rows of the estimate, but
// no less than noise asks for.
Index probe_stride(std::span<const Log> logs, const SignalOptions& signal) {
  Index shortest = logs.front().samples();
  for (const Log& log : logs) {
    shortest = std::min(shortest, log.samples());
  }
  const Index widest = std::max<Index>(shortest / least_windows, 1);
  Index out = std::clamp<Index>(stride_of(signal), 1, widest);
  for (const Log& log : logs) {
    for (Index j = 0; j < log.q.cols(); ++j) {
      if (stands_still(log.q.col(j))) {
        continue;
      }
      const Index some = std::min(log.samples(), noise_samples);
      const Index first =
          std::clamp<Index>(middle_of_motion(log.q.col(j)) - some / 2, 0, log.samples() - some);
      const PositionNoise noise(log.q.col(j).segment(first, some), log.f_m);
      const auto share = [&](Index n_d) {
        SignalOptions windowed;
        windowed.decimation = {static_cast<int>(n_d)};
        return noise.in(RowBand(windowed, log.f_m)).acceleration / noise.motion();
      };
      while (out < widest && share(out) > little_noise) {
        out = std::min(out + std::max<Index>(out / 2, 1), widest);
      }
    }
  }
  return out;
}

// Where a joint moves one way throughout a window.
class OneWay {
 public:
  OneWay(std::vector<std::int8_t> direction, Index window)
      : direction_(std::move(direction)), lasts_(direction_.size(), 0), window_(window) {
    for (std::size_t k = 0; k < lasts_.size(); ++k) {
      const bool goes_on = k > 0 && direction_[k] == direction_[k - 1];
      lasts_[k] = direction_[k] == 0 ? 0 : (goes_on ? lasts_[k - 1] : 0) + 1;
    }
  }

  // Around sample k.
  [[nodiscard]] bool at(Index k) const {
    return lasts_[static_cast<std::size_t>(k - window_ / 2 + window_ - 1)] >= window_;
  }

 private:
  std::vector<std::int8_t> direction_;
  std::vector<Index> lasts_;  // samples for which the direction has been the same
  Index window_;
};

}  // namespace

std::vector<Index> rows_that(const Eigen::Ref<const Eigen::Array<bool, Eigen::Dynamic, 1>>& hold) {
  return places_where(hold.size(), [&](Index k) { return hold[k]; });
}

std::vector<Index> spread(const std::vector<Index>& samples, Index most) {
  const std::size_t step = std::max<std::size_t>(1, samples.size() / static_cast<std::size_t>(most));
  std::vector<Index> out;
  for (std::size_t i = 0; i < samples.size(); i += step) {
    out.push_back(samples[i]);
  }
  return out;
}

TorqueProbe::TorqueProbe(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                         const SignalOptions& signal)
    : robot_(robot),
      base_(base),
      samples_of_log_(std::max<Index>(1, probe_samples / static_cast<Index>(logs.size()))) {
  const Index n_d = probe_stride(logs, signal);
  half_width_ = n_d + settled;
  window_ = decimation_window(n_d);
  const Index width = 2 * half_width_ + 1;
  const auto kernel = [&](const Matrix& impulses) -> Vector {
    return impulses.middleRows(settled + 1, window_.size()).transpose() * window_;
  };
  Matrix torque = Matrix::Identity(width, width);
  const Motion motion = averaged_motion(torque, 1.0);
  average_torque(torque, signal.held());
  position_kernel_ = kernel(motion.q);
  velocity_kernel_ = kernel(motion.qd);
  acceleration_kernel_ = kernel(motion.qdd);
  torque_kernel_ = kernel(torque);
  for (const Log& log : logs) {
    add(log, signal);
  }
  by_turns_ = by_turns();
  told_factors_ = factors(as_told());
}

Reading TorqueProbe::as_told() const {
  const Index n = robot_.size();
  Reading out{.position = std::vector<Index>(static_cast<std::size_t>(n)),
              .position_scale = Vector::Ones(n),
              .position_offset = Vector::Zero(n),
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

void TorqueProbe::add(const Log& log, const SignalOptions& signal) {
  ProbedLog out;
  out.log = &log;
  const Index n = robot_.size();
  const Index inner = window_.size();
  SignalOptions masking;
  masking.velocity_threshold = signal.velocity_threshold;
  masking.decimation = {static_cast<int>((inner + 1) / 2)};
  std::vector<OneWay> one_way;
  for (MotionMask& mask : motion_masks(robot_, log.q, log.q, log.f_m, masking)) {
    one_way.emplace_back(std::move(mask.direction), inner);
  }
  std::vector<Index> all;
  std::vector<Index> moving;  // a pause tells of holding alone, however long it is
  std::vector<std::vector<Index>> of_joint(one_way.size());
  for (Index k = half_width_; k < log.samples() - half_width_; ++k) {
    all.push_back(k);
    bool any = false;
    for (std::size_t j = 0; j < one_way.size(); ++j) {
      if (one_way[j].at(k)) {
        any = true;
        of_joint[j].push_back(k);
      }
    }
    if (any) {
      moving.push_back(k);
    }
  }
  out.samples = spread(moving.empty() ? all : moving, samples_of_log_);
  // A joint that has its turn for a short time has more of it.
  const Index fewest = samples_of_log_ / fewest_part;
  for (std::size_t j = 0; j < one_way.size(); ++j) {
    const Index have = std::ranges::count_if(out.samples, [&](Index k) { return one_way[j].at(k); });
    if (have < fewest && have < std::ssize(of_joint[j])) {
      const std::vector<Index> more = spread(of_joint[j], fewest);
      out.samples.insert(out.samples.end(), more.begin(), more.end());
    }
  }
  std::ranges::sort(out.samples);
  out.samples.erase(std::ranges::unique(out.samples).begin(), out.samples.end());
  out.motion = {Matrix(out.size(), n), Matrix(out.size(), n), Matrix(out.size(), n)};
  out.moves.resize(out.size(), n);
  for (Index i = 0; i < out.size(); ++i) {
    const Index k = out.samples[static_cast<std::size_t>(i)];
    const auto around = log.q.middleRows(k - half_width_, 2 * half_width_ + 1);
    out.motion.q.row(i).noalias() = position_kernel_.transpose() * around;
    out.motion.qd.row(i).noalias() = log.f_m * (velocity_kernel_.transpose() * around);
    out.motion.qdd.row(i).noalias() = log.f_m * log.f_m * (acceleration_kernel_.transpose() * around);
    for (Index j = 0; j < n; ++j) {
      out.moves(i, j) = one_way[static_cast<std::size_t>(j)].at(k);
    }
  }
  out.tau = torques_at(out, instants_of(out, Part::all), 0);
  probed_.push_back(std::move(out));
}

Observation TorqueProbe::averaged_observation(const ProbedLog& log, std::span<const Index> instants) const {
  const auto count = static_cast<Index>(instants.size());
  const RegressorBatch batch(robot_, base_.columns());
  RegressorBlock block(batch, window_.size());
  Observation out{.columns = base_.size(), .joints = {}};
  for (std::size_t j = 0; j < batch.joints(); ++j) {
    out.joints.push_back({batch.of_joint(j), Matrix(count, static_cast<Index>(batch.of_joint(j).size()))});
  }
  for (Index i = 0; i < count; ++i) {
    const Index k = log.samples[static_cast<std::size_t>(instants[static_cast<std::size_t>(i)])];
    const Motion around =
        averaged_motion(log.log->q.middleRows(k - half_width_, 2 * half_width_ + 1), log.log->f_m);
    batch.fill(around, settled + 1, window_.size(), block);
    for (std::size_t j = 0; j < batch.joints(); ++j) {
      out.joints[j].W.row(i).noalias() = window_.transpose() * block.W(j);
    }
  }
  // Noise turns the sign of single velocities, not that of their average.
  const Motion averages = {log.motion.q(instants, Eigen::all), log.motion.qd(instants, Eigen::all),
                           log.motion.qdd(instants, Eigen::all)};
  const Observation of_averages = observation(robot_, base_, averages);
  for (std::size_t j = 0; j < batch.joints(); ++j) {
    for (std::size_t c = 0; c < out.joints[j].columns.size(); ++c) {
      const auto leading = static_cast<std::size_t>(out.joints[j].columns[c]);
      if (role(base_.parameters[leading].leading.kind) == Role::dry) {
        const auto column = static_cast<Index>(c);
        out.joints[j].W.col(column) = of_averages.joints[j].W.col(column);
      }
    }
  }
  return out;
}

Matrix TorqueProbe::torques_at(const ProbedLog& log, std::span<const Index> instants, Index shift) const {
  const Index last = log.log->samples() - half_width_ - 1;
  const bool measured = log.log->tau.size() > 0;
  const Matrix& signal = measured ? log.log->tau : log.log->v_tau;
  Matrix out(std::ssize(instants), robot_.size());
  for (Index i = 0; i < out.rows(); ++i) {
    const auto instant = static_cast<std::size_t>(instants[static_cast<std::size_t>(i)]);
    const Index k = std::clamp(log.samples[instant] + shift, half_width_, last);
    out.row(i).noalias() =
        torque_kernel_.transpose() * signal.middleRows(k - half_width_, 2 * half_width_ + 1);
  }
  return measured ? out : Matrix(out * robot_.drive_matrix().transpose());
}

Motion TorqueProbe::motion_at(const ProbedLog& log, const Reading& reading) const {
  const auto picked = [&](const Matrix& x) {
    Matrix out = x(Eigen::all, reading.position);
    out *= reading.position_scale.asDiagonal();
    return out;
  };
  Matrix q = picked(log.motion.q);
  q.rowwise() += reading.position_offset.transpose();
  return {std::move(q), picked(log.motion.qd), picked(log.motion.qdd)};
}

std::vector<Index> TorqueProbe::instants_of(const ProbedLog& log, Part part) const {
  const Index stretches = by_turns_ ? stretches_by_turns : 2;
  std::vector<Index> out;
  for (Index i = 0; i < log.size(); i += part == Part::some ? some_step : 1) {
    const bool second = i * stretches / log.size() % 2 == 1;
    if (part == Part::all || part == Part::some || second == (part == Part::second_half)) {
      out.push_back(i);
    }
  }
  return out;
}

bool TorqueProbe::by_turns() const {
  // of a joint's moving instants in each half, else halves are taken by turns; a choice
  constexpr double least_share = 0.15;
  for (Index j = 0; j < robot_.size(); ++j) {
    double first = 0.0;
    double all = 0.0;
    for (const ProbedLog& log : probed_) {
      first += static_cast<double>(log.moves.col(j).head(log.size() / 2).count());
      all += static_cast<double>(log.moves.col(j).count());
    }
    if (std::min(first, all - first) < least_share * all) {
      return true;
    }
  }
  return false;
}

TorqueProbe::Rows TorqueProbe::rows(const Reading& reading, Part part) const {
  const Robot robot = robot_with(reading.gravity);
  Rows out;
  for (const ProbedLog& log : probed_) {
    const std::vector<Index> instants = instants_of(log, part);
    const Motion motion = motion_at(log, reading);
    out.W.push_back(observation(
        robot, base_,
        {motion.q(instants, Eigen::all), motion.qd(instants, Eigen::all), motion.qdd(instants, Eigen::all)}));
    out.tau.emplace_back(log.tau(instants, Eigen::all));
    out.moves.emplace_back(log.moves(instants, Eigen::all));
  }
  return out;
}

std::vector<Index> TorqueProbe::Rows::moving(std::size_t log, Index position_column) const {
  return rows_that(moves[log].col(position_column));
}

JointFactor TorqueProbe::factor(const Reading& reading, const Rows& rows, std::size_t joint) const {
  const Index n = robot_.size();
  const std::vector<Index>& columns = rows.W.front().joints[joint].columns;
  StreamingQr qr(static_cast<Index>(columns.size()), n);
  Vector sums = Vector::Zero(n);
  Vector squares = Vector::Zero(n);
  for (std::size_t l = 0; l < probed_.size(); ++l) {
    const std::vector<Index> places = rows.moving(l, reading.position[joint]);
    const Matrix tau = rows.tau[l](places, Eigen::all);
    sums += tau.colwise().sum().transpose();
    squares += tau.colwise().squaredNorm().transpose();
    qr.add(rows.W[l].joints[joint].W(places, Eigen::all), tau);
  }
  const auto count = static_cast<double>(std::max<Index>(qr.rows(), 1));
  return {.columns = columns,
          .R = qr.R(),
          .Z = qr.qt_carried(),
          .rest = qr.unreachable_norms().cwiseAbs2(),
          .centred = squares - sums.cwiseAbs2() / count,
          .rows = qr.rows()};
}

Index TorqueProbe::wanted(const JointFactor& factor) { return rows_per_column * factor.R.cols(); }

bool TorqueProbe::usable(const JointFactor& factor, Index torque) {
  return factor.rows >= wanted(factor) && factor.centred[torque] > 0.0;
}

std::vector<JointFactor> TorqueProbe::factors(const Reading& reading, Part part) const {
  const Rows some = rows(reading, part);
  return made_of(robot_.joints.size(), [&](std::size_t j) { return factor(reading, some, j); });
}

std::optional<ProbeScore> TorqueProbe::score_below(const Reading& reading, Part part, double most,
                                                   std::span<const Index> order) const {
  const Rows some = rows(reading, part);
  std::vector<JointFactor> factors(robot_.joints.size());
  double least = 0.0;
  for (const Index joint : order) {
    const auto j = static_cast<std::size_t>(joint);
    factors[j] = factor(reading, some, j);
    const Index torque = reading.torque[j];
    least += usable(factors[j], torque) ? factors[j].rest[torque] / factors[j].centred[torque] : 0.0;
    // The mean is over no more joints than there are.
    if (least >= most * static_cast<double>(robot_.size())) {
      return std::nullopt;
    }
  }
  return score_below(reading, most, factors);
}

std::optional<ProbeScore> TorqueProbe::score_below(const Reading& reading, double most,
                                                   const std::vector<JointFactor>& factors) const {
  double least = 0.0;
  double joints = 0.0;
  for (std::size_t j = 0; j < factors.size(); ++j) {
    const Index torque = reading.torque[j];
    if (usable(factors[j], torque)) {
      least += factors[j].rest[torque] / factors[j].centred[torque];
      joints += 1.0;
    }
  }
  if (least >= most * std::max(joints, 1.0)) {
    return std::nullopt;
  }
  ProbeScore out = score(reading, factors);
  return out.total < most ? std::optional(std::move(out)) : std::nullopt;
}

ProbeScore TorqueProbe::score(const Reading& reading, const std::vector<JointFactor>& factors) const {
  const Index n = robot_.size();
  const Index b = base_.size();
  Matrix A = Matrix::Zero(b * n, b);
  Vector y = Vector::Zero(b * n);
  Index row = 0;
  for (std::size_t j = 0; j < factors.size(); ++j) {
    if (!usable(factors[j], reading.torque[j])) {
      continue;
    }
    const JointFactor& f = factors[j];
    const double unit = reading.torque_sign[static_cast<Index>(j)];
    const double weight = 1.0 / std::sqrt(unit * unit * f.centred[reading.torque[j]]);
    A(Eigen::seqN(row, f.R.rows()), f.columns) = weight * f.R;
    y.segment(row, f.R.rows()) = weight * unit * f.Z.col(reading.torque[j]);
    row += f.R.rows();
  }
  Vector scale = A.colwise().norm();
  scale = scale.unaryExpr([](double s) { return s > 0.0 ? s : 1.0; });
  const Index rows = std::max<Index>(row, 1);
  ProbeScore out;
  // The long factorisation by the fast kernel, the one that decides about rank on its triangle.
  StreamingQr qr(b, 1);
  qr.add(A.topRows(rows) * scale.cwiseInverse().asDiagonal(), y.head(rows));
  out.chi = scale.cwiseInverse().cwiseProduct(minimum_norm_solution(qr.R(), qr.qty(), 1e-6));
  out.left = Vector::Constant(n, -1.0);
  out.wrong.assign(factors.size(), 0);
  const Vector M = inertias(out.chi).diagonal();
  double count = 0.0;
  for (std::size_t j = 0; j < factors.size(); ++j) {
    if (!usable(factors[j], reading.torque[j])) {
      continue;
    }
    const JointFactor& f = factors[j];
    const auto at = static_cast<Index>(j);
    const Vector chi = out.chi(f.columns);
    const Vector r = reading.torque_sign[at] * f.Z.col(reading.torque[j]) - f.R * chi;
    const double square = reading.torque_sign[at] * reading.torque_sign[at];
    out.left[at] = (r.squaredNorm() / square + f.rest[reading.torque[j]]) / f.centred[reading.torque[j]];
    out.total += out.left[at];
    count += 1.0;
    out.wrong[j] = out.left[at] < mostly_noise && M[at] < 0.0 && !dissipates(out.chi, at, reading) &&
                           shows(M[at], at, reading, f)
                       ? 1
                       : 0;
  }
  out.total /= std::max(count, 1.0);
  return out;
}

HalfScores TorqueProbe::halves(const Reading& reading) const {
  const std::array factors_of = {factors(reading, Part::first_half), factors(reading, Part::second_half)};
  const std::array scores = {score(reading, factors_of[0]), score(reading, factors_of[1])};
  HalfScores out;
  double joints = 0.0;
  for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
    out.faults += scores[0].wrong[j] == 1 && scores[1].wrong[j] == 1 ? 1 : 0;
    const Index column = reading.torque[j];
    for (std::size_t half = 0; half < 2; ++half) {
      const JointFactor& f = factors_of[half][j];
      if (f.rows == 0 || !(f.centred[column] > 0.0)) {
        continue;
      }
      const Vector r = f.Z.col(column) -
                       f.R * scores[1 - half].chi(f.columns) / reading.torque_sign[static_cast<Index>(j)];
      // A half that says nothing of what the other one needs counts as unexplained, not as worse than that.
      out.left += std::min(1.0, (r.squaredNorm() + f.rest[column]) / f.centred[column]);
      joints += 1.0;
    }
  }
  out.left /= std::max(joints, 1.0);
  return out;
}

bool TorqueProbe::shows(double inertia, Index joint, const Reading& reading,
                        const JointFactor& factor) const {
  // rms of inertia's torque over that of the joint's; a choice: below it friction covers it
  constexpr double part = 0.03;
  const auto j = static_cast<std::size_t>(joint);
  const Index column = reading.position[j];
  double squares = 0.0;
  double count = 0.0;
  for (const ProbedLog& log : probed_) {
    squares += (reading.position_scale[joint] * log.motion.qdd.col(column)).squaredNorm();
    count += static_cast<double>(log.size());
  }
  const double unit = reading.torque_sign[joint];
  const double torque = unit * unit * factor.centred[reading.torque[j]] / static_cast<double>(factor.rows);
  return inertia * inertia * squares / std::max(count, 1.0) > part * part * torque;
}

bool TorqueProbe::dissipates(const Vector& chi, Index joint, const Reading& reading) const {
  // Of each function of friction, per unit of its coefficient.
  std::array<double, basis_rows.size()> power_of{};
  for (const ProbedLog& log : probed_) {
    const auto v = log.motion.qd.col(reading.position[static_cast<std::size_t>(joint)]);
    for (const BasisRow& row : basis_rows) {
      // Of no instants Eigen's mean() reads what is not there.
      if (v.size() > 0 && (row.role == Role::viscous || row.role == Role::dry)) {
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
  Matrix q = Matrix::NullaryExpr(poses, n, [&]() { return turn(random); });
  for (Index k = 0; k < poses; ++k) {
    robot_.chain.into_reach([&](int j) -> double& { return q(k, j); });
  }
  // At rest, and with each joint accelerated alone, one after the other.
  Motion motion{q.replicate(n + 1, 1), Matrix::Zero((n + 1) * poses, n), Matrix::Zero((n + 1) * poses, n)};
  for (Index k = 0; k < n; ++k) {
    motion.qdd.col(k).segment((k + 1) * poses, poses).setOnes();
  }
  const Observation W = observation(robot_with(Eigen::Vector3d::Zero()), base_, motion);
  Matrix M(n, n);
  for (Index i = 0; i < n; ++i) {
    const JointRows& rows = W.joints[static_cast<std::size_t>(i)];
    const Vector torques = rows.W * chi(rows.columns);
    const double rest = torques.head(poses).mean();
    for (Index k = 0; k < n; ++k) {
      M(i, k) = torques.segment((k + 1) * poses, poses).mean() - rest;
    }
  }
  return M;
}

Vector TorqueProbe::left_at(const Reading& reading, const std::vector<Index>& shifts, Part part) const {
  const auto count = static_cast<Index>(shifts.size());
  const Rows some = rows(reading, part);
  std::vector<std::vector<Matrix>> shifted(probed_.size());  // torques of each log at each shift
  for (std::size_t l = 0; l < probed_.size(); ++l) {
    for (const Index shift : shifts) {
      shifted[l].push_back(torques_at(probed_[l], instants_of(probed_[l], part), shift));
    }
  }
  Vector out = Vector::Zero(count);
  double joints = 0.0;
  for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
    StreamingQr qr(some.W.front().joints[j].W.cols(), count);
    double sum = 0.0;
    double square = 0.0;
    for (std::size_t l = 0; l < probed_.size(); ++l) {
      const std::vector<Index> places = some.moving(l, reading.position[j]);
      Matrix tau(static_cast<Index>(places.size()), count);
      for (Index s = 0; s < count; ++s) {
        tau.col(s) = shifted[l][static_cast<std::size_t>(s)].col(reading.torque[j])(places);
      }
      const Vector now = some.tau[l].col(reading.torque[j])(places);
      sum += now.sum();
      square += now.squaredNorm();
      qr.add(some.W[l].joints[j].W(places, Eigen::all), tau);
    }
    const double centred = square - sum * sum / static_cast<double>(std::max<Index>(qr.rows(), 1));
    if (qr.rows() >= rows_per_column * qr.columns() && centred > 0.0) {
      out += (qr.unreachable_norms().cwiseAbs2() / centred).array().log().matrix();
      joints += 1.0;
    }
  }
  return (out / std::max(joints, 1.0)).array().exp();
}

}  // namespace rivid::detail
