#pragma once

#include <functional>

#include "rivid/types.hpp"

namespace rivid::detail {

/// Objective and limits at some variables; limits are wanted not to be positive.
struct MmaValue {
  double objective = 0.0;
  Vector limits = {};  ///< (m)
};

struct MmaOptions {
  double bound = 4.0;       ///< −bound ≤ z ≤ bound
  double tolerance = 0.01;  ///< change of the objective below which the search ends
  int evaluations = 500;    ///< at most
  std::function<bool()> stopped = {};
};

struct MmaResult {
  Vector z;  ///< the best that kept all limits, or the start
  double objective = 0.0;
  int evaluations = 0;
};

/// Minimum by the method of moving asymptotes [Svanberg 2002] of NLopt.
///
/// @param f  value(z, gradient (variables), jacobian (variables × limits))
/// @throws InputError  where rivid was built without NLopt
[[nodiscard]] MmaResult minimised(const std::function<MmaValue(const Vector&, Vector&, Matrix&)>& f, Vector z,
                                  const MmaOptions& options);

}  // namespace rivid::detail
