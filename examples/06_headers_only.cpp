#include <cmath>
#include <iomanip>
#include <iostream>

#include "rivid/simulate/inverse_dynamics.hpp"

// A controller that links nothing: rivid::headers asks for Eigen alone. The numbers of its robot, the SCARA
// of data/scara, are written out here as an identification found them. This program is built against
// rivid::headers and against rivid::rivid, and a test compares what the two print, bit by bit.

namespace {

using rivid::Index;
using rivid::Vector;

rivid::ModelData scara() {
  rivid::ModelData out;
  out.chain.links.resize(2);
  out.chain.links[1].p = {0.5, 0.0, 0.0};
  out.names = {"joint_1", "joint_2"};
  out.inertials.assign(2, rivid::Inertial::Zero());
  out.inertials[0][5] = 3.38;                                    // ZZ1R, rotor included
  out.inertials[1] << 0, 0, 0, 0, 0, 0.063, 0.242, 0.001, 0, 0;  // ZZ2R, LMX2, LMY2
  out.rotor = rivid::Matrix::Zero(2, 2);
  out.viscous = Eigen::Vector2d(0.03, 0.013).asDiagonal();
  out.offset = Vector::Zero(2);
  for (Index j = 0; j < 2; ++j) {
    const double Fc = j == 0 ? 0.82 : 0.137;
    const Vector axis = Vector::Unit(2, j);
    out.dry_friction.push_back(
        {out.names[static_cast<std::size_t>(j)], axis, axis, {{rivid::Basis::sign, Fc, Fc}}, Fc, Fc});
  }
  return out;
}

class ComputedTorque {
 public:
  ComputedTorque(const rivid::ModelData& model, double omega_n)
      : dynamics_(model, {.smoothing_speed = Vector::Constant(model.size(), 0.01)}),
        k_p_(omega_n * omega_n),
        k_v_(2.0 * omega_n),
        qdd_(Vector::Zero(model.size())) {}

  // Neither allocates nor throws.
  void update(const Vector& q, const Vector& qd, const Vector& q_r, const Vector& qd_r, const Vector& qdd_r,
              Vector& tau) noexcept {
    for (Index j = 0; j < qdd_.size(); ++j) {
      qdd_[j] = qdd_r[j] + k_v_ * (qd_r[j] - qd[j]) + k_p_ * (q_r[j] - q[j]);
    }
    dynamics_.torque(q, qd, qdd_, tau);
  }

 private:
  rivid::InverseDynamics dynamics_;
  double k_p_;
  double k_v_;
  Vector qdd_;
};

}  // namespace

int main() {
  ComputedTorque controller(scara(), 10.0);
  Vector q(2);
  Vector qd(2);
  Vector q_r(2);
  Vector qd_r(2);
  Vector qdd_r(2);
  Vector tau(2);
  std::cout << std::hexfloat;
  for (int k = 0; k < 1000; ++k) {
    for (Index j = 0; j < 2; ++j) {
      const double omega = j == 0 ? 3.0 : 5.0;
      const double phase = omega * 1e-3 * k;
      q_r[j] = 0.5 * (1.0 - std::cos(phase));
      qd_r[j] = 0.5 * omega * std::sin(phase);
      qdd_r[j] = 0.5 * omega * omega * std::cos(phase);
      q[j] = q_r[j] - 1e-3 * std::sin(7.0 * phase);  // as if measured
      qd[j] = qd_r[j] - 7e-3 * omega * std::cos(7.0 * phase);
    }
    controller.update(q, qd, q_r, qd_r, qdd_r, tau);
    if (!tau.allFinite()) {
      return 1;
    }
    std::cout << tau[0] << ' ' << tau[1] << '\n';
  }
}
