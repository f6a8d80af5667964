#pragma once

#include <filesystem>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/online/model.hpp"

namespace rivid {

/// What the estimators of a control loop take, of a result: base parameters as they were estimated with their covariance, the
/// deviation of each joint's residual and the speed below which it had no rows.
///
/// @throws InputError  where the result is not identified, or is that of another robot
[[nodiscard]] OnlineModel online_model(const Robot& robot, const Identification& result);

/// The same from a result.json, in one call:
///
///   PayloadEstimator<double> payload(read_online_model("my_robot_result/result.json"), {.rows = {.f_m = 1000}});
///
/// @throws InputError  "file: member …" for a file that can not be read or is none, and for a result that is not
///                     identified, unless options.force; physically consistent parameters have no covariance, so that
///                     options.parameters is not looked at
[[nodiscard]] OnlineModel read_online_model(const std::filesystem::path& path,
                                            const IdentifiedModelOptions& options = {});

}  // namespace rivid
