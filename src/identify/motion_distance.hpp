#pragma once

#include "rivid/identify/identification.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Distance of motions from others, gathered over several logs.
class MotionDistance {
 public:
  // n  joints
  explicit MotionDistance(Index n);

  void add(const Motion& a, const Motion& b);
  // ‖a − b‖ / ‖b‖; not a number where there was no motion.
  [[nodiscard]] MotionError error() const;

 private:
  Matrix difference_;  // sums of squares of q, q̇, q̈, (n × 3)
  Matrix whole_;
};

}  // namespace rivid::detail
