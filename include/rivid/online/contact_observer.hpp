#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/online/information_triangle.hpp"
#include "rivid/online/momentum.hpp"
#include "rivid/online/plausible.hpp"
#include "rivid/online/saved_state.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "rivid/text.hpp"

namespace rivid {

struct ContactObserverOptions {
  double f_m = 1000.0;  ///< ticks a second [Hz]
  double bandwidth =
      30.0;  ///< of the observer: r follows the external torque like a first-order low-pass [rad/s]
  /// Of a second, faster residual: what it has beyond the first one is a collision. What drifts slowly, as
  /// friction and payload do, is not in the difference.
  double collision_bandwidth = 150.0;
  double alarms_per_hour = 1.0;  ///< false alarms of all joints together that the thresholds are made for
  /// v_s of each joint, (n) [rad/s | m/s]: friction is smoothed by tanh(q̇ / v_s). At half of it and below a
  /// joint counts as at rest.
  Vector smoothing_speed = {};  ///< empty: 0.02 each
  double settling = 0.15;       ///< time after a reversal that has a threshold of its own [s]
  double hold = 0.1;            ///< time for which a contact goes on below half of its threshold [s]
  double memory =
      60.0;  ///< time in a class of motion after which Mode::follow forgets its mean and deviation [s]

  [[nodiscard]] std::optional<std::string> complaint(Index joints) const {
    const auto positive = [](const char* name, double value, const char* unit) -> std::optional<std::string> {
      if (std::isfinite(value) && value > 0.0) {
        return std::nullopt;
      }
      return std::string(name) + " is " + number(value) + unit + ", must be positive";
    };
    for (const auto& fault : {positive("f_m", f_m, " Hz"), positive("bandwidth", bandwidth, " rad/s"),
                              positive("collision_bandwidth", collision_bandwidth, " rad/s"),
                              positive("alarms_per_hour", alarms_per_hour, ""),
                              positive("settling", settling, " s"), positive("memory", memory, " s")}) {
      if (fault) {
        return fault;
      }
    }
    if (bandwidth >= f_m) {
      return "bandwidth is " + number(bandwidth) + " rad/s, must lie below f_m = " + number(f_m) + " Hz";
    }
    if (!(hold >= 0.0)) {
      return "hold is " + number(hold) + " s, must not be negative";
    }
    if (smoothing_speed.size() != 0 &&
        (smoothing_speed.size() != joints || !(smoothing_speed.array() > 0.0).all())) {
      return "smoothing_speed must have " + std::to_string(joints) + " positive values, one a joint";
    }
    return std::nullopt;
  }
};

/// External torques by the generalised momentum [De Luca 2006]: without measured accelerations,
///
///   p = M(q) q̇,   r = K (p − ∫ (τ − friction + Cᵀ q̇ − g + r) dt),
///
/// so that ṙ = K (τ_ext − r): r is the external torque behind a low-pass of `bandwidth`. The integral is
/// exact for a τ that is held from tick to tick. Friction that follows the load needs no acceleration either:
/// its gear passes on the u of u + Fl |u| sign q̇ = τ − other friction.
///
/// **Thresholds** are those of the robot's own residual. While update() learns, mean and deviation of each
/// joint's r are kept for classes of its motion (at rest, and for each direction just after a reversal and by
/// speed). r remembers what it was for 1 / bandwidth, so mean and deviation pass through its low-pass too:
/// what friction has left at a slow reversal is no contact behind it. The largest deviation of each second is
/// kept as well; by Gumbel's distribution these give the threshold for the false alarms that the options ask
/// for. A joint has no threshold (infinity), and sees no contact, before it has spent three seconds in one
/// class and one more.
///
/// A contact begins above a threshold and ends when it has been below half of it for `hold`. A **collision**
/// is what a faster residual has beyond r, with thresholds of its own, learned in the same way.
///
/// After the constructor no member allocates, throws or locks.
///
/// @tparam Scalar  double or float
template <typename Scalar>
class ContactObserver {
 public:
  using Values = Eigen::Ref<const Eigen::VectorX<Scalar>>;
  using Result = Eigen::VectorX<Scalar>;

  enum class Mode {
    observe,  ///< thresholds stay
    learn,    ///< nothing touches the robot: thresholds follow the residual
    follow    ///< the same wherever there is no contact, with what was seen long ago fading: friction drifts
  };

  /// @throws InputError  the model's complaint(); where options can not be used
  explicit ContactObserver(const ModelData& model, const ContactObserverOptions& options = {});

  [[nodiscard]] Index size() const noexcept { return momentum_.size(); }

  /// Takes a tick. A tick of a wrong size, or with a number that is not finite or beyond 1e6 rad or m, 1e9
  /// rad/s or m/s, 1e9 N·m or N, starts the observer anew.
  ///
  /// @param q    positions, (n) [rad | m]
  /// @param qd   velocities, (n) [rad/s | m/s]
  /// @param tau  torques from the last tick to this one, joint side, (n) [N·m | N]
  /// @return     whether there is a contact
  bool update(const Values& q, const Values& qd, const Values& tau, Mode mode = Mode::observe) noexcept;

  /// r, the external torque, (n) [N·m | N].
  [[nodiscard]] const Result& residual() const noexcept { return residual_; }
  /// r without its mean in the present class of motion, over the threshold: a contact where above 1 in
  /// magnitude, (n).
  [[nodiscard]] const Result& relative() const noexcept { return relative_; }
  /// The same of what the faster residual has beyond r: a collision where above 1 in magnitude, (n).
  [[nodiscard]] const Result& collision_relative() const noexcept { return fast_relative_; }
  /// Whether a collision is felt, or was a short while ago.
  [[nodiscard]] bool collision() const noexcept { return collision_.on; }
  /// Present threshold of joint j [N·m | N]; infinite before anything was learned. Of a joint that is none,
  /// this and level() are no number, and it has learned nothing.
  [[nodiscard]] Scalar threshold(Index j) const noexcept;
  /// Standard deviations that the threshold of joint j lies above the mean.
  [[nodiscard]] Scalar level(Index j) const noexcept {
    return j >= 0 && j < size() ? static_cast<Scalar>(level_of(j)) : std::numeric_limits<Scalar>::quiet_NaN();
  }

  /// Whether joint j has a threshold; it sees no contact before.
  [[nodiscard]] bool learned(Index j) const noexcept { return std::isfinite(level(j)); }
  /// Whether all joints have.
  [[nodiscard]] bool learned() const noexcept {
    bool out = true;
    for (Index s = 0; s < 2 * size(); ++s) {
      out = out && std::isfinite(level_of(s));
    }
    return out;
  }

  [[nodiscard]] bool contact() const noexcept { return link_ >= 0; }
  /// The link that is touched, counted from 0: the last joint that has felt more than three deviations since
  /// the contact began moves it. A force through the axes of joints behind is not seen by these, so it may be
  /// a later link. −1 without a contact.
  [[nodiscard]] Index link() const noexcept { return link_; }
  /// Whether r has come near to the contact's force, so that weak torques of later joints show too: link()
  /// and the force mean little before.
  [[nodiscard]] bool link_settled() const noexcept {
    return contact() &&
           static_cast<double>(contact_.ticks) * options_.bandwidth > time_constants * options_.f_m;
  }

  /// The smallest force on a point of a link that explains the residual of joints 0 … link, weighted by their
  /// deviations, in the axes of the base [N]. Of a link near the base some directions are not seen; they
  /// count as zero.
  ///
  /// @param link   counted from 0
  /// @param point  in the frame j of the link [m]
  [[nodiscard]] Eigen::Vector3<Scalar> force(Index link, const Eigen::Vector3<Scalar>& point) const noexcept;

  /// Force and moment on a point of a link, in the axes of the base.
  struct Wrench {
    Eigen::Matrix<Scalar, 6, 1> value = Eigen::Matrix<Scalar, 6, 1>::Zero();  ///< [N], [N·m]
    Eigen::Matrix<Scalar, 6, 1> sigma = Eigen::Matrix<Scalar, 6, 1>::Zero();  ///< standard deviations
  };
  /// Force and moment that explain the residual of joints 0 … link, and their deviations by those of r in the
  /// present class of motion. What these joints do not feel has the deviation of what is usual: 300 N, 100
  /// N·m.
  [[nodiscard]] Wrench wrench(Index link, const Eigen::Vector3<Scalar>& point) const noexcept {
    return explained(link, point, usual_force, usual_moment);
  }

  /// A body on the last link that the model does not have, XX … M in the frame of that link:
  /// PayloadEstimator::inertial(). Else its weight is an external torque. r goes on from what it was;
  /// thresholds stay.
  void set_payload(const Eigen::Matrix<Scalar, inertial_count, 1>& body) noexcept {
    const Inertial& in_link = body.template cast<double>();
    momentum_.set_payload(transformed(in_link, axes_, Eigen::Vector3d::Zero()));
    momentum_(q_.data(), qd_.data(), p_.data(), rate_.data());  // of the last tick
  }

  /// Begins anew; thresholds stay.
  void reset() noexcept {
    running_ = false;
    resting_ = 0;
    end_contact();
  }
  /// Thresholds are forgotten too.
  void forget() noexcept {
    reset();
    deviation_.setConstant(std::numeric_limits<Scalar>::infinity());
    limit_ = deviation_;
    std::ranges::fill(classes_, Moments{});
    std::ranges::fill(held_, Moments{});
    std::ranges::fill(tails_, Tail{});
    levels_.setConstant(std::numeric_limits<double>::infinity());
  }

  [[nodiscard]] auto state() noexcept {
    return std::tie(momentum_, residual_, relative_, fast_, fast_relative_, contact_, collision_, p_, rate_,
                    friction_, q_, qd_, mean_, deviation_, limit_, levels_, classes_, tails_, motions_,
                    rests_, held_, late_, resting_, link_, running_);
  }
  [[nodiscard]] const detail::StateOwner& state_owner() const noexcept { return owner_; }

 private:
  // Squares of what lies far beyond would overflow.
  static constexpr double largest_position = 1e6;
  static constexpr double largest = 1e9;
  // Classes of a joint's motion: just stopped, at rest, and by direction after a reversal and by half octaves
  // of speed.
  static constexpr int half_octaves = 20;
  static constexpr int class_count = 2 + 2 * (1 + half_octaves);
  static constexpr int stopped = 0;  // number of the class
  static constexpr int at_rest = 1;  // number of the class
  // Time over which a rest's own mean is taken [s].
  static constexpr double rest_memory = 2.0;
  // The largest size of a second, in deviations: mean and deviation before any was seen, which count for so
  // many seconds.
  static constexpr double usual_peak = 3.0;
  static constexpr double usual_spread = 1.0;
  static constexpr double usual_seconds = 5.0;
  // A threshold at rest over the largest that was learned.
  static constexpr double beyond = 1.1;
  // Memory while learning [s].
  static constexpr double ever = 1e9;
  // Length of the first stretch of learning [s].
  static constexpr double first_seconds = 2.0;
  // No threshold is lower, in deviations.
  static constexpr double least_level = 4.0;
  // Numbers without noise have none smaller: (r − mean) / deviation stays a number.
  static constexpr double least_variance = 1e-30;
  // Time in a class before its moments are its own [s].
  static constexpr double enough = 3.0;
  // Where a contact ends, over where it begins.
  static constexpr double hysteresis = 0.5;
  // Largest sizes of seconds are remembered for so many times the moments'.
  static constexpr double tail_memories = 30.0;
  static constexpr double felt = 3.0;              // deviations; chance is 0.3 %
  static constexpr double longest_contact = 10.0;  // [s] a choice: what lasts longer is learned
  static constexpr double time_constants = 3.0;    // of the low-pass: r has 95 % of a force then
  static constexpr double usual_force = 300.0;     // [N] deviation of what joints do not feel; a choice
  static constexpr double usual_moment = 100.0;    // [N·m] the same

  struct Alarm {
    bool on = false;
    Index ticks = 0;  // since it began
    Index below = 0;  // since it was last above
    void take(double highest, Index held) noexcept {
      below = highest > (on ? hysteresis : 1.0) ? 0 : below + 1;
      const bool now = below == 0 || (on && below <= held);
      ticks = now ? ticks + 1 : 0;
      on = now;
    }
  };
  struct Moments {
    double count = 0.0;
    double mean = 0.0;
    double square = 0.0;  // Σ (x − mean)²
    double largest = 0.0;
  };
  // The largest sizes of seconds, in deviations. Those of the begin, when the moments were hardly known, are
  // left behind: a stretch of learning that is twice as long as the last one takes its place.
  struct Tail {
    Moments before;
    Moments now;
    double ticks = 0.0;    // of the second at hand
    double highest = 0.0;  // and the largest size in it
  };
  struct Motion1 {
    int direction = 0;
    double since_reversal = 1e9;  // [s]
    int kind = stopped;
  };

  [[nodiscard]] static InverseDynamicsOptions smoothing(const ModelData& model,
                                                        const ContactObserverOptions& options);
  [[nodiscard]] static detail::StateOwner owner_of(const ModelData& model,
                                                   const ContactObserverOptions& options);
  void end_contact() noexcept {
    link_ = -1;
    contact_ = collision_ = {};
  }
  void classify(Index j, const Scalar& speed) noexcept;
  void learn(Index s, double memory) noexcept;
  void learn_tail(std::size_t which, double deviations, double memory) noexcept;
  void follow_rest(double memory) noexcept;
  void judge() noexcept;
  [[nodiscard]] double highest_of(Index band, Result& relative) noexcept;
  [[nodiscard]] Wrench explained(Index link, const Eigen::Vector3<Scalar>& point, double force,
                                 double moment) const noexcept;
  // most  count that is kept: what is older fades
  static void add(Moments& to, double x, double most) noexcept {
    if (to.count >= most) {
      to.square *= (most - 1.0) / to.count;
      to.count = most - 1.0;
    }
    to.count += 1.0;
    const double off = x - to.mean;
    to.mean += off / to.count;
    to.square += off * (x - to.mean);
  }
  [[nodiscard]] const Moments& moments(Index s) const noexcept;
  void follow_class(Index s) noexcept;
  // Whether friction bounds signal s: that of a joint at rest.
  [[nodiscard]] bool bounded(Index s) const noexcept {
    const auto j = static_cast<std::size_t>(s % size());
    return rubs_[j] && motions_[j].kind <= at_rest;
  }
  // Of signal s: r of joint s, or what the faster residual of joint s − n has beyond it.
  [[nodiscard]] Scalar signal(Index s) const noexcept {
    return s < size() ? residual_[s] : fast_[s - size()] - residual_[s - size()];
  }
  [[nodiscard]] std::size_t tail_of(Index s) const noexcept {
    return static_cast<std::size_t>(bounded(s) ? 2 * size() + s : s);
  }
  // Level of signal s; of a kind of motion that is not known that of the other.
  [[nodiscard]] double level_of(Index s) const noexcept {
    const double own = levels_[static_cast<Index>(tail_of(s))];
    return std::isfinite(own) ? own : std::min(levels_[s], levels_[2 * size() + s]);
  }
  template <typename Visit>
  void visit_frames(Index last, const Visit& visit) const noexcept;
  // Whether nothing touches the robot, or has for so long that it is none but an error of the model.
  [[nodiscard]] bool untouched() const noexcept {
    const auto touched_for = static_cast<double>(std::max(contact_.ticks, collision_.ticks));
    return touched_for == 0.0 || touched_for > longest_contact * options_.f_m;
  }
  [[nodiscard]] bool known(const Moments& m) const noexcept { return m.count >= enough * options_.f_m; }

  ModelData model_;
  ContactObserverOptions options_;
  detail::Momentum<Scalar> momentum_;
  BasicInverseDynamics<Scalar> dynamics_;
  Vector smoothing_speed_;
  std::vector<bool> rubs_;  // whether a joint has dry friction
  Vector load_;             // Fl of each joint …
  Vector load_speed_;       // … and the speed that smooths its sign
  Eigen::Matrix3d axes_;    // of the last link's frame in its frame j
  Scalar keep_, keep_fast_;
  Result residual_, relative_, fast_, fast_relative_, p_, rate_, friction_, q_, qd_, next_p_, next_rate_,
      next_friction_;
  // That the signals have in the classes of late; infinite deviation: not known. (2n)
  Result mean_, deviation_, limit_;
  Vector levels_;                 // of each tail
  std::vector<Moments> classes_;  // class_count of each signal, then one of all
  std::vector<Tail> tails_;       // of the signals in motion, of the signals at rest, and of rests
  std::vector<Motion1> motions_;
  std::vector<Moments> rests_, held_;  // r of the rest at hand; what r differs by from it, in all rests
  Index delay_;
  Eigen::MatrixX<Scalar> late_;  // r of the last delay_ ticks, (n × delay_)
  Index resting_ = 0;            // ticks for which all joints have been at rest
  Alarm contact_, collision_;
  Index link_ = -1;
  bool running_ = false;
  detail::StateOwner owner_;
};

template <typename Scalar>
InverseDynamicsOptions ContactObserver<Scalar>::smoothing(const ModelData& model,
                                                          const ContactObserverOptions& options) {
  if (const auto fault = options.complaint(model.size())) {
    throw InputError("ContactObserver: " + *fault);
  }
  constexpr double usual_speed = 0.02;  // [rad/s | m/s] a choice: above the noise of velocities, below motion
  return {.smoothing_speed = options.smoothing_speed.size() > 0
                                 ? options.smoothing_speed
                                 : Vector(Vector::Constant(model.size(), usual_speed))};
}

template <typename Scalar>
ContactObserver<Scalar>::ContactObserver(const ModelData& model, const ContactObserverOptions& options)
    : model_(model),
      options_(options),
      momentum_(model),
      dynamics_(model, smoothing(model, options)),
      smoothing_speed_(smoothing(model, options).smoothing_speed),
      rubs_(static_cast<std::size_t>(model.size()), false),
      load_(Vector::Zero(model.size())),
      load_speed_(smoothing_speed_),
      axes_(link_axes(model.chain.links.back()).transpose()),
      keep_(static_cast<Scalar>(std::exp(-options.bandwidth / options.f_m))),
      keep_fast_(static_cast<Scalar>(std::exp(-options.collision_bandwidth / options.f_m))),
      levels_(Vector::Constant(5 * model.size(), std::numeric_limits<double>::infinity())),
      classes_(2 * static_cast<std::size_t>(model.size()) * (class_count + 1)),
      tails_(5 * static_cast<std::size_t>(model.size())),
      motions_(static_cast<std::size_t>(model.size())),
      rests_(static_cast<std::size_t>(model.size())),
      held_(static_cast<std::size_t>(model.size())),
      delay_(std::max<Index>(std::lround(options.settling * options.f_m), 1)),
      late_(Matrix::Zero(model.size(), delay_).template cast<Scalar>()),
      owner_(owner_of(model, options)) {
  for (Result* const x : {&residual_, &relative_, &fast_, &fast_relative_, &p_, &rate_, &friction_, &q_, &qd_,
                          &next_p_, &next_rate_, &next_friction_}) {
    *x = Result::Zero(model.size());
  }
  mean_ = Result::Zero(2 * model.size());
  limit_ = deviation_ = Result::Constant(2 * model.size(), std::numeric_limits<Scalar>::infinity());
  for (const DryFriction& element : model.dry_friction) {
    for (Index j = 0; j < model.size(); ++j) {
      const bool holds = element.direction[j] != 0.0 && element.Fc_plus + element.Fc_minus > 0.0;
      rubs_[static_cast<std::size_t>(j)] = rubs_[static_cast<std::size_t>(j)] || holds;
    }
    if (element.load > 0.0) {
      load_[element.joint()] = element.load;
      load_speed_[element.joint()] =
          element.sign_speed > 0.0 ? element.sign_speed : smoothing_speed_[element.joint()];
    }
  }
}

template <typename Scalar>
detail::StateOwner ContactObserver<Scalar>::owner_of(const ModelData& model,
                                                     const ContactObserverOptions& options) {
  using detail::Fingerprint;
  const auto& [chain, names, inertials, rotor, viscous, offset, dry_friction] = model;
  std::uint64_t dry = 0;
  for (const DryFriction& element : dry_friction) {
    dry = Fingerprint::of(dry, element.direction, element.torque, element.sign_speed, element.load);
    for (const auto& [basis, plus, minus] : element.terms) {
      dry = Fingerprint::of(dry, basis, plus, minus);
    }
  }
  const auto& [f_m, bandwidth, collision_bandwidth, alarms_per_hour, smoothing_speed, settling, hold,
               memory] = options;
  return {.kind = detail::kind_of<Scalar>("ContactObserver"),
          .arm = Fingerprint::of(chain, inertials, rotor, viscous, offset, dry),
          .rate = Fingerprint::of(f_m),
          .options = Fingerprint::of(bandwidth, collision_bandwidth, alarms_per_hour, smoothing_speed,
                                     settling, hold, memory)};
}

template <typename Scalar>
bool ContactObserver<Scalar>::update(const Values& q, const Values& qd, const Values& tau,
                                     Mode mode) noexcept {
  const Index n = size();
  const double memory = mode == Mode::learn                   ? ever
                        : mode == Mode::follow && untouched() ? options_.memory
                                                              : 0.0;
  if (q.size() != n || qd.size() != n || tau.size() != n || !detail::plausible(q, largest_position) ||
      !detail::plausible(qd, largest) || !detail::plausible(tau, largest)) {
    reset();
    return false;
  }
  momentum_(q.data(), qd.data(), next_p_.data(), next_rate_.data());
  dynamics_.friction(qd, next_friction_);
  q_ = q;
  qd_ = qd;
  const auto f = static_cast<Scalar>(options_.f_m);
  for (Index j = 0; j < n; ++j) {
    if (running_) {
      const Scalar half(0.5);
      const Scalar left = tau[j] - half * (friction_[j] + next_friction_[j]);
      const Scalar driven = detail::passed_on(load_[j], static_cast<Scalar>(load_speed_[j]), left, qd[j]) +
                            half * (rate_[j] + next_rate_[j]);
      residual_[j] = detail::low_pass(residual_[j], keep_, p_[j], next_p_[j], driven, f);
      fast_[j] = detail::low_pass(fast_[j], keep_fast_, p_[j], next_p_[j], driven, f);
    } else {
      residual_[j] = fast_[j] = Scalar(0);
    }
    p_[j] = next_p_[j];
    rate_[j] = next_rate_[j];
    friction_[j] = next_friction_[j];
    classify(j, qd[j]);
    for (const Index s : {j, n + j}) {
      follow_class(s);
      if (running_ && memory > 0.0) {
        learn(s, memory);
      }
    }
  }
  running_ = true;
  relative_.setZero();
  follow_rest(memory);
  judge();
  if (contact_.on || collision_.on) {  // no second with a contact is a measure of those without
    for (Tail& tail : tails_) {
      tail.ticks = tail.highest = 0.0;
    }
  }
  if (mode == Mode::learn) {
    end_contact();
  }
  return contact();
}

template <typename Scalar>
void ContactObserver<Scalar>::classify(Index j, const Scalar& speed) noexcept {
  Motion1& motion = motions_[static_cast<std::size_t>(j)];
  const double v = static_cast<double>(speed);
  const double slow = 0.5 * smoothing_speed_[j];
  motion.since_reversal += 1.0 / options_.f_m;
  const int direction = v > slow ? 1 : v < -slow ? -1 : 0;
  if (direction != motion.direction) {
    motion.since_reversal = 0.0;
    motion.direction = direction;
  }
  if (direction == 0) {
    motion.kind = motion.since_reversal < options_.settling ? stopped : at_rest;
    return;
  }
  // An error of friction changes its sign with the direction: it belongs to the mean.
  const int speed_class = motion.since_reversal < options_.settling
                              ? 0
                              : 1 + std::clamp(std::ilogb(v * v / (slow * slow)), 0, half_octaves - 1);
  motion.kind = 2 + 2 * speed_class + (direction > 0 ? 0 : 1);
}

// Friction holds a joint at rest by any torque, but by the same one for all of a rest. A joint that breaks
// away is no contact: r is judged a little late, once it is known that all joints are still at rest.
template <typename Scalar>
void ContactObserver<Scalar>::follow_rest(double memory) noexcept {
  const bool rests = std::ranges::all_of(motions_, [](const Motion1& m) { return m.direction == 0; });
  resting_ = rests ? resting_ + 1 : 0;
  const Index settled = resting_ - 2 * delay_;
  for (Index j = 0; j < size(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    Scalar& newest = late_(j, resting_ % delay_);
    const auto r = static_cast<double>(std::exchange(newest, residual_[j]));
    if (settled <= 0) {
      rests_[at] = {};
      continue;
    }
    const double off = rests_[at].count > 0.0 ? r - rests_[at].mean : 0.0;
    const double sigma =
        std::sqrt(std::max(held_[at].square / std::max(held_[at].count, 1.0), least_variance));
    const double limit = levels_[4 * size() + j] * sigma;
    relative_[j] = std::isfinite(limit) ? static_cast<Scalar>(off / limit) : Scalar(0);
    if (untouched() || rests_[at].count == 0.0) {
      add(rests_[at], r, rest_memory * options_.f_m);
    }
    if (memory > 0.0) {
      add(held_[at], off, memory * options_.f_m);
      if (known(held_[at])) {
        learn_tail(4 * static_cast<std::size_t>(size()) + at, std::abs(off) / sigma, memory);
      }
    }
  }
}

template <typename Scalar>
void ContactObserver<Scalar>::learn(Index s, double memory) noexcept {
  const double r = static_cast<double>(signal(s));
  const auto first = static_cast<std::size_t>(s) * (class_count + 1);
  const auto kind = static_cast<std::size_t>(motions_[static_cast<std::size_t>(s % size())].kind);
  add(classes_[first + kind], r, memory * options_.f_m);
  add(classes_[first + class_count], r, memory * options_.f_m);
  if (!known(classes_[first + kind])) {
    return;
  }
  learn_tail(tail_of(s), std::abs(r - static_cast<double>(mean_[s])) / static_cast<double>(deviation_[s]),
             memory);
}

template <typename Scalar>
void ContactObserver<Scalar>::learn_tail(std::size_t which, double deviations, double memory) noexcept {
  Tail& tail = tails_[which];
  tail.highest = std::max(tail.highest, deviations);
  tail.ticks += 1.0;
  if (tail.ticks < options_.f_m) {
    return;
  }
  const double highest = std::exchange(tail.highest, 0.0);
  tail.ticks = 0.0;
  const auto joints = static_cast<std::size_t>(size());
  const bool bounded = which >= 2 * joints && which < 4 * joints;
  if (bounded && memory < ever) {
    return;
  }
  add(tail.now, highest, tail_memories * memory);
  tail.now.largest = std::max(tail.now.largest, highest);
  if (tail.now.count >= std::max(2.0 * tail.before.count, first_seconds)) {
    tail.before = tail.now;
    tail.now = {};
  }
  if (bounded) {  // what friction holds has an end, and it was nearly there
    levels_[static_cast<Index>(which)] = std::max(tail.before.largest, tail.now.largest) *
                                         (beyond + usual_seconds / (tail.before.count + tail.now.count));
    return;
  }
  Moments all{usual_seconds, usual_peak, usual_seconds * usual_spread * usual_spread};
  for (const Moments& part : {tail.before, tail.now}) {
    const double off = part.mean - all.mean;
    const double count = all.count + part.count;
    all.square += part.square + off * off * all.count * part.count / count;
    all.mean += off * part.count / count;
    all.count = count;
  }
  // A largest value has Gumbel's distribution: exp(−e^((μ − x) / β)), with mean μ + 0.577 β and deviation β π
  // / √6.
  const double beta = std::sqrt(6.0 * all.square / all.count) / std::numbers::pi;
  const double seconds_to_alarm = 3600.0 * static_cast<double>(model_.size()) / options_.alarms_per_hour;
  levels_[static_cast<Index>(which)] =
      std::max(all.mean + beta * (std::log(seconds_to_alarm) - std::numbers::egamma), least_level);
}

// Of the class at hand; where that was hardly met, of all motion.
template <typename Scalar>
auto ContactObserver<Scalar>::moments(Index s) const noexcept -> const Moments& {
  const auto first = static_cast<std::size_t>(s) * (class_count + 1);
  const Motion1& motion = motions_[static_cast<std::size_t>(s % size())];
  const Moments& own = classes_[first + static_cast<std::size_t>(motion.kind)];
  return known(own) ? own : classes_[first + class_count];
}

// Mean and deviation of the class at hand, through the low-pass that the signal has.
template <typename Scalar>
void ContactObserver<Scalar>::follow_class(Index s) noexcept {
  const Moments& m = moments(s);
  if (!(m.count > 1.0)) {
    return;
  }
  const auto mean = static_cast<Scalar>(m.mean);
  const auto deviation = static_cast<Scalar>(std::sqrt(std::max(m.square / m.count, least_variance)));
  // r begins with zero.
  mean_[s] = running_ ? keep_ * mean_[s] + (Scalar(1) - keep_) * mean : Scalar(0);
  const auto follow = [&](Scalar& x, const Scalar& to) {
    x = running_ && std::isfinite(x) ? keep_ * x + (Scalar(1) - keep_) * to : to;
  };
  follow(deviation_[s], deviation);
  follow(limit_[s], static_cast<Scalar>(level_of(s)) * deviation);
}

template <typename Scalar>
Scalar ContactObserver<Scalar>::threshold(Index j) const noexcept {
  if (j < 0 || j >= size()) {
    return std::numeric_limits<Scalar>::quiet_NaN();
  }
  return std::isfinite(limit_[j]) ? limit_[j] : static_cast<Scalar>(level_of(j)) * deviation_[j];
}

// Signals of a band over their thresholds, and the largest of these.
template <typename Scalar>
double ContactObserver<Scalar>::highest_of(Index band, Result& relative) noexcept {
  double highest = 0.0;
  for (Index j = 0; j < size(); ++j) {
    const Index s = band * size() + j;
    const Scalar now = std::isfinite(limit_[s]) ? (signal(s) - mean_[s]) / limit_[s] : Scalar(0);
    relative[j] = band == 0 && std::abs(relative[j]) > std::abs(now) ? relative[j] : now;
    highest = std::max(highest, std::abs(static_cast<double>(relative[j])));
  }
  return highest;
}

template <typename Scalar>
void ContactObserver<Scalar>::judge() noexcept {
  const auto held = static_cast<Index>(std::lround(options_.hold * options_.f_m));
  collision_.take(highest_of(1, fast_relative_), held);
  contact_.take(highest_of(0, relative_), held);
  if (!contact_.on) {
    link_ = -1;
    return;
  }
  for (Index j = 0; j < size(); ++j) {
    const double deviations = std::abs(static_cast<double>(relative_[j])) * level_of(j);
    link_ = std::isfinite(level_of(j)) && deviations > felt ? std::max(link_, j) : std::max<Index>(link_, 0);
  }
}

// Frames of the joints up to `last` one after the other, in the base.
template <typename Scalar>
template <typename Visit>
void ContactObserver<Scalar>::visit_frames(Index last, const Visit& visit) const noexcept {
  Eigen::Matrix3<Scalar> R = Eigen::Matrix3<Scalar>::Identity();
  Eigen::Vector3<Scalar> p = Eigen::Vector3<Scalar>::Zero();
  for (Index j = 0; j <= last; ++j) {
    const Chain::Link& l = model_.chain.links[static_cast<std::size_t>(j)];
    p += R * l.p.template cast<Scalar>();
    R *= l.R.template cast<Scalar>();
    if (l.type == JointType::revolute) {
      Scalar s(0);
      Scalar c(1);
      detail::sin_cos(q_[j], s, c);
      const Eigen::Vector3<Scalar> x = R.col(0);
      R.col(0) = c * x + s * R.col(1);
      R.col(1) = c * R.col(1) - s * x;
    } else {
      p += R.col(2) * q_[j];
    }
    visit(j, R, p);
  }
}

template <typename Scalar>
Eigen::Vector3<Scalar> ContactObserver<Scalar>::force(Index link,
                                                      const Eigen::Vector3<Scalar>& point) const noexcept {
  // No moment, and any force.
  constexpr double any = 1e4;    // [N] any large value
  constexpr double none = 1e-6;  // [N·m] any small value
  return explained(link, point, any, none).value.template head<3>();
}

template <typename Scalar>
auto ContactObserver<Scalar>::explained(Index link, const Eigen::Vector3<Scalar>& point, double force,
                                        double moment) const noexcept -> Wrench {
  using V = Eigen::Vector3<Scalar>;
  using M = Eigen::Matrix3<Scalar>;
  Wrench out;
  if (link < 0 || link >= size()) {
    return out;
  }
  V at = V::Zero();
  visit_frames(link, [&](Index j, const M& R, const V& p) {
    if (j == link) {
      at = p + R.col(0) * point[0] + R.col(1) * point[1] + R.col(2) * point[2];
    }
  });
  // Weighted normal equations; what is known beforehand stands for what is not seen.
  detail::Equations<6> A{};
  for (std::size_t i = 0; i < 6; ++i) {
    const double usual = i < 3 ? force : moment;
    A[i][i] = 1.0 / (usual * usual);
  }
  visit_frames(link, [&](Index j, const M& R, const V& p) {
    const V axis = R.col(2);
    const V arm = at - p;
    std::array<Scalar, 6> row = {axis[0], axis[1], axis[2], Scalar(0), Scalar(0), Scalar(0)};
    if (model_.chain.links[static_cast<std::size_t>(j)].type == JointType::revolute) {
      row = {axis[1] * arm[2] - axis[2] * arm[1],
             axis[2] * arm[0] - axis[0] * arm[2],
             axis[0] * arm[1] - axis[1] * arm[0],
             axis[0],
             axis[1],
             axis[2]};
    }
    const auto sigma = static_cast<double>(deviation_[j]);
    const double weight = std::isfinite(sigma) ? 1.0 / (sigma * sigma) : 1.0;
    for (std::size_t i = 0; i < 6; ++i) {
      const double weighted = weight * static_cast<double>(row[i]);
      for (std::size_t k = 0; k < 6; ++k) {
        A[i][k] += weighted * static_cast<double>(row[k]);
      }
      A[i][6] += weighted * static_cast<double>(residual_[j] - (std::isfinite(sigma) ? mean_[j] : Scalar(0)));
    }
  });
  const auto solved = detail::solved<6>(A);
  for (std::size_t i = 0; i < 6; ++i) {
    out.value[static_cast<Index>(i)] = static_cast<Scalar>(solved[i].value);
    out.sigma[static_cast<Index>(i)] = static_cast<Scalar>(std::sqrt(std::max(solved[i].variance, 0.0)));
  }
  return out;
}

#ifdef RIVID_LIBRARY
extern template class ContactObserver<double>;
#endif

}  // namespace rivid
