#pragma once

#include <nlohmann/json_fwd.hpp>

#include "rivid/report/json.hpp"

namespace rivid::detail {

/// Program, versions and inputs, to which `options` go last, with the overrides of the command line added to them.
[[nodiscard]] nlohmann::ordered_json provenance_json(const Provenance& provenance,
                                                     nlohmann::ordered_json options);

}  // namespace rivid::detail
