#pragma once

#include <span>
#include <vector>

#include "identify/check/checks.hpp"
#include "rivid/identify/identification.hpp"

// The fourth stage: rows → estimate → infer → judge → describe.
namespace rivid::detail {

// What speaks against a result beside its own figures, and by what it should be wider.
struct Judgement {
  std::vector<Finding> findings;  // in the order in which they came
  Alternatives alternatives;      // without a shift where deviations are not to know the errors of the model
};

// Looks at robot, logs, model and result for what makes it wrong, see identify().
//
// logs        that the result is of, and that result.validation is of, as they were given
// throws InputError where logs and robot do not fit together
[[nodiscard]] Judgement judged(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                               const Identification& result);

}  // namespace rivid::detail
