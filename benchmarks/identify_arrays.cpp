// Identification from arrays in memory, which a log is made of, judged as rivid_identify does: for
// identify_arrays.py, which does the same from NumPy. Prints the processor's milliseconds of each run, and
// the bits of the estimate.
//
//   benchmark_identify_arrays EXPERIMENT.toml RUNS

#include <cstdlib>
#include <ctime>
#include <iostream>

#include "rivid/experiment/experiment.hpp"

int main(int argc, char** argv) {
  const rivid::Experiment experiment = rivid::read_experiment(argc > 1 ? argv[1] : "");
  const std::vector<rivid::Log> logs = rivid::read_logs(experiment.log, experiment.robot);
  for (int runs = argc > 2 ? std::atoi(argv[2]) : 1; runs > 0; --runs) {
    const std::clock_t begin = std::clock();
    const std::vector<rivid::Log> own = logs;
    const rivid::Identification found = rivid::identify_logs(experiment, own);
    std::cout << 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC << std::hexfloat;
    for (const double x : found.chi) {
      std::cout << ' ' << x;
    }
    std::cout << std::defaultfloat << '\n';
  }
}
