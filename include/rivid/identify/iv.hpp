#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/least_squares_fit.hpp"
#include "rivid/simulate/closed_loop.hpp"

namespace rivid {

/// IDIM-IV: the instrumental-variable method of [RIV], Eqs. (27–34). The instruments V are the regressor along the motion
/// of the simulated closed loop with the parameters of the last iteration; gains follow these, (46), so that the loop
/// keeps its poles and the simulated motion stays near the actual one.
struct Iv {
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
  /// Velocity whose sign the Coulomb columns of W have. The sign of a noisy velocity is no linear function of the noise,
  /// so that instruments do not help against it; that of the simulated one is wrong where the assumed loop is.
  enum class Signs {
    automatic,  ///< measured where the positions are filtered or the rows are exact, simulated elsewhere
    measured,
    simulated
  };
  enum class Weights {
    none,
    by_joint  ///< each joint's rows of V, W and Y divided by the standard deviation of its error, (20)
  };

  SignalOptions signal = {};
  CovarianceOptions covariance = {};
  Control control = {};    ///< of the actual robot, as far as it is known
  Sampling sampling = {};  ///< of that control
  Follows follows = Follows::reference;
  double reference_cutoff_hz = 0.0;  ///< of Follows::measured [Hz]; 0: that of `signal`

  Start start = Start::regular;
  Vector chi_0 = {};  ///< (b) values to begin with instead, or empty

  Signs signs = Signs::automatic;
  Weights weights = Weights::by_joint;

  /// Where the simulation begins: on the reference, or in the state that was measured.
  bool start_on_reference = false;
  /// Beginning of each log that takes no part, for what the simulation remembers of its start [s]; 5 / min ω_n in [RIV].
  double transient = 0.0;

  /// Stop rule: |‖ε_{k+1}‖ − ‖ε_k‖| ≤ tolerance ‖ε_k‖ with ε_k = Y − V_k χ̂_k, and no parameter moves by more than
  /// parameter_tolerance times its standard deviation; or none moves by more than a fifth of that.
  double tolerance = 1e-3;
  double parameter_tolerance = 0.5;
  int max_iterations = 20;

  /// Prefiltered instrumental variables, IDIM-PIV [Brunot 2018]: once the iteration has settled, an autoregressive model
  /// of each joint's residual whitens Y, W and V, and the iteration goes on until model and parameters agree. It works on
  /// exact rows without decimation, whose place the filter takes. The lowest variance where the model of the robot is right;
  /// where it is not, filters of high frequencies amplify what is wrong.
  bool prefilter = false;
  int prefilter_order = 0;  ///< of the noise models; 0: by BIC, at most most_prefilter_order
  static constexpr int most_prefilter_order = 30;

  SimulationOptions simulation =
      {};           ///< tolerances, integrator and budgets; its sampling and samples are not used
  int threads = 1;  ///< that share the work, see factors(); the result is the same whatever their number
  Progress progress = {};
  std::optional<Physical> physical = {};    ///< the physically consistent model as well
  std::optional<Essential> essential = {};  ///< the parameters that matter as well
  /// An estimate that outliers do not decide, once the iteration has settled; not together with `prefilter`.
  std::optional<Robust> robust = {};

  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;
};

/// "regular", "a_priori", "least_squares".
[[nodiscard]] std::string_view name(Iv::Start start);

/// Base parameters to begin with that make M(q) regular without any knowledge of the robot, (48) and (51) of [RIV].
[[nodiscard]] Vector regular_start(const Robot& robot, const BaseParameters& base);

/// Identifies the base parameters by IDIM-IV; see the other identify().
///
/// A loop that can not be simulated, cycling, and instruments that are too weak are a status of the result with its
/// reasons, and the history tells how it came to that.
///
/// @throws InputError  where robot, logs and options do not fit together; the message names the culprit
Identification identify(const Robot& robot, std::span<const Log> logs, const Iv& method);

}  // namespace rivid
