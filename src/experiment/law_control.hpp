#pragma once

#include "rivid/experiment/experiment.hpp"

namespace rivid::detail {

/// A log without torques whose control signals are those of the control law of its source, along the measured
/// motion.
///
/// @throws InputError  where the law's gains are not known, it has an integral, or the log has no reference
[[nodiscard]] Log with_control_of_law(Log log, const LogSource& source, const Robot& robot);

}  // namespace rivid::detail
