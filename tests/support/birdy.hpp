#pragma once

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <numbers>
#include <random>
#include <string>

#include "rivid/data/log.hpp"
#include "rivid/data/table.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/references.hpp"
#include "support/normal.hpp"
#include "support/tx40.hpp"

namespace rivid::test {

/// BIRDy's simulated TX40 without the coupling of its wrist: robot, parameters, controller and noise as its
/// code has them (Leboutet et al., Applied Sciences 2021; TUM's BIRDy, MIT licence).
struct BirdyTx40 {
  static constexpr double duration = 10.0;         // s
  static constexpr Index control_periods = 50001;  // its linspace has as many points as intervals
  static constexpr double low_noise = 1e-4;        // deg, of the positions
  static constexpr double standard_noise = 1e-3;
  static constexpr double torque_noise = 0.05;  // N·m
  static constexpr Index periods_a_row = 5;     // 5 kHz control, 1 kHz log
  static constexpr double sign_speed = 0.01;    // rad/s: its Coulomb friction is Fc tanh(100 q̇)

  Robot robot = tx40(Friction::coulomb);
  PdControl control;

  BirdyTx40() {
    robot.chain.gravity = {0.0, 0.0, -9.81};
    robot.chain.links[5].R =
        robot.chain.links[5].R * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ());
    // XX XY XZ YY YZ ZZ MX MY MZ M
    const double bodies[6][10] = {
        {0.424, 0, 0, 0.424, 0, 0.352, 0, 0, -0.4305, 8.61},
        {1.63e-2, 7.85e-4, -1.57e-2, 8.81e-2, 3.24e-4, 8.28e-2, 0.392, -7.2e-3, 0.162, 4.85},
        {2.23e-2, -1.95e-4, -1.16e-3, 2.24e-2, -2.22e-3, 4.41e-3, 3.26e-2, 2.44e-2, 0.265, 4.07},
        {0.109, 2.9e-5, 1.35e-3, 0.108, -1.17e-3, 4.07e-3, 1.45e-2, -7.24e-3, -0.586, 3.62},
        {1.01e-3, 0, 0, 1.00e-3, -3.06e-6, 1.01e-3, 0, -3.06e-3, -1.02e-3, 1.02},
        {3.53e-3, 0, 0, 3.53e-3, 0, 3.53e-4, 0, 0, 8.4e-3, 0.20}};
    const double Ia[6] = {0.362, 0.507, 0.0829, 0.0341, 0.0361, 0.0114};
    const double Fv[6] = {7.9379, 5.6948, 1.9804, 1.1141, 1.60, 0.6894};
    const double Fc[6] = {6.9822, 7.8301, 6.1939, 2.4063, 3.4092, 1.8313};
    const double K_tau[6] = {35.24, 32.04, 23.94, 9.05, 15.5, 6.56};
    const double K_p[6] = {455.8254, 500, 253.7919, 200.2182, 244.3226, 478.4783};
    const double K_d[6] = {2.5361, 4.1174, 1.1793, 0.5462, 0.5714, 0.1954};
    control = {.k_p = Vector(6), .k_v = Vector(6), .reference_velocity = true};
    robot.inertials.resize(6);
    for (std::size_t j = 0; j < 6; ++j) {
      robot.inertials[j] = Inertial(Eigen::Map<const Inertial>(bodies[j]));
      robot.joints[j].Ia = Ia[j];
      robot.joints[j].Fv = Fv[j];
      robot.joints[j].Fc = Fc[j];
      robot.joints[j].drive_gain = K_tau[j];
      const auto k = static_cast<Index>(j);
      control.k_p[k] = 0.75 * K_p[j] / K_d[j];
      control.k_v[k] = K_d[j];
    }
  }

  /// Its exciting trajectory is not published; this one was made for its limits.
  ///
  /// @param file  A and B of a Fourier series with a period of 10 s, one line a joint
  static FourierReference reference(const std::string& file) {
    const Table table = read_table(file, {.header = Header::absent});
    FourierSeries series;
    series.omega_f = 2.0 * std::numbers::pi / duration;
    series.A = table.values.leftCols(20);
    series.B = table.values.rightCols(20);
    series.duration = duration;
    return FourierReference(series);
  }

  /// Its loop at 5 kHz: the reference of the end of a step meets the measurement of its start.
  static SimulationOptions loop(double position_noise_deg, std::uint64_t seed) {
    const double period = duration / static_cast<double>(control_periods);
    SimulationOptions options{.f_m = 1.0 / period, .samples = control_periods};
    options.sampling.period = period;
    options.sampling.reference_lead = 1;
    std::mt19937_64 random(seed);
    Normal normal(0.0, position_noise_deg * std::numbers::pi / 180.0);
    options.sampling.position_noise = Matrix::NullaryExpr(control_periods, 6, [&] { return normal(random); });
    return options;
  }

  /// The integrator that its data are made with: friction as tanh(100 q̇), evaluated once a step.
  static SimulationOptions with_its_integrator(SimulationOptions options) {
    options.integrator = Integrator::rk4;
    options.friction = DryFrictionScheme::held;
    options.smooth_velocity = sign_speed;
    return options;
  }

  /// Its identification model: the robot with its friction law in the regressor.
  [[nodiscard]] Robot smooth_robot() const {
    Robot out = robot;
    for (Joint& joint : out.joints) {
      joint.sign_speed = sign_speed;
    }
    return out;
  }

  /// What it records: noisy positions at 1 kHz, and beside each the torque of the control period just
  /// finished with noise of its own.
  [[nodiscard]] Log log(const FourierReference& reference, double position_noise_deg,
                        std::uint64_t seed) const {
    const DynamicModel model(robot, robot.chi_st());
    const SimulationOptions options = with_its_integrator(loop(position_noise_deg, seed));
    const Simulation run = simulate(robot, model, *control({robot, model, {}}), reference, options);
    const Index rows = (control_periods - 1) / periods_a_row;
    std::mt19937_64 random(seed + 1000);
    Normal normal(0.0, torque_noise);
    Log out;
    out.source = "seed " + std::to_string(seed);
    out.f_m = options.f_m / static_cast<double>(periods_a_row);
    out.t = Vector(rows);
    out.q = out.q_r = out.tau = Matrix(rows, 6);
    Vector q_r(6);
    Vector qd_r(6);
    Vector qdd_r(6);
    for (Index row = 0; row < rows; ++row) {
      const Index k = periods_a_row * row;
      out.t[row] = static_cast<double>(row) / out.f_m;
      reference.at(out.t[row], q_r, qd_r, qdd_r);
      out.q_r.row(row) = q_r;
      out.q.row(row) = run.q_measured.row(k);
      out.tau.row(row) = run.tau.row(std::max<Index>(k - 1, 0));
      for (Index j = 0; j < 6; ++j) {
        out.tau(row, j) += normal(random);
      }
    }
    return out;
  }

  /// T of β = T χ_st: its base parameters, which a QR with column pivoting picks by the norms of the columns.
  /// Errors of other parameters that say the same have other norms.
  [[nodiscard]] static Matrix its_base_parameters(const Robot& robot) {
    constexpr Index samples = 1000;
    const std::vector<StandardParameter> standard = robot.standard_parameters();
    const auto count = static_cast<Index>(standard.size());
    std::mt19937_64 random(1);
    Normal normal;
    Motion motion;
    for (Matrix* const part : {&motion.q, &motion.qd, &motion.qdd}) {
      *part = Matrix::NullaryExpr(samples, 6, [&] { return normal(random); });
    }
    const RegressorBatch batch(robot, standard);
    RegressorBlock block(batch, samples);
    batch.fill(motion, 0, samples, block);
    Matrix W = Matrix::Zero(6 * samples, count);
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t c = 0; c < batch.of_joint(i).size(); ++c) {
        W.col(batch.of_joint(i)[c]).segment(static_cast<Index>(i) * samples, samples) =
            block.W(i).col(static_cast<Index>(c));
      }
    }
    Eigen::ColPivHouseholderQR<Matrix> qr(W);
    qr.setThreshold(1e-10);
    const Index b = qr.rank();
    const Matrix R = qr.matrixR().topRows(b).triangularView<Eigen::Upper>();
    Matrix T(b, count);
    T << Matrix::Identity(b, b), R.leftCols(b).triangularView<Eigen::Upper>().solve(R.rightCols(count - b));
    return T * qr.colsPermutation().transpose();
  }
};

/// How often a column changes its sign.
inline Index sign_changes(const Eigen::Ref<const Vector>& x) {
  Index changes = 0;
  double last = 0.0;
  for (const double value : x) {
    if (value != 0.0) {
      changes += last * value < 0.0 ? 1 : 0;
      last = value;
    }
  }
  return changes;
}

}  // namespace rivid::test
