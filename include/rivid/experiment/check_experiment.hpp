#pragma once

#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/finding.hpp"

namespace rivid {

/// check() of the logs of an experiment file, and of its drive gains: where logs have the target currents and target torques
/// of the robot's controller, those of its own model follow (`target_gains`), and a drive_gain of the file that
/// is another is named (`drive_gain_differs`).
///
/// @return            findings, the gravest first
/// @throws InputError  as read_logs() and check() of logs do
[[nodiscard]] std::vector<Finding> check(const Experiment& experiment, int threads = 1);

}  // namespace rivid
