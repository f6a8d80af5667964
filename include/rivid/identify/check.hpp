#pragma once

#include <span>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/finding.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

struct CheckOptions {
  SignalOptions signal = {};
  bool instrumental = false;  ///< whether the method is IDIM-IV, which noise does not bias
  int threads = 1;
};

/// What some logs are worth by themselves: identify() from them alone by weighted least squares. Where that
/// determines no arm, for a joint stands still or too little is moved, there are no warnings: another fit of
/// the same logs may know the rest from elsewhere.
///
/// @param estimation  whose signal, covariance and threads are taken
/// @throws InputError  as identify() does
[[nodiscard]] Identification examined(const Robot& robot, std::span<const Log> logs,
                                      const Estimation& estimation);

/// Looks for what would make an identification from these logs fail or mislead, before there is any: doubts
/// about robot and logs, units by magnitude, columns in a wrong order or with a wrong sign, clocks that
/// disagree, saturation, standstill, cut-off frequencies, and parameters that the motion does not show.
///
/// Torques are compared with what the model can make of the motion: with one set of parameters for all
/// joints, and, where that fails, with signs, orders, units or gravity changed one at a time. The change that
/// removes the fault is named.
///
/// @param logs        of the identification, at least one
/// @param validation  logs that are only compared with the others
/// @return            findings, the gravest first
/// @throws InputError  where a log can not be used at all, see Log::complaint(), or does not fit the robot
[[nodiscard]] std::vector<Finding> check(const Robot& robot, std::span<const Log> logs,
                                         std::span<const Log> validation = {},
                                         const CheckOptions& options = {});

}  // namespace rivid
