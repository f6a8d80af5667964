#include "paper_study/scara.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace rivid::study {

const PaperTable& paper_table(int number) {
  static constexpr std::array<PaperTable, 7> tables = {{
      {.chi = {3.44, 0.03, 0.82, 0.062, 0.121, 0.007, 0.013, 0.137},
       .two_sigma = {0.034, 0.031, 0.1, 0.0006, 0.0014, 0.0007, 0.006, 0.006},
       .percent_sigma = {0.50, 52.0, 6.0, 0.51, 0.56, 5.0, 23.0, 2.30},
       .relative_error = 0.024},
      {.chi = {3.45, 0.04, 0.82, 0.061, 0.124, 0.007, 0.013, 0.137},
       .two_sigma = {0.036, 0.032, 0.05, 0.0006, 0.0013, 0.0005, 0.0084, 0.008},
       .percent_sigma = {0.52, 40.0, 3.0, 0.49, 0.52, 3.5, 30.0, 3.0},
       .relative_error = 0.021},
      {.chi = {3.45, 0.04, 0.82, 0.061, 0.124, 0.007, 0.013, 0.137},
       .two_sigma = {0.036, 0.032, 0.05, 0.0006, 0.0013, 0.0005, 0.0084, 0.008},
       .percent_sigma = {0.52, 40.0, 3.0, 0.49, 0.52, 3.5, 30.0, 3.0},
       .relative_error = 0.0},
      {},
      {.chi = {1.5, 0.095, 0.55, 0.14, 0.63, 0.1, 0.001, 0.19},
       .two_sigma = {0.05, 0.15, 0.26, 0.018, 0.035, 0.023, 0.143, 0.244},
       .percent_sigma = {1.6, 80.0, 23.3, 6.7, 2.7, 11.8, 700.0, 68.4},
       .relative_error = 0.8},
      {.chi = {3.45, 0.05, 0.81, 0.061, 0.124, 0.008, 0.023, 0.13},
       .two_sigma = {0.007, 0.023, 0.004, 0.0004, 0.0015, 0.0009, 0.0022, 0.0038},
       .percent_sigma = {0.1, 21.0, 0.24, 0.3, 0.3, 5.6, 48.0, 1.5},
       .relative_error = 0.08},
      {.chi = {3.44, 0.02, 0.86, 0.060, 0.124, 0.007, 0.01, 0.13},
       .two_sigma = {0.014, 0.012, 0.016, 0.0001, 0.0002, 0.0003, 0.003, 0.0008},
       .percent_sigma = {0.2, 15.0, 1.0, 0.1, 0.1, 2.0, 10.0, 0.3},
       .relative_error = 0.0},
  }};
  return tables.at(static_cast<std::size_t>(number) - 1);
}

const std::array<std::array<double, b>, 4>& paper_iterates() {
  static constexpr std::array<std::array<double, b>, 4> iterates = {
      {{1, 0, 0, 1, 0, 0, 0, 0},
       {3.46, 0.04, 0.82, 0.06, 0.122, 0.05, 0.005, 0.130},
       {3.45, 0.02, 0.85, 0.061, 0.124, 0.07, 0.01, 0.132},
       {3.45, 0.02, 0.85, 0.061, 0.124, 0.07, 0.01, 0.132}}};
  return iterates;
}

namespace {

// J of (38), of the true robot.
Eigen::Array2d design_inertia_of_the_truth() { return {truth(0) + truth(3) + 2.0 * truth(4), truth(3)}; }

}  // namespace

Scara::Scara() {
  // Both axes are vertical: gravity has no effect.
  robot = robot_from(std::vector<MdhRow>{{}, {.a = L}});
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::coulomb;
  }
  robot.joints[1].rotor_inertia = false;  // ZZ2R = ZZ2 + Ia2 is one parameter in the paper
  base = base_parameters(robot);
  for (std::size_t i = 0; i < b; ++i) {
    chi[static_cast<Index>(i)] = truth(i) / in_paper[i];
  }
}

PointToPointReference Scara::moves(double size, int rounds, double time) {
  Matrix once(8, 2);
  once << 0, 0, 1.5, 2, -1, -1, 1, 1.5, -1.5, -2, 1, -.5, -.5, 2, 1.2, -1.5;
  // Back to zero at the end.
  Matrix via = Matrix::Zero(8 * rounds + 1, 2);
  via.topRows(8 * rounds) = size * once.replicate(rounds, 1);
  return PointToPointReference({.via = via, .durations = Vector::Constant(1, time)});
}

PointToPointReference Scara::unused_moves() {
  Matrix via(5, 2);
  via << 0, 0, -2, 2.5, 1.5, 3, 2.5, -3, 0, 0;
  return PointToPointReference({.via = via, .durations = Vector::Constant(1, move_time)});
}

Log Scara::log(const PointToPointReference& reference, std::uint64_t seed,
               const Conditions& conditions) const {
  const Eigen::Vector2d encoder_noise(4.5e-5, 4.5e-5);  // rad
  const Eigen::Vector2d disturbance(0.06, 0.015);       // N·m
  const auto rows = static_cast<Index>(std::lround(reference.duration() * f_m)) + 1;
  SimulationOptions options{.f_m = f_m, .sampling = sampling};
  options.sampling.position_noise = white_noise(seed, 1, rows, conditions.noise * encoder_noise);
  options.disturbance = white_noise(seed, 2, rows, conditions.noise * disturbance);
  const Vector J_apriori = design_inertia_of_the_truth() * conditions.J_ratio;
  const Simulation run = simulate(robot, base, chi, control, J_apriori, reference, options);
  Log out;
  out.source = "seed " + std::to_string(seed);
  out.t = run.t;
  out.f_m = f_m;
  out.q = run.q_measured;
  out.v_tau = run.v_tau;
  out.q_r = run.q_r;
  return out;
}

Estimation Scara::iv(const SignalOptions& signal, double bandwidth) const {
  return {.method = Iv{.control = PdControl{.omega_n = bandwidth * control.omega_n, .zeta = control.zeta},
                       .sampling = sampling},
          .signal = signal,
          .judge = false};
}

Estimation Scara::iv_of_section_3_4(const SignalOptions& signal, double bandwidth) const {
  Estimation out = iv(signal, bandwidth);
  Iv& method = std::get<Iv>(out.method);
  method.start_on_reference = true;
  method.transient = transient(bandwidth);
  return out;
}

double Scara::transient(double bandwidth) const { return 5.0 / (bandwidth * control.omega_n.minCoeff()); }

SignalOptions Scara::without_transient(SignalOptions signal) const {
  signal.window = {transient(), std::numeric_limits<double>::max()};
  return signal;
}

SignalOptions filtered() { return {.rows = RowScheme::paper, .cutoff_hz = 20.0, .decimation = {20}}; }

}  // namespace rivid::study
