#include "identify/infer/parameter_set.hpp"

#include "rivid/error.hpp"

namespace rivid {

namespace detail {

void expect_identified(std::string_view who, std::string_view status, std::span<const std::string> reasons,
                       const IdentifiedModelOptions& options) {
  if (status != name(Status::identified) && !options.force) {
    throw InputError(
        std::string(who) + ": the result is " + std::string(status) + ", not identified" +
        (reasons.empty() ? "" : " (" + reasons.front() + ")") +
        "; a controller should not have it. IdentifiedModelOptions::force takes it nevertheless");
  }
}

ParameterSet chosen_set(std::string_view who, bool has_physical, const IdentifiedModelOptions& options) {
  const ParameterSet chosen =
      options.parameters.value_or(has_physical ? ParameterSet::physical : ParameterSet::estimate);
  if (chosen == ParameterSet::physical && !has_physical) {
    throw InputError(
        std::string(who) +
        ": the result has no physically consistent parameters; identify with --physical, or with "
        "physical = true in [method]");
  }
  return chosen;
}

}  // namespace detail

}  // namespace rivid
