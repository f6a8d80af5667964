// The closed loop of Eqs. (21) and (40) of [RIV] for ten seconds: the SCARA with its moves S1, 200 samples a
// second, and a TX40 on a Fourier series, a thousand. How long each integrator takes, how far it is from a
// solution at tight tolerances through all reversals and sticks, and how the same loop does in Python
// (closed_loop_python.py: SciPy's LSODA with tanh for the sign of friction), with several widths of the tanh.
// Times are medians of runs that take turns, in seconds of the processor. The Python is that of RIVID_PYTHON
// in the environment, else python3; it needs numpy, scipy and, for the TX40, pin.

#include "rivid/simulate/closed_loop.hpp"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>

#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/references.hpp"
#include "support/birdy.hpp"
#include "support/robots.hpp"
#include "turns.hpp"

namespace {

using namespace rivid;
using nlohmann::json;

constexpr double duration = 10.0;

json entries(const Vector& x) { return std::vector<double>(x.begin(), x.end()); }
json rows(const Matrix& x) {
  json out = json::array();
  for (Index i = 0; i < x.rows(); ++i) {
    out.push_back(entries(x.row(i)));
  }
  return out;
}

// A robot in its loop, and the same for the Python program.
struct Loop {
  Robot robot;
  std::unique_ptr<DynamicModel> model;
  std::unique_ptr<ControlLaw> law;
  std::unique_ptr<Reference> reference;
  double f_m = 0.0;
  json problem;

  // Torques are stiffness (q_r − q) − damping q̇: Eq. (40) behind the drive gains.
  void close(const PdControl& control, const Vector& J) {
    law = control(Plant{robot, *model, J});
    problem["stiffness"] = entries(J.cwiseProduct(control.omega_n.cwiseAbs2()));
    problem["damping"] = entries(2.0 * J.cwiseProduct(control.zeta).cwiseProduct(control.omega_n));
    problem["rate"] = f_m;
    problem["samples"] = samples();
  }

  [[nodiscard]] Index samples() const { return static_cast<Index>(duration * f_m) + 1; }

  [[nodiscard]] SimulationOptions options(Integrator integrator, double rtol, double period) const {
    SimulationOptions out{.f_m = f_m, .samples = samples()};
    out.integrator = integrator;
    out.rtol = rtol;
    out.atol = 1e-2 * rtol;
    out.sampling.period = period;
    return out;
  }

  [[nodiscard]] Simulation run(const SimulationOptions& options) const {
    return simulate(robot, *model, *law, *reference, options);
  }
};

// The case study of [RIV].
Loop scara() {
  Loop out;
  out.robot = test::scara();
  const BaseParameters base = base_parameters(out.robot);
  const std::map<std::string, double> values = {{"ZZ1R", 3.44}, {"Fv1", 0.03},  {"Fc1", 0.82},
                                                {"ZZ2", 0.062}, {"MX2", 0.242}, {"MY2", 0.014},
                                                {"Fv2", 0.013}, {"Fc2", 0.137}};
  Vector chi(base.size());
  for (Index i = 0; i < base.size(); ++i) {
    chi[i] = values.at(base.parameters[static_cast<std::size_t>(i)].name);
  }
  out.model = std::make_unique<DynamicModel>(out.robot, base, chi);
  Matrix via(5, 2);
  via << 0, 0, 1.5, 2, -1, -1, 1, 1.5, -1.5, -2;
  constexpr double move = 2.5;
  out.reference = std::make_unique<PointToPointReference>(
      PointToPoint{.via = via, .durations = Vector::Constant(1, move)});
  out.f_m = 200.0;
  out.problem = {
      {"robot", "scara"}, {"parameters", values}, {"length", 0.5}, {"via", rows(via)}, {"move", move}};
  out.close({.omega_n = Eigen::Vector2d(1, 10), .zeta = Eigen::Vector2d(1, 1)},
            Eigen::Vector2d(3.44 + 0.062 + 2 * 0.121, 0.062));
  return out;
}

// Five harmonics of 0.1 Hz for each joint, poles of 20 to 30 rad/s.
Loop tx40() {
  Loop out;
  out.robot = test::BirdyTx40().robot;
  out.model = std::make_unique<DynamicModel>(out.robot, out.robot.chi_st());
  std::mt19937_64 random(40);
  std::normal_distribution<double> normal(0.0, 0.4);
  FourierSeries series{.omega_f = 2.0 * std::numbers::pi / duration};
  series.A = Matrix::NullaryExpr(6, 5, [&] { return normal(random); });
  series.B = Matrix::NullaryExpr(6, 5, [&] { return normal(random); });
  out.reference = std::make_unique<FourierReference>(series);
  out.f_m = 1000.0;
  json links = json::array();
  for (std::size_t j = 0; j < 6; ++j) {
    const Chain::Link& link = out.robot.chain.links[j];
    const Joint& joint = out.robot.joints[j];
    links.push_back({{"R", rows(link.R)},
                     {"p", entries(link.p)},
                     {"inertial", entries(out.robot.inertials[j])},
                     {"Ia", joint.Ia},
                     {"Fv", joint.Fv},
                     {"Fc", joint.Fc}});
  }
  out.problem = {{"robot", "chain"},    {"gravity", entries(out.robot.chain.gravity)},
                 {"links", links},      {"omega_f", series.omega_f},
                 {"A", rows(series.A)}, {"B", rows(series.B)}};
  Vector omega_n(6);
  omega_n << 20, 20, 22, 25, 28, 30;
  out.close({.omega_n = omega_n, .zeta = Vector::Ones(6)}, design_inertia(*out.model));
  return out;
}

const Loop& loop_of(const std::string& name) {
  static const Loop the_scara = scara();
  static const Loop the_tx40 = tx40();
  return name == "scara" ? the_scara : the_tx40;
}

// Positions at the samples, at the tightest tolerance that makes sense.
const Matrix& exact(const std::string& name, double period) {
  static std::map<std::pair<std::string, double>, Matrix> known;
  const auto [at, fresh] = known.try_emplace({name, period});
  if (fresh) {
    const Loop& loop = loop_of(name);
    at->second = loop.run(loop.options(Integrator::dormand_prince, 1e-12, period)).motion.q;
  }
  return at->second;
}

double error(const Matrix& q, const Matrix& truth) {
  return q.rows() == truth.rows() ? (q - truth).cwiseAbs().maxCoeff() : HUGE_VAL;
}

struct Timed {
  double ms = 0.0;
  double error = 0.0;
  SimulationEffort effort;
};

Timed timed(const std::string& name, const SimulationOptions& options) {
  const Loop& loop = loop_of(name);
  Simulation last;
  const auto seconds =
      benchmarks::turns<1>(11, {[&] { last = loop.run(options); }}, benchmarks::Clock::processor);
  return {1e3 * benchmarks::median(seconds[0]), error(last.motion.q, exact(name, options.sampling.period)),
          last.effort};
}

void integrator(benchmark::State& state, const std::string& name, const SimulationOptions& options) {
  const Timed found = timed(name, options);
  for (auto _ : state) {
    state.SetIterationTime(1e-3 * found.ms);
  }
  state.counters["error"] = found.error;
  state.counters["right_hand_sides"] = static_cast<double>(found.effort.right_hand_sides);
  state.counters["steps"] = static_cast<double>(found.effort.steps);
  state.counters["mode_changes"] = static_cast<double>(found.effort.mode_changes);
}

// What the Python program found for one setting of its own.
struct FromPython {
  std::string how;
  double v_s = 0.0;
  double ms = 0.0;
  double right_hand_sides = 0.0;
  double error = 0.0;
};

// Empty where it could not be run.
std::vector<FromPython> from_python(const std::string& name) {
  namespace fs = std::filesystem;
  const char* const chosen = std::getenv("RIVID_PYTHON");  // NOLINT(concurrency-mt-unsafe): one thread
  const fs::path folder = fs::temp_directory_path() / ("rivid_closed_loop_" + std::to_string(getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "problem.json") << loop_of(name).problem;
  const std::string command = std::string(chosen != nullptr ? chosen : "python3") +
                              " " RIVID_CLOSED_LOOP_PYTHON " " + folder.string();
  std::vector<FromPython> out;
  if (std::system(command.c_str()) ==
      0) {  // NOLINT(concurrency-mt-unsafe,cert-env33-c): one thread, own script
    std::ifstream results(folder / "results.json");
    for (const json& run : json::parse(results)) {
      FromPython& found =
          out.emplace_back(FromPython{run["how"], run["v_s"], run["ms"], run["right_hand_sides"]});
      const Loop& loop = loop_of(name);
      Matrix q(loop.robot.size(), loop.samples());
      std::ifstream positions(folder / run["positions"].get<std::string>(), std::ios::binary);
      positions.read(reinterpret_cast<char*>(q.data()), q.size() * Index{sizeof(double)});
      found.error = error(q.transpose(), exact(name, 0.0));
    }
  }
  fs::remove_all(folder);
  return out;
}

// The loop by one integrator against each of the Python program's settings: factors in time and in accuracy.
void against_python(benchmark::State& state, const std::string& name, Integrator method, double rtol) {
  static std::map<std::string, std::vector<FromPython>> known;
  const auto [at, fresh] = known.try_emplace(name);
  if (fresh) {
    at->second = from_python(name);
  }
  const Timed ours = timed(name, loop_of(name).options(method, rtol, 0.0));
  for (auto _ : state) {
    state.SetIterationTime(1e-3 * ours.ms);
  }
  if (at->second.empty()) {
    state.SkipWithError("no Python with what closed_loop_python.py needs; name one in RIVID_PYTHON");
    return;
  }
  state.counters["error"] = ours.error;
  std::printf("%9s %8s %9s %7s %9s %7s %8s\n", "Python", "v_s", "ms", "calls", "error", "x_time", "x_error");
  for (const FromPython& run : at->second) {
    std::printf("%9s %8.0e %9.1f %7.0f %9.1e %7.1f %8.0f\n", run.how.c_str(), run.v_s, run.ms,
                run.right_hand_sides, run.error, run.ms / ours.ms, run.error / ours.error);
  }
}

const int registered = [] {
  constexpr std::array methods = {Integrator::adams, Integrator::bdf, Integrator::dormand_prince,
                                  Integrator::bogacki_shampine};
  const auto add = [](const std::string& title, auto&& run) {
    benchmark::RegisterBenchmark(title.c_str(), run)
        ->Iterations(1)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  };
  for (const std::string robot : {"scara", "tx40"}) {
    for (const Integrator method : methods) {
      for (const int digits : {4, 6, 8}) {
        const double rtol = std::pow(10.0, -digits);
        const std::string how = std::string(name(method)) + "/1e-" + std::to_string(digits);
        const auto looped = [=](double period) {
          return [=](benchmark::State& state) {
            integrator(state, robot, loop_of(robot).options(method, rtol, period));
          };
        };
        add(robot + "/continuous/" + how, looped(0.0));
        add(robot + "/every_ms/" + how, looped(1e-3));
        if (method == Integrator::adams || method == Integrator::dormand_prince) {
          add(robot + "/against_python/" + how,
              [=](benchmark::State& state) { against_python(state, robot, method, rtol); });
        }
      }
    }
  }
  return 0;
}();

}  // namespace
