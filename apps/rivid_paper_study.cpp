#include <cstdint>
#include <filesystem>
#include <string>

#include "paper_study/study.hpp"
#include "programs.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;

// The case study of [RIV], sections 4.2 to 5: its SCARA in simulation, identified by IDIM-OLS and IDIM-IV,
// beside the numbers that the paper prints.
int study_in(const std::filesystem::path& folder, std::uint64_t seeds) {
  const study::Scara scara;
  study::Report report(folder);
  report.print(
      "SCARA of [RIV], section 4, in simulation: means over " +
      counted(static_cast<std::ptrdiff_t>(seeds), "log") +
      ". σ is rivid's standard\ndeviation, from residuals that are correlated (HAC); scatter that of the "
      "estimates from log to log.\n\"all samples\": the simulation starts in the measured state; \"section "
      "3.4\": on "
      "the reference, and samples with\nt < 5 / min ω_n are dropped, as in the paper.\n");
  study::misprints(report);
  study::identification(scara, seeds, report);
  study::reference_regressor(scara, seeds, report);
  study::raw_least_squares(scara, seeds, report);
  study::wrong_design(scara, seeds, report);
  study::cutoff(scara, seeds, report);
  study::length_of_the_log(scara, seeds, report);
  study::replay(scara, seeds, report);
  report.finish();
  return report.all_hold() ? success : no_success;
}

}  // namespace

int rivid::apps::paper_study_tool(int argc, char** argv) {
  std::filesystem::path folder = "paper_study";
  std::uint64_t seeds = 20;
  return run_command(
      {.name = "rivid paper",
       .description = "The case study of the paper, its tables and figures on a simulated SCARA",
       .arguments = {{"folder", "DIR", "Folder for the tables and figures; default: paper_study", &folder},
                     {"--seeds", "NUMBER", "Number of logs, which differ in their noise; default: 20",
                      &seeds}},
       .footer = "Exit codes: 0 all that it claims holds, 1 a claim does not, 2 bad input or usage."},
      argc, argv, [&] { return study_in(folder, seeds); });
}
