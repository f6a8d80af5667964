#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "rivid/experiment/excitation.hpp"

namespace rivid {

/// What may be wrong with a robot, its log or its description without anyone knowing.
enum class Trouble {
  torque_unit,
  torque_late,
  weak_motion,
  saturation,
  wrong_tip,
  gripper_missing,
  coarse_encoder,
  load_friction,
  coupling,
  soft_loop,
  zero_offset
};

template <>
inline constexpr std::array names_of<Trouble> = std::to_array<std::string_view>(
    {"torque_unit", "torque_late", "weak_motion", "saturation", "wrong_tip", "gripper_missing",
     "coarse_encoder", "load_friction", "coupling", "soft_loop", "zero_offset"});

/// In words and figures: "torques five samples late".
[[nodiscard]] std::string_view about(Trouble trouble);

/// What is supposed of a robot and its log before it has moved.
struct RehearsalOptions {
  static constexpr double largest_spread = 0.9;  // at 1 a mass could be zero

  double spread = 0.3;     ///< largest relative error of the a-priori masses, inertias and friction
  std::uint64_t seed = 1;  ///< of hidden robot and noise
  bool troubles = true;    ///< whether each is planted, one at a time

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// A base parameter of the hidden robot, and what the identification says of it.
struct RehearsedParameter {
  std::string name;
  std::string unit;
  double truth = 0.0;  ///< not a number where the trouble is no matter of these parameters
  double estimate = 0.0;
  double sigma = 0.0;
  double forecast = 0.0;  ///< 0 for a parameter that the plan's robot has not
  bool covered = false;
  Verdict verdict = Verdict::identified;

  /// Distance of the estimate from the truth in standard deviations.
  [[nodiscard]] double sigmas_off() const { return std::abs(estimate - truth) / sigma; }

  template <typename R = RehearsedParameter>
  static constexpr auto fields() {
    return std::tuple(
        Field{"name", &R::name, "of the base parameter"}, Field{"unit", &R::unit, "SI, joint side"},
        Field{"truth", &R::truth, "of the hidden robot"}, Field{"estimate", &R::estimate, "identified"},
        Field{"sigma", &R::sigma, "its reported standard deviation"},
        Field{"forecast", &R::forecast, "that of the forecast"},
        Field{"covered", &R::covered, "whether the 95 % interval holds the truth"},
        Field{"verdict", &R::verdict, "of the identification"});
  }
};

/// What came of one rehearsed experiment.
struct RehearsedRun {
  std::optional<Trouble> trouble = {};  ///< that was planted; none: all was as it should be
  std::string status = "refused";       ///< of the identification
  /// Warnings and errors, the gravest first: of a planted trouble those that it adds. They are those of the
  /// identification, and beside them, with the codes rehearsal_…, what plan and description show.
  std::vector<Finding> findings = {};
  double torque_error = std::numeric_limits<double>::quiet_NaN();  ///< Fit::reference_error
  double sigma_ratio = 0.0;  ///< geometric mean of reported over forecast standard deviations
  std::vector<RehearsedParameter> parameters = {};
  std::string log = {};  ///< as the robot would record it: CSV; empty with a trouble
};

struct [[nodiscard]] Rehearsal {
  RehearsedRun as_planned;
  std::vector<RehearsedRun> troubles;

  /// Whether the robot may move: the log as planned is identified, and no finding of it is an error.
  [[nodiscard]] bool passes() const;
};

/// Plays a motion with a hidden robot in the simulator, records it as the robot would, and identifies the
/// record as draft_experiment() has it, with the robot of the plan: as planned, then with each trouble.
///
/// The hidden robot is drawn about the description: bodies are scaled and stretched by up to ± `spread` and
/// stay physically consistent; rotors and friction are drawn about the a-priori values, or in proportion to
/// inertias and torques of the motion where there are none. Its loop is [control], tuned for the hidden
/// robot, else PD with ω_n = 60 rad/s; its drives give max_effort and no more. Noise is that of [simulation],
/// else recorded torques have the noise of the plan; the resolution of positions is that of [control].
///
/// @param motion  file with positions over time, with the columns of [log]
/// @throws InputError  where motion or options can not be used, or the robot has no a-priori masses
Rehearsal rehearse(const ExcitationPlan& plan, const std::filesystem::path& motion,
                   const RehearsalOptions& options = {}, const Progress& progress = {});

}  // namespace rivid
