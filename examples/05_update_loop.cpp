#include <cmath>
#include <iostream>
#include <memory>

#include "rivid/rivid.hpp"

// The loop of a controller in the manner of ros2_control: everything is made in on_configure(), and update(), which a
// real-time thread calls every millisecond, neither allocates nor throws nor waits. The controller knows the SCARA of
// data/scara as it was identified from a log; the robot that it moves here has the true parameters.

namespace {

using rivid::Index;
using rivid::Vector;

class ComputedTorque {
 public:
  // What the hardware fills and takes.
  struct Interfaces {
    Vector q, qd;             // measured
    Vector q_r, qd_r, qdd_r;  // reference
    Vector tau;               // command
  };

  void on_configure(const rivid::InverseDynamics& dynamics, double omega_n) {
    dynamics_ = std::make_unique<rivid::InverseDynamics>(dynamics);  // a copy of its own, with its scratch
    k_p_ = omega_n * omega_n;
    k_v_ = 2.0 * omega_n;
    const Vector zeros = Vector::Zero(dynamics.size());
    io = {zeros, zeros, zeros, zeros, zeros, zeros};
    qdd_ = zeros;
  }

  void update() noexcept {
    qdd_ = io.qdd_r + k_v_ * (io.qd_r - io.qd) + k_p_ * (io.q_r - io.q);
    dynamics_->torque(io.q, io.qd, qdd_, io.tau);
  }

  Interfaces io;

 private:
  std::unique_ptr<rivid::InverseDynamics> dynamics_;
  double k_p_ = 0.0;
  double k_v_ = 0.0;
  Vector qdd_;
};

rivid::Robot scara(const std::filesystem::path& data) {
  rivid::Robot robot = rivid::read_urdf(data / "scara.urdf");
  for (rivid::Joint& joint : robot.joints) {
    joint.friction = rivid::Friction::coulomb;
    joint.rotor_inertia = false;
  }
  return robot;
}

// Largest error of the joints' positions on the way of two seconds [rad].
double tracking_error(ComputedTorque& controller, const rivid::DynamicModel& truth) {
  constexpr double period = 1e-3;
  const Eigen::Vector2d amplitude(0.8, -0.5);
  const Eigen::Vector2d omega(3.0, 5.0);
  Vector q = Vector::Zero(2);
  Vector qd = Vector::Zero(2);
  double largest = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Array2d phase = omega.array() * (k * period);
    // 1 − cos: starts at rest.
    controller.io.q_r = amplitude.array() * (1.0 - phase.cos());
    controller.io.qd_r = amplitude.array() * omega.array() * phase.sin();
    controller.io.qdd_r = amplitude.array() * omega.array().square() * phase.cos();
    controller.io.q = q;
    controller.io.qd = qd;
    controller.update();
    largest = std::max(largest, (controller.io.q_r - q).cwiseAbs().maxCoeff());
    qd += period * rivid::direct_dynamics(truth, q, qd, controller.io.tau);
    q += period * qd;
  }
  return largest;
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path data = argc > 1 ? argv[1] : "data/scara";
  const rivid::Robot robot = scara(data);
  const rivid::Log log = rivid::shift_torque(rivid::read_csv(data / "scara_s2.csv"), -0.5);
  const rivid::SignalOptions signal = {
      .cutoff_hz = 20.0, .decimation = {14}, .trim = {{20, 20}}, .velocity_threshold = {0.1, 0.1}};
  const rivid::Identification result = rivid::identify(robot, log, rivid::Ols{signal});

  // From a file instead: DynamicModel(robot, read_parameters("result.json", base_parameters(robot))).
  const rivid::InverseDynamicsOptions smooth = {.smoothing_speed = Vector::Constant(2, 0.01)};  // rad/s
  const rivid::InverseDynamics identified(robot, result.base, result.chi, smooth);
  // A guess for comparison: half of everything.
  const rivid::InverseDynamics guessed(robot, result.base, 0.5 * result.chi, smooth);

  const rivid::DynamicModel truth(robot, robot.chi_st());
  constexpr double omega_n = 10.0;  // rad/s
  ComputedTorque controller;
  controller.on_configure(identified, omega_n);
  const double with_model = tracking_error(controller, truth);
  controller.on_configure(guessed, omega_n);
  const double with_guess = tracking_error(controller, truth);
  std::cout << "largest tracking error: " << 1e3 * with_model << " mrad with the identified model, "
            << 1e3 * with_guess << " mrad with half of it\n";
  return with_model < 0.1 * with_guess ? 0 : 1;
}
