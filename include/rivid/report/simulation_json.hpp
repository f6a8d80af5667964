#pragma once

#include <string>

#include "rivid/model/robot.hpp"
#include "rivid/report/provenance.hpp"
#include "rivid/simulate/simulation_record.hpp"

namespace rivid {

/// What rivid_simulate tells of a simulation, the content of simulation.json; docs/simulation.md describes its members.
/// read_parameters() reads it as a parameter file. Numbers are written so that they read back bit by bit; what is not a
/// number becomes null.
[[nodiscard]] std::string to_json(const Robot& robot, const SimulationRecord& record,
                                  const Provenance& provenance);

/// The same for people: verdict, tracking and friction joint by joint, effort. UTF-8, at most 110 columns wide.
[[nodiscard]] std::string summary(const Robot& robot, const SimulationRecord& record);

}  // namespace rivid
