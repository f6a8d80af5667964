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

  const rivid::Log log = rivid::read_csv(data / "scara_s2.csv");  // columns t, q1, q2, v1, v2

  const rivid::SignalOptions signal = {.torque_held = true,  // v acts from t_k to t_{k+1}
                                       .cutoff_hz = 20.0,
                                       .decimation = {20}};
  std::cout << rivid::identify(robot, log, {.method = rivid::Ols{}, .signal = signal});
}
