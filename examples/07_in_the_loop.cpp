#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include "rivid/rivid.hpp"

// A control loop in the manner of ros2_control at 1 kHz, on the simulated six-axis robot of data/six_axis:
// computed torque that knows the payload, the payload estimated while it moves, contacts seen by the
// momentum, and gravity compensation for hand guiding. on_configure() allocates; update() neither allocates
// nor throws nor waits.

namespace {

using rivid::Index;
using rivid::Vector;
constexpr double f_m = 1000.0;

class Controller {
 public:
  struct Interfaces {
    Vector q, qd;             // measured
    Vector q_r, qd_r, qdd_r;  // reference
    Vector tau;               // command
  };

  void on_configure(const rivid::OnlineModel& model) {
    const rivid::DynamicModel dynamics(model.robot, model.base, model.chi);
    const Index n = model.robot.size();
    dynamics_.emplace_back(dynamics,
                           rivid::InverseDynamicsOptions{.smoothing_speed = Vector::Constant(n, 0.02)});
    payload_.emplace_back(model, rivid::PayloadEstimatorOptions{.rows = {.f_m = f_m}});
    contact_.emplace_back(dynamics, rivid::ContactObserverOptions{.f_m = f_m});
    const Vector zeros = Vector::Zero(n);
    io = {zeros, zeros, zeros, zeros, zeros, zeros};
    qdd_ = last_tau_ = zeros;
  }

  // Computed torque; the estimators hear of the torque that acted until now. What touches the robot is no
  // payload; but when the gripper has just closed, what pulls is one.
  void update(bool learn_contacts) noexcept {
    Contact& contact = contact_[0];
    rivid::PayloadEstimator<double>& payload = payload_[0];
    contact.update(io.q, io.qd, last_tau_, learn_contacts ? Contact::Mode::learn : Contact::Mode::observe);
    constexpr double omega_n = 20.0;
    qdd_ = io.qdd_r + 2.0 * omega_n * (io.qd_r - io.qd) + omega_n * omega_n * (io.q_r - io.q);
    dynamics_[0].torque(io.q, io.qd, qdd_, io.tau);
    if (contact.contact() && !expects_payload_) {
      payload.pause();
    } else {
      payload.update(io.q, io.tau);
    }
    if (expects_payload_ && payload.payload().held && payload.payload().good) {
      contact.set_payload(payload.inertial());
      expects_payload_ = false;
    }
    last_tau_ = io.tau;
  }

  void gripper_has_closed() noexcept { expects_payload_ = true; }

  // Hand guiding: whoever pushes feels inertia and friction, not weight.
  void compensate_gravity() noexcept {
    dynamics_[0].gravity(io.q, io.tau);
    contact_[0].update(io.q, io.qd, last_tau_);
    last_tau_ = io.tau;
  }

  using Contact = rivid::ContactObserver<double>;
  [[nodiscard]] const rivid::PayloadEstimator<double>& payload() const { return payload_[0]; }
  [[nodiscard]] const Contact& contact() const { return contact_[0]; }

  Interfaces io;

 private:
  // Made once, in on_configure().
  std::vector<rivid::InverseDynamics> dynamics_;
  std::vector<rivid::PayloadEstimator<double>> payload_;
  std::vector<Contact> contact_;
  Vector qdd_, last_tau_;
  bool expects_payload_ = false;
};

// The robot that is controlled: true parameters, with or without a load on its last link.
class Plant {
 public:
  Plant(const rivid::Robot& robot, const Vector& chi_st)
      : dynamics_(rivid::DynamicModel(robot, chi_st)),
        friction_(rivid::DynamicModel(robot, chi_st),
                  {.smoothing_speed = Vector::Constant(robot.size(), 0.005)}),
        qdd_(robot.size()) {}

  void step(const Vector& tau, const Vector& external, Vector& q, Vector& qd) {
    const auto n = static_cast<std::size_t>(q.size());
    // Half a step of explicit and half of what follows, at a tenth of the controller's period.
    constexpr int parts = 10;
    constexpr double h = 1.0 / (f_m * parts);
    for (int k = 0; k < parts; ++k) {
      static_cast<void>(dynamics_.set_state({q.data(), n}, {qd.data(), n}));
      friction_.friction(qd, qdd_);
      for (Index j = 0; j < q.size(); ++j) {
        qdd_[j] = tau[j] + external[j] - qdd_[j] - dynamics_.N()[static_cast<std::size_t>(j)];
      }
      dynamics_.solve({qdd_.data(), n});
      qd += h * qdd_;
      q += h * qd;
    }
  }

 private:
  rivid::Dynamics<double> dynamics_;
  rivid::InverseDynamics friction_;
  Vector qdd_;
};

rivid::OnlineModel model_of(const rivid::Robot& robot) {
  rivid::OnlineModel out{robot, rivid::base_parameters(robot), {}, {}, {}, {}};
  out.chi = out.base.from_standard(robot.chi_st());
  // What an identification would say: each parameter to 1 %. read_online_model() takes it from a result.json.
  out.C_chi = (1e-4 * out.chi.cwiseAbs2()).cwiseMax(1e-6).asDiagonal();
  out.sigma_rho = Vector::Constant(robot.size(), 0.1);
  out.velocity_threshold = Vector::Constant(robot.size(), 0.02);
  return out;
}

Vector with_load(const rivid::Robot& robot, double mass) {
  rivid::Robot out = robot;
  out.inertials.back() +=
      rivid::inertial_from_com(mass, {0.02, 0.0, 0.08}, 0.004 * Eigen::Matrix3d::Identity());
  return out.chi_st();
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path data = argc > 1 ? argv[1] : "data/six_axis";
  rivid::Robot robot = rivid::read_urdf(data / "six_axis.urdf");
  for (rivid::Joint& joint : robot.joints) {
    joint.friction = rivid::Friction::symmetric;
    joint.Ia = 0.1;
    joint.Fv = 2.0;
    joint.Fc = 3.0;
  }
  const Index n = robot.size();
  Controller controller;
  controller.on_configure(model_of(robot));
  constexpr double mass = 3.0;
  Plant empty(robot, robot.chi_st());
  Plant loaded(robot, with_load(robot, mass));
  Vector q = Vector::Zero(n);
  Vector qd = Vector::Zero(n);
  Vector push = Vector::Zero(n);
  Controller::Interfaces& io = controller.io;

  // A minute of motion, in which nothing touches the robot; then a pick-up, and 8 s later a push on joint 3.
  constexpr double pick_up = 60.0;
  constexpr double pushed = 68.0;
  double seen = -1.0;
  double touched = -1.0;
  double learned = -1.0;
  for (int k = 0; k < 70000; ++k) {
    const double t = k / f_m;
    for (Index j = 0; j < n; ++j) {
      const double omega = 1.0 + 0.3 * static_cast<double>(j);
      io.q_r[j] = 0.5 * (1.0 - std::cos(omega * t));
      io.qd_r[j] = 0.5 * omega * std::sin(omega * t);
      io.qdd_r[j] = 0.5 * omega * omega * std::cos(omega * t);
    }
    io.q = q;
    io.qd = qd;
    controller.update(t < pick_up - 1.0 ||
                      (t > pick_up + 2.0 && t < pushed - 1.0));  // nothing touches it then
    if (learned < 0.0 && controller.contact().learned()) {
      learned = t;  // before, some joint sees no contact
    }
    if (t == pick_up) {
      controller.gripper_has_closed();
    }
    if (seen < 0.0 && controller.payload().change().tick > 0) {
      seen = t;
    }
    if (touched < 0.0 && t > pushed - 1.0 && controller.contact().contact()) {
      touched = t;
    }
    push[2] = t > pushed ? 20.0 : 0.0;
    (t < pick_up ? empty : loaded).step(io.tau, push, q, qd);
  }
  const auto& found = controller.payload().payload();
  std::cout << "thresholds of contacts for all joints after " << learned << " s; pick-up at " << pick_up
            << " s seen at " << seen << " s, mass " << found.mass << " ± " << found.mass_half_width()
            << " kg of " << mass << "; push at " << pushed << " s seen at " << touched << " s\n";

  // Hand guiding from rest: the arm stays where it is, and follows a hand.
  qd.setZero();
  const Vector held = q;
  for (int k = 0; k < 1000; ++k) {
    io.q = q;
    io.qd = qd;
    controller.compensate_gravity();
    empty.step(io.tau, Vector::Zero(n), q, qd);
  }
  const double sagged = (q - held).cwiseAbs().maxCoeff();
  push.setZero();
  push[0] = 10.0;
  for (int k = 0; k < 1000; ++k) {
    io.q = q;
    io.qd = qd;
    controller.compensate_gravity();
    empty.step(io.tau, push, q, qd);
  }
  std::cout << "hand guiding: " << 1e3 * sagged << " mrad in a second without a hand, " << q[0] - held[0]
            << " rad with 10 N·m on joint 1\n";
  const bool good = learned > 0.0 && learned < pick_up && seen > pick_up && seen < pick_up + 0.5 &&
                    touched > pushed && touched < pushed + 0.3 && std::abs(found.mass - mass) < 0.15 &&
                    sagged < 0.01 && q[0] - held[0] > 0.1;
  return good ? 0 : 1;
}
