// What examine() costs beside identify(): benchmark_examine EXPERIMENT.toml …, processor seconds of one thread, the median of 15 turns.

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <exception>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/check.hpp"

namespace {

constexpr std::size_t turns = 15;

double thread_seconds() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double median(std::array<double, turns> seconds) {
  std::ranges::nth_element(seconds, seconds.begin() + turns / 2);
  return seconds[turns / 2];
}

void measure(const char* file) {
  const rivid::Experiment experiment = rivid::read_experiment(file);
  const std::vector<rivid::Log> logs = rivid::read_logs(experiment.log, experiment.robot);
  const std::vector<rivid::Log> validation = rivid::read_logs(experiment.validation, experiment.robot);
  std::array<double, turns> identify{};
  std::array<double, turns> examine{};
  for (std::size_t turn = 0; turn < turns; ++turn) {
    const double begin = thread_seconds();
    rivid::Identification result = rivid::identify(experiment.robot, logs, experiment.estimation);
    const double identified = thread_seconds();
    for (const rivid::Log& log : validation) {
      result.validation.push_back(rivid::validate(experiment.robot, result, log));
    }
    const double validated = thread_seconds();
    rivid::examine(experiment.robot, logs, validation, result);
    identify[turn] = identified - begin;
    examine[turn] = thread_seconds() - validated;
  }
  std::printf("%s: identify() %.1f ms, examine() %.1f ms, %.2f of it\n", file, 1e3 * median(identify),
              1e3 * median(examine), median(examine) / median(identify));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    for (int k = 1; k < argc; ++k) {
      measure(argv[k]);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark_examine: %s\n", error.what());
    return 1;
  }
  return 0;
}
