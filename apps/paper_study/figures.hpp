#pragma once

#include <string>

#include "paper_study/report.hpp"
#include "paper_study/scara.hpp"

// Figures 7 to 13 of [RIV].
namespace rivid::study {

/// Fig. 7: torques measured, and those of the model along the simulated motion.
void figure_torques(const Scara& scara, const Log& log, const Identification& found, Report& report);

/// Figs 8 and 9, or 12 and 13, one a joint: distance of the simulated motion from the filtered measured one and from the
/// reference.
///
/// @param number  of the first of the two
void figure_motion_errors(int number, const std::string& what, const Identification& found, Report& report);

/// Fig. 10.
void figure_parameters(const Identification& found, Report& report);

/// Fig. 11; beside the error against W that of the stop rule, against the simulated V.
void figure_torque_errors(const Scara& scara, const Log& log, const Identification& found, Report& report);

}  // namespace rivid::study
