#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "paper_study/study.hpp"
#include "rivid/version.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;

// The case study of [RIV], sections 4.2 to 5: its SCARA in simulation, identified by IDIM-OLS and IDIM-IV, beside the
// numbers that the paper prints.
int run(int argc, char** argv) {
  std::filesystem::path folder = "paper_study";
  std::uint64_t seeds = 20;
  CLI::App app("The case study of the paper, its tables and figures on a simulated SCARA",
               "rivid_paper_study");
  app.add_option("folder", folder, "Folder for the tables and figures; default: paper_study")
      ->type_name("DIR");
  app.add_option("--seeds", seeds, "Number of logs, which differ in their noise; default: 20")
      ->check(CLI::Range(1, 1000))
      ->type_name("NUMBER");
  app.set_version_flag("--version", std::string("rivid_paper_study ") + version);
  app.footer("Exit codes: 0 all that it claims holds, 1 a claim does not, 2 bad input or usage.");
  if (const auto code = parse(app, argc, argv)) {
    return *code;
  }
  const study::Scara scara;
  study::Report report(folder);
  report.print("SCARA of [RIV], section 4, in simulation: means over " +
               counted(static_cast<std::ptrdiff_t>(seeds), "log") +
               ". σ is the classical standard\ndeviation, scatter that of the estimates from log to log.\n");
  study::identification(scara, seeds, report);
  study::reference_regressor(scara, seeds, report);
  study::wrong_design(scara, seeds, report);
  study::cutoff(scara, seeds, report);
  study::length_of_the_log(scara, seeds, report);
  study::replay(scara, seeds, report);
  report.finish();
  return report.all_hold() ? success : no_success;
}

}  // namespace

int main(int argc, char** argv) { return run_tool("rivid_paper_study", run, argc, argv); }
