#pragma once

#include <optional>
#include <string>

#include "rivid/fields.hpp"
#include "rivid/simulate/control.hpp"

namespace rivid {

namespace detail {

/// Fields that all laws have.
template <typename Law>
constexpr auto pole_fields() {
  return std::tuple(Field{"omega_n",
                          &Law::omega_n,
                          "natural frequency: the law by its poles. Either these or gains.",
                          {.otherwise = "–", .unit = "rad/s"}},
                    Field{"zeta", &Law::zeta, "damping", {.otherwise = "1"}},
                    Field{"v_tau_max", &Law::v_tau_max, "saturation", {.otherwise = "none", .unit = "v"}});
}

/// Fields that laws share by pairs.
template <typename Law>
constexpr auto integral_pole_field() {
  return Field{
      "omega_i", &Law::omega_i, "pole of the integral action", {.otherwise = "none", .unit = "rad/s"}};
}
template <typename Law>
constexpr auto tuned_for_field() {
  return Field{"J_apriori",
               &Law::J_apriori,
               "inertias that known gains were tuned for, which are then adapted by (46)",
               {.otherwise = "none", .unit = "kg·m², kg"}};
}
template <typename Law>
constexpr auto tracking_time_field() {
  return Field{"tracking_time",
               &Law::tracking_time,
               "anti-windup",
               {.otherwise = "see [control](control.md)", .unit = "s", .range = Range::from(0.0, 1e9)}};
}

}  // namespace detail

/// PD law, Eq. (40) of [RIV]:
///
///   v_τ = k_p k_v (q_r − q) − k_v q̇
///
/// By poles: with (omega_n, zeta), the gains are (45), k_p = ω_n / (2ζ) and k_v = 2ζ ω_n J / g_τ. By gains:
/// with the (k_p, k_v) that are known of an actual controller, and the J_apriori that it was tuned for, k_v
/// is adapted by (46) to k_v J / J_apriori; k_p stays. Without J_apriori both stay as they are.
///
/// Joints that are coupled by a full gear matrix are decoupled, v_τ = G⁻¹ τ, so that the poles are the asked
/// ones here as well; k_v is then a torque a velocity. Known gains are refused there: each signal moves
/// several joints.
struct PdControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)

  Vector k_p = {};  ///< known gains, (n) [1/s]
  Vector k_v = {};  ///< (n) [v_τ s/rad | v_τ s/m]
  Vector J_apriori =
      {};  ///< design inertias that they were tuned for, (n); empty: no adaptation [kg·m² | kg]

  /// Whether the velocity error is fed back, v_τ = k_p k_v (q_r − q) + k_v (q̇_r − q̇).
  bool reference_velocity = false;
  Vector v_tau_max = {};  ///< largest |v_τ|, (n); empty: no saturation [as v_τ]

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint(); where J is needed and is not positive
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;

  static constexpr std::string_view word = "pd";  ///< that files name it by
  template <typename Law = PdControl>
  static constexpr auto fields() {
    return std::tuple(
        Field{"k_p", &Law::k_p, "known gain of the position loop", {.otherwise = "–", .unit = "1/s"}},
        Field{"k_v", &Law::k_v, "known gain of the velocity loop", {.otherwise = "–", .unit = "v s/rad"}},
        detail::tuned_for_field<Law>(),
        Field{"reference_velocity", &Law::reference_velocity, "whether the velocity error is fed back"});
  }
};

/// PID law with reference velocity, gains in units of the control signal, and anti-windup by
/// back-calculation:
///
///   v = K_p (q_r − q) + K_d (q̇_r − q̇) + x,   v_τ = sat(v),   ẋ = K_i (q_r − q) + (v_τ − v) / T_t
///
/// By poles: with (omega_n, zeta, omega_i) those of the closed loop are (s² + 2ζ ω_n s + ω_n²)(s + ω_i) = 0,
/// hence
///
///   K_p = (ω_n² + 2ζ ω_n ω_i) J / g_τ,   K_i = ω_n² ω_i J / g_τ,   K_d = (2ζ ω_n + ω_i) J / g_τ.
///
/// By gains: K_p, K_i, K_d of an actual controller, all adapted by J / J_apriori as in (46) of [RIV]. Without
/// K_i it is the PD law of manufacturers, v_τ = K_p e + K_d ė.
///
/// Coupled gears: see PdControl.
struct PidControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)
  Vector omega_i = {};  ///< pole of the integral action, (n); empty or zero: none [rad/s]

  Vector K_p = {};  ///< known gains, (n) [v_τ/rad | v_τ/m]
  Vector K_i = {};  ///< (n); empty or zero: no integral action [v_τ/(rad s) | v_τ/(m s)]
  Vector K_d = {};  ///< (n) [v_τ s/rad | v_τ s/m]
  Vector J_apriori =
      {};  ///< design inertias that they were tuned for, (n); empty: no adaptation [kg·m² | kg]

  Vector v_tau_max = {};  ///< largest |v_τ|, (n); empty: no saturation [as v_τ]
  /// T_t: how fast the integral follows a saturated signal, (n); empty: √(K_d / K_i), or K_p / K_i without
  /// K_d [s]
  Vector tracking_time = {};

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint(); where J is needed and is not positive
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;

  static constexpr std::string_view word = "pid";  ///< that files name it by
  template <typename Law = PidControl>
  static constexpr auto fields() {
    return std::tuple(detail::integral_pole_field<Law>(),
                      Field{"K_p", &Law::K_p, "known gain", {.otherwise = "–", .unit = "v/rad"}},
                      Field{"K_i", &Law::K_i, "known gain", {.otherwise = "0", .unit = "v/(rad s)"}},
                      Field{"K_d", &Law::K_d, "known gain", {.otherwise = "–", .unit = "v s/rad"}},
                      detail::tuned_for_field<Law>(), detail::tracking_time_field<Law>());
  }
};

/// Cascade of drives: a proportional position loop whose output, with the reference velocity fed forward, is
/// what a proportional-integral velocity loop follows; anti-windup by back-calculation.
///
///   e_v = k_p (q_r − q) + k_f q̇_r − q̇,   v = k_v e_v + x,   v_τ = sat(v),
///   ẋ = k_v e_v / T_i + (v_τ − v) / T_t
///
/// By poles: with (omega_n, zeta, omega_i) those of the closed loop are (s² + 2ζ ω_n s + ω_n²)(s + ω_i) = 0,
/// where k_v = (2ζ ω_n + ω_i) J / g_τ, and k_p and 1/T_i are the larger and the smaller root of z² − (ω_n² +
/// 2ζ ω_n ω_i)/(2ζ ω_n + ω_i) z + ω_n² ω_i/(2ζ ω_n + ω_i) = 0. They are real for ω_i ≤ ω_n / (2 (1 + ζ)): a
/// cascade cannot have a faster integral pole. As ω_i → 0 it becomes the PD law with (45) of [RIV].
///
/// By gains: k_p, k_v, T_i of an actual drive; k_v is adapted by J / J_apriori as in (46), the others stay.
///
/// Coupled gears: see PdControl.
struct CascadeControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)
  Vector omega_i = {};  ///< pole of the integral action, (n); empty or zero: none [rad/s]

  Vector k_p = {};  ///< known gains: position loop, (n) [1/s]
  Vector k_v = {};  ///< velocity loop, (n) [v_τ s/rad | v_τ s/m]
  Vector T_i = {};  ///< integral time of the velocity loop, (n); empty or infinite: no integral action [s]
  Vector J_apriori =
      {};  ///< design inertias that they were tuned for, (n); empty: no adaptation [kg·m² | kg]

  Vector feed_forward = {};   ///< k_f, (n); empty: 1, the whole of it
  Vector v_tau_max = {};      ///< largest |v_τ|, (n); empty: no saturation [as v_τ]
  Vector tracking_time = {};  ///< T_t, (n); empty: T_i [s]

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint(); where J is needed and is not positive
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;

  static constexpr std::string_view word = "cascade";  ///< that files name it by
  template <typename Law = CascadeControl>
  static constexpr auto fields() {
    return std::tuple(
        detail::integral_pole_field<Law>(),
        Field{"k_p", &Law::k_p, "known gain of the position loop", {.otherwise = "–", .unit = "1/s"}},
        Field{"k_v", &Law::k_v, "known gain of the velocity loop", {.otherwise = "–", .unit = "v s/rad"}},
        Field{"T_i",
              &Law::T_i,
              "known integral time",
              {.otherwise = "none", .unit = "s", .range = Range::from(0.0, 1e9)}},
        detail::tuned_for_field<Law>(), Field{"feed_forward", &Law::feed_forward, "k_f", {.otherwise = "1"}},
        detail::tracking_time_field<Law>());
  }
};

/// Model that computed torque has of its robot.
enum class ControllerModel {
  simulated,  ///< the one of the plant
  a_priori    ///< the values of the robot's description
};
template <>
inline constexpr std::array names_of<ControllerModel> =
    std::to_array<std::string_view>({"simulated", "a_priori"});

/// Computed torque: the inverse dynamics of a model of the robot make it n double integrators, which a PD law
/// governs,
///
///   τ = M̂(q) (q̈_r + k_d (q̇_r − q̇) + k_p (q_r − q)) + N̂(q, q̇) + friction,   v_τ = sat(G⁻¹ τ).
///
/// By poles: k_p = ω_n² and k_d = 2ζ ω_n. Where the model is the plant's, the error obeys ë + k_d ė + k_p e =
/// 0. The design inertia is not used. Coupled gears need no more than G⁻¹.
struct ComputedTorqueControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)

  Vector k_p = {};  ///< gains in place of the poles, (n) [1/s²]
  Vector k_d = {};  ///< (n) [1/s]

  /// The model that the controller has, as it was in the experiment. Empty: adapted, the model of each plant.
  std::shared_ptr<const DynamicModel> model = {};

  /// Whether friction is compensated as well: viscous friction and offset at the measured velocity, Coulomb
  /// friction at the reference's, whose sign does not chatter, smoothed by tanh(q̇_r / coulomb_velocity).
  bool friction = true;
  double coulomb_velocity = 1e-2;  ///< [rad/s | m/s]

  Vector v_tau_max = {};  ///< largest |v_τ|, (n); empty: no saturation [as v_τ]

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint()
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;

  static constexpr std::string_view word = "computed_torque";  ///< that files name it by
  template <typename Law = ComputedTorqueControl>
  static constexpr auto fields() {
    return std::tuple(
        Field{"k_p", &Law::k_p, "known gain", {.otherwise = "–", .unit = "1/s²"}},
        Field{"k_d", &Law::k_d, "known gain", {.otherwise = "–", .unit = "1/s"}},
        Field{"friction", &Law::friction, "whether friction is compensated"},
        Field{"coulomb_velocity",
              &Law::coulomb_velocity,
              "smoothing of the compensated Coulomb friction",
              {.unit = "rad/s, m/s"}},
        Field{
            "model",
            [](const Law& law) { return law.model ? ControllerModel::a_priori : ControllerModel::simulated; },
            "model that the controller has: the `\"simulated\"` one, or that of the `\"a_priori\"` values"});
  }
};

/// The laws that files know by their word.
using ControlLaws = std::tuple<PdControl, PidControl, CascadeControl, ComputedTorqueControl>;

}  // namespace rivid

#ifdef RIVID_DEFINITIONS
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/simulate/dynamics.hpp"
#include "rivid/text.hpp"

// What is declared above, for users of rivid::headers; rivid::rivid has it in its archive.
namespace rivid {

namespace detail {

using Complaint = std::optional<std::string>;

// What is wanted of a gain, one entry a joint. Gains in units of the control signal act against the error
// only with the sign of the drive gain.
struct GainRule {
  const char* required;
  bool (*accepts)(double value, double g_tau);
  bool in_signals = false;  // whether it needs a control signal of its own
};
inline constexpr GainRule positive = {
    "positive and finite", [](double value, double) { return std::isfinite(value) && value > 0.0; }};
inline constexpr GainRule not_negative = {
    "finite and not negative", [](double value, double) { return std::isfinite(value) && value >= 0.0; }};
inline constexpr GainRule time_or_never = {"positive and finite",
                                           [](double value, double) { return value > 0.0; }};
inline constexpr GainRule feedback = {"finite and of the sign of the drive gain g_tau, not zero",
                                      [](double value, double g_tau) {
                                        return std::isfinite(value) && value != 0.0 &&
                                               std::signbit(value) == std::signbit(g_tau);
                                      },
                                      true};
inline constexpr GainRule feedback_or_zero = {
    "finite and zero or of the sign of the drive gain g_tau",
    [](double value, double g_tau) { return value == 0.0 || feedback.accepts(value, g_tau); }};

// An option of a law, by its name.
struct GainCheck {
  const char* name;
  const Vector& values;
  const GainRule& rule;
  bool optional = false;
};

inline Complaint complaint_of(const Robot& robot, const GainCheck& check) {
  const Vector& values = check.values;
  if (check.optional && values.size() == 0) {
    return std::nullopt;
  }
  if (values.size() != robot.size()) {
    return std::string(check.name) + " has " + std::to_string(values.size()) + " entries for " +
           counted(robot.size(), "joint");
  }
  for (Index j = 0; j < values.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (!check.rule.accepts(values[j], joint.g_tau())) {
      return std::string(check.name) + " of joint \"" + joint.name + "\" is " + number(values[j]) +
             ", must be " + check.rule.required;
    }
  }
  return std::nullopt;
}

inline Complaint complaint_of(const Robot& robot, std::initializer_list<GainCheck> checks) {
  for (const GainCheck& check : checks) {
    if (auto fault = complaint_of(robot, check)) {
      return fault;
    }
  }
  return std::nullopt;
}

// "k_p and k_v (with T_i, J_apriori)".
inline std::string names_of_form(std::initializer_list<GainCheck> form) {
  std::string needed;
  std::string further;
  for (const GainCheck& check : form) {
    std::string& list = check.optional ? further : needed;
    list += (list.empty() ? "" : check.optional ? ", " : " and ") + std::string(check.name);
  }
  return needed + (further.empty() ? "" : " (with " + further + ")");
}

inline bool is_given(std::initializer_list<GainCheck> form) {
  return std::any_of(form.begin(), form.end(),
                     [](const GainCheck& check) { return check.values.size() > 0; });
}

inline bool is_diagonal(const Matrix& G) { return G.isDiagonal(0.0); }

// A law is given either by its poles or by its gains. Gains in units of the control signal need one signal a
// joint.
inline Complaint complaint_of_forms(const Robot& robot, std::initializer_list<GainCheck> poles,
                                    std::initializer_list<GainCheck> gains) {
  if (is_given(poles) == is_given(gains)) {
    return "give either " + names_of_form(poles) + ", or " + names_of_form(gains) +
           (is_given(poles) ? ", not both" : "");
  }
  if (is_given(poles)) {
    return complaint_of(robot, poles);
  }
  const bool in_signals =
      std::any_of(gains.begin(), gains.end(), [](const GainCheck& gain) { return gain.rule.in_signals; });
  if (in_signals && !is_diagonal(robot.drive_matrix())) {
    return "the robot's gear_matrix couples its joints, so that no control signal belongs to one joint "
           "alone; "
           "give the poles, omega_n and zeta, instead of gains";
  }
  return complaint_of(robot, gains);
}

// Gauss-Jordan with partial pivoting, of a small regular matrix.
inline Matrix inverse_of(Matrix A) {
  const Index n = A.rows();
  Matrix out = Matrix::Identity(n, n);
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    for (Index i = k + 1; i < n; ++i) {
      pivot = std::abs(A(i, k)) > std::abs(A(pivot, k)) ? i : pivot;
    }
    A.row(k).swap(A.row(pivot));
    out.row(k).swap(out.row(pivot));
    const double scale = 1.0 / A(k, k);
    A.row(k) *= scale;
    out.row(k) *= scale;
    for (Index i = 0; i < n; ++i) {
      const double factor = A(i, k);
      if (i != k && factor != 0.0) {
        A.row(i) -= factor * A.row(k);
        out.row(i) -= factor * out.row(k);
      }
    }
  }
  return out;
}

inline const Vector& checked_inertias(const char* who, const Plant& plant) {
  if (const auto fault = complaint_of(plant.robot, {"the design inertia J", plant.J, positive})) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  return plant.J;
}

// The gains with the factors that the plant asks for.
inline void scale(const Plant& plant, std::initializer_list<Vector*> gains) {
  Index k = 0;
  for (Vector* const gain : gains) {
    if (plant.gain_factors.size() > 0) {
      gain->array() *= plant.gain_factors.col(k++).array();
    }
  }
}

// Factor of the velocity gains, and how the joints' signals become those of the drives.
struct GainScale {
  Vector factor;  // (n)
  Matrix mixing;  // (n × n), empty where each drive moves its own joint
};

// How the gains of a law follow the plant, once they are known to be good. By poles, they are those of a unit
// inertia with a unit drive: times J / g_τ as in (45), or G⁻¹ J where gears couple the joints. Gains known of
// a controller: times J / J_apriori as in (46), or 1.
template <typename Law>
GainScale scale_of(const char* who, const Law& law, const Plant& plant) {
  if (const auto fault = law.complaint(plant.robot)) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  if (law.omega_n.size() == 0) {
    const bool adapted = law.J_apriori.size() > 0;
    return {.factor = adapted ? Vector(checked_inertias(who, plant).cwiseQuotient(law.J_apriori))
                              : Vector(Vector::Ones(plant.robot.size())),
            .mixing = {}};
  }
  const Vector& J = checked_inertias(who, plant);
  const Matrix G = plant.robot.drive_matrix();
  if (is_diagonal(G)) {
    return {.factor = J.cwiseQuotient(G.diagonal()), .mixing = {}};
  }
  return {.factor = J, .mixing = inverse_of(G)};
}

// `values`, or so many times `otherwise` where they are empty.
inline Vector or_constant(const Vector& values, Index n, double otherwise) {
  return values.size() == 0 ? Vector(Vector::Constant(n, otherwise)) : values;
}

inline constexpr double never = std::numeric_limits<double>::infinity();

// Feedback of one joint that is linear in the position error, the reference velocity and the velocity, (n)
// each: position (q_r − q) + reference_velocity q̇_r − velocity q̇.
struct LinearFeedback {
  Vector position;
  Vector reference_velocity;
  Vector velocity;

  [[nodiscard]] double of(const ControlInput& input, Index j) const {
    return position[j] * (input.q_r[j] - input.q[j]) + reference_velocity[j] * input.qd_r[j] -
           velocity[j] * input.qd[j];
  }
};

// What all laws with constant gains are: with u and w such feedbacks,
//
//   v = mixing u + x,   v_τ = sat(v),   ẋ = mixing w + (v_τ − v) / T_t
struct LinearGains {
  LinearFeedback direct;         // u
  LinearFeedback integral = {};  // w; empty vectors: no states
  Vector tracking_time = {};     // T_t, (n); used where there is an integral
  Matrix mixing;                 // (n × n), empty: the identity
  Vector v_tau_max;              // (n), empty: no saturation
};

class LinearLaw final : public ControlLaw {
 public:
  LinearLaw(LinearGains gains, ControlDescription description)
      : gains_(std::move(gains)),
        tracking_rate_(Vector::Zero(gains_.integral.position.size())),
        description_(std::move(description)) {
    gains_.v_tau_max = or_constant(gains_.v_tau_max, gains_.direct.position.size(), never);
    for (Index i = 0; i < tracking_rate_.size(); ++i) {
      // Without an integral there is nothing that could wind up, and nothing that could unwind the
      // correction.
      if (integrates(i)) {
        tracking_rate_[i] = 1.0 / gains_.tracking_time[i];
      }
    }
  }

  [[nodiscard]] Index states() const override { return gains_.integral.position.size(); }

  void control(const ControlInput& input, const Eigen::Ref<const Vector>& x, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> xd) const override {
    mixed(gains_.direct, input, v_tau);
    const bool with_states = states() > 0;
    if (with_states) {
      v_tau += x;
      mixed(gains_.integral, input, xd);
    }
    for (Index i = 0; i < v_tau.size(); ++i) {
      const double saturated = std::clamp(v_tau[i], -gains_.v_tau_max[i], gains_.v_tau_max[i]);
      if (with_states) {
        xd[i] += tracking_rate_[i] * (saturated - v_tau[i]);
      }
      v_tau[i] = saturated;
    }
  }

  [[nodiscard]] ControlDescription description() const override { return description_; }

 private:
  [[nodiscard]] bool integrates(Index i) const {
    const Vector& integral = gains_.integral.position;
    for (Index j = 0; j < integral.size(); ++j) {
      const double share = gains_.mixing.size() > 0 ? gains_.mixing(i, j) : i == j ? 1.0 : 0.0;
      if (share * integral[j] != 0.0) {
        return true;
      }
    }
    return false;
  }

  void mixed(const LinearFeedback& errors, const ControlInput& input, Eigen::Ref<Vector>& out) const {
    if (gains_.mixing.size() == 0) {
      for (Index j = 0; j < out.size(); ++j) {
        out[j] = errors.of(input, j);
      }
      return;
    }
    out.setZero();
    for (Index j = 0; j < out.size(); ++j) {
      out += errors.of(input, j) * gains_.mixing.col(j);
    }
  }

  LinearGains gains_;
  Vector tracking_rate_;  // 1 / T_t, zero where there is no integral
  ControlDescription description_;
};

// Gains of one joint of unit inertia with a unit drive.
struct CascadeLoop {
  double k_p = 0.0;
  double k_v = 0.0;
  double T_i = 0.0;
};

// Half of the distance between k_p and 1/T_i, squared; negative where no cascade has these poles.
inline double cascade_discriminant(double omega_n, double zeta, double omega_i) {
  const double damping = 2.0 * zeta * omega_n;
  const double sum = (omega_n * omega_n + damping * omega_i) / (damping + omega_i);
  return 0.25 * sum * sum - omega_n * omega_n * omega_i / (damping + omega_i);
}

inline CascadeLoop cascade_with_poles(double omega_n, double zeta, double omega_i) {
  const double k_v = 2.0 * zeta * omega_n + omega_i;
  const double half_sum = 0.5 * (omega_n * omega_n + 2.0 * zeta * omega_n * omega_i) / k_v;
  const double k_p = half_sum + std::sqrt(std::max(0.0, cascade_discriminant(omega_n, zeta, omega_i)));
  return {.k_p = k_p, .k_v = k_v, .T_i = k_p * k_v / (omega_n * omega_n * omega_i)};
}

class ComputedTorqueLaw final : public ControlLaw {
 public:
  ComputedTorqueLaw(const ComputedTorqueControl& control, const Plant& plant, const ModelData& model)
      : dynamics_(model),
        k_p_(control.k_p),
        k_d_(control.k_d),
        signal_(inverse_of(plant.robot.drive_matrix())),
        viscous_(Matrix::Zero(signal_.rows(), signal_.cols())),
        offset_(Vector::Zero(signal_.rows())),
        coulomb_velocity_(control.coulomb_velocity),
        v_tau_max_(or_constant(control.v_tau_max, signal_.rows(), never)) {
    if (control.omega_n.size() > 0) {
      k_p_ = control.omega_n.cwiseAbs2();
      k_d_ = 2.0 * control.zeta.cwiseProduct(control.omega_n);
    }
    scale(plant, {&k_p_, &k_d_});
    if (control.friction) {
      viscous_ = signal_ * model.viscous;
      offset_ = signal_ * model.offset;
      dry_friction_ = model.dry_friction;
      for (DryFriction& element : dry_friction_) {
        element.torque = signal_ * element.torque;
      }
    }
  }

  void control(const ControlInput& input, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    const Index n = v_tau.size();
    const auto size = static_cast<std::size_t>(n);
    static_cast<void>(dynamics_.set_state({input.q.data(), size}, {input.qd.data(), size}));
    v_tau = offset_;
    for (Index i = 0; i < n; ++i) {
      v_tau += rigid_torque(input, i) * signal_.col(i) + input.qd[i] * viscous_.col(i);
    }
    for (const DryFriction& element : dry_friction_) {
      const double speed = element.direction.dot(input.qd);
      const double part = std::tanh(element.direction.dot(input.qd_r) / coulomb_velocity_);
      double tau = element.dry(part > 0.0, speed, part) + element.viscous(speed > 0.0, speed);
      if (element.load > 0.0) {
        tau += element.load * std::abs(rigid_torque(input, element.joint())) * part;
      }
      v_tau += tau * element.torque;
    }
    v_tau = v_tau.cwiseMin(v_tau_max_).cwiseMax(-v_tau_max_);
  }

  [[nodiscard]] ControlDescription description() const override {
    return {.law = "computed torque", .gains = {{"k_p", k_p_}, {"k_d", k_d_}}};
  }

 private:
  // M q̈ + N of joint i for the acceleration that is asked for.
  [[nodiscard]] double rigid_torque(const ControlInput& input, Index i) const {
    double tau = dynamics_.N()[static_cast<std::size_t>(i)];
    for (Index j = 0; j < input.q.size(); ++j) {
      tau += dynamics_.M(i, j) * acceleration(input, j);
    }
    return tau;
  }
  [[nodiscard]] double acceleration(const ControlInput& input, Index j) const {
    return input.qdd_r[j] + k_d_[j] * (input.qd_r[j] - input.qd[j]) + k_p_[j] * (input.q_r[j] - input.q[j]);
  }

  mutable Dynamics<double> dynamics_;  // scratch
  Vector k_p_;
  Vector k_d_;
  Matrix signal_;  // G⁻¹, which all that follows is multiplied with
  Matrix viscous_;
  Vector offset_;
  std::vector<DryFriction> dry_friction_;
  double coulomb_velocity_;
  Vector v_tau_max_;
};

}  // namespace detail

RIVID_INLINE std::optional<std::string> PdControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault = detail::complaint_of_forms(
          robot, {{"omega_n", omega_n, positive}, {"zeta", zeta, positive}},
          {{"k_p", k_p, positive}, {"k_v", k_v, feedback}, {"J_apriori", J_apriori, positive, true}})) {
    return fault;
  }
  return detail::complaint_of(robot, {{"v_tau_max", v_tau_max, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> PdControl::operator()(const Plant& plant) const {
  const detail::GainScale scale = detail::scale_of("PdControl", *this, plant);
  const bool by_poles = omega_n.size() > 0;
  Vector position = by_poles ? Vector(0.5 * omega_n.cwiseQuotient(zeta)) : k_p;
  Vector velocity = scale.factor.cwiseProduct(by_poles ? Vector(2.0 * zeta.cwiseProduct(omega_n)) : k_v);
  detail::scale(plant, {&position, &velocity});
  detail::LinearGains gains{.direct = {.position = position.cwiseProduct(velocity),
                                       .reference_velocity = (reference_velocity ? 1.0 : 0.0) * velocity,
                                       .velocity = velocity},
                            .mixing = scale.mixing,
                            .v_tau_max = v_tau_max};
  return std::make_unique<detail::LinearLaw>(
      std::move(gains), ControlDescription{.law = "PD", .gains = {{"k_p", position}, {"k_v", velocity}}});
}

RIVID_INLINE std::optional<std::string> PidControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault = detail::complaint_of_forms(robot,
                                              {{"omega_n", omega_n, positive},
                                               {"zeta", zeta, positive},
                                               {"omega_i", omega_i, not_negative, true}},
                                              {{"K_p", K_p, feedback},
                                               {"K_d", K_d, feedback_or_zero},
                                               {"K_i", K_i, feedback_or_zero, true},
                                               {"J_apriori", J_apriori, positive, true}})) {
    return fault;
  }
  return detail::complaint_of(
      robot, {{"v_tau_max", v_tau_max, positive, true}, {"tracking_time", tracking_time, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> PidControl::operator()(const Plant& plant) const {
  const detail::GainScale scale = detail::scale_of("PidControl", *this, plant);
  const Index n = plant.robot.size();
  // Gains of a unit inertia with a unit drive, or those given.
  Vector proportional = K_p;
  Vector integral = detail::or_constant(K_i, n, 0.0);
  Vector derivative = K_d;
  if (omega_n.size() > 0) {
    const Eigen::ArrayXd third = detail::or_constant(omega_i, n, 0.0);
    const Eigen::ArrayXd omega = omega_n;
    const Eigen::ArrayXd damping = 2.0 * zeta.array() * omega;
    proportional = omega.square() + damping * third;
    integral = omega.square() * third;
    derivative = damping + third;
  }
  for (Vector* const gain : {&proportional, &integral, &derivative}) {
    gain->array() *= scale.factor.array();
  }
  detail::scale(plant, {&proportional, &integral, &derivative});
  detail::LinearGains gains{
      .direct = {.position = proportional, .reference_velocity = derivative, .velocity = derivative},
      .tracking_time = tracking_time,
      .mixing = scale.mixing,
      .v_tau_max = v_tau_max};
  if (!integral.isZero(0.0)) {
    gains.integral = {
        .position = integral, .reference_velocity = Vector::Zero(n), .velocity = Vector::Zero(n)};
    if (tracking_time.size() == 0) {
      gains.tracking_time = Vector::NullaryExpr(n, [&](Index j) {
        return derivative[j] != 0.0 ? std::sqrt(derivative[j] / integral[j]) : proportional[j] / integral[j];
      });
    }
  }
  return std::make_unique<detail::LinearLaw>(
      std::move(gains),
      ControlDescription{.law = "PID",
                         .gains = {{"K_p", proportional}, {"K_i", integral}, {"K_d", derivative}}});
}

RIVID_INLINE std::optional<std::string> CascadeControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault = detail::complaint_of_forms(robot,
                                              {{"omega_n", omega_n, positive},
                                               {"zeta", zeta, positive},
                                               {"omega_i", omega_i, not_negative, true}},
                                              {{"k_p", k_p, positive},
                                               {"k_v", k_v, feedback},
                                               {"T_i", T_i, time_or_never, true},
                                               {"J_apriori", J_apriori, positive, true}})) {
    return fault;
  }
  // At the limit ω_i = ω_n / (2 (1 + ζ)) itself the roots are equal, but for rounding.
  constexpr double rounding = 1e-12;
  for (Index j = 0; j < omega_i.size(); ++j) {
    if (detail::cascade_discriminant(omega_n[j], zeta[j], omega_i[j]) < -rounding * omega_n[j] * omega_n[j]) {
      return "omega_i of joint \"" + robot.joints[static_cast<std::size_t>(j)].name + "\" is " +
             number(omega_i[j]) + " rad/s, must be at most omega_n / (2 (1 + zeta)) = " +
             number(omega_n[j] / (2.0 * (1.0 + zeta[j])), 4) +
             " rad/s: a cascade has no faster integral pole; PidControl has";
    }
  }
  return detail::complaint_of(robot, {{"feed_forward", feed_forward, not_negative, true},
                                      {"v_tau_max", v_tau_max, positive, true},
                                      {"tracking_time", tracking_time, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> CascadeControl::operator()(const Plant& plant) const {
  const detail::GainScale scale = detail::scale_of("CascadeControl", *this, plant);
  const Index n = plant.robot.size();
  Vector position = k_p;
  Vector velocity = k_v;
  Vector integral_times = detail::or_constant(T_i, n, detail::never);
  if (omega_n.size() > 0) {
    position.resize(n);
    velocity.resize(n);
    for (Index j = 0; j < n; ++j) {
      const auto loop =
          detail::cascade_with_poles(omega_n[j], zeta[j], omega_i.size() == 0 ? 0.0 : omega_i[j]);
      position[j] = loop.k_p;
      velocity[j] = loop.k_v;
      integral_times[j] = loop.T_i;
    }
  }
  velocity.array() *= scale.factor.array();

  Vector ahead = detail::or_constant(feed_forward, n, 1.0);
  detail::scale(plant, {&position, &velocity, &integral_times, &ahead});
  const auto feedback_of = [&](const Vector& gain) {
    return detail::LinearFeedback{.position = position.cwiseProduct(gain),
                                  .reference_velocity = ahead.cwiseProduct(gain),
                                  .velocity = gain};
  };
  detail::LinearGains gains{.direct = feedback_of(velocity),
                            .tracking_time = tracking_time.size() == 0 ? integral_times : tracking_time,
                            .mixing = scale.mixing,
                            .v_tau_max = v_tau_max};
  if ((integral_times.array() < detail::never).any()) {
    gains.integral = feedback_of(velocity.cwiseQuotient(integral_times));
  }
  return std::make_unique<detail::LinearLaw>(
      std::move(gains),
      ControlDescription{
          .law = "cascade",
          .gains = {{"k_p", position}, {"k_v", velocity}, {"T_i", integral_times}, {"k_f", ahead}}});
}

RIVID_INLINE std::optional<std::string> ComputedTorqueControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault =
          detail::complaint_of_forms(robot, {{"omega_n", omega_n, positive}, {"zeta", zeta, positive}},
                                     {{"k_p", k_p, positive}, {"k_d", k_d, positive}})) {
    return fault;
  }
  if (model && model->size() != robot.size()) {
    return "the model has " + counted(model->size(), "joint") + ", the robot has " +
           std::to_string(robot.size());
  }
  if (!(coulomb_velocity > 0.0) || !std::isfinite(coulomb_velocity)) {
    return "coulomb_velocity is " + number(coulomb_velocity) + ", must be positive and finite";
  }
  return detail::complaint_of(robot, {{"v_tau_max", v_tau_max, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> ComputedTorqueControl::operator()(const Plant& plant) const {
  if (const auto fault = complaint(plant.robot)) {
    throw InputError("ComputedTorqueControl: " + *fault);
  }
  return std::make_unique<detail::ComputedTorqueLaw>(*this, plant, model ? *model : plant.model);
}

}  // namespace rivid
#endif
