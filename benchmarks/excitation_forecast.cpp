// Forecast standard deviations beside the spread of many identifications, with white torque errors and with
// such as are correlated from sample to sample, for robots of the command line.
//
//   benchmark_excitation_forecast RUNS ROBOT.urdf …
//
// Each robot gets a motion of ten seconds, whose torques by the a-priori model are disturbed and identified
// RUNS times. Correlated errors follow e_k = 0.8 e_{k−1} + n_k; the forecast gets the rate at which white
// ones of that size are worth as much, 250 Hz · (1 − 0.8) / (1 + 0.8).

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <random>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/urdf.hpp"

namespace {

using namespace rivid;

constexpr double rate_hz = 250.0;
constexpr double acceleration = 10.0;    // rad/s², m/s²
constexpr double share_of_limit = 0.01;  // of the torques: their errors

Robot arm(const char* path) {
  Robot robot = read_urdf(path);
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::coulomb;
  }
  return robot;
}

ExcitationOptions options_for(const Robot& robot) {
  ExcitationOptions out{.duration = 10.0, .rate_hz = rate_hz, .starts = 1, .evaluations = 200};
  out.limits.acceleration = Vector::Constant(robot.size(), acceleration);
  out.noise.sigma.resize(robot.size());
  for (Index j = 0; j < robot.size(); ++j) {
    out.noise.sigma[j] = share_of_limit * robot.joints[static_cast<std::size_t>(j)].max_effort;
  }
  return out;
}

struct Part {
  double low, median, high;  // 5, 50 and 95 %
};

Part parts(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  return {at(0.05), at(0.5), at(0.95)};
}

// Forecast over spread of each parameter, errors having the correlation phi from sample to sample.
Part compared(const Robot& robot, const Motion& motion, ExcitationOptions options, double phi, int runs) {
  options.noise.rate_hz = rate_hz * (1.0 - phi) / (1.0 + phi);
  const Forecast expected = forecast(robot, motion, rate_hz, options);
  Log log;
  log.f_m = rate_hz;
  log.t = Vector::LinSpaced(motion.samples(), 0.0, static_cast<double>(motion.samples() - 1) / rate_hz);
  log.q = motion.q;
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Vector squares = Vector::Zero(expected.chi.size());
  for (int k = 0; k < runs; ++k) {
    log.tau = expected.tau;
    for (Index j = 0; j < robot.size(); ++j) {
      double error = normal(random);
      for (double& tau : log.tau.col(j)) {
        tau += options.noise.sigma[j] * error;
        error = phi * error + std::sqrt(1.0 - phi * phi) * normal(random);
      }
    }
    const Identification found = identify(robot, log, {.method = Wls{}, .signal = {.decimation = {5}}});
    squares += (found.chi - expected.chi).cwiseAbs2();
  }
  std::vector<double> ratios;
  for (Index i = 0; i < squares.size(); ++i) {
    ratios.push_back(expected.parameters[static_cast<std::size_t>(i)].sigma / std::sqrt(squares[i] / runs));
  }
  return parts(ratios);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: benchmark_excitation_forecast RUNS ROBOT.urdf ...\n";
    return 2;
  }
  const int runs = std::atoi(argv[1]);
  std::cout << "forecast over spread of " << runs << " runs: median (5-95 % of the parameters)\n";
  for (int k = 2; k < argc; ++k) {
    try {
      const Robot robot = arm(argv[k]);
      const ExcitationOptions options = options_for(robot);
      const Excitation found = design(robot, options);
      std::cout << robot.name << ", " << found.forecast.chi.size() << " parameters:";
      for (const double phi : {0.0, 0.8}) {
        const Part part = compared(robot, found.motion, options, phi, runs);
        std::cout << (phi > 0.0 ? "  correlated " : "  white ") << part.median << " (" << part.low << "-"
                  << part.high << ")";
      }
      std::cout << std::endl;
    } catch (const Error& e) {
      std::cout << argv[k] << ": " << e.what() << '\n';
    }
  }
  return 0;
}
