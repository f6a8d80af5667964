#pragma once

#include <span>

#include "rivid/identify/identification.hpp"

namespace rivid::detail {

// Where the rows of a robot whose friction follows the load, which is not linear in all parameters, are to be
// the tangent at.
struct LoadPasses {
  LoadPoint point;
  std::string fault;  // where the passes did not settle
};

// Steps of Gauss-Newton from the estimate without that friction on, each of them a whole estimate on the rows
// of the tangent. The last one is left to the caller, who infers from it, so that covariances know that the
// load is an estimate.
[[nodiscard]] LoadPasses load_passes(const Robot& robot, std::span<const Log> logs,
                                     const Estimation& estimation);

// The same values for the parameters of another friction law, zero where they are new.
[[nodiscard]] Vector carried_over(const BaseParameters& from, const Vector& chi, const BaseParameters& to);

}  // namespace rivid::detail
