// Torques against what one set of parameters can make of the motion; and, where that fails, against motions and torques
// with one thing changed: the change that mends the fit, or makes inertia and friction positive, is what was wrong.

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "identify/check_parts.hpp"
#include "identify/exact_rows.hpp"
#include "rivid/identify/signal_chain.hpp"
#include "rivid/regressor/observation.hpp"
#include "rivid/signal/differentiate.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/signal/zero_phase.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Samples of all logs that the model is compared with.
constexpr Index probe_samples = 1600;
// A joint with fewer rows of motion than its columns times this tells nothing.
constexpr Index rows_per_column = 3;
// Squared part of a joint's torque that the model leaves: from here on something is looked for, and from there on it is
// told even where nothing is found.
constexpr double suspicious = 0.003;
constexpr double hopeless = 0.5;
// A change is believed where it leaves this part of what was left, or where it mends signs and makes nothing worse.
constexpr double convincing = 0.4;
constexpr double no_worse = 1.05;
constexpr double tie = 1.005;
// A delay is believed where it leaves this part of what was left (squared), and is so many samples long.
constexpr double delay_convincing = 0.6;
constexpr double least_delay_samples = 2.0;
constexpr double longest_delay = 0.3;  // [s]
// It does harm where so much is left, or where it is behind most of what is left.
constexpr double harmless_delay = 0.01;
constexpr double harmful_gain = 0.4;
// Sizes that differ from the a-priori ones by such factors are another unit, or another clock.
constexpr double wrong_unit = 8.0;
constexpr double wrong_clock = 20.0;  // of inertia against gravity: the square of the clock's factor
// Part of the torques that gravity, or inertia, must make up to be compared.
constexpr double visible = 0.1;
// Mass that moves with a joint, as inertia over its squared reach, beyond which no arm is [kg].
constexpr double lightest = 0.01;
constexpr double heaviest = 1500.0;
constexpr Index poses = 32;
constexpr unsigned pose_seed = 1687;

// The motion of a log, filtered, and its torques, at all samples.
struct ProbedLog {
  Motion motion;
  Matrix tau;                     // (n_m × n)
  std::vector<MotionMask> masks;  // where each joint moves
  std::vector<Index> samples;     // that rows are made of
  double f_m = 0.0;
};

// A way to read the log: which column is which joint, with which sign and unit, and where gravity points.
struct Reading {
  std::vector<Index> position;  // column of each joint
  Vector position_scale;
  std::vector<Index> torque;
  Vector torque_sign;
  Eigen::Vector3d gravity;
};

// A change of a reading and what it would be called.
struct Change {
  std::string_view code;
  std::string subject;
  std::string text;
  Reading reading;
};

// The rows of one joint, with the torque columns of all joints.
struct JointFactor {
  std::vector<Index> columns;
  Matrix R;
  Matrix Z;        // Qᵀ tau, (columns × n)
  Vector rest;     // squared norm of what no parameters reach, (n)
  Vector centred;  // squared norm of each torque with its mean taken off, (n)
  Index rows = 0;
};

// How well a reading fits.
struct Score {
  Vector chi;
  Vector left;                      // squared part of each joint's torque that is left, (n); −1 without rows
  std::vector<std::uint8_t> wrong;  // joints whose inertia and friction are negative
  double total = 0.0;               // mean of `left`

  [[nodiscard]] Index faults() const { return std::ranges::count(wrong, 1); }
};

class Probe {
 public:
  Probe(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
        const CheckOptions& options)
      : robot_(robot), base_(base), logs_(logs) {
    for (const Log& log : logs) {
      add(log, options);
    }
  }

  [[nodiscard]] Reading as_told() const {
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

  [[nodiscard]] std::vector<JointFactor> factors(const Reading& reading) const;
  [[nodiscard]] Score score(const Reading& reading, const std::vector<JointFactor>& factors) const;
  [[nodiscard]] Score score(const Reading& reading) const { return score(reading, factors(reading)); }
  // Squared part of its torque that each joint leaves by itself, mean over joints, for torques that come `shift` samples
  // later; a number for each shift.
  [[nodiscard]] Vector left_at(const Reading& reading, const std::vector<Index>& shifts) const;
  [[nodiscard]] const std::vector<ProbedLog>& logs() const { return probed_; }
  [[nodiscard]] Matrix inertias(const Vector& chi) const;
  [[nodiscard]] Robot robot_with(const Eigen::Vector3d& gravity) const {
    Robot out = robot_;
    out.chain.gravity = gravity;
    return out;
  }
  [[nodiscard]] Motion motion_at(const ProbedLog& log, const Reading& reading) const;
  [[nodiscard]] std::vector<Index> moving_rows(const ProbedLog& log, Index position_column) const;

 private:
  void add(const Log& log, const CheckOptions& options);
  [[nodiscard]] bool dissipates(const Vector& chi, Index joint, const Reading& reading) const;

  const Robot& robot_;
  const BaseParameters& base_;
  std::span<const Log> logs_;
  std::vector<ProbedLog> probed_;
};

void Probe::add(const Log& log, const CheckOptions& options) {
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
  out.tau = zero_phase(averaged_torque(effort(robot_, log), signal.torque_held), filter);
  out.masks = motion_masks(robot_, log.q, q, log.f_m, signal);
  const Index border = std::min(settling_samples(filter) + 2, log.samples() / 4);
  const Index count = log.samples() - 2 * border;
  const Index wanted = std::max<Index>(1, probe_samples / static_cast<Index>(logs_.size()));
  const Index stride = std::max<Index>(1, count / wanted);
  for (Index k = border; k < border + count; k += stride) {
    const double t = log.t[k];
    if (!options.signal.window || (t >= (*options.signal.window)[0] && t <= (*options.signal.window)[1])) {
      out.samples.push_back(k);
    }
  }
  probed_.push_back(std::move(out));
}

Motion Probe::motion_at(const ProbedLog& log, const Reading& reading) const {
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

// Places in log.samples where the joint of that column moves.
std::vector<Index> Probe::moving_rows(const ProbedLog& log, Index position_column) const {
  std::vector<Index> out;
  const MotionMask& mask = log.masks[static_cast<std::size_t>(position_column)];
  for (std::size_t k = 0; k < log.samples.size(); ++k) {
    if (mask.moving[static_cast<std::size_t>(log.samples[k])] != 0) {
      out.push_back(static_cast<Index>(k));
    }
  }
  return out;
}

std::vector<JointFactor> Probe::factors(const Reading& reading) const {
  const Index n = robot_.size();
  const Robot robot = robot_with(reading.gravity);
  std::vector<Observation> W;
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

Score Probe::score(const Reading& reading, const std::vector<JointFactor>& factors) const {
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
  Eigen::CompleteOrthogonalDecomposition<Matrix> solver;
  solver.setThreshold(1e-6);
  solver.compute(A.topRows(std::max<Index>(row, 1)) * scale.cwiseInverse().asDiagonal());
  Score out;
  out.chi = scale.cwiseInverse().cwiseProduct(solver.solve(y.head(std::max<Index>(row, 1))));
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

// Whether friction takes power from a joint's motion; a joint without friction does not say no.
bool Probe::dissipates(const Vector& chi, Index joint, const Reading& reading) const {
  double speed = 0.0;
  double square = 0.0;
  for (const ProbedLog& log : probed_) {
    const auto v = log.motion.qd.col(reading.position[static_cast<std::size_t>(joint)]);
    speed += v.cwiseAbs().mean();
    square += v.squaredNorm() / static_cast<double>(v.size());
  }
  double power = 0.0;
  for (std::size_t i = 0; i < base_.parameters.size(); ++i) {
    const StandardParameter& p = base_.parameters[i].leading;
    if (p.joint != joint) {
      continue;
    }
    switch (p.kind) {
      using enum ParameterKind;
      case Fv:
        power += chi[static_cast<Index>(i)] * square;
        break;
      case Fc:
        power += chi[static_cast<Index>(i)] * speed;
        break;
      case Fv_plus:
      case Fv_minus:
        power += 0.5 * chi[static_cast<Index>(i)] * square;
        break;
      case Fc_plus:
      case Fc_minus:
        power += 0.5 * chi[static_cast<Index>(i)] * speed;
        break;
      default:
        break;
    }
  }
  return power > 0.0;
}

// Mean of M(q) over random poses, (n × n).
Matrix Probe::inertias(const Vector& chi) const {
  const Index n = robot_.size();
  std::mt19937_64 random(pose_seed);
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

Vector Probe::left_at(const Reading& reading, const std::vector<Index>& shifts) const {
  const auto count = static_cast<Index>(shifts.size());
  const Robot robot = robot_with(reading.gravity);
  Vector out = Vector::Zero(count);
  double joints = 0.0;
  std::vector<Observation> W;
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

std::string joint_name(const Robot& robot, Index j) { return robot.joints[static_cast<std::size_t>(j)].name; }

std::string base_name(const Robot& robot) { return robot.base.empty() ? "base" : robot.base; }

// Every single change of a reading that is looked at. Those that change torques alone come first: they win ties.
std::vector<Change> changes(const Robot& robot, const Reading& reading) {
  const Index n = robot.size();
  std::vector<Change> out;
  Reading all = reading;
  all.torque_sign *= -1.0;
  for (Index j = 0; j < n; ++j) {
    Reading r = reading;
    r.torque_sign[j] *= -1.0;
    out.push_back({"torque_sign", joint_name(robot, j), "its torque has the other sign", r});
  }
  if (n > 1) {
    out.push_back({"torque_sign", "all joints", "all torques have the other sign", all});
  }
  for (Index j = 0; j < n; ++j) {
    Reading r = reading;
    r.position_scale[j] *= -1.0;
    out.push_back({"position_sign", joint_name(robot, j), "its position has the other sign", r});
  }
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < j; ++i) {
      const auto a = static_cast<std::size_t>(i);
      const auto b = static_cast<std::size_t>(j);
      const std::string pair = joint_name(robot, i) + " and " + joint_name(robot, j);
      Reading torques = reading;
      std::swap(torques.torque[a], torques.torque[b]);
      std::swap(torques.torque_sign[i], torques.torque_sign[j]);
      Reading positions = reading;
      std::swap(positions.position[a], positions.position[b]);
      std::swap(positions.position_scale[i], positions.position_scale[j]);
      Reading both = torques;
      both.position = positions.position;
      both.position_scale = positions.position_scale;
      out.push_back({"torque_order", pair, "their torques are exchanged", torques});
      out.push_back({"position_order", pair, "their positions are exchanged", positions});
      out.push_back({"joint_order", pair, "positions and torques are exchanged", both});
    }
  }
  if (n > 2) {
    Reading reversed = reading;
    std::ranges::reverse(reversed.position);
    std::ranges::reverse(reversed.torque);
    reversed.position_scale.reverseInPlace();
    reversed.torque_sign.reverseInPlace();
    out.push_back({"joint_order", "all joints", "the columns run from tip to base", reversed});
  }
  const double degree = std::numbers::pi / 180.0;
  for (const double scale : {degree, 1.0 / degree}) {
    Reading every = reading;
    for (Index j = 0; j < n; ++j) {
      if (robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute) {
        Reading r = reading;
        r.position_scale[j] *= scale;
        every.position_scale[j] *= scale;
        out.push_back(
            {"position_unit", joint_name(robot, j),
             scale < 1.0 ? "its position is in degrees" : "its position was turned from degrees twice", r});
      }
    }
    out.push_back({"position_unit", "all joints",
                   scale < 1.0 ? "positions are in degrees" : "positions were turned from degrees twice",
                   every});
  }
  const double g = reading.gravity.norm() > 0.0 ? reading.gravity.norm() : 9.80665;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Reading r = reading;
      r.gravity = sign * g * Eigen::Vector3d::Unit(axis);
      if (!r.gravity.isApprox(reading.gravity)) {
        const char* const name = axis == 0 ? "x" : axis == 1 ? "y" : "z";
        out.push_back(
            {"gravity_direction", base_name(robot),
             std::string("gravity points along ") + (sign < 0.0 ? "-" : "+") + name + " of the base", r});
      }
    }
  }
  return out;
}

bool only_torques(std::string_view code) { return code == "torque_sign" || code == "torque_order"; }

// Signs of a torque and of its position are hard to tell apart where a joint hardly feels the others.
std::string rival(const Probe& probe, const Change& best, const Score& score, const Reading& before) {
  constexpr double nearly_as_well = 1.5;
  const bool torque = best.code == "torque_sign";
  if ((!torque && best.code != "position_sign") || best.subject == "all joints") {
    return "";
  }
  Reading other = before;
  (torque ? other.position_scale : other.torque_sign) =
      torque ? Vector(before.position_scale.cwiseProduct(
                   best.reading.torque_sign.cwiseProduct(before.torque_sign)))
             : Vector(before.torque_sign.cwiseProduct(
                   best.reading.position_scale.cwiseProduct(before.position_scale).cwiseSign()));
  const Score rivals = probe.score(other);
  return rivals.faults() == score.faults() && rivals.total < nearly_as_well * score.total
             ? std::string("; the other sign of its ") + (torque ? "position" : "torque") +
                   " does nearly as well"
             : "";
}

// Upside down, gravity turns the signs of first moments, which inertia hardly notices.
void check_gravity(const Probe& probe, const Robot& robot, const Reading& reading, Findings& out) {
  constexpr double clearly_better = 0.8;
  if (out.has("gravity_direction") || reading.gravity.norm() == 0.0) {
    return;
  }
  Reading other = reading;
  other.gravity *= -1.0;
  const Score now = probe.score(reading);
  const Score upside_down = probe.score(other);
  if (upside_down.faults() <= now.faults() && upside_down.total < clearly_better * now.total) {
    out.add("gravity_direction", base_name(robot),
            "gravity points the other way: the model then leaves " +
                number(100.0 * std::sqrt(upside_down.total), 2) + " % of the torques instead of " +
                number(100.0 * std::sqrt(now.total), 2) + " %");
  }
}

// Looks for changes of the reading that mend what is wrong, one after the other; the reading that is believed at last.
Reading mended(const Probe& probe, const Robot& robot, Findings& out) {
  Reading reading = probe.as_told();
  for (Index round = 0; round <= robot.size(); ++round) {
    const std::vector<JointFactor> factors = probe.factors(reading);
    const Score now = probe.score(reading, factors);
    if (now.left.maxCoeff() < suspicious && now.faults() == 0) {
      break;
    }
    std::optional<Change> best;
    Score best_score;
    for (Change& change : changes(robot, reading)) {
      const Score score =
          only_torques(change.code) ? probe.score(change.reading, factors) : probe.score(change.reading);
      const bool mends_fit = score.total < convincing * now.total && score.faults() <= now.faults();
      const bool mends_signs = score.faults() < now.faults() && score.total < no_worse * now.total;
      if (!mends_fit && !mends_signs) {
        continue;
      }
      const bool better = !best || score.faults() < best_score.faults() ||
                          (score.faults() == best_score.faults() && tie * score.total < best_score.total);
      if (better) {
        best_score = score;
        best = std::move(change);
      }
    }
    if (!best) {
      break;
    }
    // A unit is told once, even where single joints were seen to leave their limits.
    const bool told =
        best->code == "position_unit" ? out.has_error(best->code) : out.has(best->code, best->subject);
    if (!told) {
      out.add(best->code, best->subject,
              best->text + ": the model then leaves " + number(100.0 * std::sqrt(best_score.total), 2) +
                  " % of the torques instead of " + number(100.0 * std::sqrt(now.total), 2) + " %" +
                  (best_score.faults() < now.faults() ? ", and inertia and friction are positive" : "") +
                  rival(probe, *best, best_score, reading));
    }
    reading = best->reading;
  }
  return reading;
}

// Shifts of torques by whole samples, closer together near zero.
std::vector<Index> shifts_for(double f_m) {
  std::vector<Index> out = {0};
  const auto longest = static_cast<Index>(longest_delay * f_m);
  for (Index s = 1; s <= longest; s = std::max(s + 1, s + s / 6)) {
    out.push_back(s);
    out.push_back(-s);
  }
  return out;
}

struct Delay {
  Index samples = 0;
  double left = 0.0;
};

Delay least_left(const Probe& probe, const Reading& reading, const std::vector<Index>& shifts) {
  const Vector left = probe.left_at(reading, shifts);
  Index at = 0;
  const double least = left.minCoeff(&at);
  return {shifts[static_cast<std::size_t>(at)], least};
}

void check_delay(const Probe& probe, const Reading& reading, Findings& out) {
  const double f_m = probe.logs().front().f_m;
  const double now = probe.left_at(reading, {0})[0];
  const Delay coarse = least_left(probe, reading, shifts_for(f_m));
  if (coarse.samples == 0 || coarse.left > delay_convincing * now) {
    return;
  }
  std::vector<Index> around;
  const Index width = std::min<Index>(std::abs(coarse.samples) / 6 + 1, 16);
  for (Index s = coarse.samples - width; s <= coarse.samples + width; ++s) {
    around.push_back(s);
  }
  const Delay found = least_left(probe, reading, around);
  if (std::abs(static_cast<double>(found.samples)) < least_delay_samples) {
    return;
  }
  // Where the torques are explained well all the same, a delay changes little.
  const bool harms = now > harmless_delay || found.left < harmful_gain * now;
  const Severity severity = harms ? Severity::error : Severity::note;
  out.add("torque_delay", "all joints",
          "torques are " + counted(std::abs(found.samples), "sample") + " (" +
              number(std::abs(static_cast<double>(found.samples)) / f_m, 2) + " s) " +
              (found.samples > 0 ? "behind" : "ahead of") + " the motion: the model then leaves " +
              number(100.0 * std::sqrt(found.left), 2) + " % of them instead of " +
              number(100.0 * std::sqrt(now), 2) + " %",
          severity,
          (found.samples > 0 ? "Add " : "Take ") + std::to_string(std::abs(found.samples)) +
              (found.samples > 0 ? " to" : " from") + " [log] torque_lag.");
}

void check_unexplained(const Robot& robot, const Score& score, Findings& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    if (score.left[j] > hopeless) {
      out.add("unexplained_torque", joint_name(robot, j),
              "the model leaves " + number(100.0 * std::sqrt(score.left[j]), 2) +
                  " % of its torque (mean taken off)");
    }
  }
}

// Factors of the a-priori model that the torques ask for.
struct Sizes {
  double gravity = 0.0;  // 0 where gravity is not seen, or nothing is known
  double inertia = 0.0;
  double dry_friction = 0.0;
};

bool knows_inertias(const Robot& robot) {
  return std::ranges::all_of(robot.inertials, [](const Inertial& i) { return i[inertial_count - 1] > 0.0; });
}

// One factor for the a-priori gravity and one for the a-priori inertia of all joints, beside friction and rotor inertia
// of each joint.
Sizes sizes(const Probe& probe, const Robot& robot, const BaseParameters& base, const Reading& reading) {
  const Index n = robot.size();
  Robot frictionless = robot;
  for (Joint& joint : frictionless.joints) {
    joint.Fv = joint.Fc = joint.Ia = 0.0;
  }
  const Vector chi = base.from_standard(frictionless.chi_st());
  constexpr Index own = 4;  // q̇, sign q̇, 1, q̈
  StreamingQr qr(2 + own * n, 1);
  double gravity = 0.0;
  double inertia = 0.0;
  double all = 0.0;
  for (const ProbedLog& log : probe.logs()) {
    const Motion motion = probe.motion_at(log, reading);
    const Matrix none = Matrix::Zero(motion.q.rows(), n);
    const Robot loaded = probe.robot_with(reading.gravity);
    const Observation full = observation(loaded, base, motion);
    const Observation poses_only = observation(loaded, base, {motion.q, none, none});
    for (Index j = 0; j < n; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const std::vector<Index> rows = probe.moving_rows(log, reading.position[at]);
      const auto count = static_cast<Index>(rows.size());
      const Vector own_chi = chi(full.joints[at].columns);
      const Vector held = poses_only.joints[at].W * own_chi;
      const Vector moved = full.joints[at].W * own_chi - held;
      Vector tau(count);
      for (Index k = 0; k < count; ++k) {
        tau[k] = reading.torque_sign[j] *
                 log.tau(log.samples[static_cast<std::size_t>(rows[static_cast<std::size_t>(k)])],
                         reading.torque[at]);
      }
      const double scale = tau.norm() > 0.0 ? 1.0 / tau.norm() : 0.0;
      Matrix W = Matrix::Zero(count, qr.columns());
      W.col(0) = held(rows);
      W.col(1) = moved(rows);
      const Vector v = motion.qd.col(j)(rows);
      W.col(2 + own * j) = v;
      W.col(3 + own * j) = v.cwiseSign();
      W.col(4 + own * j).setOnes();
      if (robot.joints[at].rotor_inertia) {
        W.col(5 + own * j) = motion.qdd.col(j)(rows);
      }
      qr.add(scale * W, scale * tau);
      gravity += (scale * W.col(0)).squaredNorm();
      inertia += (scale * W.col(1)).squaredNorm();
      all += 1.0;
    }
  }
  const Matrix R = qr.R();
  Vector norms = R.colwise().norm();
  norms = norms.unaryExpr([](double x) { return x > 0.0 ? x : 1.0; });
  Eigen::CompleteOrthogonalDecomposition<Matrix> solver;
  solver.setThreshold(1e-6);
  solver.compute(R * norms.cwiseInverse().asDiagonal());
  const Vector x = norms.cwiseInverse().cwiseProduct(solver.solve(qr.qty()));
  const auto seen = [&](double factor, double square) {
    return std::isfinite(factor) && std::abs(factor) * std::sqrt(square / all) > visible ? factor : 0.0;
  };
  // Geometric mean over the joints whose dry friction the description tells.
  double logarithms = 0.0;
  double told = 0.0;
  for (Index j = 0; j < n; ++j) {
    const double Fc = robot.joints[static_cast<std::size_t>(j)].Fc;
    const double fitted = x[3 + own * j];
    if (Fc > 0.0 && fitted > 0.0) {
      logarithms += std::log(fitted / Fc);
      told += 1.0;
    }
  }
  return {.gravity = seen(x[0], gravity),
          .inertia = seen(x[1], inertia),
          .dry_friction = told > 0.0 ? std::exp(logarithms / told) : 0.0};
}

bool mended_already(const Findings& found) {
  return std::ranges::any_of(std::array{"gravity_direction", "torque_sign", "position_sign", "torque_order",
                                        "position_order", "joint_order"},
                             [&](const char* code) { return found.has(code); });
}

bool off_by(double factor, double limit) { return factor > limit || factor < 1.0 / limit; }

void check_sizes(const Probe& probe, const Robot& robot, const BaseParameters& base, const Reading& reading,
                 Findings& out) {
  const std::string all = "all joints";
  if (out.has("torque_unit") || out.has("time_scale")) {
    return;
  }
  if (knows_inertias(robot)) {
    const Sizes found = sizes(probe, robot, base, reading);
    if (found.gravity < -visible && !mended_already(out)) {
      out.add("gravity_direction", base_name(robot),
              "torques ask for " + number(found.gravity, 2) + " times the weight of the a-priori masses");
    }
    // What does not depend on the clock, as far as it is known.
    const bool by_gravity = found.gravity > 0.0;
    const double timeless = by_gravity ? found.gravity : found.dry_friction;
    const double torque = timeless > 0.0 ? timeless : found.inertia;
    if (torque > 0.0 && off_by(torque, wrong_unit)) {
      out.add("torque_unit", all,
              "torques ask for " + number(torque, 2) + " times the a-priori " +
                  (by_gravity       ? "masses"
                   : timeless > 0.0 ? "dry friction"
                                    : "inertias; or the clock is wrong by " + number(std::sqrt(torque), 2)));
    }
    if (timeless > 0.0 && found.inertia > 0.0 && off_by(found.inertia / timeless, wrong_clock)) {
      const double clock = std::sqrt(found.inertia / timeless);
      out.add("time_scale", all,
              "against " + std::string(by_gravity ? "gravity" : "dry friction") + " inertia is " +
                  number(found.inertia / timeless, 2) +
                  " times that of the a-priori model: the rate would be " +
                  number(probe.logs().front().f_m * clock, 2) + " Hz");
    }
    return;
  }
  const Matrix M = probe.inertias(probe.score(reading).chi);
  double mass = 0.0;
  for (Index j = 0; j < robot.size(); ++j) {
    double reach = 0.2;
    for (std::size_t k = static_cast<std::size_t>(j) + 1; k < robot.chain.links.size(); ++k) {
      reach += robot.chain.links[k].p.norm();
    }
    const bool turns = robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute;
    mass = std::max(mass, M(j, j) / (turns ? reach * reach : 1.0));
  }
  if (mass > heaviest || (mass > 0.0 && mass < lightest)) {
    out.add("torque_unit", all, "torques ask for a mass of some " + number(mass, 2) + " kg for this reach");
  }
}

}  // namespace

void check_torques(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                   const CheckOptions& options, Findings& out) {
  if (out.has("at_rest") || out.has("dead_torque") || out.has("duplicate_column")) {
    return;
  }
  const Probe probe(robot, base, logs, options);
  const Reading reading = mended(probe, robot, out);
  check_gravity(probe, robot, reading, out);
  check_delay(probe, reading, out);
  check_sizes(probe, robot, base, reading, out);
  check_unexplained(robot, probe.score(reading), out);
}

}  // namespace rivid::detail
