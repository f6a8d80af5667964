#pragma once

#include <string>
#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

// drive_gain of one motor by the model of the robot's own controller.
struct TargetGain {
  // Torque for one unit of the control signal, with the sign that the robot's has: that follows the axes of
  // the URDF.
  double value = 0.0;
  double half_width = 0.0;  // of the 95 % interval
  std::string missing;      // why there is none; empty where there is
};

// Target current and target torque of one motor in some logs, for the least-squares gain K of
//
//   i = τ / K + Fv q̇ + Fr √|q̇| sign q̇ + Fc sign q̇ + offset
//
// where the friction, which follows the temperature, is each log's own: sums by blocks of time of what it
// leaves of i and τ.
struct TargetSums {
  struct Block {
    double torque = 0.0;  // Σ τ²
    double both = 0.0;    // Σ τ i
  };
  std::vector<Block> blocks;
  Index samples = 0;
  double all_torque = 0.0;      // Σ τ² with friction
  double all_current = 0.0;     // Σ i² with friction
  double current_beside = 0.0;  // Σ i² without it

  // slowest  samples below this speed are left out: they say little of the sign of the friction
  void add(const Eigen::Ref<const Vector>& current, const Eigen::Ref<const Vector>& torque,
           const Eigen::Ref<const Vector>& velocity, double slowest);
  [[nodiscard]] TargetGain gain() const;
};

}  // namespace rivid::detail
