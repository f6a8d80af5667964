#pragma once

#include <cstdint>

#include "paper_study/report.hpp"
#include "paper_study/scara.hpp"

// The parts of the study, each over logs of the seeds 1 … `seeds`.
namespace rivid::study {

/// Sections 4.2 to 4.5: tables 1 to 7, figures 7 to 13, and the limit of the bandwidth.
void identification(const Scara& scara, std::uint64_t seeds, Report& report);

/// Section 5: estimates over the cut-off of the filter, by least squares and by instrumental variables.
void cutoff(const Scara& scara, std::uint64_t seeds, Report& report);

/// Section 4.3: W from the reference trajectory in place of the measured one.
void reference_regressor(const Scara& scara, std::uint64_t seeds, Report& report);

/// (47): a controller that was designed with wrong inertias, and a wrong drive gain.
void wrong_design(const Scara& scara, std::uint64_t seeds, Report& report);

/// (24–33): the error over the length of the log.
void length_of_the_log(const Scara& scara, std::uint64_t seeds, Report& report);

/// (21): the direct dynamic model, driven by the torques of a trajectory that was not used.
void replay(const Scara& scara, std::uint64_t seeds, Report& report);

}  // namespace rivid::study
