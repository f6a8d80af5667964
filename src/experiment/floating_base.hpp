#pragma once

#include <functional>
#include <vector>

#include "rivid/experiment/experiment.hpp"

namespace rivid::detail {

/// A log of the columns that are asked for.
using ColumnsRead = std::function<Log(const LogOptions&)>;

/// The log with Robot::base_joints in front: their positions from the pose of the base, without torque. As it
/// is where the source says no pose.
///
/// @throws InputError  where the base is pitched to within 5° of ±90°, with the instant; where no torque is
///                     there to fix the scale
[[nodiscard]] Log with_base(Log log, const LogSource& source, const Robot& robot, const ColumnsRead& read);

/// The columns of all contacts of a source, as the positions of a log.
[[nodiscard]] Log wrenches_of(const LogSource& source, const ColumnsRead& read);

/// The log with the torques that the measured wrenches make: τ += Jᵀ w.
[[nodiscard]] Log with_wrenches(Log log, const Log& wrenches, const LogSource& source, const Robot& robot);

}  // namespace rivid::detail
