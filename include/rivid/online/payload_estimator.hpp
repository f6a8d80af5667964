#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/row_noise.hpp"
#include "rivid/online/row_triangle.hpp"
#include "rivid/online/saved_state.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/text.hpp"

namespace rivid {

struct PayloadEstimatorOptions {
  RowStreamOptions rows = {};
  /// Pose of the flange frame in the frame of the last link, which payloads refer to: orientation and origin
  /// [m].
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  /// Relative standard deviation of the drive gains, as if all erred alike: it is that of the mass.
  double gain_sigma = 0.0;
  /// Relative standard deviation by which friction may have changed since the identification: by temperature,
  /// say.
  double friction_change = 0.05;
  /// Friction that follows the load in joints whose law lacks it, as a standard deviation of its part of the
  /// load.
  double load_friction = 0.02;
  /// A change that is shorter is no payload's but something that touches the robot, and until then it may be
  /// one. 0: each change that is found is a payload's [s].
  double longest_touch = 0.0;
  /// Mass and distance from the flange that a payload may have, as standard deviations about none [kg], [m].
  double mass_scale = 10.0;
  double length_scale = 0.15;
  /// Time constant of forgetting while the robot moves [s]: of what was learned; the model's parameters stay
  /// known as it knows them. Infinite: nothing is forgotten but a payload that has changed.
  double forgetting = 60.0;
  double hours_to_false_alarm = 10.0;  ///< mean time of motion to a change of payload that is none [h]
  double largest_change = 10.0;        ///< of the mass at once, as a standard deviation [kg]
  /// When numbers are good enough to send: half widths of the 95 % intervals of the mass, relative (or 50 g),
  /// and of the centre of mass [m].
  double good_mass = 0.05;
  double good_com = 0.02;

  [[nodiscard]] std::optional<std::string> complaint(Index joints) const {
    struct Named {
      const char* name;
      double value;
      bool finite;
    };
    for (const auto& [name, value, finite] :
         {Named{"mass_scale", mass_scale, true}, Named{"length_scale", length_scale, true},
          Named{"largest_change", largest_change, true}, Named{"forgetting", forgetting, false},
          Named{"hours_to_false_alarm", hours_to_false_alarm, false}, Named{"good_mass", good_mass, false},
          Named{"good_com", good_com, false}}) {
      if (!(value > 0.0)) {
        return std::string(name) + " is " + number(value) + ", must be positive";
      }
      if (finite && std::isinf(value)) {
        return std::string(name) + " is infinite, must be finite";
      }
    }
    if (!(longest_touch >= 0.0 && longest_touch < 1e6)) {
      return "longest_touch is " + number(longest_touch) + " s, must not be negative";
    }
    if (!(load_friction >= 0.0 && load_friction < 1.0)) {
      return "load_friction is " + number(load_friction) + ", must not be negative and be below 1";
    }
    if (!(gain_sigma >= 0.0 && gain_sigma <= 1.0) || !(friction_change >= 0.0) ||
        std::isinf(friction_change)) {
      return "gain_sigma is " + number(gain_sigma) + " and friction_change " + number(friction_change) +
             ", must be finite and not negative, the former at most 1";
    }
    if (!detail::is_rotation(R) || !p.allFinite()) {
      return "R is no rotation, or p is not finite";
    }
    return rows.complaint(joints);
  }
};

/// A payload as an estimator sees it, in the flange frame.
template <typename Scalar>
struct OnlinePayload {
  Scalar mass = 0;        ///< [kg], not negative
  Scalar mass_sigma = 0;  ///< standard deviation, all that is not known included
  Eigen::Vector3<Scalar> com =
      Eigen::Vector3<Scalar>::Zero();  ///< centre of mass [m]; zero where `held` is not set
  Eigen::Vector3<Scalar> com_sigma = Eigen::Vector3<Scalar>::Zero();  ///< [m]
  /// About the centre of mass, axes of the flange [kg·m²]: of some body. Zero where the motion does not show
  /// it.
  Eigen::Matrix3<Scalar> inertia = Eigen::Matrix3<Scalar>::Zero();
  Eigen::Vector3<Scalar> inertia_sigma = Eigen::Vector3<Scalar>::Zero();  ///< of Ixx Iyy Izz [kg·m²]
  bool held = false;  ///< whether there is a payload: the mass is above two deviations
  bool body = false;  ///< whether the inertia is determined; else the payload is a point
  /// Whether mass and centre of mass are known well enough for set_target_payload() or setLoad(), and nothing
  /// has changed in the last half second of motion.
  bool good = false;

  /// Half width of the 95 % interval of the mass.
  [[nodiscard]] Scalar mass_half_width() const { return quantile * mass_sigma; }
  /// The largest half width of the 95 % intervals of the centre of mass [m].
  [[nodiscard]] Scalar com_half_width() const { return quantile * com_sigma.maxCoeff(); }

  static constexpr Scalar quantile = Scalar(1.96);  ///< of 97.5 %

  /// For save_state().
  [[nodiscard]] auto state() noexcept {
    return std::tie(mass, mass_sigma, com, com_sigma, inertia, inertia_sigma, held, body, good);
  }
};

/// What hangs on the flange, in the control loop: mass, centre of mass and inertia with intervals, and when
/// that changes.
///
/// The ten parameters λ of a body on the last link and the base parameters χ of the arm are estimated
/// together from the rows of RowStream,
///
///   y = W χ + L λ + e,
///
/// with the model's χ̂ and covariance as what is known beforehand, friction of which may have changed by
/// `friction_change`. So the interval of the payload carries what is not known of the arm, and friction that
/// has warmed up is no payload. Errors of a joint's rows that are alike from row to row count with their
/// long-run variance; the gains' deviation is added. Nothing but q and τ is measured: no acceleration, see
/// RowStream.
///
/// A change of the payload is found by a likelihood-ratio test of the prediction errors on the columns of L
/// that belong to mass and first moments, for several onsets, and of those on what is held, which may be let
/// go; thresholds follow from `hours_to_false_alarm`. Then the estimate of the arm goes back to before the
/// change, and the payload is learned anew.
///
/// A tick costs the same as any other: the triangle takes a row over several ticks, and the solution is made
/// row by row, so that payload() is 11 ticks old at most. After the constructor no member allocates, throws
/// or locks.
///
/// @tparam Scalar  double or float
template <typename Scalar>
class PayloadEstimator {
 public:
  using Values = typename RowStream<Scalar>::Values;

  /// A change of the payload.
  struct Change {
    /// Whether the mass has grown or fallen; `unclear` until the new one is known, unless there was none
    /// before.
    enum class Kind { none, unclear, pick_up, release };
    Kind kind = Kind::none;
    Index tick = 0;          ///< when it was found, counted from the first
    Scalar mass_before = 0;  ///< and the mass and its deviation until then [kg]
    Scalar sigma_before = 0;
  };

  /// @throws InputError  where model or options can not be used
  explicit PayloadEstimator(const OnlineModel& model, const PayloadEstimatorOptions& options = {})
      : PayloadEstimator(Extended{detail::with_load_friction(
                             detail::usable("PayloadEstimator", model, options), options.load_friction)},
                         options) {}

  [[nodiscard]] Index joints() const noexcept { return rows_.stream().size(); }

  /// Takes a tick.
  ///
  /// @param q    positions, (n) [rad | m]
  /// @param tau  torques, joint side, or currents times drive gains, (n) [N·m | N]
  /// @return     whether a change of the payload was found
  bool update(const Values& q, const Values& tau) noexcept;

  /// The gripper has closed on something or has let it go: the payload is learned anew from now on, and what
  /// is known of the arm stays. To be called between the last tick before and the first one after.
  void payload_changed() noexcept;
  /// The payload is known, from a database or by weighing: a point in the flange frame, with deviations.
  ///
  /// @return  false, and nothing is done, where a number can not be used
  bool payload_known(const Scalar& mass, const Eigen::Vector3<Scalar>& com, const Scalar& mass_sigma,
                     const Scalar& com_sigma) noexcept;
  /// The gripper opens, or closes. What was held while it was open is held again when it opens.
  void gripper(bool open) noexcept;
  /// Something touches the robot, or no longer does. While it does nothing is learned, and nothing is good;
  /// what goes on for longer than `longest_touch`, as a change of the payload would, is one.
  void touched(bool now) noexcept;
  /// Whether something touches the robot: as said, or a change that was found and is no payload's yet.
  [[nodiscard]] bool touched() const noexcept { return counters_.touched; }
  /// Whether a change was found that may be something that touches the robot, and rows show it now.
  [[nodiscard]] bool touch_found() const noexcept {
    return counters_.touched && load_change_.shows() && !rests();
  }

  /// Instead of update(), for a tick that says nothing of the payload: while something touches the robot.
  void pause() noexcept {
    rows_.reset_stream();
    ++counters_.ticks;
  }

  [[nodiscard]] const OnlinePayload<Scalar>& payload() const noexcept { return payload_; }
  /// The last change that was found.
  [[nodiscard]] const Change& change() const noexcept { return change_; }
  /// The payload's parameters as columns of the last link have them, XX … M [frame of the link].
  [[nodiscard]] const Eigen::Matrix<Scalar, inertial_count, 1>& inertial() const noexcept { return lambda_; }
  /// Deviation that rows of joint j at this speed count with, alike as they are [N·m | N]; of a joint that is
  /// none no number.
  [[nodiscard]] Scalar row_sigma(Index j, const Scalar& speed) const noexcept {
    return j >= 0 && j < joints() ? static_cast<Scalar>(noise_.sigma(
                                        noise_.kind(static_cast<std::size_t>(j), static_cast<double>(speed))))
                                  : std::numeric_limits<Scalar>::quiet_NaN();
  }
  /// Mean square of late of errors that look like a load, over that of the noise, at least 1: all deviations
  /// are widened by its root.
  [[nodiscard]] Scalar misfit() const noexcept { return static_cast<Scalar>(load_change_.misfit()); }

  /// Friction, as the rows say it of late: coefficients of the model's base parameters.
  struct Coefficient {
    StandardParameter parameter;
    Scalar identified = 0;  ///< [SI, joint side]
    Scalar value = 0;
    Scalar sigma = 0;
  };
  [[nodiscard]] const std::vector<Coefficient>& friction() const noexcept { return friction_; }
  /// The test of a change over its threshold; above 1 there is one.
  [[nodiscard]] Scalar suspicion() const noexcept { return static_cast<Scalar>(load_change_.suspicion()); }

  /// All work that waits, and the solution: what the next ticks would do.
  void finish() noexcept;

  [[nodiscard]] auto state() noexcept {
    return std::tie(rows_, noise_, load_change_, friction_, friction_row_, without_, snapshots_[0],
                    snapshots_[1], snapshots_[2], snapshots_[3], inverse_, C_lambda_, lambda_, next_lambda_,
                    payload_, change_, counters_);
  }
  [[nodiscard]] const detail::StateOwner& state_owner() const noexcept { return owner_; }

 private:
  using Triangle = detail::InformationTriangle<Scalar>;
  using Outcome = typename Triangle::Outcome;
  using Ten = Eigen::Matrix<Scalar, inertial_count, 1>;
  using TenByTen = Eigen::Matrix<Scalar, inertial_count, inertial_count>;

  struct Extended {
    OnlineModel model;
  };
  PayloadEstimator(const Extended& extended, const PayloadEstimatorOptions& options);

  // Earlier states to go back to after a change.
  struct Snapshot {
    std::vector<Scalar> R;
    std::vector<detail::RowNoise::State> noise;
    Index step = 0;

    [[nodiscard]] auto state() noexcept { return std::tie(R, noise, step); }
  };
  static constexpr Index most_snapshots = 4;  // to go back to before a change; a choice
  struct Counters {
    Index ticks = 0;
    Index steps = 0;         // strides of motion so far
    Index since_change = 0;  // strides of motion since the payload changed
    Index prior_row = 0;     // that is repeated next
    Index solution_row = 0;  // that is made next
    Index friction = 0;      // coefficient that was made last
    Index snapshot = 0;      // the newest …
    Index snapshots = 1;     // … and how many there are of this payload
    bool touched = false;
    bool touch_said = false;
    Index touched_for = 0;  // ticks of motion
    Index since_row = 0;    // ticks
    Index tried_at = 0;     // step
    Index without = -1;     // step at which the gripper closed, if what it held was good
  };
  static constexpr double half_a_second = 0.5;  // [s] of motion; a choice: a change takes so long to count
  // Suspicion from which on nothing is good: noise alone has it once in some minutes.
  static constexpr double doubtful = 0.6;
  // Deviations of principal moments up to this part of the largest moment show an inertia.
  static constexpr double visible_inertia = 0.5;
  static constexpr double least_good_mass = 0.05;  // [kg] half-width that is good for any mass; a choice
  static constexpr double held_deviations = 2.0;   // of the mass: more is held; chance is 2.3 %
  // Time without rows after which the robot rests [s].
  static constexpr double shortest_rest = 0.2;
  // Columns beside y: changes of first moments and mass, of each onset.
  static constexpr Index signatures = 4 * detail::LoadChange::onsets;
  // Of the friction that may hold a joint at rest: uniform up to the dry friction.
  static constexpr double held_friction = 0.58;

  void make_prior(const OnlineModel& model);
  void make_flange();
  void take(const Outcome& outcome) noexcept;
  [[nodiscard]] auto taking() noexcept {
    return [this](const Outcome& outcome) { take(outcome); };
  }
  void add(const typename RowStream<Scalar>::Row& row, std::size_t kind) noexcept;
  void step() noexcept;
  void repeat_prior() noexcept;
  void take_snapshot() noexcept;
  void go_back(Index age) noexcept;
  void begin_touch() noexcept;
  [[nodiscard]] bool rests() const noexcept {
    return static_cast<double>(counters_.since_row) > shortest_rest * options_.rows.f_m;
  }
  [[nodiscard]] bool follow_touch() noexcept;
  void forget_payload() noexcept;
  void try_change() noexcept;
  void follow_change() noexcept;
  void payload_is_known() noexcept;
  void solve_a_row() noexcept;
  void solve_friction() noexcept;
  void publish() noexcept;
  // Of a linear function of the body in the flange frame; `by_body` are its slopes.
  [[nodiscard]] Scalar deviation(const Ten& by_body) const noexcept;
  // A deviation, with what the gains add to that of a value.
  [[nodiscard]] Scalar with_gain(const Scalar& sigma, const Scalar& value) const noexcept;
  void add_centre_of_mass(const Ten& body, OnlinePayload<Scalar>& out) const noexcept;
  void add_inertia(const Ten& body, OnlinePayload<Scalar>& out) const noexcept;
  void name_change(const Scalar& m, const Scalar& sigma) noexcept;
  [[nodiscard]] bool is_good(const OnlinePayload<Scalar>& payload, const Scalar& estimate) const noexcept;

  PayloadEstimatorOptions options_;
  detail::BodyColumns columns_;
  Index b_;
  detail::RowTriangle<Scalar> rows_;  // into that of [λ, χ]
  Triangle prior_;                    // what is known beforehand, of the same
  detail::RowNoise noise_;
  detail::LoadChange load_change_;
  std::array<Snapshot, most_snapshots> snapshots_;
  std::vector<Coefficient> friction_;
  std::vector<Index> friction_unknowns_;
  std::vector<Scalar> friction_row_;
  std::vector<Scalar> without_;           // rows of R of what the open gripper held
  std::vector<Scalar> inverse_;           // first rows of R⁻¹, as far as they are made
  TenByTen C_lambda_ = TenByTen::Zero();  // covariance of λ, as far as it is made
  TenByTen to_flange_;
  Ten lambda_ = Ten::Zero();
  Ten next_lambda_ = Ten::Zero();
  OnlinePayload<Scalar> payload_;
  Change change_;
  Counters counters_;
  Index steps_between_snapshots_;
  Index steps_of_half_a_second_;
  detail::StateOwner owner_;
};

template <typename Scalar>
PayloadEstimator<Scalar>::PayloadEstimator(const Extended& extended, const PayloadEstimatorOptions& options)
    : options_(options),
      columns_(extended.model.robot, extended.model.base),
      b_(extended.model.base.size()),
      rows_(extended.model, columns_.all.columns(), detail::row_options(extended.model, options),
            inertial_count + b_, options.forgetting, 1, signatures),
      prior_(inertial_count + b_, 1, signatures),
      noise_(extended.model.sigma_rho, detail::row_options(extended.model, options).velocity_threshold,
             rows_.seconds()),
      load_change_({.per_second = 1.0 / rows_.seconds(),
                    .hours_to_false_alarm = options.hours_to_false_alarm,
                    .mass = options.largest_change,
                    .length = options.length_scale}),
      inverse_(static_cast<std::size_t>(inertial_count * rows_.triangle().room_of_row()), Scalar(0)) {
  const OnlineModel& model = extended.model;
  steps_of_half_a_second_ = std::max<Index>(std::lround(half_a_second / rows_.seconds()), 1);
  steps_between_snapshots_ = steps_of_half_a_second_;
  owner_ = detail::owner_of<Scalar>("PayloadEstimator", model, options.rows, options.gain_sigma,
                                    options.friction_change, options.load_friction, options.longest_touch,
                                    options.mass_scale, options.length_scale, options.forgetting,
                                    options.hours_to_false_alarm, options.largest_change, options.good_mass,
                                    options.good_com);
  owner_.flange = detail::Fingerprint::of(options.R, options.p);
  make_flange();
  make_prior(model);
  for (Index i = 0; i < b_; ++i) {
    const StandardParameter& p = model.base.parameters[static_cast<std::size_t>(i)].leading;
    if (is_friction(p.kind)) {
      friction_.push_back(
          {p, static_cast<Scalar>(model.chi[i]), static_cast<Scalar>(model.chi[i]), Scalar(0)});
      friction_unknowns_.push_back(inertial_count + i);
    }
    if (about(p.kind).basis == Basis::sign) {
      noise_.set_rest(static_cast<std::size_t>(p.joint), held_friction * std::abs(model.chi[i]));
    }
  }
  friction_row_.assign(inverse_.size() / inertial_count, Scalar(0));
  without_.resize(static_cast<std::size_t>(inertial_count * rows_.triangle().room_of_row()));
  rows_.triangle().instead() = without_;
  for (Snapshot& snapshot : snapshots_) {
    snapshot.R = rows_.triangle().entries();
    snapshot.noise = noise_.states();
  }
  finish();
}

template <typename Scalar>
void PayloadEstimator<Scalar>::make_flange() {
  const Eigen::Matrix3d back = options_.R.transpose();
  const Eigen::Vector3d origin = -back * options_.p;
  for (Index k = 0; k < inertial_count; ++k) {
    to_flange_.col(k) = transformed(Inertial::Unit(k), back, origin).template cast<Scalar>();
  }
}

template <typename Scalar>
void PayloadEstimator<Scalar>::make_prior(const OnlineModel& model) {
  Matrix C = model.C_chi;
  for (Index i = 0; i < b_; ++i) {
    const StandardParameter& p = model.base.parameters[static_cast<std::size_t>(i)].leading;
    if (!is_friction(p.kind)) {
      continue;
    }
    double size = std::abs(model.chi[i]);
    if (role(p.kind) == Role::constant) {  // an offset changes with the dry friction of its joint
      for (Index k = 0; k < b_; ++k) {
        const StandardParameter& other = model.base.parameters[static_cast<std::size_t>(k)].leading;
        size =
            other.joint == p.joint && about(other.kind).basis == Basis::sign ? std::abs(model.chi[k]) : size;
      }
    }
    C(i, i) += options_.friction_change * options_.friction_change * size * size;
  }
  for (Index i = 0; i < inertial_count; ++i) {
    const double length = i < 6   ? options_.length_scale * options_.length_scale
                          : i < 9 ? options_.length_scale
                                  : 1.0;
    prior_.row_of_R(i)[i] = static_cast<Scalar>(1.0 / (options_.mass_scale * length));
  }
  detail::add_prior(prior_, C, model.chi, [](Index i) { return inertial_count + i; }, "PayloadEstimator");
  rows_.triangle().set_entries(prior_.entries(), rows_.triangle().size());
}

template <typename Scalar>
bool PayloadEstimator<Scalar>::update(const Values& q, const Values& tau) noexcept {
  ++counters_.ticks;
  rows_.tick(
      q, tau, [this](const auto& row) { add(row, noise_.kind(row.joint, static_cast<double>(row.speed))); },
      [this] { step(); }, taking());
  rows_.rest([this](const auto& row) { add(row, detail::RowNoise::at_rest(row.joint)); });
  bool changed = false;
  if (counters_.touched) {
    changed = follow_touch();
  } else if (load_change_.found() && options_.longest_touch > 0.0) {
    begin_touch();
  } else if (load_change_.found()) {
    go_back(static_cast<Index>(load_change_.age()));
    payload_changed();
    changed = true;
  }
  solve_a_row();
  return changed;
}

template <typename Scalar>
void PayloadEstimator<Scalar>::add(const typename RowStream<Scalar>::Row& row, std::size_t kind) noexcept {
  Scalar* const w = rows_.room(taking());
  const std::vector<Index>& own = rows_.stream().columns().of_joint(row.joint);
  const Scalar weight = Scalar(1) / static_cast<Scalar>(noise_.sigma(kind));
  for (std::size_t c = 0; c < own.size(); ++c) {
    const Index at = own[c];
    const Scalar value = row.values[c] * weight;
    if (at < b_) {
      w[inertial_count + at] = value;
    }
    for (std::size_t k = 0; k < inertial_count; ++k) {
      if (columns_.body[k] == at) {
        w[k] = value;
      }
    }
  }
  Scalar* const y = w + rows_.triangle().size();
  *y = row.y * weight;
  for (Index k = 0; k < signatures; ++k) {
    y[1 + k] = w[6 + k % 4];
  }
  rows_.triangle().commit(static_cast<int>(kind));
}

// A row has passed into the triangle.
template <typename Scalar>
void PayloadEstimator<Scalar>::take(const Outcome& outcome) noexcept {
  if (outcome.tag < 0) {
    return;
  }
  const auto kind = static_cast<std::size_t>(outcome.tag);
  const auto residual = static_cast<double>(outcome.residual);
  counters_.since_row = 0;
  detail::LoadChange::Signatures l;
  for (std::size_t k = 0; k < signatures; ++k) {
    l[k / 4][k % 4] = static_cast<double>(outcome.beside[k]);
  }
  if (!counters_.touched) {
    noise_.take(kind, (residual - load_change_.suspected(l)) * noise_.sigma(kind));
  }
  load_change_.take(l, residual, noise_, kind);
}

// Once a stride while anything moves.
template <typename Scalar>
void PayloadEstimator<Scalar>::step() noexcept {
  ++counters_.steps;
  ++counters_.since_change;
  load_change_.step();
  if (load_change_.found() && !counters_.touched) {
    return;
  }
  detail::LoadChange::Vector4 release{};
  for (std::size_t k = 0; k < 4 && payload_.mass > Scalar(0); ++k) {
    release[k] = -static_cast<double>(lambda_[static_cast<Index>(6 + k)]);
  }
  if (const auto onset = load_change_.restart(release)) {
    rows_.triangle().clear_beside(4 * static_cast<Index>(*onset), 4);
  }
  if (counters_.touched) {
    return;
  }
  if (rows_.keep() < 1.0) {
    rows_.triangle().fade(0, rows_.triangle().size(), static_cast<Scalar>(rows_.keep()));
    repeat_prior();
  }
  if (counters_.steps % steps_between_snapshots_ == 0 && load_change_.quiet()) {
    take_snapshot();
  }
}

// What is known beforehand fades with all else, and comes back row by row.
template <typename Scalar>
void PayloadEstimator<Scalar>::repeat_prior() noexcept {
  Scalar* const w = rows_.room(taking());
  const auto repeated = static_cast<Scalar>(rows_.repeated(prior_.size()));
  const Scalar* const r = prior_.row_of_R(counters_.prior_row);
  for (Index c = counters_.prior_row; c <= rows_.triangle().size(); ++c) {
    w[c] = r[c] * repeated;
  }
  rows_.triangle().commit(-1);
  counters_.prior_row = (counters_.prior_row + 1) % rows_.triangle().size();
}

template <typename Scalar>
void PayloadEstimator<Scalar>::take_snapshot() noexcept {
  counters_.snapshot = (counters_.snapshot + 1) % most_snapshots;
  counters_.snapshots = std::min(counters_.snapshots + 1, most_snapshots);
  Snapshot& to = snapshots_[static_cast<std::size_t>(counters_.snapshot)];
  rows_.triangle().keep_entries(to.R, rows_.triangle().size());
  std::ranges::copy(noise_.states(), to.noise.begin());
  to.step = counters_.steps;
}

// To what was known so many strides of motion ago, and half a second at least.
template <typename Scalar>
void PayloadEstimator<Scalar>::go_back(Index age) noexcept {
  age = std::max(age, steps_of_half_a_second_);
  const auto newest = [this] { return static_cast<std::size_t>(counters_.snapshot); };
  for (; counters_.snapshots > 1 && snapshots_[newest()].step > counters_.steps - age;
       --counters_.snapshots) {
    counters_.snapshot = (counters_.snapshot + most_snapshots - 1) % most_snapshots;
  }
  const Snapshot& before = snapshots_[newest()];
  rows_.triangle().drop_waiting();
  rows_.triangle().set_entries(before.R, rows_.triangle().size());
  rows_.triangle().clear_beside(0, signatures);
  std::ranges::copy(before.noise, noise_.states().begin());
  counters_.solution_row = 0;
  load_change_.reset();
  rows_.reset_stream();
}

template <typename Scalar>
void PayloadEstimator<Scalar>::payload_changed() noexcept {
  forget_payload();
  follow_change();
}

// From now on instead() is what is known of the payload.
template <typename Scalar>
void PayloadEstimator<Scalar>::follow_change() noexcept {
  change_ = {payload_.held ? Change::Kind::unclear : Change::Kind::pick_up, counters_.ticks, payload_.mass,
             payload_.mass_sigma};
  payload_.good = false;
  rows_.triangle().drop_waiting();
  rows_.triangle().set_entries(rows_.triangle().instead(), inertial_count);
  rows_.triangle().clear_beside(0, signatures);
  counters_.snapshots = 0;
  take_snapshot();
  counters_.since_change = 0;
  counters_.solution_row = 0;
  counters_.touched = false;
  rows_.triangle().watch(false);
  load_change_.reset();
  rows_.reset_stream();
}

// Rows of what is known of the ten parameters in the flange frame: a point, whose own inertia is like that of
// any body of its mass.
template <typename Scalar>
bool PayloadEstimator<Scalar>::payload_known(const Scalar& mass, const Eigen::Vector3<Scalar>& com,
                                             const Scalar& mass_sigma, const Scalar& com_sigma) noexcept {
  using std::abs;
  using std::sqrt;
  if (!(mass >= Scalar(0)) || !com.allFinite() || !(mass_sigma > Scalar(0)) || !(com_sigma > Scalar(0)) ||
      !(mass + mass_sigma + com_sigma < Scalar(1e9))) {
    return false;
  }
  payload_changed();
  const Eigen::Vector3<Scalar>& c = com;
  const Scalar reach = c.squaredNorm();
  Ten known;
  known << reach - c[0] * c[0], -c[0] * c[1], -c[0] * c[2], reach - c[1] * c[1], -c[1] * c[2],
      reach - c[2] * c[2], c, Scalar(1);
  const auto length = static_cast<Scalar>(options_.length_scale);
  for (Index k = 0; k < inertial_count; ++k) {
    const Scalar slope = k < 6 ? length * length : k < 9 ? abs(c[k - 6]) : Scalar(1);
    const Scalar own = k < 6   ? (mass + mass_sigma) * length * length
                       : k < 9 ? (mass + mass_sigma) * com_sigma
                               : Scalar(0);
    const Scalar sigma = sqrt(slope * slope * mass_sigma * mass_sigma + own * own);
    Scalar* const w = rows_.room(taking());
    for (Index i = 0; i < inertial_count; ++i) {
      w[i] = to_flange_(k, i) / sigma;
    }
    w[rows_.triangle().size()] = mass * known[k] / sigma;
    rows_.triangle().commit(-1);
  }
  payload_is_known();
  return true;
}

template <typename Scalar>
void PayloadEstimator<Scalar>::payload_is_known() noexcept {
  rows_.triangle().finish(taking());
  counters_.snapshots = 0;
  take_snapshot();
  counters_.since_change = steps_of_half_a_second_;
  finish();
}

template <typename Scalar>
void PayloadEstimator<Scalar>::gripper(bool open) noexcept {
  if (!open) {
    rows_.triangle().keep_entries(without_, inertial_count);
    counters_.without = payload_.good ? counters_.steps : -1;
  }
  payload_changed();
  if (open && counters_.without >= 0) {
    const auto since = static_cast<double>(counters_.steps - counters_.without);
    rows_.triangle().set_entries(without_, inertial_count);
    rows_.triangle().fade(0, inertial_count, static_cast<Scalar>(std::pow(rows_.keep(), since)));
    payload_is_known();
  }
}

template <typename Scalar>
void PayloadEstimator<Scalar>::touched(bool now) noexcept {
  counters_.touch_said = now;
  if (now && !counters_.touched) {
    begin_touch();
  }
}

// Nothing is learned from now on, and the rows that come are tested against what was known before.
template <typename Scalar>
void PayloadEstimator<Scalar>::begin_touch() noexcept {
  const bool found = load_change_.found();
  if (found) {
    try_change();
  }
  const detail::LoadChange tried = load_change_;
  const Index age = found ? static_cast<Index>(load_change_.age()) : 0;
  go_back(age);
  load_change_ = tried;
  rows_.triangle().watch(true);
  counters_.touched = true;
  // The time since a change counts, but rows that come show it for half of the time at least.
  const auto longest = static_cast<Index>(options_.longest_touch * options_.rows.f_m);
  counters_.touched_for = std::min(age * rows_.stream().stride(), longest / 2);
  counters_.since_row = 0;
  payload_.good = false;
}

template <typename Scalar>
void PayloadEstimator<Scalar>::try_change() noexcept {
  load_change_.try_change();
  forget_payload();
  counters_.tried_at = counters_.steps;
}

// Whether it was no touch but another payload.
template <typename Scalar>
bool PayloadEstimator<Scalar>::follow_touch() noexcept {
  const auto longest = static_cast<Index>(options_.longest_touch * options_.rows.f_m);
  // At rest no rows say whether it goes on.
  ++counters_.since_row;
  if (rests()) {
    load_change_.forget_rows();
  } else {
    ++counters_.touched_for;
  }
  if (!load_change_.tried() && load_change_.found()) {
    try_change();
  }
  if (counters_.touched_for >= longest && !rests() && load_change_.goes_on()) {
    follow_change();
    counters_.since_change = counters_.steps - counters_.tried_at;
    return true;
  }
  if (load_change_.over()) {  // one that looks otherwise in another pose is tried anew
    if (load_change_.shows()) {
      try_change();
    } else {
      load_change_.reset();
    }
  }
  if (!counters_.touch_said && !load_change_.tried()) {
    counters_.touched = false;
    rows_.triangle().watch(false);
    rows_.triangle().drop_waiting();
    load_change_.reset();
    rows_.reset_stream();
  }
  return false;
}

template <typename Scalar>
void PayloadEstimator<Scalar>::forget_payload() noexcept {
  std::vector<Scalar>& rows = rows_.triangle().instead();
  std::ranges::fill(rows, Scalar(0));
  for (Index i = 0; i < inertial_count; ++i) {
    rows[static_cast<std::size_t>(i * (rows_.triangle().room_of_row() + 1))] = prior_.R(i, i);
  }
}

// One row of R⁻¹ a tick; after the tenth the solution is published.
template <typename Scalar>
void PayloadEstimator<Scalar>::solve_a_row() noexcept {
  const Index n = rows_.triangle().size();
  const Index i = counters_.solution_row;
  if (i == inertial_count) {
    publish();
    counters_.solution_row = 0;
    solve_friction();
    return;
  }
  Scalar* const x = &inverse_[static_cast<std::size_t>(i * rows_.triangle().room_of_row())];
  next_lambda_[i] = rows_.triangle().estimate(i, x).value;
  using Rest = Eigen::Map<const Eigen::VectorX<Scalar>>;
  for (Index k = 0; k <= i; ++k) {
    const Scalar* const other = &inverse_[static_cast<std::size_t>(k * rows_.triangle().room_of_row())];
    C_lambda_(i, k) = C_lambda_(k, i) = Rest(x + i, n - i).dot(Rest(other + i, n - i));
  }
  ++counters_.solution_row;
}

// One coefficient of friction.
template <typename Scalar>
void PayloadEstimator<Scalar>::solve_friction() noexcept {
  using std::sqrt;
  if (friction_.empty()) {
    return;
  }
  counters_.friction = (counters_.friction + 1) % std::ssize(friction_);
  const Index i = friction_unknowns_[static_cast<std::size_t>(counters_.friction)];
  const auto [value, variance] = rows_.triangle().estimate(i, friction_row_.data());
  friction_[static_cast<std::size_t>(counters_.friction)].value = value;
  friction_[static_cast<std::size_t>(counters_.friction)].sigma = sqrt(variance);
}

template <typename Scalar>
void PayloadEstimator<Scalar>::finish() noexcept {
  rows_.triangle().finish(taking());
  counters_.solution_row = 0;
  for (Index i = 0; i <= inertial_count; ++i) {
    solve_a_row();
  }
}

template <typename Scalar>
void PayloadEstimator<Scalar>::publish() noexcept {
  lambda_ = next_lambda_;
  rows_.set_body(lambda_, columns_.body);
  const Ten body = to_flange_.lazyProduct(lambda_);
  const Scalar m = body[9];
  OnlinePayload<Scalar> out;
  out.mass_sigma = with_gain(deviation(Ten::Unit(9)), m);
  out.mass = std::max(m, Scalar(0));
  out.held = m > static_cast<Scalar>(held_deviations) * out.mass_sigma;
  if (out.held) {
    add_centre_of_mass(body, out);
    add_inertia(body, out);
  }
  name_change(m, out.mass_sigma);
  out.good = is_good(out, m);
  payload_ = out;
}

template <typename Scalar>
Scalar PayloadEstimator<Scalar>::deviation(const Ten& by_body) const noexcept {
  using std::sqrt;
  const Ten slope = to_flange_.transpose().lazyProduct(by_body);  // by λ
  return sqrt(std::max(slope.dot(C_lambda_.lazyProduct(slope)), Scalar(0)) * misfit());
}

template <typename Scalar>
Scalar PayloadEstimator<Scalar>::with_gain(const Scalar& sigma, const Scalar& value) const noexcept {
  using std::sqrt;
  const auto gain = static_cast<Scalar>(options_.gain_sigma);
  return sqrt(sigma * sigma + gain * gain * value * value);
}

template <typename Scalar>
void PayloadEstimator<Scalar>::add_centre_of_mass(const Ten& body,
                                                  OnlinePayload<Scalar>& out) const noexcept {
  const Scalar& m = body[9];
  out.com = body.template segment<3>(6) / m;
  for (Index k = 0; k < 3; ++k) {
    Ten slope = Ten::Zero();
    slope[6 + k] = Scalar(1) / m;
    slope[9] = -out.com[k] / m;
    out.com_sigma[k] = with_gain(deviation(slope), out.com.norm());
  }
}

// About the centre of mass, where the motion shows it.
template <typename Scalar>
void PayloadEstimator<Scalar>::add_inertia(const Ten& body, OnlinePayload<Scalar>& out) const noexcept {
  const Eigen::Vector3<Scalar>& c = out.com;
  Eigen::Matrix3<Scalar> I;
  I << body[0], body[1], body[2], body[1], body[3], body[4], body[2], body[4], body[5];
  Eigen::Vector3<Scalar> sigma;
  constexpr std::array<Index, 3> moments = {0, 3, 5};  // places of Ixx, Iyy, Izz
  for (Index k = 0; k < 3; ++k) {
    // Ixx about the centre of mass: XX − m (c_y² + c_z²), in the first moments.
    Ten slope = Ten::Zero();
    slope[moments[static_cast<std::size_t>(k)]] = Scalar(1);
    for (Index i = 0; i < 3; ++i) {
      if (i != k) {
        slope[6 + i] = Scalar(-2) * c[i];
        slope[9] += c[i] * c[i];
      }
    }
    sigma[k] = deviation(slope);
  }
  I -= body[9] * (c.squaredNorm() * Eigen::Matrix3<Scalar>::Identity() - c * c.transpose());
  const Scalar largest = I.diagonal().maxCoeff();
  out.body = sigma.maxCoeff() <= static_cast<Scalar>(visible_inertia) * largest;
  if (out.body) {
    out.inertia = detail::nearest_inertia(I);
    for (Index k = 0; k < 3; ++k) {
      out.inertia_sigma[k] = with_gain(sigma[k], largest);
    }
  }
}

template <typename Scalar>
void PayloadEstimator<Scalar>::name_change(const Scalar& m, const Scalar& sigma) noexcept {
  using std::abs;
  if (change_.kind != Change::Kind::unclear) {
    return;
  }
  const Scalar more = m - change_.mass_before;
  if (abs(more) > static_cast<Scalar>(held_deviations) * (sigma + change_.sigma_before)) {
    change_.kind = more > Scalar(0) ? Change::Kind::pick_up : Change::Kind::release;
  }
}

template <typename Scalar>
bool PayloadEstimator<Scalar>::is_good(const OnlinePayload<Scalar>& payload,
                                       const Scalar& estimate) const noexcept {
  // A mass below nothing by more than its interval is that of no body: the model is wrong.
  const bool possible = estimate > -payload.mass_half_width();
  return counters_.since_change >= steps_of_half_a_second_ && load_change_.suspicion() < doubtful &&
         !counters_.touched && possible &&
         payload.mass_half_width() <= std::max(static_cast<Scalar>(options_.good_mass) * payload.mass,
                                               static_cast<Scalar>(least_good_mass)) &&
         (!payload.held || payload.com_half_width() <= static_cast<Scalar>(options_.good_com));
}

#ifdef RIVID_LIBRARY
extern template class PayloadEstimator<double>;
#endif

}  // namespace rivid
