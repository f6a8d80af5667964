#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <random>
#include <string>

#include "rivid/data/table.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/fourier_reference.hpp"
#include "rivid/simulate/pd_control.hpp"
#include "support/tx40.hpp"

namespace rivid::test {

/// BIRDy's simulated TX40 without the coupling of its wrist: robot, parameters, controller and noise as its code has
/// them (Leboutet et al., Applied Sciences 2021; TUM's BIRDy, MIT licence).
struct BirdyTx40 {
  static constexpr double duration = 10.0;         // s
  static constexpr Index control_periods = 50001;  // its linspace has as many points as intervals
  static constexpr double low_noise = 1e-4;        // deg, of the positions
  static constexpr double standard_noise = 1e-3;
  static constexpr double torque_noise = 0.05;  // N·m

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
    std::normal_distribution<double> normal(0.0, position_noise_deg * std::numbers::pi / 180.0);
    options.sampling.position_noise = Matrix::NullaryExpr(control_periods, 6, [&] { return normal(random); });
    return options;
  }

  /// The integrator that its data are made with: friction as tanh(100 q̇), evaluated once a step.
  static SimulationOptions with_its_integrator(SimulationOptions options) {
    options.integrator = Integrator::rk4;
    options.friction = DryFrictionScheme::held;
    options.smooth_velocity = 0.01;
    return options;
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
