#pragma once

#include <span>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/identification.hpp"

namespace rivid::detail {

/// A log without torques whose control signals are those of the control law of its source, along the measured
/// motion.
///
/// @throws InputError  where the law's gains are not known, it has an integral, or the log has no reference
[[nodiscard]] Log with_control_of_law(Log log, const LogSource& source, const Robot& robot);

/// Whether it is such a log.
[[nodiscard]] bool has_control_of_law(const Log& log);

/// Those of such logs once more, by what was estimated of the loop; other logs as they are.
[[nodiscard]] std::vector<Log> with_control_of_loop(std::span<const Log> logs, LogSource source,
                                                    const Robot& robot,
                                                    const std::vector<LoopEstimate>& loop);

}  // namespace rivid::detail
