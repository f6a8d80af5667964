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
  return Field{
      "J_apriori",
      &Law::J_apriori,
      "inertias that known gains were tuned for: they are adapted by (46). Without it they stay as they are.",
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
        Field{"k_v",
              &Law::k_v,
              "known gain of the velocity loop; v is the unit of the control signal",
              {.otherwise = "–", .unit = "v s/rad"}},
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
///   e_v = k_p (q_r − q) + k_f q̇_r − q̇,   v = k_v e_v + x,   v_τ = sat(v),   ẋ = k_v e_v / T_i + (v_τ − v) / T_t
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
        Field{"k_v",
              &Law::k_v,
              "known gain of the velocity loop; v is the unit of the control signal",
              {.otherwise = "–", .unit = "v s/rad"}},
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
#include "rivid/simulate/control_laws_inline.hpp"
#endif
