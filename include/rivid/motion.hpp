#pragma once

#include "rivid/types.hpp"

namespace rivid {

/// A motion of n joints at n_m instants: one row a sample, one column a joint.
struct Motion {
  Matrix q;    ///< positions, (n_m × n) [rad | m]
  Matrix qd;   ///< velocities, (n_m × n) [rad/s | m/s]
  Matrix qdd;  ///< accelerations, (n_m × n) [rad/s² | m/s²]

  [[nodiscard]] Index samples() const { return q.rows(); }
  [[nodiscard]] Index joints() const { return q.cols(); }
};

}  // namespace rivid
