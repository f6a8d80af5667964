#pragma once

#include <string>
#include <string_view>

#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

/// Torques of a robot as a C header with its numbers baked in, for C99 and any C++, which includes nothing
/// but <math.h>:
///
///   #define NAME_JOINTS n
///   void NAME_inverse_dynamics(const double q[n], const double qd[n], const double qdd[n], double tau[n]);
///   void NAME_rigid_body(const double q[n], const double qd[n], const double qdd[n], double tau[n]);
///   void NAME_gravity(const double q[n], double tau[n]);
///   void NAME_friction(const double qd[n], const double smoothing_speed[n], double tau[n]);
///   void NAME_observe(NAME_observer*, …);
///   void NAME_estimate_payload(NAME_payload*, …);
///
/// inverse_dynamics is rigid_body plus friction; friction takes a null pointer for sign(q̇), or speeds v_s
/// for tanh(q̇ / v_s). They are the torques of InverseDynamics: recursive Newton-Euler over the links that
/// the base parameters leave, SI units on the joint side, no memory but the stack.
///
/// observe is the residual of ContactObserver, estimate_payload ten parameters of a body on the last link by
/// recursive least squares on it; the objects begin with all zeros.
///
/// @param name    a C identifier, see c_identifier()
/// @param origin  one line that says where the numbers come from, for the comment on top
/// @throws InputError  where the name is no C identifier, or the robot branches
[[nodiscard]] std::string c_header(const DynamicModel& model, std::string_view name,
                                   std::string_view origin = {});

/// `text` with every character that a C identifier can not hold as '_', and a leading digit after one.
[[nodiscard]] std::string c_identifier(std::string_view text);

}  // namespace rivid
