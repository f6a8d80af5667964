// Time and memory of rows by the million: logs of seven joints that are generated one after the other, 1e5
// samples each, reduced to factors and merged, as rivid_identify reduces and merges many logs. Generating is
// not part of the time. Ratios are those of the second half of the rows against the first one, in the same
// run, and a solution at the end shows that all rows count.

#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

#include "moving_log.hpp"
#include "process_memory.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/solve/least_squares.hpp"
#include "robots.hpp"
#include "turns.hpp"

namespace {

using namespace rivid;
using benchmarks::Clock;

constexpr Index samples = 100'000;

void rows(benchmark::State& state) {
  const Robot robot = benchmarks::panda();
  const BaseParameters base = base_parameters(robot);
  const auto wanted = static_cast<double>(state.range(0));
  for (auto _ : state) {
    RowFactors all;
    double count = 0.0;
    double seconds = 0.0;
    double half = 0.0;  // rows, and what they took
    double half_seconds = 0.0;
    double half_bytes = 0.0;
    double bytes = 0.0;
    for (std::uint64_t seed = 1; count < wanted; ++seed) {
      const Log log = benchmarks::moving_log(robot, samples, seed);
      const double begin = benchmarks::now(Clock::processor);
      RowFactors part = factors(robot, base, log, {.cutoff_hz = 20.0});
      if (all.groups.empty()) {
        all = std::move(part);
      } else {
        for (std::size_t j = 0; j < all.groups.size(); ++j) {
          all.groups[j].qr.merge(part.groups[j].qr);
        }
      }
      seconds += benchmarks::now(Clock::processor) - begin;
      count = 0.0;
      for (const RowGroup& group : all.groups) {
        count += static_cast<double>(group.qr.rows());
      }
      bytes = benchmarks::status_bytes("VmRSS");
      if (half == 0.0 && count >= 0.5 * wanted) {
        half = count;
        half_seconds = seconds;
        half_bytes = bytes;
      }
    }
    const std::vector<double> weights(all.groups.size(), 1.0);
    state.SetIterationTime(seconds);
    state.counters["rank"] = static_cast<double>(least_squares(all.groups, base.size(), weights).rank);
    state.counters["ns_a_row"] = 1e9 * seconds / count;
    state.counters["x_time_a_row"] = (seconds - half_seconds) / (count - half) / (half_seconds / half);
    state.counters["x_memory"] = bytes / half_bytes;
  }
}

}  // namespace

BENCHMARK(rows)
    ->Arg(10'000'000)
    ->Arg(100'000'000)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
