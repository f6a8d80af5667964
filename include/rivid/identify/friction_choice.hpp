#pragma once

#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// The friction law of a joint that cross-validation chose, Friction::automatic.
struct FrictionChoice {
  int joint = 0;  ///< counted from 0
  Friction law = Friction::symmetric;
  double error =
      0.0;  ///< of stretches of time that took no part in the fit: ‖Y_j − Ŷ_j‖ / ‖Y_j‖ with this law …
  double symmetric_error = 0.0;  ///< … and with Friction::symmetric

  /// "joint_2: load friction (Fv Fc off Fl) by cross-validation, 2.1 % of unseen torques instead of 3.9 %"
  ///
  /// @throws InputError  where the robot has no such joint
  [[nodiscard]] std::string text(const Robot& robot) const;
};

/// Chooses the law of each joint that has Friction::automatic among symmetric, root, load and load_root.
///
/// The logs are cut into stretches of time; the model is fitted without one of them by weighted least
/// squares, and judged by it, each in turn. A joint gets the simplest law whose unseen error no other law
/// undercuts by more than 3 %, and by more than two standard errors of the difference from stretch to
/// stretch.
///
/// @return  one a joint with Friction::automatic; none where there is none
/// @throws InputError  where robot, logs and options do not fit together
[[nodiscard]] std::vector<FrictionChoice> choose_friction(const Robot& robot, std::span<const Log> logs,
                                                          const Estimation& estimation);

/// The robot with the laws that were chosen.
///
/// @throws InputError  where it has no such joint
[[nodiscard]] Robot with_friction(Robot robot, std::span<const FrictionChoice> choices);

}  // namespace rivid
