#pragma once

#include "rivid/regressor/base.hpp"

namespace rivid::detail {

// Standard parameters whose friction brakes: where Fv or Fc of a joint is negative it becomes zero, and the other one
// takes over its torque as well as it can along a motion, by least squares over Fv |q̇| + Fc. (Early iterates trade one for
// the other; the simulation could only leave the negative one out, and the positive one alone may hold the joint fast.)
//
// chi_st      (N_s) values of base.standard
// mean_speed  mean |q̇| of each joint along the motion, (n)
// mean_square mean q̇², (n)
void make_dissipative(const BaseParameters& base, const Vector& mean_speed, const Vector& mean_square,
                      Vector& chi_st);

}  // namespace rivid::detail
