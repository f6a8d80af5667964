#pragma once

#include <string>

#include "rivid/experiment/plan_file.hpp"

namespace rivid {

/// Two plans compared, for people: what B is worth in experiment time of A, and the standard deviations of
/// both. UTF-8, at most 110 columns wide.
[[nodiscard]] std::string in_words(const PlanFile& a, const PlanFile& b, const PlanComparison& comparison);
/// The same as JSON; docs/excite.md describes its members.
[[nodiscard]] std::string to_json(const PlanFile& a, const PlanFile& b, const PlanComparison& comparison);

/// Forecast and reported standard deviations, for people: joint by joint, and the parameters where they
/// disagree.
[[nodiscard]] std::string in_words(const PlanFile& plan, const PlanCheck& check);
/// The same as JSON, all parameters included: the content of plan_check.json.
[[nodiscard]] std::string to_json(const PlanFile& plan, const PlanCheck& check);

}  // namespace rivid
