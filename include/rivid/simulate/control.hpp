#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

/// What a control law sees at one instant: the measured motion and the reference, (n) each.
struct ControlInput {
  double t = 0.0;                  ///< [s]
  Eigen::Ref<const Vector> q;      ///< measured positions [rad | m]
  Eigen::Ref<const Vector> qd;     ///< measured velocities, or what the controller takes for them
  Eigen::Ref<const Vector> q_r;    ///< reference
  Eigen::Ref<const Vector> qd_r;   ///< [rad/s | m/s]
  Eigen::Ref<const Vector> qdd_r;  ///< [rad/s² | m/s²]
};

/// One kind of gain of a control law.
struct Gain {
  std::string name;  ///< "k_p", "K_d", "T_i", …
  Vector values;     ///< (n), one a joint, as they are in force: adapted to the plant
};

/// Gains by their names.
[[nodiscard]] inline std::map<std::string, Vector> by_name(const std::vector<Gain>& gains) {
  std::map<std::string, Vector> out;
  for (const Gain& gain : gains) {
    out[gain.name] = gain.values;
  }
  return out;
}

/// What reports say about a control law.
struct ControlDescription {
  std::string law;  ///< "PD", "PID", …; empty for a law without a name
  std::vector<Gain> gains;
};

/// A control law with its gains, the one interface to implement for a law of one's own. It must not remember
/// anything while it works: what it has to remember, an integral say, are states x, which the simulation
/// keeps and integrates. Scratch it may have: a law belongs to one simulation, a Control makes another one
/// for the next.
class ControlLaw {
 public:
  ControlLaw() = default;
  ControlLaw(const ControlLaw&) = delete;
  ControlLaw& operator=(const ControlLaw&) = delete;
  virtual ~ControlLaw() = default;

  /// Number of states x; they start at zero.
  [[nodiscard]] virtual Index states() const { return 0; }

  /// Control signals and rates of the states. No allocation.
  ///
  /// @param input  what is measured and asked for
  /// @param x      states
  /// @param v_tau  (n) control signals, saturated as the drives do [as logged]
  /// @param xd     rates of the states [1/s]
  virtual void control(const ControlInput& input, const Eigen::Ref<const Vector>& x, Eigen::Ref<Vector> v_tau,
                       Eigen::Ref<Vector> xd) const = 0;

  /// Name and gains for reports; a law of one's own may leave it empty.
  [[nodiscard]] virtual ControlDescription description() const { return {}; }
};

/// The loop that gains are matched to.
struct Plant {
  const Robot& robot;         ///< its drives
  const DynamicModel& model;  ///< what it is simulated with
  Vector J;                   ///< design inertias (38) of [RIV], (n) [kg·m² | kg]; see design_inertia()
  /// Factors of the gains in the order of the law's description(), (n × gains); empty: 1.
  Matrix gain_factors = {};
};

/// A kind of control law whose gains follow the plant: PdControl, PidControl, …, or any function of a plant.
/// That is how gains are adapted, Eq. (46) of [RIV]: with the inertias of another plant the same poles.
///
/// @throws InputError  from the call, where gains and robot do not fit together
using Control = std::function<std::unique_ptr<ControlLaw>(const Plant&)>;

namespace detail {

/// The law that a control makes for a plant.
///
/// @throws InputError  where the control is empty or makes none
[[nodiscard]] inline std::unique_ptr<ControlLaw> law_of(const Control& control, const Plant& plant) {
  std::unique_ptr<ControlLaw> law = control ? control(plant) : nullptr;
  if (!law) {
    throw InputError(std::string("control ") + (control ? "returns no law" : "is empty") +
                     ", must make a ControlLaw");
  }
  return law;
}

}  // namespace detail

}  // namespace rivid
