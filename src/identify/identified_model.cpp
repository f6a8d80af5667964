#include <algorithm>
#include <string>

#include "identify/parameter_set.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/prediction.hpp"

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

DynamicModel identified_model(const Robot& robot, const Identification& result,
                              const IdentifiedModelOptions& options) {
  constexpr std::string_view who = "identified_model";
  detail::expect_identified(who, name(result.status), result.reasons, options);
  if (detail::chosen_set(who, result.physical.has_value(), options) == ParameterSet::estimate) {
    return {robot, result.base, result.chi};
  }
  const auto same = [](const StandardParameter& a, const StandardParameter& b) {
    return a.kind == b.kind && a.joint == b.joint;
  };
  if (!std::ranges::equal(result.base.standard, robot.standard_parameters(), same)) {
    throw InputError("identified_model: the result is that of another robot than \"" + robot.name +
                     "\", or of other friction laws");
  }
  return {robot, result.physical->parameters.chi_st};
}

}  // namespace rivid
