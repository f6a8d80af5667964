#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/control.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/types.hpp"

namespace rivid {

namespace detail {
// {1, −1}, made where no exception can pass: g++ 12 warns of members that an aggregate has not made yet
// otherwise.
[[nodiscard]] std::vector<double> backward_difference() noexcept;
}  // namespace detail

/// How the motion is integrated.
enum class Integrator {
  automatic,  ///< adams where the control is continuous, bogacki_shampine where it is sampled
  adams,  ///< CVODE, variable-order Adams method with functional iteration: smooth loops that are not stiff
  bdf,    ///< CVODE, variable-order BDF with Newton iteration: stiff loops
  bogacki_shampine,  ///< explicit Runge-Kutta 3(2): control in periods that are short against the motion,
                     ///< after each of which a multistep method would have to start again
  dormand_prince,    ///< explicit Runge-Kutta 5(4): the same with tight tolerances or long periods
  rk4                ///< the classical method with one fixed step a control period and no error control
};

/// What happens where a joint reverses.
enum class DryFrictionScheme {
  exact,   ///< sign(q̇) and stiction, reversal by reversal, see StickSlip
  smooth,  ///< tanh(q̇ / smooth_velocity) instead of the sign; nothing ever sticks
  held  ///< as `smooth`, but all friction is evaluated once a step and held (rk4 alone): the scheme of BIRDy
};

template <>
inline constexpr std::array names_of<Integrator> = std::to_array<std::string_view>(
    {"automatic", "adams", "bdf", "bogacki_shampine", "dormand_prince", "rk4"});
template <>
inline constexpr std::array names_of<DryFrictionScheme> =
    std::to_array<std::string_view>({"exact", "smooth", "held"});

/// Velocity filters that have a name: {1, −1}, {1/2, 0, −1/2}, {}.
enum class VelocityFilter { backward, central, none };
template <>
inline constexpr std::array names_of<VelocityFilter> =
    std::to_array<std::string_view>({"backward", "central", "none"});

/// A control law that runs on a computer: measures at t_k, and holds what it computes until t_{k+1}.
struct Sampling {
  double period = 0.0;  ///< [s]; 0: the law is continuous, and sees the true motion
  /// Periods, and a part of one, from a measurement to the control signal that follows from it, which is
  /// held for a period from then on.
  double delay = 0.0;
  /// q̇[k] = Σ_i velocity_filter[i] q[k − i] / period, for what the law takes as velocity: {1, −1} is the
  /// backward difference; empty: the true velocity. Before the first sample the position counts as constant.
  std::vector<double> velocity_filter = detail::backward_difference();
  Vector quantum = {};  ///< resolution of the position measurement, (n) or empty [rad | m]; 0 is none
  /// Error of the measured position at each instant, (periods × n) or empty [rad | m]; rows beyond the last
  /// are zero. It goes through the controller.
  Matrix position_noise = {};
  /// Which reference the law sees at t_k: that of t_k + reference_lead periods (BIRDy's has that of the end
  /// of the step).
  int reference_lead = 0;

  /// @param n  joints
  [[nodiscard]] std::optional<std::string> complaint(Index n) const;

  template <typename S = Sampling>
  static constexpr auto fields() {
    return std::tuple(
        Field{"rate_hz",
              [](const S& s) { return s.period > 0.0 ? 1.0 / s.period : 0.0; },
              "rate of the controller: it measures at t_k and holds its signal until t_{k+1}",
              {.otherwise = "continuous", .unit = "Hz", .range = rate_range}},
        Field{"delay",
              &S::delay,
              "from a measurement to its signal, also a part of one; with `rate_hz`",
              {.unit = "periods", .range = Range::from(0.0, 1e6)}},
        Field{"velocity_filter",
              shown_key<std::variant<VelocityFilter, std::vector<double>>>(
                  [](const S& s) { return s.velocity_filter; }),
              "c of q̇[k] = Σ c_i q[k−i] rate_hz: `\"backward\"` is [1, −1], `\"central\"` [0.5, 0, −0.5]; "
              "`\"none\"`: the true velocity; with `rate_hz`",
              {.otherwise = "`\"backward\"`"}},
        Field{"reference_lead",
              &S::reference_lead,
              "the law sees the reference of so many periods later; with `rate_hz`",
              {.unit = "periods", .range = Range::within(-1e6, 1e6)}},
        Field{"quantum",
              &S::quantum,
              "resolution of measured positions",
              {.otherwise = "0", .unit = "rad, m"}});
  }
};

struct SimulationOptions {
  double f_m = 1000.0;  ///< rate of the samples of the result [Hz]
  Index samples = 0;    ///< of the result; 0: the whole reference, first and last instant included
  /// Where the motion starts, (n); empty: on the reference.
  Vector q_0 = {};
  Vector qd_0 = {};

  Sampling sampling = {};
  /// Added to the control signal, after its saturation, and not seen by the law, (periods × n) or empty. Held
  /// for a control period, or for a sample where the law is continuous.
  Matrix added_control = {};
  Matrix disturbance =
      {};  ///< torques that act beside the drives, held alike, (periods × n) or empty [N·m | N]

  DryFrictionScheme friction = DryFrictionScheme::exact;
  double smooth_velocity = 1e-3;  ///< [rad/s | m/s]

  Integrator integrator = Integrator::automatic;
  double rtol = 1e-6;     ///< relative tolerance of a step
  double atol = 1e-8;     ///< absolute tolerance of a step [rad | m, and per second]
  double max_step = 0.0;  ///< [s]; 0 is none

  /// Budgets, so that a loop that can not be integrated ends: steps, and wall-clock time [s].
  Index max_steps = 10'000'000;
  double max_seconds = 600.0;
  /// Velocities beyond this end the simulation as `diverged` [rad/s | m/s].
  double max_velocity = 1e6;

  template <typename S = SimulationOptions>
  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple(
            Field{"rate_hz",
                  &S::f_m,
                  "rate of the log; required with a continuous law",
                  {.otherwise = "that of the controller", .unit = "Hz", .range = rate_range}},
            Field{
                "q_0", &S::q_0, "position at the start", {.otherwise = "on the reference", .unit = "rad, m"}},
            Field{"qd_0",
                  &S::qd_0,
                  "velocity at the start",
                  {.otherwise = "of the reference", .unit = "rad/s, m/s"}}),
        integration<S>());
  }
  /// Of the integration itself, which the loop of the instruments has too.
  template <typename S = SimulationOptions>
  static constexpr auto integration() {
    return std::tuple(
        Field{"dry_friction", &S::friction,
              "`\"exact\"`: stick and slip; `\"smooth\"`: tanh; `\"held\"`: tanh, once a step"},
        Field{
            "smooth_velocity", &S::smooth_velocity, "of tanh(q̇ / `smooth_velocity`)", {.unit = "rad/s, m/s"}},
        Field{"integrator", &S::integrator,
              "`\"adams\"`, `\"bdf\"`, `\"bogacki_shampine\"`, `\"dormand_prince\"`, `\"rk4\"`; "
              "`\"automatic\"` is `adams` for continuous laws, else `bogacki_shampine`"},
        Field{"rtol", &S::rtol, "relative tolerance of a step", {.range = Range::between(1e-15, 1.0)}},
        Field{"atol",
              &S::atol,
              "absolute tolerance of a step",
              {.unit = "rad, m and per s", .range = Range::from(1e-30, 1e3)}},
        Field{"max_step",
              &S::max_step,
              "longest step",
              {.otherwise = "none", .unit = "s", .range = Range::from(0.0, 1e6)}},
        Field{"max_steps", &S::max_steps, "budget", {.range = Range::from(1, 1e12)}},
        Field{"max_seconds",
              &S::max_seconds,
              "budget of wall-clock time",
              {.unit = "s", .range = Range::above(0.0, 1e7)}},
        Field{"max_velocity",
              &S::max_velocity,
              "faster is diverged",
              {.unit = "rad/s, m/s", .range = Range::above(0.0, largest_number)}});
  }

  /// Called with the fraction of the samples that is done, once in some hundred steps; may be empty.
  std::function<void(double)> progress = {};

  /// @param n         joints
  /// @param duration  of the reference, for a whole one (samples = 0) [s]
  [[nodiscard]] std::optional<std::string> complaint(Index n, double duration = 0.0) const;
};

/// How a simulation ended.
enum class Outcome {
  completed,
  not_positive_definite,  ///< M(q) lost definiteness: these parameters are no robot there
  diverged,               ///< the loop is unstable, or its law or its reference is no number
  too_slow,               ///< a budget was used up
  integrator_failed       ///< the tolerances could not be met
};

template <>
inline constexpr std::array names_of<Outcome> = std::to_array<std::string_view>(
    {"completed", "not positive definite", "diverged", "too slow", "integrator failed"});

/// What it took.
struct SimulationEffort {
  Index steps = 0;             ///< of the integrator
  Index right_hand_sides = 0;  ///< evaluations of the dynamics by the integrator
  Index restarts = 0;          ///< of the integrator, at events and control periods
  Index mode_changes = 0;      ///< slip to stick, stick to slip, reversals, over all elements
  double seconds = 0.0;        ///< wall-clock time

  template <typename R = SimulationEffort>
  static constexpr auto fields() {
    return std::tuple(Field{"steps", &R::steps, "of the integrator"},
                      Field{"right_hand_sides", &R::right_hand_sides, "evaluations of the dynamics"},
                      Field{"restarts", &R::restarts, "at events and control periods"},
                      Field{"mode_changes", &R::mode_changes, "of dry friction"},
                      Field{"seconds", &R::seconds, "wall-clock time", {.unit = "s"}});
  }
};

/// A motion of the robot in its closed loop, the answer of simulate().
struct [[nodiscard]] Simulation {
  Outcome outcome = Outcome::completed;
  std::string reason;  ///< why it ended early, in words that name time and joint

  Vector t;       ///< instants, (n_m) [s]; those before the end, where it came early
  Motion motion;  ///< true motion at these instants, (n_m × n); q̈ with the torques of the same row
  Matrix v_tau;   ///< control signals that act from t_k on, saturated, without added_control, (n_m × n)
  Matrix tau;     ///< torques of the drives, G (v_tau + added_control), (n_m × n) [N·m | N]
  Matrix q_r;     ///< reference, (n_m × n)
  Matrix qd_r;
  /// Positions as the controller measured them, where it is sampled and t_k is one of its instants; else the
  /// true ones.
  Matrix q_measured;

  std::vector<std::string> element_names;  ///< dry friction elements
  std::vector<Index> element_changes;      ///< mode changes of each
  Vector max_tracking_error;               ///< largest |q_r − q| over the samples, (n) [rad | m]
  std::vector<Finding> warnings;           ///< reference outside of the joint limits, clamped friction
  SimulationEffort effort;
};

/// The motion that a robot makes in its closed loop, by the direct dynamic model, Eq. (21) of [RIV].
///
/// @param robot      its drives and limits
/// @param model      its dynamics with numbers
/// @param law        control law with its gains
/// @param reference  what the law follows
/// @return           the motion; where it could not be carried through, up to there, with the reason in
///                   `outcome`
/// @throws InputError  where the sizes, an option, or the reference's beginning or duration can not be used
Simulation simulate(const Robot& robot, const DynamicModel& model, const ControlLaw& law,
                    const Reference& reference, const SimulationOptions& options = {});

/// The same from base parameters, with gains adapted to them, Eq. (46) of [RIV].
///
/// @param chi      (b)
/// @param control  kind of law
/// @param J        design inertias that the gains are matched to, see design_inertia(), (n)
/// @throws InputError  as above; where the control is empty or makes no law
Simulation simulate(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi,
                    const Control& control, const Eigen::Ref<const Vector>& J, const Reference& reference,
                    const SimulationOptions& options = {});

/// A simulated experiment: what happened, what it was made with, and the log that a recorder would have kept.
struct [[nodiscard]] SimulationRecord {
  Simulation simulation;
  Log log;

  BaseParameters base;
  Vector chi;  ///< base parameters that were simulated, (b)
  Vector J;    ///< design inertias that the gains are matched to, (n); empty where M_jj is not positive
  ControlDescription control;    ///< gains in force
  double control_hz = 0.0;       ///< 0: the law is continuous [Hz]
  bool control_assumed = false;  ///< see ControlLoop
  std::uint64_t seed = 0;
  std::vector<Finding> warnings;  ///< of robot, simulation and log together
};

/// What a simulation is going to be.
struct SimulationOutlook {
  SimulationRecord record;  ///< all that is known before the motion; the outcome where it can not even start
  Index samples = 0;
  double f_m = 0.0;  ///< [Hz]
};

}  // namespace rivid
