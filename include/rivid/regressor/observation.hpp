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

/// Base parameters that one motion can show: the same scan on IDM_st along the motion instead of at random states. A
/// joint that stands still, or an arm that moves in a plane, shows fewer parameters, and regroups more of them, than
/// the robot has; the names and the regrouping say which. Meant for judging an excitation, and for models of robots
/// that can move in no other way; a fit with the structural base parameters tells the same as `rank_deficient`.
///
/// What counts is the independent part of a column relative to the largest column of the same unit: a parameter is
/// seen if a value of 1 moves the torques at least `tolerance` times as much as the best-seen parameter of its unit.
///
/// The motion is used as it is. Filter it first and leave out its borders, as rows() does: noise is independent
/// of everything, and a joint's Coulomb column is ±1 for any velocity but zero.
///
/// Memory is that of one block of samples and a triangle of (N_s × N_s), however long the motion is.
///
/// @param motion     (n_m × n)
/// @param tolerance  between 0 and 1: about 1e-9 for a motion that is computed, 1e-3 to 1e-2 for a measured one
/// @throws InputError where the robot, the motion or the tolerance can not be used
[[nodiscard]] BaseParameters base_parameters(const Robot& robot, const Motion& motion, double tolerance);

}  // namespace rivid
