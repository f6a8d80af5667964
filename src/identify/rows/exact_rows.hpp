#pragma once

#include <cstdint>
#include <vector>

#include "rivid/identify/rows.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Standard deviation of white noise on a series, from fourth differences, which leave little of a motion.
[[nodiscard]] double noise_level(const Eigen::Ref<const Vector>& x);

// What RowScheme::exact does to a log beside what all rows go through.

// Averages torques with the weights that two central differences in a row give to the accelerations around a
// sample, a triangle over four periods: (1, 3, 3, 1)/8 over samples k−2 … k+1 where a torque acts until the
// next sample, and for one that was measured at the samples (1, 1, 1)/3, which has the triangle's second
// moment.
void average_torque(Matrix& tau, bool held);

// Motion at the samples of q as the averages over that same triangle see it: q̈ is the central difference of
// the central difference, which is such an average already; q̇ and q are averaged until their weights have
// its second moment, 2/3 of a squared period. Like differentiate() it spoils two samples at each end.
//
// q  positions, (n_m × n), n_m ≥ 2
[[nodiscard]] Motion averaged_motion(const Eigen::Ref<const Matrix>& q, double f_m);

// Samples whose torque the model explains: those where a joint moves, and all samples that its row is made of
// lie between the same two reversals.
struct MotionMask {
  std::vector<std::int8_t> direction;  // one a sample: 1 or −1 where the joint moves, 0 where it has no row
  double threshold = 0.0;              // of |q̇| [rad/s | m/s]
  bool smoothed =
      false;  // directions are of a low-passed velocity: that of single samples may have the other sign
};

// The mask of each joint's rows, (n). A joint counts as moving where its velocity stands out of the noise of
// its own positions. Where that takes more than a small part of the motion, the velocity is low-passed for
// the mask alone: noise would choose its own rows otherwise, those that it makes fast, and tear the stretches
// that windows lie in.
//
// q         measured positions, (n_m × n)
// filtered  the same, after the position filter of the options
[[nodiscard]] std::vector<MotionMask> motion_masks(const Robot& robot, const Matrix& q,
                                                   const Matrix& filtered, double f_m,
                                                   const SignalOptions& options);

// Samples, counted from `first`, that windows of 2 n_d − 1 samples fit around without touching a sample that
// is masked: as many as fit into each stretch of motion, n_d apart.
[[nodiscard]] std::vector<Index> window_centres(const MotionMask& mask, Index first, Index count, Index n_d);

}  // namespace rivid::detail
