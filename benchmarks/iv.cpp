// IDIM-IV: one pass over the data with instruments against the pass of least squares, and whole
// identifications. The reference of the passes is what is usually written down: V and W as dense matrices,
// Eigen's HouseholderQR of V, and Q_Vᵀ [W Y] (34). Times are medians of runs that take turns, in seconds of
// the processor for one thread.

#include <benchmark/benchmark.h>

#include <Eigen/QR>
#include <algorithm>
#include <numbers>
#include <vector>

#include "identify/rows/kept_rows.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/solve/instrumental.hpp"
#include "robots.hpp"
#include "support/birdy.hpp"
#include "support/scara_study.hpp"
#include "turns.hpp"

namespace {

using namespace rivid;
using benchmarks::Clock;
using benchmarks::median;
using benchmarks::turns;

constexpr int repetitions = 11;

// Rows of a joint into a factor.
class FactorSink final : public detail::RowSink {
 public:
  FactorSink(Index columns, Index carried) : qr_(columns, carried) {}
  RowsRoom room(Index wanted) override { return qr_.room(wanted); }
  void commit(std::span<const Index> samples) override { qr_.commit(static_cast<Index>(samples.size())); }
  [[nodiscard]] const StreamingQr& qr() const { return qr_; }

 private:
  StreamingQr qr_;
};

// The factors of [W Y], or with a motion those of [V | W Y].
std::vector<FactorSink> pass(const Robot& robot, const BaseParameters& base, const Log& log,
                             std::span<const Motion> instruments) {
  const SignalOptions signal{.rows = RowScheme::paper};
  detail::ThreadTeam team(1);
  detail::RowSource source(robot, base, log, signal, team);
  std::vector<FactorSink> sinks;
  std::vector<detail::RowSink*> to;
  sinks.reserve(source.joints());
  for (std::size_t j = 0; j < source.joints(); ++j) {
    const auto own = static_cast<Index>(source.columns(j).size());
    to.push_back(&sinks.emplace_back(own, instruments.empty() ? 1 : own + 1));
  }
  source.send(to, instruments);
  return sinks;
}

Motion motion_of(const FourierReference& reference, Index samples, double f_m) {
  const Index n = reference.joints();
  Motion out{Matrix(samples, n), Matrix(samples, n), Matrix(samples, n)};
  Vector q(n);
  Vector qd(n);
  Vector qdd(n);
  for (Index k = 0; k < samples; ++k) {
    reference.at(static_cast<double>(k) / f_m, q, qd, qdd);
    out.q.row(k) = q;
    out.qd.row(k) = qd;
    out.qdd.row(k) = qdd;
  }
  return out;
}

// Velocities of some 2 rad/s and accelerations of some 15 rad/s².
FourierReference moving(Index n) {
  constexpr Index harmonics = 20;
  std::mt19937_64 random(40);
  std::normal_distribution<double> normal(0.0, 0.3);
  FourierSeries series{.omega_f = 2.0 * std::numbers::pi / 10.0};
  series.A = Matrix::NullaryExpr(n, harmonics, [&] { return normal(random); });
  series.B = Matrix::NullaryExpr(n, harmonics, [&] { return normal(random); });
  return FourierReference(series);
}

// Seven joints, 1e5 samples at 1 kHz, nothing filtered.
void passes(benchmark::State& state) {
  const Robot robot = benchmarks::panda();
  const BaseParameters base = base_parameters(robot);
  constexpr Index samples = 100'000;
  const Motion motion = motion_of(moving(robot.size()), samples, 1000.0);
  Log log;
  log.source = "moving";
  log.f_m = 1000.0;
  log.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / log.f_m);
  log.q = motion.q;
  log.tau = Matrix::Ones(samples, robot.size());
  const auto least_squares_pass = [&] { benchmark::DoNotOptimize(pass(robot, base, log, {}).data()); };
  const auto instruments_pass = [&] {
    benchmark::DoNotOptimize(pass(robot, base, log, std::span(&motion, 1)).data());
  };
  // A tenth of the samples, and its time tenfold: dense matrices of all would need gigabytes.
  const auto usual = [&] {
    constexpr Index part = samples / 10;
    const Motion some{motion.q.topRows(part), motion.qd.topRows(part), motion.qdd.topRows(part)};
    const Matrix V = observation(robot, base, some).dense();
    Matrix WY(V.rows(), base.size() + 1);
    WY.leftCols(base.size()) = observation(robot, base, differentiate(some.q, log.f_m)).dense();
    WY.rightCols(1).setOnes();
    const Eigen::HouseholderQR<Matrix> qr(V);
    WY.applyOnTheLeft(qr.householderQ().adjoint());
    benchmark::DoNotOptimize(WY.data());
  };
  for (auto _ : state) {
    const auto times = turns<3>(repetitions, {least_squares_pass, instruments_pass, usual}, Clock::processor);
    state.SetIterationTime(median(times[1]));
    state.counters["ols_pass_ms"] = 1e3 * median(times[0]);
    state.counters["ols_passes"] = median(times[1]) / median(times[0]);
    state.counters["x_usual"] = 10.0 * median(times[2]) / median(times[1]);
  }
}

// A pass with decimated [V | W Y] where [W Y] was kept, against one that makes it anew. Seven joints, 2e4
// samples.
void kept_rows(benchmark::State& state) {
  const Robot robot = benchmarks::panda();
  const BaseParameters base = base_parameters(robot);
  const Motion motion = motion_of(moving(robot.size()), 20'000, 1000.0);
  Log log;
  log.source = "moving";
  log.f_m = 1000.0;
  log.t = Vector::LinSpaced(motion.samples(), 0.0, static_cast<double>(motion.samples() - 1) / log.f_m);
  log.q = motion.q;
  log.tau = Matrix::Ones(motion.samples(), robot.size());
  const SignalOptions signal{.rows = RowScheme::paper, .cutoff_hz = 50.0, .decimation = {10}};
  detail::ThreadTeam team(1);
  detail::KeptRows kept(robot, base, log, signal, team);
  const auto into_factors = [&](auto& source) {
    detail::JointSinks<FactorSink> sinks(robot.joints.size(), [&](std::size_t j) {
      const auto own = static_cast<Index>(kept.source().columns(j).size());
      return FactorSink(own, own + 1);
    });
    source.send(sinks.sinks(), std::span(&motion, 1));
    benchmark::DoNotOptimize(sinks[0].qr().R().data());
  };
  into_factors(kept);
  const auto from_memory = [&] { into_factors(kept); };
  const auto anew = [&] {
    detail::RowSource source(robot, base, log, signal, team);
    into_factors(source);
  };
  for (auto _ : state) {
    const auto times = turns<2>(repetitions, {from_memory, anew}, Clock::processor);
    state.SetIterationTime(median(times[0]));
    state.counters["anew_ms"] = 1e3 * median(times[1]);
    state.counters["x_made_anew"] = median(times[1]) / median(times[0]);
  }
}

void whole(benchmark::State& state, const Robot& robot, const Log& log, const Estimation& method) {
  Identification found;
  const auto iv = [&] { found = identify(robot, log, method); };
  const auto ols = [&] {
    benchmark::DoNotOptimize(identify(robot, log, {.method = Ols{}, .signal = method.signal}).chi.data());
  };
  for (auto _ : state) {
    const auto times = turns<2>(repetitions, {iv, ols}, Clock::processor);
    state.SetIterationTime(median(times[0]));
    state.counters["ols_ms"] = 1e3 * median(times[1]);
    state.counters["x_ols"] = median(times[0]) / median(times[1]);
    double simulating = 0.0;
    double steps = 0.0;
    for (const IvIteration& iteration : found.iv->iterations) {
      simulating += iteration.effort.seconds;
      steps += static_cast<double>(iteration.effort.steps);
    }
    state.counters["simulations"] = static_cast<double>(found.iv->iterations.size());
    state.counters["simulating_ms"] = 1e3 * simulating;
    state.counters["steps"] = steps;
    state.counters["identified"] = found.status == Status::identified ? 1.0 : 0.0;
  }
}

// The case study of [RIV], 30 s at 200 Hz.
struct Scara {
  test::ScaraStudy study;
  Log log;

  Scara() {
    Matrix via(13, 2);
    via << 0, 0, 3, 4, -2, -2, 2, 3, -3, -4, 2, -1, -1, 4, 2.4, -3, 0, 2, -2, 1, 3, -2, 1, 3, 0, 0;
    const PointToPointReference reference({.via = via, .durations = Vector::Constant(1, 2.5)});
    constexpr Index rows = 6001;
    SimulationOptions options{.f_m = test::ScaraStudy::f_m};
    options.sampling = test::ScaraStudy::computer();
    options.sampling.position_noise = white_noise(1, 1, rows, Vector::Constant(2, study.encoder_noise));
    options.disturbance = white_noise(1, 2, rows, study.disturbance);
    const Simulation run =
        simulate(study.robot, study.base, study.truth, study.control, study.J, reference, options);
    log.source = "scara";
    log.f_m = options.f_m;
    log.t = run.t;
    log.q = run.q_measured;
    log.v_tau = run.v_tau;
    log.q_r = run.q_r;
  }
};

void scara(benchmark::State& state, bool filtered) {
  const Scara scara;
  Estimation method = scara.study.iv();
  if (filtered) {
    method.signal = test::ScaraStudy::filtered();
  }
  whole(state, scara.study.robot, scara.log, method);
}

// Six joints, 10 s at 1 kHz, known poles of 20 to 30 rad/s: the controller on a computer, or continuous.
void tx40(benchmark::State& state, bool filtered, double period) {
  const Robot robot = test::BirdyTx40().robot;
  const DynamicModel model(robot, robot.chi_st());
  Vector omega_n(6);
  omega_n << 20, 20, 22, 25, 28, 30;
  const PdControl control{.omega_n = omega_n, .zeta = Vector::Ones(6), .reference_velocity = true};
  constexpr Index rows = 10'001;
  SimulationOptions options{.f_m = 1000.0, .samples = rows};
  options.sampling.period = period;
  if (period > 0.0) {
    options.sampling.position_noise = white_noise(1, 1, rows, Vector::Constant(6, 1e-6));
  }
  const FourierReference reference = moving(6);
  const Vector J = design_inertia(model, motion_of(reference, rows, options.f_m).q);
  const Simulation run = simulate(robot, model, *control({robot, model, J}), reference, options);
  Log log;
  log.source = "tx40";
  log.f_m = options.f_m;
  log.t = run.t;
  log.q = run.q_measured + white_noise(2, 1, rows, Vector::Constant(6, period > 0.0 ? 0.0 : 1e-6));
  log.tau = run.tau;
  log.q_r = run.q_r;
  Estimation method{.method = Iv{.control = control, .sampling = {.period = period}}};
  if (filtered) {
    method.signal = {.cutoff_hz = 50.0, .decimation = {10}};
  }
  method.signal.velocity_threshold = std::vector<double>(6, 0.1);  // joints stick at their reversals
  whole(state, robot, log, method);
}

}  // namespace

BENCHMARK(kept_rows)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(passes)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scara, filtered, true)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scara, raw, false)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tx40, continuous_filtered, true, 0.0)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tx40, continuous_raw, false, 0.0)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tx40, every_ms_filtered, true, 1e-3)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tx40, every_ms_raw, false, 1e-3)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
