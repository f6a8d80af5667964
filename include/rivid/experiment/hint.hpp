#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/experiment/experiment.hpp"

namespace rivid {

/// What an experiment comes to.
struct HintOutcome {
  Status status = Status::identified;
  double fit = 0.0;  ///< relative error of the fit
  /// Relative error on the validation logs; without any, of each half of the logs with the parameters of the
  /// other half. Nothing where these can not be identified.
  std::optional<double> held_out = {};
};

/// A hint of a finding, tried.
struct HintTrial {
  Finding finding;                 ///< whose hint it is
  std::string change;              ///< in words
  std::vector<std::string> lines;  ///< of the experiment file, with their sections
  HintOutcome before;
  HintOutcome after;

  /// Whether what took no part is explained better, or, where nothing can say so, the fit is.
  [[nodiscard]] bool helps() const;
};

/// Applies the hint of a finding to an experiment. Of several readings of it, as a motor of two joints has,
/// the one that fits best is taken; a size is refined by the findings of the changed experiment.
///
/// @param code     of a finding: a sign, an order, a unit, a zero, a gain, gravity, a clock, a delay, a law of
///                 friction, a coupling
/// @param subject  joint or joints that it is about; empty: what the finding says
/// @throws InputError  where the experiment has no such finding, or its hint is none that can be applied; as
///                     run() does
[[nodiscard]] HintTrial try_hint(const Experiment& experiment, std::string_view code,
                                 std::string_view subject, Reading& reading);

/// The trial in words, the lines to paste at its end.
[[nodiscard]] std::string in_words(const HintTrial& trial);

}  // namespace rivid
