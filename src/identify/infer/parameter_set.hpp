#pragma once

#include <span>
#include <string>
#include <string_view>

#include "rivid/identify/prediction.hpp"

namespace rivid::detail {

/// @param who     what messages start with: "identified_model", or a file
/// @param status  as name(Status) tells it
/// @throws InputError  where the status is not `identified` and force was not asked for
void expect_identified(std::string_view who, std::string_view status, std::span<const std::string> reasons,
                       const IdentifiedModelOptions& options);

/// @throws InputError  where a set of parameters has not one value for each base parameter
void expect_values(std::string_view who, const Identification& result);

/// The set that the options ask for.
///
/// @throws InputError  where that is the physically consistent one and there is none
[[nodiscard]] ParameterSet chosen_set(std::string_view who, bool has_physical,
                                      const IdentifiedModelOptions& options);

}  // namespace rivid::detail
