#include "rivid/model/mdh.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

// Headers that two files include.
rivid::Index joints_of(const rivid::Robot& robot) {
  return robot.standard_parameters().empty() ? 0 : robot.size();
}
