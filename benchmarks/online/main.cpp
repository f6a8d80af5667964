// benchmark_online_study NAME [NUMBER [ARM]]: the long measurements of docs/online.md.

#include <cstdlib>
#include <iostream>
#include <string>

#include "studies.hpp"

int main(int argc, char** argv) {
  using namespace rivid::benchmarks;
  const std::string name = argc > 1 ? argv[1] : "";
  const double count = argc > 2 ? std::atof(argv[2]) : 0.0;
  const std::string arm = argc > 3 ? argv[3] : "";
  const std::string data = RIVID_DATA;
  if (name == "ur10e") {
    ur10e_study(RIVID_REAL_DATA, RIVID_UR10E_EXPERIMENT);
  } else if (name == "pick_ups") {
    pick_up_study(data, count > 0.0 ? static_cast<int>(count) : 100, arm);
  } else if (name == "bound") {
    bound_study(data, count > 0.0 ? static_cast<int>(count) : 100, arm);
  } else if (name == "false_alarms") {
    false_alarm_study(data, count > 0.0 ? count : 10.0, arm);
  } else if (name == "pushes") {
    push_study(data, count > 0.0 ? static_cast<int>(count) : 20, arm);
  } else if (name == "drift") {
    drift_study(data, arm);
  } else if (name == "ticks") {
    tick_study(data, count > 0.0 ? static_cast<int>(count) : 100);
  } else {
    std::cerr << "benchmark_online_study ur10e | pick_ups [COUNT [ARM]] | bound [COUNT [ARM]] | false_alarms "
                 "[HOURS [ARM]] | "
                 "pushes [EACH [ARM]] | "
                 "drift [0 ARM] | ticks [REPETITIONS]\n";
    return 2;
  }
  return 0;
}
