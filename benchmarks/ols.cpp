// Whole ordinary least squares from a log to parameters with their deviations: seven joints, 1e5 samples, 69
// base parameters; filtered positions, differences, regressor, decimation where asked for, factorisation,
// statistics. Against what is usually done, where Pinocchio was found: its regressor for each sample, W as
// one dense matrix, Eigen's HouseholderQR, which copies it. The filters of the reference are rivid's own for
// whole series, and it computes no statistics. Times are medians of runs that take turns, in seconds of the
// processor for one thread, so that a busy machine can be used, and by the clock on the wall for two; memory
// is the most that was held beside the log.

#include <benchmark/benchmark.h>

#include <Eigen/QR>
#include <cmath>

#include "moving_log.hpp"
#include "process_memory.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/signal/filter.hpp"
#include "robots.hpp"
#include "turns.hpp"

#if defined(RIVID_WITH_PINOCCHIO)
#include "pinocchio_robot.hpp"
#endif

namespace {

using namespace rivid;
using benchmarks::median;
using benchmarks::moving_log;
using benchmarks::peak_bytes;
using benchmarks::turns;

constexpr Index samples = 100'000;
constexpr double cutoff_hz = 20.0;

// What the others compute: the paper's rows and classical deviations.
Estimation method(std::vector<int> decimation, int threads) {
  return {.signal = {.rows = RowScheme::paper, .cutoff_hz = cutoff_hz, .decimation = std::move(decimation)},
          .covariance = {.kind = CovarianceKind::classical},
          .threads = threads};
}

// What rivid does unless told otherwise: exact rows, and deviations from a second look at them.
Estimation by_default(const Estimation& other) {
  return {.signal = {.cutoff_hz = cutoff_hz, .decimation = other.signal.decimation}};
}

#if defined(RIVID_WITH_PINOCCHIO)
Vector usual_fit(const Robot& robot, const BaseParameters& base, const Log& log,
                 const SignalOptions& signal) {
  const Motion motion = differentiate(zero_phase(log.q, log.f_m, signal.cutoff_hz, signal.order), log.f_m);
  const Index trim = 2 + settling_samples(butterworth(signal.order, signal.cutoff_hz, log.f_m));
  const Index n_m = log.samples() - 2 * trim;
  const Index n = robot.size();
  const std::vector<StandardParameter> parameters = base.columns();
  PinocchioRegressor pinocchio = benchmarks::pinocchio_of(robot);
  Matrix W(n * n_m, base.size());
  Vector Y(n * n_m);
  Vector q(n);
  Vector qd(n);
  Vector qdd(n);
  for (Index k = 0; k < n_m; ++k) {
    q = motion.q.row(trim + k);
    qd = motion.qd.row(trim + k);
    qdd = motion.qdd.row(trim + k);
    const Eigen::Map<const Matrix> inertial(pinocchio(q.data(), qd.data(), qdd.data()), n, 10 * n);
    for (Index c = 0; c < base.size(); ++c) {
      const StandardParameter& p = parameters[static_cast<std::size_t>(c)];
      for (Index j = 0; j < n; ++j) {
        double& entry = W(j * n_m + k, c);
        if (p.kind < ParameterKind::Ia) {
          entry = inertial(j, benchmarks::pinocchio_column(p));
        } else if (p.joint != j) {
          entry = 0.0;
        } else {
          entry = p.kind == ParameterKind::Ia ? qdd[j] : friction_entry<double>(p.kind, qd[j]);
        }
      }
    }
  }
  for (Index j = 0; j < n; ++j) {
    Y.segment(j * n_m, n_m) = log.tau.col(j).segment(trim, n_m);
  }
  for (const int n_d : signal.decimation) {
    const Filter filter = decimation_filter(n_d);
    const Index kept = (n_m + n_d - 1) / n_d;
    const auto decimated = [&](const auto& x) {
      Matrix out(n * kept, x.cols());
      for (Index j = 0; j < n; ++j) {
        const Matrix smooth = zero_phase(x.middleRows(j * n_m, n_m), filter);
        out.middleRows(j * kept, kept) = smooth(Eigen::seqN(0, kept, n_d), Eigen::all);
      }
      return out;
    };
    Y = decimated(Y);
    W = decimated(W);
  }
  return W.householderQr().solve(Y);
}
#endif

void ols(benchmark::State& state, const std::vector<int>& decimation) {
  const Robot robot = benchmarks::panda();
  const Log log = moving_log(robot, samples);
  const BaseParameters base = base_parameters(robot);
  const Estimation one = method(decimation, 1);
  const Estimation two = method(decimation, 2);
  Vector chi;
  const auto ours = [&] { chi = identify(robot, log, one).chi; };
  const auto two_threads = [&] { benchmark::DoNotOptimize(identify(robot, log, two).chi.data()); };
  const double memory = peak_bytes(ours);
  const double memory_of_two = peak_bytes(two_threads);
  for (auto _ : state) {
    const auto wall = turns<2>(21, {ours, two_threads});
    state.SetIterationTime(median(wall[0]));
    state.counters["x_two_threads"] = median(wall[0]) / median(wall[1]);
    const auto defaults = [&] { benchmark::DoNotOptimize(identify(robot, log, by_default(one)).chi.data()); };
    state.counters["times_of_defaults"] = median(turns<2>(7, {defaults, ours})[0]) / median(wall[0]);
    state.counters["x_two_threads_fastest"] = wall[0].front() / wall[1].front();
    const double filtered = static_cast<double>(log.q.size() * Index{sizeof(double)});
    constexpr double mebibyte = 1024.0 * 1024.0;
    state.counters["MiB_beside_log_and_q"] = (memory - filtered) / mebibyte;
    state.counters["MiB_of_two"] = (memory_of_two - filtered) / mebibyte;
    state.counters["columns"] = static_cast<double>(base.size());
#if defined(RIVID_WITH_PINOCCHIO)
    Vector usual;
    const auto theirs = [&] { usual = usual_fit(robot, base, log, one.signal); };
    const double their_memory = peak_bytes(theirs);
    const auto times = turns<2>(7, {ours, theirs}, benchmarks::Clock::processor);
    state.counters["ms"] = 1e3 * median(times[0]);
    state.counters["usual_ms"] = 1e3 * median(times[1]);
    state.counters["x_usual"] = median(times[1]) / median(times[0]);
    const double held = static_cast<double>((log.q.size() + log.tau.size()) * Index{sizeof(double)});
    state.counters["x_memory_with_log"] = (their_memory + held) / (memory + held);
    state.counters["disagreement"] = (usual - chi).norm() / chi.norm();
#endif
  }
}

// What comes after the pass over the data, from the triangles alone.
void statistics(benchmark::State& state) {
  const Robot robot = benchmarks::panda();
  const Log log = moving_log(robot, samples / 10);
  const BaseParameters base = base_parameters(robot);
  const RowFactors data = factors(robot, base, log, method({}, 1).signal);
  const std::vector<double> ones(data.groups.size(), 1.0);
  for (auto _ : state) {
    std::vector<double> weights = group_sigmas(data.groups);
    for (double& weight : weights) {
      weight = 1.0 / weight;
    }
    const LeastSquares ordinary = least_squares(data.groups, base.size(), ones);
    const LeastSquares weighted = least_squares(data.groups, base.size(), weights);
    benchmark::DoNotOptimize(residual(data.groups, ordinary.chi, ones).norm);
    benchmark::DoNotOptimize(residual(data.groups, weighted.chi, weights).norm);
  }
}

}  // namespace

BENCHMARK_CAPTURE(ols, whole, {})->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ols, decimated_20, {20})->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(statistics)->Unit(benchmark::kMillisecond);
