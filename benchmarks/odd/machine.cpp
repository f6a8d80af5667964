#include "odd/machine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rivid::odd {

namespace {

// Below it friction that grows with the root of the speed ends, as rivid's does [rad/s | m/s].
constexpr double root_speed = 1e-3;

}  // namespace

Plant::Plant(const Machine& machine) : machine_(machine), dynamics_(machine.arm), loaded_(machine.arm) {
  if (machine.payload) {
    loaded_.carry(machine.payload->body);
  }
}

const ArmDynamics& Plant::dynamics(double t) const {
  const auto& payload = machine_.payload;
  return payload && t >= payload->from && t < payload->until ? loaded_ : dynamics_;
}

void Plant::equation(double t, const Numbers& x, const Numbers& v, const Numbers& torque,
                     const Numbers& disturbance, const Numbers& direction, Equation& out) const {
  const Index n = joints();
  const Index size = freedoms();
  const ArmDynamics& links = dynamics(t);
  const Numbers q = x.head(n);
  out.M.setZero(size, size);
  out.M.topLeftCorner(n, n) = links.mass(q);
  out.N.setZero(size);
  out.N.head(n) = links.torques(q, v.head(n), Numbers::Zero(n));
  out.Fl.setZero(size);
  out.b = -out.N;
  out.F_plus.setZero(size);
  out.F_minus.setZero(size);
  const double warm = 1.0 - machine_.drift * (1.0 - std::exp(-t / machine_.drift_time));
  for (Index j = 0; j < n; ++j) {
    const Index i = motor(j);
    const JointFriction& friction = machine_.friction[static_cast<std::size_t>(j)];
    out.M(i, i) += machine_.Ia[j];
    double b = torque[j] + disturbance[j] - friction.offset;
    b -= warm * (direction[i] > 0.0 ? friction.Fv_plus : friction.Fv_minus) * v[i];
    if (machine_.ripple.size() > 0) {
      b -= machine_.ripple[j] * std::sin(2.0 * std::numbers::pi * machine_.ripple_cycles[j] * x[i]);
    }
    if (machine_.elastic()) {
      const double twist = x[i] - x[j];
      const double beyond_play = twist - std::clamp(twist, -machine_.backlash, machine_.backlash);
      const double spring = machine_.stiffness[j] * beyond_play + machine_.damping[j] * (v[i] - v[j]);
      out.b[j] += spring;
      b -= spring;
    }
    if (j == 1) {
      b -= machine_.spring * x[i];
    }
    out.b[i] += b;
    const double speed = v[i] / friction.stribeck_speed;
    const double beside =
        (friction.stribeck > 0.0 ? friction.stribeck * std::exp(-speed * speed) : 0.0) +
        friction.load * std::abs(torque[j]) +
        friction.Fr * std::abs(v[i]) / std::pow(v[i] * v[i] + root_speed * root_speed, 0.25);
    out.Fl[i] = warm * friction.Fl;
    out.F_plus[i] = warm * (friction.Fc_plus + beside);
    out.F_minus[i] = warm * (friction.Fc_minus + beside);
  }
}

}  // namespace rivid::odd
