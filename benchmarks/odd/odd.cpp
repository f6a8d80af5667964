#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>

#include "odd/run.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;

struct Arguments {
  std::string kinds = "good,hard";
  std::string ways;
  std::string method = "as-drafted";
  std::uint64_t seed = 1;
  std::uint64_t first = 0;
  std::uint64_t count = 100;
  int threads = 2;
  bool check = false;
  bool visible = false;
  bool table_only = false;
  bool codes = false;
  bool friction = false;
  bool keep_all = false;
  std::filesystem::path records = "odd.csv";
  std::filesystem::path keep;
};

int run(const Arguments& arguments) {
  odd::Asked asked{.methods = {},
                   .check = arguments.check,
                   .visible = arguments.visible,
                   .keep = arguments.keep,
                   .keep_all = arguments.keep_all};
  std::istringstream methods(arguments.method);
  for (std::string method; std::getline(methods, method, ',');) {
    asked.methods.push_back(method);
  }
  odd::RecordFile file(arguments.records);
  if (!arguments.table_only) {
    odd::run_series({.seed = arguments.seed,
                     .kinds = odd::kinds_of(arguments.kinds),
                     .ways = arguments.ways.empty() ? std::vector<const odd::Way*>{nullptr}
                                                    : odd::ways_of(arguments.ways),
                     .first = arguments.first,
                     .count = arguments.count,
                     .threads = arguments.threads},
                    asked, file, true);
  }
  apps::print(odd::tables(file.records()) + (arguments.codes ? odd::code_table(file.records()) : "") +
              (arguments.friction ? odd::friction_table(file.records()) : ""));
  return apps::success;
}

int tool(int argc, char** argv) {
  Arguments to;
  return apps::run_command(
      {.name = "rivid_odd",
       .description =
           "Random experiments with something odd about them, as a user would have them: what rivid_identify "
           "says of each, against the truth.",
       .arguments =
           {{"--kinds", "NAME",
             "Kinds or groups, comma between: good, hard, log, physics, user, laws, no_rotor, all",
             &to.kinds},
            {"--ways", "NAME", "Ways to move in place of the drawn ones: fourier, pick_and_place, … or all",
             &to.ways},
            {"--count", "N", "Experiments, the kinds in turn", &to.count},
            {"--first", "N", "Number of the first one of each kind", &to.first},
            {"--seed", "N", "What all that is random follows from", &to.seed},
            {"--method", "NAME", "as-drafted, wls, iv, or several of them, comma between", &to.method},
            {"--check", "", "What rivid check finds as well", &to.check},
            {"--visible", "", "How much of the residual what is odd explains, by a twin that has nothing odd",
             &to.visible},
            {"--records", "FILE.csv", "One line an experiment and method; those in it are not run again",
             &to.records},
            {"--keep", "DIR", "Keeps the folders of what was confidently wrong or crashed", &to.keep},
            {.name = "--keep-all",
             .value = "",
             .text = "Keeps all of them",
             .target = &to.keep_all,
             .needs = "--keep"},
            {"--table", "", "Only prints the table of the records", &to.table_only},
            {"--codes", "", "Prints as well which warnings and findings each kind has", &to.codes},
            {"--friction", "", "Prints as well how many intervals of friction parameters hold the truth",
             &to.friction},
            {"--threads", "N", "Experiments at a time", &to.threads}},
       .footer =
           "docs/validation.md says what the columns mean, benchmarks/odd/kinds.cpp what the kinds are."},
      argc, argv, [&] { return run(to); });
}

}  // namespace

int main(int argc, char** argv) { return rivid::apps::run_tool("rivid_odd", tool, argc, argv); }
