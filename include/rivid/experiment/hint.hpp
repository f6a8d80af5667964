#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/experiment/experiment.hpp"

namespace rivid {

/// How well an experiment explains its torques.
struct HintOutcome {
  Status status = Status::identified;
  double fit = 0.0;  ///< relative error of the fit
  /// Relative error on the validation logs; without any, of each half of the logs by the parameters of the
  /// other half. Not a number where these can not be identified.
  double held_out = std::numeric_limits<double>::quiet_NaN();

  template <typename R = HintOutcome>
  static constexpr auto fields() {
    return std::tuple(
        Field{"status", &R::status, "of the identification"},
        Field{"fit", &R::fit, "relative error of the fit"},
        Field{"held_out", &R::held_out, "relative error on validation logs, or of halves by each other"});
  }
};

/// The hint of a finding, taken.
struct HintTrial {
  Finding finding;                 ///< whose hint it is
  std::vector<std::string> lines;  ///< of the experiment file that are new, with their sections
  std::string text;                ///< of the whole file with them
  HintOutcome before;
  HintOutcome after;

  /// Whether what took no part in the fit is explained better; the fit, where nothing is held out.
  [[nodiscard]] bool helps() const;
};

/// Takes the hint of a finding: the experiment file is edited and identified anew, and a size is refined for
/// as long as the changed experiment has the same finding and fits better.
///
/// @param file     the experiment file, which is not changed
/// @param code     of a finding of its identification with Finding::changes
/// @param subject  that it is about; empty: the first of that code
/// @throws InputError  where there is no such finding, or its hint is none that a key of the file stands for;
///                     and as run() does
[[nodiscard]] HintTrial try_hint(const std::filesystem::path& file, std::string_view code,
                                 std::string_view subject = {}, const Progress& progress = {});

}  // namespace rivid
