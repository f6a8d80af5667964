#pragma once

#include <vector>

#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/regressor/columns.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// The rows of one joint in the observation matrix: only the columns that this joint's torque can depend on.
struct JointRows {
  std::vector<Index> columns;  ///< indices into the base parameters, ascending
  Matrix W;                    ///< (rows × columns.size())
};

/// Observation matrix W_fm of Eqs. (10–12) of [RIV], grouped joint by joint, without its zero blocks.
struct Observation {
  Index columns = 0;              ///< b
  std::vector<JointRows> joints;  ///< (n), each with n_m rows

  /// W as the paper writes it, (Σ rows × b), zeros filled in.
  [[nodiscard]] Matrix dense() const;
};

/// W_fm(q, q̇, q̈) of Eq. (12): the base regressor sampled along a motion.
///
/// It holds all of W at once; RegressorBatch gives it block by block.
///
/// @param motion  (n_m × n)
/// @throws InputError where the motion has another number of joints than the robot, or sizes that differ, or an
///                    option can not be used
[[nodiscard]] Observation observation(const Robot& robot, const BaseParameters& base, const Motion& motion,
                                      const BatchOptions& options = {});

}  // namespace rivid
