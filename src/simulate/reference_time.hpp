#pragma once

#include <algorithm>

#include "rivid/simulate/references.hpp"

namespace rivid::detail {

// Where in its motion a reference is, and whether it rests before or after it.
struct ReferenceTime {
  double t = 0.0;  // [s], between begin and end
  bool rests = false;

  ReferenceTime(const Reference& reference, double asked) {
    // An instant that rounding put beyond an end, the sum of many periods say, still belongs to the motion.
    constexpr double rounding = 1e-9;
    const double begin = reference.begin();
    const double slack = rounding * reference.duration();
    const double end = begin + reference.duration();
    t = std::clamp(asked, begin, end);
    rests = asked < begin - slack || asked > end + slack;
  }
};

}  // namespace rivid::detail
