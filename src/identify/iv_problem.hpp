#pragma once

#include <span>
#include <vector>

#include "rivid/identify/identification.hpp"

namespace rivid::detail {

// What an identification by instrumental variables stands on, from the beginning to the end.
struct IvProblem {
  // All are referred to, not copied.
  //
  // throws InputError where they do not fit together
  IvProblem(const Robot& robot, std::span<const Log> logs, const Estimation& estimation);

  const Robot& robot;
  std::span<const Log> logs;
  const Estimation& estimation;
  const Iv& method;  // that of the estimation
  BaseParameters base;
  std::vector<SignalOptions> signals;  // one a log: the transient is left out
  RowFactors data;                     // of [W Y]

  [[nodiscard]] Index joints() const { return robot.size(); }
};

}  // namespace rivid::detail
