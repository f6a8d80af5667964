#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/online/plausible.hpp"
#include "rivid/online/saved_state.hpp"
#include "rivid/regressor/regressor.hpp"
#include "rivid/text.hpp"

namespace rivid {

/// How the ticks of a control loop become rows.
struct RowStreamOptions {
  double f_m = 1000.0;  ///< ticks a second [Hz]
  /// Ticks from one row of a joint to the next; a row is a Hann window of twice as many. 0: 25 ms, at least 5
  /// ticks: windows of fewer hardly average the noise of accelerations, and the direction of motion is that
  /// of neighbouring ticks.
  Index stride = 0;
  bool torque_held = true;  ///< whether the torque of a tick acts until the next one, as a command does
  /// Speeds below which a joint has no rows, (n) [rad/s | m/s]. Empty: those of the model.
  Vector velocity_threshold = {};
  /// The direction of motion is that of q[k + s] − q[k − s]: noise of the positions must not reverse it.
  /// Every tick of s delays all rows by one. 0: a quarter of the stride, at least 1.
  Index velocity_span = 0;

  [[nodiscard]] std::optional<std::string> complaint(Index joints) const {
    constexpr double largest_f_m = 1e7;   // [Hz] any large value: windows stay finite
    constexpr Index longest = 1'000'000;  // all ticks of a window are kept
    if (!std::isfinite(f_m) || f_m <= 0.0 || f_m > largest_f_m) {
      return "f_m is " + number(f_m) + " Hz, must be positive" +
             (f_m > largest_f_m ? " and at most " + number(largest_f_m) : "");
    }
    if (stride < 0 || velocity_span < 0 || stride > longest || velocity_span > longest) {
      return "stride is " + std::to_string(stride) + " and velocity_span " + std::to_string(velocity_span) +
             " ticks, must not be negative" +
             (stride > longest || velocity_span > longest ? " and at most " + std::to_string(longest) : "");
    }
    if (velocity_threshold.size() != joints && velocity_threshold.size() != 0) {
      return "velocity_threshold has " + counted(velocity_threshold.size(), "value") + ", must have " +
             std::to_string(joints) + ", one a joint";
    }
    if (velocity_threshold.hasNaN() || (velocity_threshold.array() < 0.0).any()) {
      return "velocity_threshold must not be negative";
    }
    return std::nullopt;
  }
  [[nodiscard]] Index ticks_of_stride() const {
    return stride > 0 ? stride : std::max<Index>(std::lround(0.025 * f_m), 5);
  }
  [[nodiscard]] Index ticks_of_span() const {
    return velocity_span > 0 ? velocity_span : std::max<Index>(ticks_of_stride() / 4, 1);
  }
};

namespace detail {

// A regressor with the memory that it takes, to be copied.
template <typename Scalar>
struct Regressor {
  Regressor(const Robot& robot, std::span<const StandardParameter> parameters)
      : columns(robot, parameters), workspace(columns) {}
  Regressor(const Regressor& other) : columns(other.columns), workspace(columns) {}
  Regressor& operator=(const Regressor&) = delete;

  // Calls take(joint, column, value) for the entries at q, q̇, q̈, one behind the other.
  template <typename Take>
  void rows(const Scalar* q, const Scalar* qd, const Scalar* qdd, const Take& take) noexcept {
    const std::size_t n = columns.joints();
    columns.rows(State<Scalar>{{q, n}, {qd, n}, {qdd, n}}, workspace, take);
  }

  RegressorColumns columns;
  RegressorWorkspace<Scalar> workspace;
};

}  // namespace detail

/// Rows of Eq. (13) of [RIV], tick by tick: the exact rows of docs/rows.md in a control loop.
///
/// Positions and torques alone are asked for. Velocities and accelerations are differences of positions, the
/// torque is averaged with the weights that these differences have, and a Hann window that meets no reversal
/// makes one row of 2 stride − 1 ticks. Noise-free ticks give rows without error, and those of a log are the
/// rows of its identification. Where all joints move, each has a row every `stride` ticks; it is (stride +
/// velocity_span + 2) ticks old at its centre.
///
/// After the constructor no member allocates, throws or locks.
///
/// @tparam Scalar  double or float
template <typename Scalar>
class RowStream {
 public:
  using Values = Eigen::Ref<const Eigen::VectorX<Scalar>>;

  /// A row of one joint.
  struct Row {
    std::size_t joint;
    const Scalar* values;  ///< in the order of columns().of_joint(joint); of friction that follows the load
                           ///< the sign alone
    Scalar y;              ///< torque [N·m | N]
    int direction;         ///< of its motion, ±1; 0 at rest
    Scalar speed;          ///< mean velocity [rad/s | m/s]
  };

  /// @param columns  of the rows
  /// @throws InputError  where options can not be used
  RowStream(const Robot& robot, std::span<const StandardParameter> columns, const RowStreamOptions& options);

  [[nodiscard]] Index size() const noexcept { return n_; }
  [[nodiscard]] Index stride() const noexcept { return stride_; }
  [[nodiscard]] const RegressorColumns& columns() const noexcept { return regressor_.columns; }

  /// Takes a tick. What is not finite, or beyond 1e6 rad or m, or 1e9 N·m or N, is no tick: all windows begin
  /// anew.
  ///
  /// @param q    positions, (n) [rad | m]
  /// @param tau  torques, joint side, (n) [N·m | N]
  /// @return     whether rows are finished, see for_each_row(); false where a size is wrong
  bool update(const Values& q, const Values& tau) noexcept;

  /// Calls take(Row) for the rows that the last tick has finished.
  template <typename Take>
  void for_each_row(const Take& take) const noexcept {
    for (Index j = 0; j < n_; ++j) {
      const int which = finished_[static_cast<std::size_t>(j)];
      if (which >= 0) {
        const Scalar* const sums = sums_of(j, which);
        const Index count = count_of(j);
        take(Row{static_cast<std::size_t>(j), sums, sums[count], direction(j), sums[count + 1]});
      }
    }
  }

  /// Whether the last tick has ended the first 0.3 s of a rest of all joints. Then calls take(Row) for the
  /// torques that hold the robot, the mean of 0.2 s: one row a joint, in which friction is silent and may
  /// hold anything.
  template <typename Take>
  bool for_each_rest_row(const Take& take) noexcept {
    if (rest_.ticks != rest_settling_ + rest_averaged_) {
      return false;
    }
    ++rest_.ticks;  // once
    make_rest_values();
    for (Index j = 0; j < n_; ++j) {
      const Scalar* const values = &values_[static_cast<std::size_t>(offsets_[static_cast<std::size_t>(j)])];
      take(Row{static_cast<std::size_t>(j), values, values[count_of(j)], 0, Scalar(0)});
    }
    return true;
  }

  /// Whether joint j moves, fast enough and for long enough for rows.
  [[nodiscard]] bool moving(Index j) const noexcept { return usable(j); }
  /// Direction of joint j at the centre of the ticks at hand: ±1, 0 below its threshold.
  [[nodiscard]] int direction(Index j) const noexcept { return runs_[static_cast<std::size_t>(j)].direction; }

  /// Begins anew, as after a gap of the ticks.
  void reset() noexcept {
    ticks_ = 0;
    std::ranges::fill(runs_, Run{});
    std::ranges::fill(positions_, Index{0});
    std::ranges::fill(finished_, -1);
    rest_ = {};
  }

  [[nodiscard]] auto state() noexcept {
    return std::tie(q_, tau_, runs_, positions_, sums_, finished_, ticks_, rest_, rest_sums_);
  }

 private:
  // Squares of what lies far beyond would overflow in the estimate, which could not forget them.
  static constexpr double largest_position = 1e6;
  static constexpr double largest_torque = 1e9;
  // Two central differences in a row reach over two samples to each side.
  static constexpr Index reach = 2;
  // A rest: no joint leaves its place by what its threshold of velocity is in so many seconds …
  static constexpr double rest_tolerance = 0.05;
  // … and at least this [rad | m]; what a stop leaves behind, and what is averaged [s].
  static constexpr double least_tolerance = 2e-4;
  static constexpr double settling_seconds = 0.1;
  static constexpr double averaged_seconds = 0.2;

  struct Run {
    int direction = 0;
    Index samples = 0;  // of that direction, up to the newest velocity
  };
  struct Rest {
    Index ticks = 0;
  };
  // A motor that several joints turn, whose reversals are theirs.
  struct Motor {
    Vector row;
    double threshold;
  };
  // Column of joint's own row that is a sign, whose direction the wider difference knows better.
  struct SignColumn {
    std::size_t joint;
    Index column;
    Basis basis;
    Direction direction;
  };

  [[nodiscard]] static const RowStreamOptions& usable_options(const RowStreamOptions& options, Index n) {
    if (const auto fault = options.complaint(n)) {
      throw InputError("RowStream: " + *fault);
    }
    return options;
  }
  [[nodiscard]] static Vector thresholds_of(const RowStreamOptions& options, Index n) {
    return options.velocity_threshold.size() == 0 ? Vector::Zero(n) : options.velocity_threshold;
  }
  [[nodiscard]] Index count_of(Index j) const noexcept {
    return offsets_[static_cast<std::size_t>(j) + 1] - offsets_[static_cast<std::size_t>(j)] - 2;
  }
  // Sums of joint j's window: values, then y and the velocity.
  [[nodiscard]] const Scalar* sums_of(Index j, int which) const noexcept {
    return &sums_[static_cast<std::size_t>(which * offsets_.back() + offsets_[static_cast<std::size_t>(j)])];
  }
  // Position of joint j so many ticks ago.
  [[nodiscard]] const Scalar& ago(const std::vector<Scalar>& ring, Index ticks, Index j) const noexcept {
    return ring[static_cast<std::size_t>((ticks_ - 1 - ticks) % length_ * n_ + j)];
  }
  [[nodiscard]] bool usable(Index j) const noexcept;
  void take_velocity(std::size_t axis, const Scalar& velocity, double threshold) noexcept;
  void find_directions() noexcept;
  void follow_rest(const Values& q, const Values& tau) noexcept;
  void make_rest_values() noexcept;
  void fill_columns() noexcept;
  void make_values() noexcept;
  void add_to_windows(Index j) noexcept;

  RowStreamOptions options_;
  Index n_;
  Index stride_;
  Index span_;
  Index length_;  // of the rings, in ticks
  std::vector<Motor> motors_;
  std::vector<SignColumn> signs_;
  detail::Regressor<Scalar> regressor_;
  std::vector<Index> offsets_;  // of the joints' values, y and velocity behind them; (n + 1)
  std::vector<Scalar> window_;  // h, (2 stride − 1)
  Vector thresholds_;
  std::vector<Scalar> q_, tau_;   // rings
  std::vector<Run> runs_;         // of joints, then of motors
  std::vector<Index> positions_;  // of the sample at hand in the joint's stretch
  std::vector<Scalar> sums_;      // of the two windows of each joint that a sample lies in
  std::vector<Scalar> values_;    // of the sample at hand
  std::vector<Scalar> state_;     // q, q̇, q̈ at hand
  std::vector<int> finished_;     // of joint j, which of its two windows; −1: none
  Index ticks_ = 0;
  Index rest_settling_, rest_averaged_;
  Rest rest_;
  std::vector<Scalar> rest_sums_;  // place of the rest, and sums of q and τ
};

template <typename Scalar>
RowStream<Scalar>::RowStream(const Robot& robot, std::span<const StandardParameter> columns,
                             const RowStreamOptions& options)
    : options_(usable_options(options, robot.size())),
      n_(robot.size()),
      stride_(options.ticks_of_stride()),
      span_(options.ticks_of_span()),
      length_(2 * (options.ticks_of_span() + reach) + 1),
      regressor_(robot, columns),
      thresholds_(thresholds_of(options, robot.size())),
      rest_settling_(std::max<Index>(std::lround(settling_seconds * options.f_m), 1)),
      rest_averaged_(std::max<Index>(std::lround(averaged_seconds * options.f_m), 1)) {
  for (const Coupling& coupling : robot.couplings) {
    if (coupling.coulomb == Coupling::Coulomb::sum) {
      const Vector row = coupling.row(n_);
      motors_.push_back({row, row.cwiseAbs().dot(thresholds_)});
    }
  }
  offsets_.push_back(0);
  for (std::size_t j = 0; j < regressor_.columns.joints(); ++j) {
    const std::vector<Index>& own = regressor_.columns.of_joint(j);
    for (std::size_t c = 0; span_ > 1 && robot.joints[j].sign_speed == 0.0 && c < own.size(); ++c) {
      const KindRow& row = about(columns[static_cast<std::size_t>(own[c])].kind);
      if ((row.basis == Basis::sign || row.basis == Basis::load) && !row.coupled) {
        signs_.push_back({j, static_cast<Index>(c), row.basis, row.direction});
      }
    }
    offsets_.push_back(offsets_.back() + static_cast<Index>(own.size()) + 2);
  }
  for (Index m = 1 - stride_; m < stride_; ++m) {
    const double phase = std::numbers::pi * static_cast<double>(m) / static_cast<double>(stride_);
    window_.push_back(static_cast<Scalar>((1.0 + std::cos(phase)) / (2.0 * static_cast<double>(stride_))));
  }
  const auto n = static_cast<std::size_t>(n_);
  q_.assign(static_cast<std::size_t>(length_) * n, Scalar(0));
  tau_ = q_;
  runs_.assign(n + motors_.size(), {});
  positions_.assign(n, 0);
  sums_.assign(2 * static_cast<std::size_t>(offsets_.back()), Scalar(0));
  values_.assign(static_cast<std::size_t>(offsets_.back()), Scalar(0));
  state_.assign(3 * n, Scalar(0));
  finished_.assign(n, -1);
  rest_sums_.assign(3 * n, Scalar(0));
}

template <typename Scalar>
bool RowStream<Scalar>::update(const Values& q, const Values& tau) noexcept {
  if (q.size() != n_ || tau.size() != n_) {
    return false;
  }
  if (!detail::plausible(q, largest_position) || !detail::plausible(tau, largest_torque)) {
    reset();
    return false;
  }
  const Index slot = ticks_ % length_ * n_;
  for (Index j = 0; j < n_; ++j) {
    q_[static_cast<std::size_t>(slot + j)] = q[j];
    tau_[static_cast<std::size_t>(slot + j)] = tau[j];
  }
  ++ticks_;
  follow_rest(q, tau);
  std::ranges::fill(finished_, -1);
  if (ticks_ < length_) {
    return false;
  }
  find_directions();
  bool any = false;
  for (Index j = 0; j < n_; ++j) {
    any = any || usable(j);
  }
  if (any) {
    make_values();
  }
  bool finished = false;
  for (Index j = 0; j < n_; ++j) {
    if (usable(j)) {
      add_to_windows(j);
      finished = finished || finished_[static_cast<std::size_t>(j)] >= 0;
    } else {
      positions_[static_cast<std::size_t>(j)] = 0;
    }
  }
  return finished;
}

template <typename Scalar>
void RowStream<Scalar>::take_velocity(std::size_t axis, const Scalar& velocity, double threshold) noexcept {
  using std::abs;
  Run& run = runs_[axis];
  const int direction = abs(velocity) > Scalar(threshold) ? (velocity > Scalar(0) ? 1 : -1) : 0;
  run.samples = direction == run.direction ? run.samples + 1 : 1;
  run.direction = direction;
}

// Sums of the positions and torques of a rest, once what came before has settled.
template <typename Scalar>
void RowStream<Scalar>::follow_rest(const Values& q, const Values& tau) noexcept {
  using std::abs;
  const auto n = static_cast<std::size_t>(n_);
  bool still = rest_.ticks > 0;
  for (std::size_t j = 0; j < n && still; ++j) {
    const auto at = static_cast<Index>(j);
    const double tolerance = std::max(rest_tolerance * thresholds_[at], least_tolerance);
    still = abs(q[at] - rest_sums_[j]) <= static_cast<Scalar>(tolerance);
  }
  rest_.ticks = still ? rest_.ticks + 1 : 1;
  const bool counts = rest_.ticks > rest_settling_ && rest_.ticks <= rest_settling_ + rest_averaged_;
  for (std::size_t j = 0; j < n && (counts || !still); ++j) {
    const auto at = static_cast<Index>(j);
    rest_sums_[j] = still ? rest_sums_[j] : q[at];
    rest_sums_[n + j] = still ? rest_sums_[n + j] + q[at] : Scalar(0);
    rest_sums_[2 * n + j] = still ? rest_sums_[2 * n + j] + tau[at] : Scalar(0);
  }
}

// What holds the robot at the mean position of its rest.
template <typename Scalar>
void RowStream<Scalar>::make_rest_values() noexcept {
  const auto n = static_cast<std::size_t>(n_);
  const Scalar share = Scalar(1) / static_cast<Scalar>(rest_averaged_);
  for (std::size_t j = 0; j < n; ++j) {
    state_[j] = rest_sums_[n + j] * share;
    state_[n + j] = state_[2 * n + j] = Scalar(0);
    values_[static_cast<std::size_t>(offsets_[j] + count_of(static_cast<Index>(j)))] =
        rest_sums_[2 * n + j] * share;
  }
  fill_columns();
}

// Velocities of the newest sample that has one, span ticks ago.
template <typename Scalar>
void RowStream<Scalar>::find_directions() noexcept {
  const auto to_velocity = static_cast<Scalar>(options_.f_m / (2.0 * static_cast<double>(span_)));
  const auto velocity = [&](Index j) { return (ago(q_, 0, j) - ago(q_, 2 * span_, j)) * to_velocity; };
  for (Index j = 0; j < n_; ++j) {
    take_velocity(static_cast<std::size_t>(j), velocity(j), thresholds_[j]);
  }
  for (std::size_t m = 0; m < motors_.size(); ++m) {
    Scalar sum(0);
    for (Index j = 0; j < n_; ++j) {
      sum = sum + static_cast<Scalar>(motors_[m].row[j]) * velocity(j);
    }
    take_velocity(static_cast<std::size_t>(n_) + m, sum, motors_[m].threshold);
  }
}

// Whether the sample at hand lies in a stretch of one direction, two samples from its ends.
template <typename Scalar>
bool RowStream<Scalar>::usable(Index j) const noexcept {
  const auto good = [&](std::size_t axis) {
    return runs_[axis].direction != 0 && runs_[axis].samples > 2 * reach;
  };
  bool out = ticks_ >= length_ && good(static_cast<std::size_t>(j));
  for (std::size_t m = 0; m < motors_.size(); ++m) {
    out = out && (motors_[m].row[j] == 0.0 || good(static_cast<std::size_t>(n_) + m));
  }
  return out;
}

// The columns at the state at hand.
template <typename Scalar>
void RowStream<Scalar>::fill_columns() noexcept {
  const auto n = static_cast<std::size_t>(n_);
  regressor_.rows(&state_[0], &state_[n], &state_[2 * n],
                  [&](std::size_t joint, Index column, const Scalar& value) {
                    values_[static_cast<std::size_t>(offsets_[joint] + column)] = value;
                  });
}

// The row of the sample span + 2 ticks ago, see average_torque() and averaged_motion() of the identification.
template <typename Scalar>
void RowStream<Scalar>::make_values() noexcept {
  const Index k = span_ + reach;
  const auto f = static_cast<Scalar>(options_.f_m);
  const Scalar third = Scalar(1) / Scalar(3);
  const auto n = static_cast<std::size_t>(n_);
  for (std::size_t j = 0; j < n; ++j) {
    const auto q = [&](Index shift) { return ago(q_, k - shift, static_cast<Index>(j)); };
    state_[j] = (q(-1) + q(0) + q(1)) * third;
    state_[n + j] = (q(2) - q(-2) + Scalar(4) * (q(1) - q(-1))) * (f / Scalar(12));
    state_[2 * n + j] = ((q(2) - q(0)) - (q(0) - q(-2))) * (f * f * Scalar(0.25));
    const auto tau = [&](Index shift) { return ago(tau_, k - shift, static_cast<Index>(j)); };
    values_[static_cast<std::size_t>(offsets_[j + 1] - 1)] = state_[n + j];
    values_[static_cast<std::size_t>(offsets_[j + 1] - 2)] =
        options_.torque_held ? (tau(-2) + Scalar(3) * (tau(-1) + tau(0)) + tau(1)) * Scalar(1) / Scalar(8)
                             : (tau(-1) + tau(0) + tau(1)) * third;
  }
  fill_columns();
  for (const SignColumn& sign : signs_) {
    const auto direction = static_cast<Scalar>(runs_[sign.joint].direction);
    values_[static_cast<std::size_t>(offsets_[sign.joint] + sign.column)] =
        friction_entry(sign.basis, sign.direction, direction, 0.0);
  }
}

// Windows begin every stride samples, so a sample lies in two, the older one in its second half.
template <typename Scalar>
void RowStream<Scalar>::add_to_windows(Index j) noexcept {
  const auto at = static_cast<std::size_t>(j);
  const Index position = positions_[at]++;
  const Index phase = position % stride_;
  const int younger = static_cast<int>(position / stride_ % 2);
  const Index begin = offsets_[at];
  const Index count = offsets_[at + 1] - begin;
  const Scalar* const values = &values_[static_cast<std::size_t>(begin)];
  const auto add = [&](int which, const Scalar& weight, bool first) {
    Scalar* const sums = &sums_[static_cast<std::size_t>(which * offsets_.back() + begin)];
    if (first) {
      for (Index c = 0; c < count; ++c) {
        sums[c] = weight * values[c];
      }
    } else {
      for (Index c = 0; c < count; ++c) {
        sums[c] = sums[c] + weight * values[c];
      }
    }
  };
  add(younger, window_[static_cast<std::size_t>(phase)], phase == 0);
  if (position >= stride_ && phase + 1 < stride_) {
    add(1 - younger, window_[static_cast<std::size_t>(phase + stride_)], false);
    finished_[at] = phase + 2 == stride_ ? 1 - younger : -1;
  }
  if (stride_ == 1) {
    finished_[at] = younger;
  }
}

}  // namespace rivid
