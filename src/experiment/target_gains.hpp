#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/check/target_gain.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid::detail {

struct TargetGains {
  std::vector<TargetGain> motors;
  std::vector<std::string> logs;    ///< that have target currents and target torques
  std::vector<std::string> doubts;  ///< logs whose targets can not be read, and why

  [[nodiscard]] bool any() const;
  /// "drive_gain = [11.9, 12, ?] by the target currents and torques of run.csv, 95 % intervals ± 0.4, 0.1 %;
  /// elbow: its target torque hardly changes".
  [[nodiscard]] std::string text(const Robot& robot) const;
};

/// Drive gains by what a controller logs of its own model, its target currents and target torques, whose
/// columns are recognised by their names: see TargetSums. The interval is by blocks of time.
///
/// @param sources  their files, positions, control columns, clocks and side of the gears; target currents are
///                 taken to be in the unit of the control columns, with the factors of these but without
///                 their signs
/// @return         nothing where no log has such columns
[[nodiscard]] std::optional<TargetGains> target_gains(std::span<const LogSource> sources, const Robot& robot);

}  // namespace rivid::detail
