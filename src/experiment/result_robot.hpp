#pragma once

#include "experiment/json_node.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

/// The robot that a result.json describes, in its member `robot`; without a-priori values and limits.
///
/// @throws InputError  where a member is missing or can not be used
[[nodiscard]] Robot result_robot(const JsonNode& robot);

/// @throws InputError  where the geometry of the two differs, with the joint and both values; `result` is that of `node`
void expect_same_geometry(const JsonNode& node, const Robot& result, const Robot& robot);

}  // namespace rivid::detail
