// What judging costs beside the estimate: benchmark_judge EXPERIMENT.toml …, processor seconds of one thread,
// the median of 15 turns.

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <exception>
#include <vector>

#include "identify/check/checks.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/friction_choice.hpp"

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
  rivid::Experiment experiment = rivid::read_experiment(file);
  const std::vector<rivid::Log> logs = rivid::read_logs(experiment.log, experiment.robot);
  const std::vector<rivid::Log> validation = rivid::read_logs(experiment.validation, experiment.robot);
  experiment.robot = rivid::with_friction(
      experiment.robot,
      rivid::choose_friction(experiment.robot, logs, experiment.estimation, validation).kinds);
  const rivid::Identification result =
      rivid::identify(experiment.robot, logs, experiment.estimation, validation);
  std::array<double, turns> whole{};
  std::array<double, turns> judging{};
  for (std::size_t turn = 0; turn < turns; ++turn) {
    double begin = thread_seconds();
    (void)rivid::identify(experiment.robot, logs, experiment.estimation, validation);
    whole[turn] = thread_seconds() - begin;
    begin = thread_seconds();
    (void)rivid::detail::judged(experiment.robot, logs, validation, result);
    judging[turn] = thread_seconds() - begin;
  }
  const double judge = median(judging);
  const double rest = median(whole) - judge;
  std::printf("%s: identify() %.1f ms, judging %.1f ms of it, %.2f of the rest\n", file, 1e3 * (rest + judge),
              1e3 * judge, judge / rest);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    for (int k = 1; k < argc; ++k) {
      measure(argv[k]);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark_judge: %s\n", error.what());
    return 1;
  }
  return 0;
}
