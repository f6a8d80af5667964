// What the physically consistent parameters of a six-joint arm take: 84 standard parameters, from a plain
// estimate whose last link is no body, by both priors, from the robot description and from a vector that is
// no robot. The ratio is to the weighted least-squares fit of 10 s at 1 kHz that the estimate comes from.
// Times are medians of runs that take turns, in seconds of the processor.

#include "rivid/identify/physical.hpp"

#include <benchmark/benchmark.h>

#include <Eigen/QR>
#include <array>
#include <random>

#include "rivid/identify/identification.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"
#include "robots.hpp"
#include "turns.hpp"

namespace {

using namespace rivid;
using benchmarks::median;
using benchmarks::turns;

constexpr Index samples = 10'000;
constexpr double noise = 1.0;  // N·m
constexpr int turns_of_each = 21;

// The TX40 with bodies that get lighter towards the tip.
Robot arm() {
  Robot robot = benchmarks::tx40();
  std::mt19937_64 random(14);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  double mass = 8.0;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Eigen::Vector3d com(0.1 * uniform(random), 0.1 * uniform(random), 0.1 * uniform(random));
    const Eigen::Vector3d moments(2.0 + uniform(random), 2.0 + uniform(random), 2.0 + uniform(random));
    const Eigen::Matrix3d spread = 1e-3 * moments.asDiagonal();
    robot.inertials[j] =
        inertial_from_com(mass, com, mass * (spread.trace() * Eigen::Matrix3d::Identity() - spread));
    robot.joints[j].Ia = 0.1;
    robot.joints[j].Fv = 2.0;
    robot.joints[j].Fc = 3.0;
    mass *= 0.7;
  }
  return robot;
}

// Torques of a robot that differs from its description, and whose last link is no body.
Log log_of(const Robot& robot, const BaseParameters& base) {
  std::mt19937_64 random(15);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  Log log;
  log.source = "moving";
  log.f_m = 1000.0;
  log.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / log.f_m);
  log.q = Matrix::Zero(samples, robot.size());
  for (Index j = 0; j < robot.size(); ++j) {
    for (int harmonic = 0; harmonic < 4; ++harmonic) {
      const double omega = 1.0 + 4.0 * uniform(random);
      const double phase = 6.0 * uniform(random);
      log.q.col(j).array() += 0.4 * (omega * log.t.array() + phase).sin();
    }
  }
  Robot other = robot;
  for (Inertial& inertial : other.inertials) {
    inertial *= 0.8 + 0.4 * uniform(random);
  }
  other.inertials.back().head<6>() *= -1.0;
  const Vector chi = base.from_standard(other.chi_st());
  const Observation W = observation(robot, base, differentiate(log.q, log.f_m));
  log.tau.resize(samples, robot.size());
  for (Index j = 0; j < robot.size(); ++j) {
    const JointRows& rows = W.joints[static_cast<std::size_t>(j)];
    log.tau.col(j) =
        rows.W * chi(rows.columns) + noise * Vector::NullaryExpr(samples, [&] { return normal(random); });
  }
  return log;
}

void physical_parameters(benchmark::State& state) {
  const Robot robot = arm();
  const BaseParameters base = base_parameters(robot);
  const Log log = log_of(robot, base);
  const Estimation method{.method = Wls{}, .signal = {.cutoff_hz = 20.0}};
  const Identification plain = identify(robot, log, method);
  const Matrix root = plain.C_chi.llt().matrixL().solve(Matrix::Identity(base.size(), base.size()));

  const auto prior = static_cast<Physical::Prior>(state.range(0));
  Physical options{.prior = prior};
  if (state.range(1) != 0) {
    std::mt19937_64 random(16);
    std::normal_distribution<double> normal;
    options.start = Vector::NullaryExpr(std::ssize(base.standard), [&] { return normal(random); });
  }
  PhysicalParameters found;
  std::array<std::vector<double>, 2> seconds;
  for (auto _ : state) {
    seconds = turns<2>(turns_of_each,
                       {[&] { found = physical(robot, base, plain.chi, root, options); },
                        [&] { benchmark::DoNotOptimize(identify(robot, log, method)); }},
                       benchmarks::Clock::processor);
  }
  if (!found.reached) {
    state.SkipWithError("the least cost was not reached");
  }
  state.SetLabel(std::string(name(prior)) + (state.range(1) != 0 ? ", start that is no robot" : ""));
  state.counters["columns"] = static_cast<double>(base.standard.size());
  state.counters["steps"] = found.steps;
  state.counters["ms"] = 1e3 * median(seconds[0]);
  state.counters["ms_of_WLS"] = 1e3 * median(seconds[1]);
  state.counters["of_WLS"] = median(seconds[0]) / median(seconds[1]);
}

BENCHMARK(physical_parameters)->ArgsProduct({{0, 1}, {0, 1}})->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
