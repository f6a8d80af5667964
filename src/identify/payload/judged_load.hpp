#pragma once

#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/gains.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

// What speaks against logs with a payload that a fit has in common with others: examined() by themselves,
// with the gains that were found, and by what that fit leaves of them.
//
// name       of the logs, before the subjects of findings
// sigma_rho  that the common fit leaves of each joint, at nominal gains, (n)
[[nodiscard]] std::vector<Finding> judged_load(const Robot& robot, const std::string& name,
                                               std::span<const Log> logs, const Estimation& estimation,
                                               const std::vector<GainEstimate>& gains,
                                               const Vector& sigma_rho);

// Findings with what they are about before their subjects.
[[nodiscard]] std::vector<Finding> about(const std::string& name, std::vector<Finding> findings);

}  // namespace rivid::detail
