#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "rivid/fields.hpp"
#include "rivid/identify/covariance.hpp"
#include "rivid/identify/essential.hpp"
#include "rivid/identify/physical.hpp"
#include "rivid/identify/robust.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/control.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// IDIM-OLS: ordinary least squares, Eqs. (15–19) of [RIV].
struct Ols {};

/// IDIM-WLS: each joint's rows divided by the standard deviation of the error of a fit to these rows alone,
/// Eq. (20) of [RIV].
struct Wls {};

/// IDIM-IV: the instrumental-variable method of [RIV], Eqs. (27–34). The instruments V are the regressor
/// along the motion of the simulated closed loop with the parameters of the last iteration; gains follow
/// these, (46), so that the loop keeps its poles and the simulated motion stays near the actual one. Two
/// relatives hold other signals of the same loop against the log, see Compares.
struct Iv {
  /// What of the simulated loop the log is compared with.
  enum class Compares {
    instruments,  ///< nothing: it is the instruments of the measured rows, IDIM-IV
    /// its torques, DIDIM [Gautier 2013]: least squares of the measured torques on the regressor V along the
    /// simulated motion, whose fixed point is found from the estimate of IDIM-IV, or chi_0, on by Newton
    /// steps, b + 1 simulations each. What is measured of the motion serves for masks and the start alone.
    torques,
    /// its positions, closed-loop output error (CLOE): Σ ‖(q − q_s(χ)) / σ‖² by Gauss-Newton steps, b + 1
    /// simulations each, from the same start. Gains stay those of the control law for that estimate: such as
    /// follow the parameters would hide them.
    positions
  };
  /// Where the iteration begins.
  enum class Start {
    regular,   ///< (48): all parameters zero but Ia_j = 1; ZZ_j = 1 (51), or M_j = 1, for a joint without Ia
    a_priori,  ///< the values of the robot description
    least_squares  ///< IDIM-WLS on the same rows
  };
  /// What the controller of the simulation follows.
  enum class Follows {
    reference,  ///< the log's reference columns
    measured    ///< the zero-phase filtered measured positions, where no reference was logged
  };
  /// Velocity whose sign the Coulomb columns of W have. The sign of a noisy velocity is no linear function of
  /// the noise, so that instruments do not help against it; that of the simulated one is wrong where the
  /// assumed loop is.
  enum class Signs {
    automatic,  ///< measured where the positions are filtered or the rows are exact, simulated elsewhere
    measured,
    simulated
  };
  enum class Weights {
    none,
    by_joint  ///< each joint's rows of V, W and Y divided by the standard deviation of its error, (20)
  };

  Control control = {};    ///< of the actual robot, as far as it is known
  Sampling sampling = {};  ///< of that control
  /// Gains that Compares::positions estimates beside χ, one of each joint, by their names in the law's
  /// description(), with the relative standard deviations that are known beforehand.
  std::map<std::string, double> gain_sigma = {};
  double delay_sigma = 0.0;  ///< the same of sampling.delay [periods]; 0: it is known
  Follows follows = Follows::reference;
  double reference_cutoff_hz = 0.0;  ///< of Follows::measured [Hz]; 0: that of the estimation's signal

  Start start = Start::regular;
  Vector chi_0 = {};  ///< (b) values to begin with instead, or empty

  Signs signs = Signs::automatic;
  Weights weights = Weights::by_joint;

  /// Where the simulation begins: on the reference, or in the state that was measured.
  bool start_on_reference = false;
  /// Beginning of each log that takes no part, for what the simulation remembers of its start [s]; 5 / min
  /// ω_n in [RIV].
  double transient = 0.0;

  /// Stop rule: |‖ε_{k+1}‖ − ‖ε_k‖| ≤ tolerance ‖ε_k‖ with ε_k = Y − V_k χ̂_k, and no parameter moves by more
  /// than parameter_tolerance times its standard deviation; or none moves by more than a fifth of that.
  double tolerance = 1e-3;
  double parameter_tolerance = 0.5;
  int max_iterations = 20;

  /// Prefiltered instrumental variables, IDIM-PIV [Brunot 2018]: once the iteration has settled, an
  /// autoregressive model of each joint's residual whitens Y, W and V, and the iteration goes on until model
  /// and parameters agree. It works on exact rows without decimation, whose place the filter takes. The
  /// lowest variance where the model of the robot is right; where it is not, filters of high frequencies
  /// amplify what is wrong.
  bool prefilter = false;
  int prefilter_order = 0;  ///< of the noise models; 0: by BIC, at most most_prefilter_order
  static constexpr int most_prefilter_order = 30;  // a choice: each order takes a column of lagged residuals

  SimulationOptions simulation =
      {};  ///< tolerances, integrator and budgets; its sampling and samples are not used

  Compares compares = Compares::instruments;

  template <typename R = Iv>
  static constexpr auto fields() {
    return std::tuple(
        Field{"start", &R::start,
              "where the iteration begins. `\"regular\"`: nothing is known (48, 51); `\"a_priori\"`: the "
              "values of the robot's file; `\"least_squares\"`: WLS on the same rows"},
        Field{"follows", &R::follows,
              "what the simulated loop follows: the log's `\"reference\"` columns, or, where none were "
              "logged, the `\"measured\"` positions filtered at `reference_cutoff_hz`"},
        Field{"reference_cutoff_hz",
              &R::reference_cutoff_hz,
              "zero-phase low-pass of `follows = \"measured\"`",
              {.otherwise = "that of `[signal]`", .unit = "Hz", .range = rate_range}},
        Field{"signs", &R::signs,
              "velocity whose sign the Coulomb columns of W have: `\"measured\"`, `\"simulated\"`, or "
              "`\"automatic\"`: simulated with the paper's rows and without `cutoff_hz`, measured otherwise"},
        Field{
            "weights", &R::weights,
            "`\"by_joint\"`: rows of V, W and Y divided by the deviation of their joint's error; `\"none\"`"},
        Field{"initial_state",
              &R::start_on_reference,
              "state that the simulation begins in: the `\"measured\"` one, or on the `\"reference\"`",
              {.words = {"measured", "reference"}}},
        Field{"transient",
              &R::transient,
              "beginning of each log that takes no part; [RIV] takes 5/min ω_n with `initial_state = "
              "\"reference\"`",
              {.unit = "s", .range = Range::from(0.0, 1e6)}},
        Field{"tolerance",
              &R::tolerance,
              "relative change of ‖Y − V χ‖ below which the iteration may stop",
              {.range = Range::from(1e-12, 1e3)}},
        Field{"parameter_tolerance",
              &R::parameter_tolerance,
              "largest step of a parameter, in its standard deviations, with which it may stop",
              {.range = Range::from(1e-9, 1e6)}},
        Field{"max_iterations",
              &R::max_iterations,
              "after so many the result is `not_converged`",
              {.range = Range::from(1, 1e3)}},
        Field{"prefilter",
              [](const Iv& iv) -> std::variant<bool, int> {
                if (iv.prefilter_order > 0) {
                  return iv.prefilter_order;
                }
                return iv.prefilter;
              },
              "[prefiltered instrumental variables](statistics.md#prefiltered-instrumental-variables): "
              "autoregressive models of the residual whiten the rows. An integer is their order, 1 to 30; "
              "`true` leaves it to BIC. Exact rows only.",
              {.range = Range::within(1, most_prefilter_order)}});
  }
};

template <>
inline constexpr std::array names_of<Iv::Start> =
    std::to_array<std::string_view>({"regular", "a_priori", "least_squares"});
template <>
inline constexpr std::array names_of<Iv::Follows> =
    std::to_array<std::string_view>({"reference", "measured"});
template <>
inline constexpr std::array names_of<Iv::Signs> =
    std::to_array<std::string_view>({"automatic", "measured", "simulated"});
template <>
inline constexpr std::array names_of<Iv::Weights> = std::to_array<std::string_view>({"none", "by_joint"});

/// Base parameters to begin with that make M(q) regular without any knowledge of the robot, (48) and (51) of
/// [RIV].
[[nodiscard]] Vector regular_start(const Robot& robot, const BaseParameters& base);

/// The method that the logs allow, see MethodChoice: instrumental variables where controller and reference
/// are known, least squares where they are not, or where there is no answer by instruments.
struct Auto {
  Iv iv = {};  ///< with the controller, where it is known
};

/// How an estimate is made of the rows; what belongs to one method alone is a member of its struct.
using Method = std::variant<Ols, Wls, Iv, Auto>;

/// Names of all methods: those of Method in their order, then what else Iv compares.
inline constexpr std::array<std::string_view, 6> method_names = {"ols",  "wls",   "iv",
                                                                 "auto", "didim", "output_error"};
/// "ols", "wls", "iv", "auto", "didim", "output_error".
[[nodiscard]] std::string_view name(const Method& method);
/// "IDIM-OLS", "IDIM-WLS", "IDIM-IV", "automatic", "DIDIM", "closed-loop output error".
[[nodiscard]] std::string_view title(const Method& method);

/// Called on the way through a long computation with a name and the fraction done, 0 to 1.
using Progress = std::function<void(std::string_view stage, double fraction)>;

/// What identify() does: rows by `signal`, an estimate of them by `method`, and what is inferred from it.
struct Estimation {
  Method method = Auto{};
  SignalOptions signal = {};
  CovarianceOptions covariance = {};
  /// Relative covariance of the drive gains, (n × n), which the covariance of the parameters then contains,
  /// see identify_gains(); empty: gains are exact.
  Matrix gain_covariance = {};
  /// Covariance of the base parameters by what was chosen before, (b × b), which theirs then contains, see
  /// choose_friction(); empty: none.
  Matrix choice_covariance = {};
  std::optional<Physical> physical = {};    ///< the physically consistent model as well
  std::optional<Essential> essential = {};  ///< the parameters that matter as well
  std::optional<Robust> robust = {};  ///< robust against outliers in the torques; not with Iv::prefilter
  int threads = 1;  ///< that share the work, see factors(); the result is the same whatever their number
  Progress progress = {};
  /// Whether the answer is judged, see identify(). Without it a wrong sign or column is found by nobody: for
  /// inner loops alone.
  bool judge = true;

  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;
};

}  // namespace rivid
