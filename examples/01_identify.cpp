#include <iostream>

#include "rivid/rivid.hpp"

// The SCARA robot of data/scara by ordinary least squares.
int main(int argc, char** argv) {
  const std::filesystem::path data = argc > 1 ? argv[1] : "data/scara";

  rivid::Robot robot = rivid::read_urdf(data / "scara.urdf");
  for (rivid::Joint& joint : robot.joints) {
    joint.friction = rivid::Friction::coulomb;  // Fv q̇ + Fc sign q̇
    joint.rotor_inertia = false;                // direct drive
  }

  rivid::Log log = rivid::read_csv(data / "scara_s2.csv");  // columns t, q1, q2, v1, v2
  log = rivid::shift_torque(log, -0.5);                     // v is held from t_k to t_{k+1}

  const rivid::SignalOptions signal = {
      .cutoff_hz = 20.0, .decimation = {14}, .trim = {{20, 20}}, .velocity_threshold = {0.1, 0.1}};
  std::cout << rivid::identify(robot, log, rivid::Ols{signal});
}
