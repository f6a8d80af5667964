#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/excite/limits.hpp"
#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// What a design makes small, of the covariance C of the base parameters.
enum class Criterion {
  information,  ///< log det C: the geometric mean of all standard deviations, whatever the units (D-optimal)
  torque,       ///< the mean variance of predicted torques along other motions within the limits (I-optimal)
  parameters,   ///< the geometric mean of the standard deviations of some parameters
  condition  ///< the condition number of the weighted observation matrix, which others make small: to compare
             ///< with
};

template <>
inline constexpr std::array names_of<Criterion> =
    std::to_array<std::string_view>({"information", "torque", "parameters", "condition"});

/// Functions of time that a motion is made of.
enum class CurveKind {
  fourier,  ///< Fourier series
  spline    ///< splines of fifth degree
};

template <>
inline constexpr std::array names_of<CurveKind> = std::to_array<std::string_view>({"fourier", "spline"});

/// Errors that an identification will meet.
struct TorqueNoise {
  Vector sigma =
      {};  ///< standard deviation of each joint's torque errors, (n); empty: 1 % of its limit [N·m | N]
  double rate_hz =
      0.0;  ///< at which these are independent of each other; 0: that of the motion's samples [Hz]

  template <typename N = TorqueNoise>
  static constexpr auto fields() {
    return std::tuple(
        Field{"noise",
              &N::sigma,
              "standard deviation of each joint's torque errors",
              {.otherwise = "1 % of the torque limit", .unit = "N·m, N", .range = Range::above(0.0, 1e12)}},
        Field{"noise_rate_hz",
              &N::rate_hz,
              "rate at which errors of that size are independent of each other",
              {.otherwise = "`rate_hz`", .unit = "Hz", .range = rate_range}});
  }
};

/// Standard deviations that an identification is to reach, in percent of a parameter's a-priori value, or of
/// a tenth of the largest of its unit where that is more. 0: not asked for.
struct ExcitationTarget {
  double mass_percent = 0.0;  ///< of masses, first moments, inertias and rotors
  double Fv_percent = 0.0;
  double Fc_percent = 0.0;
  double seconds = 300.0;  ///< that all repetitions of the motion may take [s]

  [[nodiscard]] bool wanted() const { return mass_percent > 0.0 || Fv_percent > 0.0 || Fc_percent > 0.0; }

  template <typename T = ExcitationTarget>
  static constexpr auto fields() {
    constexpr Range percent = Range::within(0.0, 1e3);
    return std::tuple(Field{"mass_percent",
                            &T::mass_percent,
                            "largest standard deviation of masses, first moments, inertias and rotors",
                            {.otherwise = "not asked for", .unit = "%", .range = percent}},
                      Field{"Fv_percent",
                            &T::Fv_percent,
                            "of viscous friction",
                            {.otherwise = "not asked for", .unit = "%", .range = percent}},
                      Field{"Fc_percent",
                            &T::Fc_percent,
                            "of Coulomb friction",
                            {.otherwise = "not asked for", .unit = "%", .range = percent}},
                      Field{"seconds",
                            &T::seconds,
                            "that all repetitions may take",
                            {.unit = "s", .range = Range::above(0.0, 1e5)}});
  }
};

/// What design() is asked for.
struct ExcitationOptions {
  double duration = 15.0;  ///< of the motion, one period of a Fourier series [s]
  CurveKind curve = CurveKind::fourier;
  int harmonics = 5;       ///< of a Fourier series
  int points = 15;         ///< of a spline: coefficients of a joint between those of the ends
  Vector start = {};       ///< position at both ends, (n); empty: the design decides [rad | m]
  Vector lead_from = {};   ///< pose of the robot before the motion, (n); empty: that of the motion [rad | m]
  Vector lead_to = {};     ///< and behind it; empty: the same [rad | m]
  double rate_hz = 500.0;  ///< of the controller that plays the motion
  Criterion criterion = Criterion::information;
  std::vector<std::string> parameters = {};  ///< of Criterion::parameters, by their names
  TorqueNoise noise = {};
  /// If one is wanted, the design chooses harmonics, a period of at most `duration`, and its repetitions.
  ExcitationTarget target = {};
  MotionLimits limits = {};
  Space space = {};        ///< what the robot must not touch
  Matrix known = {};       ///< information of earlier logs, Σ Wᵀ W / σ², (b × b); empty: none
  int starts = 4;          ///< random motions that the search begins with
  std::uint64_t seed = 1;  ///< of the first one; the others have the next numbers
  int evaluations = 800;   ///< of a search, at most; polishing takes a third of it, of the best start as many
  int samples = 0;  ///< instants at which limits are kept while searching; 0: 40 a harmonic, 16 a point
  int threads = 1;  ///< that share the starts; the result is the same whatever their number
  std::function<void(std::string_view stage, double fraction)> progress = {};
  /// Asked now and then: true ends the search, and the best motion so far is returned.
  std::function<bool()> stopped = {};

  /// @param robot  that is to be moved
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  template <typename E = ExcitationOptions>
  static constexpr auto fields() {
    return std::tuple(
        Field{"duration",
              &E::duration,
              "of the motion, one period of its Fourier series",
              {.unit = "s", .range = Range::above(0.0, 1e6)}},
        Field{"curve", &E::curve,
              "`\"fourier\"`: series, or `\"spline\"`: of fifth degree, written as a CSV file only"},
        Field{"harmonics", &E::harmonics, "of the Fourier series", {.range = Range::within(2, 50)}},
        Field{"points",
              &E::points,
              "of the spline: control points of a joint between its ends",
              {.range = Range::within(3, 200)}},
        Field{"start",
              &E::start,
              "position at both ends",
              {.otherwise = "the design decides", .unit = "rad, m"}},
        Field{"lead_from",
              &E::lead_from,
              "pose of the robot before the motion: a lead-in from it and a lead-out are planned within the "
              "same limits",
              {.otherwise = "where the motion begins", .unit = "rad, m", .range = MotionLimits::positions}},
        Field{"lead_to",
              &E::lead_to,
              "pose that the lead-out goes to",
              {.otherwise = "`lead_from`", .unit = "rad, m", .range = MotionLimits::positions}},
        Field{"rate_hz",
              &E::rate_hz,
              "rate of the controller that plays the motion, and of the log",
              {.unit = "Hz", .range = rate_range}},
        Field{"criterion", &E::criterion,
              "what is minimised: `\"information\"`: geometric mean of all standard deviations; "
              "`\"torque\"`: variance of predicted torques on other motions; `\"parameters\"`: standard "
              "deviations of those in `for`; `\"condition\"`: condition number"},
        Field{"for",
              &E::parameters,
              "names of base parameters, for `criterion = \"parameters\"`",
              {.otherwise = "–"}},
        Field{"starts",
              &E::starts,
              "random motions that the search begins with",
              {.range = Range::from(1, 1e5)}},
        Field{"seed",
              &E::seed,
              "of the random motions; gives the same motion with the same program on the same kind of "
              "processor",
              {.range = seed_range}},
        Field{"evaluations",
              &E::evaluations,
              "of the search of each start, at most, polishing besides",
              {.range = Range::from(1, 1e6)}},
        Field{"samples",
              &E::samples,
              "instants at which limits are kept while searching",
              {.otherwise = "40 a harmonic, 16 a point", .range = Range::from(0, 1e4)}},
        embedded(&E::noise),
        Field{
            "target",
            &E::target,
            "standard deviations to reach, see [below](#excitationtarget): the design chooses `harmonics`, a "
            "period of at most `duration`, and how often it is repeated",
            {.otherwise = "none"}},
        Field{"limits",
              &E::limits,
              "what the motion must keep to, see [below](#excitationlimits)",
              {.otherwise = "those of the robot"}},
        Field{"space",
              &E::space,
              "what the robot must not touch, see [below](#excitationspace)",
              {.otherwise = "nothing is kept clear of"}});
  }
};

/// Forecast of the estimate of a base parameter from a motion.
struct ForecastParameter {
  enum class Prospect {
    good,   ///< a standard deviation of at most 30 % of the a-priori value
    weak,   ///< more than that
    unseen  ///< the motion does not show it
  };
  std::string name;
  std::string unit;    ///< SI, joint side
  double value = 0.0;  ///< a priori
  double sigma = 0.0;  ///< standard deviation of its estimate, infinite for one that is unseen
  double relative_sigma_percent = 0.0;  ///< 100 σ / |value|
  double sigma_alone = 0.0;             ///< standard deviation if all other parameters were known
  std::string closest = {};  ///< parameter whose estimate correlates most with this one; empty: unseen ones
  double correlation = 0.0;  ///< of the two estimates
  Prospect prospect = Prospect::good;

  template <typename R = ForecastParameter>
  static constexpr auto fields() {
    return std::tuple(
        Field{"name", &R::name, "of the base parameter"}, Field{"unit", &R::unit, "SI, joint side"},
        Field{"value", &R::value, "a priori"},
        Field{"sigma", &R::sigma, "forecast standard deviation of its estimate"},
        Field{"relative_sigma_percent", &R::relative_sigma_percent, "100 σ / \\|value\\|", {.unit = "%"}},
        Field{"sigma_alone", &R::sigma_alone, "standard deviation if all other parameters were known"},
        Field{"closest", &R::closest, "parameter whose estimate correlates most with this one"},
        Field{"correlation", &R::correlation, "of these two estimates"},
        Field{"prospect", &R::prospect,
              "`\"good\"`; `\"weak\"`: σ above 30 % of the a-priori value; `\"unseen\"`: the motion does not "
              "show it"});
  }
};

template <>
inline constexpr std::array names_of<ForecastParameter::Prospect> =
    std::to_array<std::string_view>({"good", "weak", "unseen"});

/// How much of a limit a motion uses.
struct LimitUse {
  std::string joint;
  std::string quantity;  ///< "position", "velocity", "acceleration", "jerk", "torque"
  std::string unit;
  double value = 0.0;  ///< the extreme one
  double limit = 0.0;  ///< of that side
  double share = 0.0;  ///< of the half range: 1 where the limit is reached
  double time = 0.0;   ///< [s]

  template <typename R = LimitUse>
  static constexpr auto fields() {
    return std::tuple(Field{"joint", &R::joint, "name of the joint"},
                      Field{"quantity", &R::quantity,
                            "`\"position\"`, `\"velocity\"`, `\"acceleration\"`, `\"jerk\"` or `\"torque\"`"},
                      Field{"unit", &R::unit, "of value and limit"},
                      Field{"value", &R::value, "the extreme one of the motion"},
                      Field{"limit", &R::limit, "what it may be, shares included"},
                      Field{"share", &R::share, "how much of half the range is used: 1 reaches the limit"},
                      Field{"time", &R::time, "when", {.unit = "s"}});
  }
};

/// What the rows of one joint contribute to a forecast.
struct JointInformation {
  std::string joint;
  std::string unit;
  double sigma = 0.0;  ///< standard deviation of the torque errors of a sample of the motion [N·m | N]
  double share = 0.0;  ///< tr(M⁻¹ Wᵀ W) / (σ² b): of all joints and what was known the sum is 1; not a number
                       ///< if M is singular

  template <typename R = JointInformation>
  static constexpr auto fields() {
    return std::tuple(
        Field{"joint", &R::joint, "name of the joint"}, Field{"unit", &R::unit, "of sigma"},
        Field{"sigma", &R::sigma, "standard deviation of the torque errors of a sample of the motion"},
        Field{"share", &R::share,
              "of the information that the rows of the joint contribute, `known` logs counted besides"});
  }
};

/// Forecast of an identification from a motion, before the robot has moved.
struct [[nodiscard]] Forecast {
  BaseParameters base;
  double f_m = 0.0;                           ///< rate of the motion [Hz]
  double duration = 0.0;                      ///< from its first to its last sample [s]
  Vector chi;                                 ///< a-priori values, (b)
  Matrix information;                         ///< Σ Wᵀ W / σ² of the motion and of what was known, (b × b)
  double log_det = 0.0;                       ///< of it; −∞ where it does not determine all parameters
  double condition = 0.0;                     ///< of the weighted observation matrix
  std::vector<ForecastParameter> parameters;  ///< (b)
  std::vector<LimitUse> limits;               ///< one for each limit of each joint
  std::vector<ClearanceUse> clearances;       ///< of each pair, the nearest first, those left out last
  std::vector<JointInformation> joints;       ///< (n)
  Matrix leverage;  ///< w M⁻¹ wᵀ / σ² of each sample's row w of each joint, (n_m × n); empty if M is singular
  Matrix tau;       ///< predicted torques, (n_m × n); empty without a-priori masses
  std::vector<Finding> findings;  ///< what was taken for granted
};

/// Forecasts the standard deviations of weighted least squares from a motion: sqrt diag (M₀ + Σ_j W_jᵀ W_j /
/// σ_j²)⁻¹.
///
/// @param motion   (n_m × n)
/// @param f_m      its rate [Hz]
/// @param options  of which noise, limits and known are used
/// @throws InputError  where robot, motion and options do not fit together
Forecast forecast(const Robot& robot, const Motion& motion, double f_m, const ExcitationOptions& options);

/// What one start came to.
struct StartReport {
  std::uint64_t seed = 0;
  double objective_begin = 0.0;  ///< of the random motion
  double objective_end = 0.0;
  int evaluations = 0;

  template <typename R = StartReport>
  static constexpr auto fields() {
    return std::tuple(Field{"seed", &R::seed, "of the random motion"},
                      Field{"objective_begin", &R::objective_begin, "of the random motion"},
                      Field{"objective_end", &R::objective_end, "what the search came to"},
                      Field{"evaluations", &R::evaluations, "of the objective"});
  }
};

/// A designed motion.
struct [[nodiscard]] Excitation {
  std::optional<FourierSeries>
      series;  ///< of the section [reference] of an experiment file; none of a spline
  std::optional<PointToPoint> lead_in;   ///< moves to the motion, where ExcitationOptions::lead_from asks
  std::optional<PointToPoint> lead_out;  ///< moves from the motion
  Vector t;                              ///< instants at rate_hz, those of the leads too, (n_m) [s]
  Motion motion;                         ///< at these
  Forecast forecast;
  std::vector<StartReport> starts;
  Index best_start = 0;
  bool stopped = false;  ///< whether the search was ended from outside

  /// The motion with its leads, between its samples too.
  [[nodiscard]] std::unique_ptr<const Reference> reference() const;
};

/// Designs a motion that determines a robot's base parameters as well as possible, within limits:
///
///   min f(M(z)),  M = M₀ + Σ_k Σ_j W_jᵀ W_j / σ_j²,
///   subject to  q, q̇, q̈, dq̈/dt, τ and distances within their limits
///
/// over the coefficients of Fourier series, or splines, that begin and end at rest, q̇ = q̈ = 0, in one pose.
/// Gradients are exact; limits are soft maxima joint by joint and pair by pair; the method of moving
/// asymptotes [Svanberg 2002] begins from several random motions, and the best is brought to its limits on
/// the samples that are played. The motion that is returned keeps all limits there.
///
/// @throws InputError  where a limit is missing, no pose can be held at rest within the limits, no motion
///                     determines the parameters, or an option can not be used; the message names the joint
Excitation design(const Robot& robot, const ExcitationOptions& options);

}  // namespace rivid
