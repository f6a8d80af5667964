#pragma once

#include <optional>
#include <string>

#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

/// Largest inertia that each joint's drive sees along a motion, Eq. (38) of [RIV]:
///
///   J_j = ZZ_j + Ia_j + max_q (M_jj(q) − ZZ_j − Ia_j) = max_q M_jj(q)
///
/// [RIV] takes the maximum over all q; here it is over the samples of `q`, every one of them, which is what the loop
/// meets.
///
/// @param q  joint positions, (n_m × n), n_m ≥ 1 [rad | m]
/// @return   J, (n) [kg·m² | kg]; all entries positive
/// @throws InputError     where q does not fit the robot or is not finite
/// @throws NumericsError  where M_jj is not positive at a sample, with joint, sample and value
[[nodiscard]] Vector design_inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q);

/// How the largest M_jj is searched among all positions.
struct InertiaSearch {
  Index samples = 1024;  ///< positions of the global search, a quasi-random sequence, the same in every run
  Index starts = 4;      ///< the best positions of each joint, from which it is refined

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Largest inertia that each joint's drive sees at all, the J_j of Eq. (38) of [RIV] over all q.
///
/// M_jj depends on the joints behind j only. It is searched over a box of their positions: within the limits of each
/// joint, a revolute joint without limits through one turn. From the best of the positions sampled, M_jj climbs along
/// one coordinate at a time until none gives more.
/// That is a lower bound of the true maximum: it is a local one, in practice the global one, without a proof.
///
/// @return  J, (n) [kg·m² | kg]; all entries positive
/// @throws InputError     the search's complaint(); where a prismatic joint beyond the first has no limits
/// @throws NumericsError  where M_jj is not positive at a position that was sampled, with joint and value
[[nodiscard]] Vector design_inertia(const DynamicModel& model, const InertiaSearch& search = {});

}  // namespace rivid
