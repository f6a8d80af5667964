#pragma once

#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid::detail {

/// An experiment file that is edited: what is not changed stays as it is, comments and all.
struct ChangedText {
  std::string text;
  std::vector<std::string> lines;  ///< that are new: "[log]", "torque_lag = 5"
};

/// @param text        of the file
/// @param experiment  that it says
/// @param log         one of its logs, for columns that are found by default
/// @throws InputError  where the file is written in a way that leaves no place for a key
[[nodiscard]] ChangedText changed_text(std::string text, const Experiment& experiment, const Log& log,
                                       std::span<const Change> changes);

}  // namespace rivid::detail
