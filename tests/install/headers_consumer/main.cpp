#include <array>
#include <iostream>

#include "rivid/model/mdh.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

rivid::Index joints_of(const rivid::Robot& robot);

// A planar arm of two joints, from its table to torques in two number types, without a library.
int main() {
  const std::array<rivid::MdhRow, 2> table = {{{.name = "shoulder"}, {.a = 0.5, .name = "elbow"}}};
  const rivid::Robot robot = rivid::robot_from(table, {0.0, -9.81, 0.0});
  const rivid::BaseParameters base = rivid::base_parameters(robot);
  const rivid::DynamicModel model(robot, base, rivid::Vector::Ones(base.size()));
  const Eigen::Vector2d q(0.3, -0.8);
  const Eigen::Vector2d qd(0.5, 1.5);
  const Eigen::Vector2d qdd(2.0, -3.0);
  Eigen::Vector2d tau;
  rivid::InverseDynamics dynamics(model);
  dynamics.torque(q, qd, qdd, tau);
  Eigen::Vector2f tau_f;
  rivid::BasicInverseDynamics<float> in_float(model);
  in_float.torque(q.cast<float>(), qd.cast<float>(), qdd.cast<float>(), tau_f);
  const bool same = (tau - rivid::inverse_dynamics(model, q, qd, qdd)).norm() < 1e-12 &&
                    (tau - tau_f.cast<double>()).norm() < 1e-4 &&
                    (rivid::direct_dynamics(model, q, qd, tau) - qdd).norm() < 1e-10 &&
                    rivid::design_inertia(model).minCoeff() > 0.0;
  std::cout << "rivid " << RIVID_VERSION << ": " << base.size() << " base parameters of " << joints_of(robot)
            << " joints, dynamics " << (same ? "agree" : "differ") << '\n';
}
