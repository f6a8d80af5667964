#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// The friction law of all joints of a kind that had Friction::automatic, by the evidence of all logs.
struct FrictionChoice {
  std::vector<int> joints;  ///< counted from 0
  Friction law = Friction::symmetric;
  /// ‖Y − Ŷ‖ / ‖Y‖ of these joints in stretches of time that took no part in the fit, with this law …
  double error = 0.0;
  double symmetric_error = 0.0;  ///< … and with Friction::symmetric
  /// The same on validation logs, by the fit to all others; nothing where there are none.
  std::optional<double> validation_error = {};
  std::optional<double> symmetric_validation_error = {};
  std::vector<Friction> close = {};  ///< laws that the logs hardly distinguish from this one

  /// "friction load_root (Fv Fc off Fl Fr) of all joints, by cross-validation: 2.1 % of unseen torques
  /// instead of 3.9 % with symmetric, …"
  ///
  /// @throws InputError  where the robot has no such joint
  [[nodiscard]] std::string text(const Robot& robot) const;
};

/// What choose_friction() found.
struct FrictionChoices {
  std::vector<FrictionChoice> kinds;  ///< one a law of revolute and of prismatic joints, where they are open
  /// What the choice leaves open of the base parameters of with_friction(), (b × b): the shifts by the other
  /// laws and what these leave open more, weighted by the chance that they are better.
  /// Estimation::choice_covariance should be that.
  Matrix C;
};

/// Chooses one law for all revolute joints that have Friction::automatic, and one for all prismatic ones,
/// among symmetric, root, load and load_root.
///
/// The logs are cut into stretches of time; the model is fitted without one of them by weighted least
/// squares, and judged by it, each in turn. A richer law is taken where it leaves less of the unseen torques
/// of all these joints together, each relative to its own error, by more than two standard errors of the
/// difference from stretch to stretch, and by 3 % of the error.
///
/// @param validation  logs that take no part, but say what they leave of the law and of symmetric
/// @return  no kinds where no joint has Friction::automatic
/// @throws InputError  where robot, logs and options do not fit together
[[nodiscard]] FrictionChoices choose_friction(const Robot& robot, std::span<const Log> logs,
                                              const Estimation& estimation,
                                              std::span<const Log> validation = {});

/// The robot with the laws that were chosen.
///
/// @throws InputError  where it has no such joint
[[nodiscard]] Robot with_friction(Robot robot, std::span<const FrictionChoice> choices);

}  // namespace rivid
