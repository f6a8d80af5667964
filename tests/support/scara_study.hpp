#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "rivid/data/log.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/measurement.hpp"
#include "rivid/simulate/references.hpp"
#include "support/robots.hpp"

namespace rivid::test {

/// The case study of [RIV], section 4: its SCARA, its poles, moves that it can follow, and simulated logs of
/// it.
struct ScaraStudy {
  static constexpr double f_m = 200.0;

  Robot robot = scara();
  BaseParameters base = base_parameters(robot);
  Vector truth = Vector::Zero(8);
  PdControl control{.omega_n = Eigen::Vector2d(1, 10), .zeta = Eigen::Vector2d(1, 1)};
  Vector J = Eigen::Vector2d(3.44 + 0.062 + 2 * 0.121, 0.062);
  double encoder_noise = 4.5e-5;                      // rad, fed back
  Vector disturbance = Eigen::Vector2d(0.06, 0.015);  // N·m

  ScaraStudy() {
    set("ZZ1R", 3.44);
    set("Fv1", 0.03);
    set("Fc1", 0.82);
    set("ZZ2", 0.062);
    set("MX2", 0.242);
    set("MY2", 0.014);
    set("Fv2", 0.013);
    set("Fc2", 0.137);
  }

  [[nodiscard]] Index index(const std::string& name) const {
    for (Index i = 0; i < base.size(); ++i) {
      if (base.parameters[static_cast<std::size_t>(i)].name == name) {
        return i;
      }
    }
    throw std::invalid_argument(name);
  }
  void set(const std::string& name, double value) { truth[index(name)] = value; }

  /// S1, or S2 with its via points doubled; gone through so many times, each move in so many seconds.
  [[nodiscard]] static PointToPointReference moves(double size, int rounds = 1, double seconds = 2.5) {
    Matrix once(8, 2);
    once << 0, 0, 1.5, 2, -1, -1, 1, 1.5, -1.5, -2, 1, -.5, -.5, 2, 1.2, -1.5;
    Matrix via = Matrix::Zero(8 * rounds + 1, 2);
    via.topRows(8 * rounds) = size * once.replicate(rounds, 1);
    return PointToPointReference({.via = via, .durations = Vector::Constant(1, seconds)});
  }

  [[nodiscard]] static Sampling computer() { return {.period = 1.0 / f_m}; }

  /// What the controller's computer would log.
  [[nodiscard]] Log log(double size, std::uint64_t seed) const { return log(moves(size), seed); }
  [[nodiscard]] Log log(const PointToPointReference& reference, std::uint64_t seed) const {
    SimulationOptions options{.f_m = f_m};
    options.sampling = computer();
    const Index rows = std::lround(reference.duration() * f_m) + 1;
    options.sampling.position_noise = white_noise(seed, 1, rows, Vector::Constant(2, encoder_noise));
    options.disturbance = white_noise(seed, 2, rows, disturbance);
    const Simulation run = simulate(robot, base, truth, control, J, reference, options);
    Log out;
    out.source = "seed " + std::to_string(seed);
    out.t = run.t;
    out.f_m = f_m;
    out.q = run.q_measured;
    out.v_tau = run.v_tau;
    out.q_r = run.q_r;
    return out;
  }

  /// IDIM-IV with the controller known, its poles scaled.
  [[nodiscard]] Estimation iv(double bandwidth = 1.0) const {
    return {.method = Iv{.control = PdControl{.omega_n = bandwidth * control.omega_n, .zeta = control.zeta},
                         .sampling = computer()},
            .signal = unfiltered()};
  }

  /// The signal chain of section 4: Butterworth at 20 Hz, decimation by 20.
  [[nodiscard]] static SignalOptions filtered() {
    return {.rows = RowScheme::paper, .cutoff_hz = 20.0, .decimation = {20}};
  }
  /// The same without data filtering, section 4.4.
  [[nodiscard]] static SignalOptions unfiltered() { return {.rows = RowScheme::paper}; }
};

}  // namespace rivid::test
