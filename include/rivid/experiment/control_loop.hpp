#pragma once

#include "rivid/simulate/closed_loop.hpp"

namespace rivid {

/// The controller of an experiment, [control]: its law, and how it is sampled. A simulation runs it, and the auxiliary
/// loop of the instrumental variables (3.4 of [RIV]) is made of it.
struct ControlLoop {
  /// Positions that design inertias (38) are the maximum over.
  enum class InertiaOver {
    reference,  ///< those of the reference motion, which is what the loop meets
    all         ///< all within the limits
  };

  Control control;
  Sampling sampling;
  InertiaOver design_inertia = InertiaOver::reference;
  /// Whether law and gains are a guess, by a bandwidth, rather than those known of the actual controller.
  bool assumed = false;
  Vector omega_n;  ///< natural frequencies that the law is given by, (n); empty: it is given by gains [rad/s]

  /// Design inertias J (38) that the gains of `control` are matched to, (n) [kg·m² | kg].
  ///
  /// @param q_r  reference positions, (n_m × n) [rad | m]
  /// @throws InputError, NumericsError  as design_inertia()
  [[nodiscard]] Vector inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q_r) const;
};

}  // namespace rivid
