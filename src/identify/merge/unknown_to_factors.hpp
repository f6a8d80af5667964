#pragma once

#include <optional>
#include <string>

#include "rivid/identify/estimation.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

// What factors of logs can not be asked for, whatever the method: it needs single rows.
[[nodiscard]] std::optional<std::string> unknown_to_factors(const Robot& robot, const Estimation& estimation);

}  // namespace rivid::detail
