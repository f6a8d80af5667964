#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/model/robot.hpp"

namespace rivid::detail {

/// The standard parameters of one joint and its link, as robot descriptions have them.
struct JointValues {
  Inertial inertial = Inertial::Zero();  // in rivid's link frame
  double Ia = 0.0;
  std::optional<double> damping;     // Fv, the mean of both directions; none where the law has none
  std::optional<double> friction;    // Fc, likewise
  std::string rotor;                 // "Ia1 = 0.3 kg·m²"; empty where it is zero
  std::vector<std::string> rest;     // the same of asymmetric friction, offsets, coupled motors
  std::vector<std::string> coupled;  // those of `rest` that belong to coupled motors

  /// value × function(speed, sign) in the friction of the joint alone.
  struct FrictionTerm {
    double value = 0.0;
    std::string function;  // friction_function(), as C and Python write it
    Direction direction = Direction::both;
  };
  std::vector<FrictionTerm> friction_terms;
  double load_friction = 0.0;  // Fl: friction per |τ_load| of the joint

  /// What has no place beside inertial, damping and friction.
  [[nodiscard]] std::vector<std::string> unsaid(bool with_rotor) const;
};

/// "1 2 3", each number with as many digits as it takes to read it back.
[[nodiscard]] std::string exact_list(const Eigen::Ref<const Vector>& values);

/// One a link, those of dependent joints last.
///
/// @param who  the function that was called, in messages
/// @throws InputError  a wrong number of values, or one that is not finite
[[nodiscard]] std::vector<JointValues> joint_values(const Robot& robot,
                                                    const Eigen::Ref<const Vector>& chi_st,
                                                    std::string_view who);

}  // namespace rivid::detail
