#include "paper_study/scara.hpp"

#include <cmath>
#include <vector>

namespace rivid::study {

namespace {

PointToPointReference through(const Matrix& via) {
  return PointToPointReference({.via = via, .durations = Vector::Constant(1, Scara::move_time)});
}

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
    chi[static_cast<Index>(i)] = truth[i] / in_paper[i];
  }
}

Vector Scara::J() {
  const double J_2 = truth[3];
  return Eigen::Vector2d(truth[0] + J_2 + 2.0 * truth[4], J_2);
}

PointToPointReference Scara::moves(double size, int rounds) {
  Matrix once(8, 2);
  once << 0, 0, 1.5, 2, -1, -1, 1, 1.5, -1.5, -2, 1, -.5, -.5, 2, 1.2, -1.5;
  // Back to zero at the end.
  Matrix via = Matrix::Zero(8 * rounds + 1, 2);
  via.topRows(8 * rounds) = size * once.replicate(rounds, 1);
  return through(via);
}

PointToPointReference Scara::unused_moves() {
  Matrix via(5, 2);
  via << 0, 0, -2, 2.5, 1.5, 3, 2.5, -3, 0, 0;
  return through(via);
}

Log Scara::log(const PointToPointReference& reference, std::uint64_t seed, const Design& design) const {
  const Eigen::Vector2d encoder_noise(4.5e-5, 4.5e-5);  // rad
  const Eigen::Vector2d disturbance(0.06, 0.015);       // N·m
  const auto rows = static_cast<Index>(std::lround(reference.duration() * f_m)) + 1;
  SimulationOptions options{.f_m = f_m, .sampling = sampling};
  options.sampling.position_noise = white_noise(seed, 1, rows, design.noise * encoder_noise);
  options.disturbance = white_noise(seed, 2, rows, design.noise * disturbance);
  const Vector J_apriori = J().array() * design.J_ratio;
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
          .signal = signal};
}

SignalOptions filtered() { return {.rows = RowScheme::paper, .cutoff_hz = 20.0, .decimation = {20}}; }

}  // namespace rivid::study
