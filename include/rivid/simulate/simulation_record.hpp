#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/closed_loop.hpp"

namespace rivid {

/// A simulated experiment: what happened, what it was made with, and the log that a recorder would have kept.
struct [[nodiscard]] SimulationRecord {
  Simulation simulation;
  Log log;

  BaseParameters base;
  Vector chi;  ///< base parameters that were simulated, (b)
  Vector J;    ///< design inertias that the gains are matched to, (n); empty where M_jj is not positive
  ControlDescription control;    ///< gains in force
  double control_hz = 0.0;       ///< 0: the law is continuous [Hz]
  bool control_assumed = false;  ///< see ControlLoop
  std::uint64_t seed = 0;
  std::vector<Warning> warnings;  ///< of robot, simulation and log together
};

/// What a simulation is going to be.
struct SimulationOutlook {
  SimulationRecord record;  ///< all that is known before the motion; the outcome where it can not even start
  Index samples = 0;
  double f_m = 0.0;  ///< [Hz]
};

}  // namespace rivid
