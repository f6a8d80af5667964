// Monte Carlo studies of data/: runs one by one against runs in groups whose simulations share the lanes of a
// register (monte_carlo_runs() on one thread). Both give the same rows to the last bit. They take turns;
// seconds are those of the processor, of all threads, since those of a group take turns as well.

#include "rivid/experiment/monte_carlo.hpp"

#include <benchmark/benchmark.h>

#include <filesystem>
#include <numeric>
#include <vector>

#include "turns.hpp"

namespace {

using namespace rivid;
using benchmarks::Clock;
using benchmarks::median;
using benchmarks::turns;

constexpr int repetitions = 5;

void study(benchmark::State& state, const char* file, int count) {
  const MonteCarlo plan = read_monte_carlo(std::filesystem::path(RIVID_DATA) / file);
  std::vector<int> runs(static_cast<std::size_t>(count));
  std::iota(runs.begin(), runs.end(), 0);
  for (auto _ : state) {
    const auto times =
        turns<2>(repetitions,
                 {[&] {
                    for (const int run : runs) {
                      benchmark::DoNotOptimize(monte_carlo_run(plan, run));
                    }
                  },
                  [&] {
                    monte_carlo_runs(plan, runs, 1, [](const std::vector<MonteCarloRow>& rows) {
                      benchmark::DoNotOptimize(rows.data());
                    });
                  }},
                 Clock::process);
    state.counters["ms_a_run"] = 1e3 * median(times[1]) / count;
    state.counters["x_one_by_one"] = median(times[0]) / median(times[1]);
  }
}

}  // namespace

BENCHMARK_CAPTURE(study, scara_iv, "scara/montecarlo_iv.toml", 32)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(study, six_axis, "six_axis/montecarlo.toml", 16)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
