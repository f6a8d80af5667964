#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "rivid/finding.hpp"

namespace rivid::detail {

/// A list of objects with code and text.
[[nodiscard]] nlohmann::ordered_json warnings_json(const std::vector<Finding>& warnings);

}  // namespace rivid::detail
