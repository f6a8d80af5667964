#pragma once

#include <array>
#include <map>
#include <string>

#include "rivid/identify/identification.hpp"

namespace rivid::odd {

/// What became of an experiment.
enum class Outcome {
  honest,    ///< identified, no warning, and no parameter that is wrong
  warned,    ///< identified, with a warning that covers what is wrong, if anything is
  doubtful,  ///< an estimate that the result itself doubts
  refused,   ///< no answer: another status, or the input was refused
  wrong,     ///< confidently wrong, see judged()
  crashed    ///< an exception that is no refusal
};
/// "honest", …
[[nodiscard]] std::string_view word(Outcome outcome);

struct Judgement {
  Outcome outcome = Outcome::refused;
  bool material = false;
  Index counted = 0;       ///< parameters with an interval and a truth
  Index covered = 0;       ///< those whose interval holds the truth
  double rms_error = 0.0;  ///< root mean square of (χ̂ − χ) over the largest |χ| of the unit
  std::string worst;       ///< name of the parameter that is most standard deviations off
  double worst_sigmas = 0.0;
  double worst_percent = 0.0;
  std::string warnings;  ///< codes
  /// Of friction parameters the same two numbers by symbol: "Fc", "Fl", …
  std::map<std::string, std::array<Index, 2>, std::less<>> friction;
};

/// The definition of "confidently wrong": the status is `identified`, and a parameter with the verdict
/// `identified` lies more than five of its standard deviations from the truth, is not named by the warning
/// `weak_excitation`, and there is no other warning. Material: such a parameter is also more than 10 % off,
/// and by more than 2 % of the largest of its unit.
///
/// @param truth          (b) base parameters
/// @param inertial_only  friction has no truth and is not judged
[[nodiscard]] Judgement judged(const Identification& result, const Vector& truth, bool inertial_only);

}  // namespace rivid::odd
