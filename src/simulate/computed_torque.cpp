#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/dynamics.hpp"
#include "rivid/text.hpp"
#include "simulate/gains.hpp"

namespace rivid {

namespace {

class ComputedTorqueLaw final : public ControlLaw {
 public:
  ComputedTorqueLaw(const ComputedTorqueControl& control, const Plant& plant, const DynamicModel& model)
      : dynamics_(model),
        k_p_(control.k_p),
        k_d_(control.k_d),
        signal_(plant.robot.drive_matrix().inverse()),
        viscous_(Matrix::Zero(signal_.rows(), signal_.cols())),
        offset_(Vector::Zero(signal_.rows())),
        coulomb_velocity_(control.coulomb_velocity),
        v_tau_max_(
            detail::or_constant(control.v_tau_max, signal_.rows(), std::numeric_limits<double>::infinity())) {
    if (control.omega_n.size() > 0) {
      k_p_ = control.omega_n.cwiseAbs2();
      k_d_ = 2.0 * control.zeta.cwiseProduct(control.omega_n);
    }
    if (control.friction) {
      viscous_ = signal_ * model.viscous();
      offset_ = signal_ * model.offset();
      dry_friction_ = model.dry_friction();
      for (DryFriction& element : dry_friction_) {
        element.torque = signal_ * element.torque;
      }
    }
  }

  void control(const ControlInput& input, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    const Index n = v_tau.size();
    const auto size = static_cast<std::size_t>(n);
    static_cast<void>(dynamics_.set_state({input.q.data(), size}, {input.qd.data(), size}));
    v_tau = offset_;
    for (Index i = 0; i < n; ++i) {
      double tau = dynamics_.N()[static_cast<std::size_t>(i)];
      for (Index j = 0; j < n; ++j) {
        tau += dynamics_.M(i, j) * acceleration(input, j);
      }
      v_tau += tau * signal_.col(i) + input.qd[i] * viscous_.col(i);
    }
    for (const DryFriction& element : dry_friction_) {
      const double speed = element.direction.dot(input.qd);
      const double part = std::tanh(element.direction.dot(input.qd_r) / coulomb_velocity_);
      v_tau += (element.dry(part > 0.0, speed, part) + element.viscous(speed > 0.0, speed)) * element.torque;
    }
    v_tau = v_tau.cwiseMin(v_tau_max_).cwiseMax(-v_tau_max_);
  }

  [[nodiscard]] ControlDescription description() const override {
    return {.law = "computed torque", .gains = {{"k_p", k_p_}, {"k_d", k_d_}}};
  }

 private:
  [[nodiscard]] double acceleration(const ControlInput& input, Index j) const {
    return input.qdd_r[j] + k_d_[j] * (input.qd_r[j] - input.qd[j]) + k_p_[j] * (input.q_r[j] - input.q[j]);
  }

  mutable Dynamics<double> dynamics_;  // scratch
  Vector k_p_;
  Vector k_d_;
  Matrix signal_;  // G⁻¹, which all that follows is multiplied with
  Matrix viscous_;
  Vector offset_;
  std::vector<DryFriction> dry_friction_;
  double coulomb_velocity_;
  Vector v_tau_max_;
};

}  // namespace

std::optional<std::string> ComputedTorqueControl::complaint(const Robot& robot) const {
  using namespace detail;
  const Index poles = omega_n.size() + zeta.size();
  if (auto complaint = one_form(poles, k_p.size() + k_d.size(), "omega_n and zeta", "k_p and k_d")) {
    return complaint;
  }
  if (auto complaint = poles > 0 ? first({positive(robot, "omega_n", omega_n), positive(robot, "zeta", zeta)})
                                 : first({positive(robot, "k_p", k_p), positive(robot, "k_d", k_d)})) {
    return complaint;
  }
  if (model && model->size() != robot.size()) {
    return "the model has " + counted(model->size(), "joint") + ", the robot has " +
           std::to_string(robot.size());
  }
  if (!(coulomb_velocity > 0.0) || !std::isfinite(coulomb_velocity)) {
    return "coulomb_velocity is " + number(coulomb_velocity) + ", must be positive and finite";
  }
  return optional_positive(robot, "v_tau_max", v_tau_max);
}

std::unique_ptr<ControlLaw> ComputedTorqueControl::operator()(const Plant& plant) const {
  detail::require("ComputedTorqueControl", complaint(plant.robot));
  return std::make_unique<ComputedTorqueLaw>(*this, plant, model ? *model : plant.model);
}

}  // namespace rivid
