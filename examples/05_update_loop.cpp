#include <cmath>
#include <iostream>
#include <memory>

#include "rivid/rivid.hpp"

// The loop of a controller in the manner of ros2_control: everything is made in on_configure(), and update(),
// which a real-time thread calls every millisecond, neither allocates nor throws nor waits. The controller
// knows the SCARA of data/scara from the result.json of its identification; the robot that it moves here has
// the true parameters.

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

  // Reads the file, allocates, and throws where something is wrong with it: a result that is not identified,
  // say.
  void on_configure(const std::filesystem::path& result, double omega_n) {
    configure(rivid::read_identified_model(result), omega_n);
  }

  void configure(const rivid::DynamicModel& model, double omega_n) {
    const rivid::InverseDynamicsOptions smooth = {.smoothing_speed =
                                                      Vector::Constant(model.size(), 0.01)};  // rad/s
    dynamics_ = std::make_unique<rivid::InverseDynamics>(model, smooth);
    k_p_ = omega_n * omega_n;
    k_v_ = 2.0 * omega_n;
    const Vector zeros = Vector::Zero(model.size());
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

// What `rivid identify scara.toml --physical` writes.
void write_result(const rivid::Experiment& experiment, const std::filesystem::path& file) {
  const rivid::Identification result = rivid::run(experiment);
  rivid::write_file(file, rivid::to_json(experiment.robot, result, rivid::Provenance()));
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
  rivid::Experiment experiment = rivid::read_experiment(data / "scara.toml");
  experiment.estimation.physical = rivid::Physical{};
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "rivid_05_update_loop.json";
  write_result(experiment, file);

  const rivid::Robot& robot = experiment.robot;
  const rivid::DynamicModel truth(robot, robot.chi_st());
  constexpr double omega_n = 10.0;  // rad/s
  ComputedTorque controller;
  controller.on_configure(file, omega_n);
  const double with_model = tracking_error(controller, truth);
  std::filesystem::remove(file);
  // A guess for comparison: half of everything.
  controller.configure(rivid::DynamicModel(robot, 0.5 * robot.chi_st()), omega_n);
  const double with_guess = tracking_error(controller, truth);
  std::cout << "largest tracking error: " << 1e3 * with_model << " mrad with the identified model, "
            << 1e3 * with_guess << " mrad with half of it\n";
  return with_model < 0.1 * with_guess ? 0 : 1;
}
