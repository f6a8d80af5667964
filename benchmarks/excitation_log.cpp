// Designed motions beside the one that was logged: what each is worth.
//
//   benchmark_excitation_log EXPERIMENT.toml [EVALUATIONS]
//
// The log of the experiment file is identified; its residuals are the noise of every forecast, its best
// fifteen seconds the motion to compare with. Designs of fifteen seconds keep to the envelope of the log, the
// largest positions, velocities, accelerations and torques in it, or to the limits of the robot's
// description, with a floor and without touching itself. A second design knows the information of the first.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <limits>

#include "rivid/error.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/signal/filter.hpp"
#include "turns.hpp"

namespace {

using namespace rivid;

constexpr double duration = 15.0;      // s
constexpr double cutoff_hz = 7.0;      // of positions and torques of the log
constexpr Index trim = 50;             // samples at each end
constexpr double row_rate_hz = 20.0;   // at which residuals count as independent
constexpr double acceleration = 10.0;  // rad/s², with the limits of the description

struct Logged {
  Motion motion;
  Matrix torque;
  double f_m = 0.0;
};

Logged logged(const Experiment& experiment) {
  const Log log = read_logs(experiment.log, experiment.robot).front();
  const Motion motion = differentiate(zero_phase(log.q, log.f_m, cutoff_hz), log.f_m);
  const Matrix torque = zero_phase(effort(experiment.robot, log), log.f_m, cutoff_hz);
  const auto inner = [](const Matrix& x) { return Matrix(x.middleRows(trim, x.rows() - 2 * trim)); };
  return {{inner(motion.q), inner(motion.qd), inner(motion.qdd)}, inner(torque), log.f_m};
}

// Of the windows of the log, the forecast of the one that is worth most.
Forecast best_window(const Robot& robot, const Logged& log, const ExcitationOptions& options) {
  const auto width = std::min(log.motion.samples(), static_cast<Index>(duration * log.f_m));
  Forecast best;
  best.log_det = -std::numeric_limits<double>::infinity();
  for (Index first = 0; first + width <= log.motion.samples(); first += static_cast<Index>(log.f_m / 2.0)) {
    const auto window = [&](const Matrix& x) { return Matrix(x.middleRows(first, width)); };
    Forecast found = forecast(robot, {window(log.motion.q), window(log.motion.qd), window(log.motion.qdd)},
                              log.f_m, options);
    if (found.log_det > best.log_det) {
      best = std::move(found);
    }
  }
  return best;
}

MotionLimits envelope_of(const Logged& log) {
  const auto largest = [](const Matrix& x) { return Vector(x.cwiseAbs().colwise().maxCoeff()); };
  return {.lower = log.motion.q.colwise().minCoeff(),
          .upper = log.motion.q.colwise().maxCoeff(),
          .velocity = largest(log.motion.qd),
          .acceleration = largest(log.motion.qdd),
          .torque = largest(log.torque),
          .position_share = 1.0,
          .velocity_share = 1.0,
          .torque_share = 1.0};
}

class Study {
 public:
  Study(const Robot& robot, const Forecast& first) : robot_(robot), first_(first) {
    std::cout << std::fixed << std::setprecision(1);
    row("logged", first, 0.0);
  }

  Excitation designed(const char* what, const ExcitationOptions& options) const {
    const double start = benchmarks::now(benchmarks::Clock::process);
    Excitation found = design(robot_, options);
    row(what, found.forecast, benchmarks::now(benchmarks::Clock::process) - start);
    return found;
  }

 private:
  void row(const char* what, const Forecast& found, double seconds) const {
    const double gain = found.log_det - first_.log_det;
    std::cout << std::setw(32) << what << "  log det " << found.log_det << " (" << std::showpos << gain
              << std::noshowpos << ")  mean sigma " << std::setprecision(2)
              << std::exp(-gain / 2.0 / static_cast<double>(found.chi.size())) << std::setprecision(1)
              << "  condition " << found.condition << "  " << seconds << " s";
    if (!found.clearances.empty()) {
      std::cout << "  nearest " << std::setprecision(4) << found.clearances.front().distance
                << std::setprecision(1) << " m";
    }
    std::cout << std::endl;
  }

  const Robot& robot_;
  const Forecast& first_;
};

void compare(const Experiment& experiment, int evaluations) {
  const Robot& robot = experiment.robot;
  ExcitationOptions options{.duration = duration};
  if (evaluations > 0) {
    options.evaluations = evaluations;
  }
  const Identification found = identify(robot, read_logs(experiment.log, robot), experiment.estimation);
  options.noise.sigma = Vector::Map(found.weights.data(), robot.size()).cwiseInverse();
  options.noise.rate_hz = row_rate_hz;
  const Logged log = logged(experiment);
  const Forecast first = best_window(robot, log, options);
  const Study study(robot, first);

  ExcitationOptions rated = options;
  options.limits = envelope_of(log);
  const Excitation fourier = study.designed("envelope, Fourier", options);
  ExcitationOptions other = options;
  other.curve = CurveKind::spline;
  (void)study.designed("envelope, spline", other);
  other = options;
  other.criterion = Criterion::condition;
  (void)study.designed("envelope, condition number", other);
  other = options;
  other.known = fourier.forecast.information;
  other.seed = 11;
  const auto b = static_cast<double>(first.chi.size());
  const auto second = [&](const char* what) {
    const double both = study.designed(what, other).forecast.log_det;
    std::cout << "second above running the first twice: "
              << both - fourier.forecast.log_det - b * std::log(2.0) << '\n';
  };
  second("envelope, second");
  other.harmonics = 2 * options.harmonics;
  second("envelope, second, more harmonics");
  other.harmonics = options.harmonics;
  other.curve = CurveKind::spline;
  second("envelope, second, spline");

  rated.limits.acceleration = Vector::Constant(robot.size(), acceleration);
  (void)study.designed("rated", rated);
  rated.space.half_spaces = {{.name = "floor"}};
  rated.space.radius = 0.05;
  (void)study.designed("rated, floor, no self-collision", rated);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: benchmark_excitation_log EXPERIMENT.toml [EVALUATIONS]\n";
    return 2;
  }
  try {
    compare(read_experiment(argv[1]), argc > 2 ? std::atoi(argv[2]) : 0);
  } catch (const Error& e) {
    std::cerr << "benchmark_excitation_log: " << e.what() << '\n';
    return 1;
  }
  return 0;
}
