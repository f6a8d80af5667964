#include "rivid/simulate/computed_torque.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rivid/simulate/body.hpp"
#include "rivid/text.hpp"
#include "simulate/gains.hpp"

namespace rivid {

namespace {

using detail::FrameMotion;
using detail::Wrench;

class ComputedTorqueLaw final : public ControlLaw {
 public:
  ComputedTorqueLaw(const ComputedTorqueControl& control, const Plant& plant)
      : model_(control.model ? control.model : std::make_shared<const DynamicModel>(plant.model)),
        k_p_(control.k_p),
        k_d_(control.k_d),
        signal_(plant.robot.drive_matrix().inverse()),
        rotor_(signal_ * model_->rotor()),
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
      viscous_ = signal_ * model_->viscous();
      offset_ = signal_ * model_->offset();
      dry_friction_ = model_->dry_friction();
      for (DryFriction& element : dry_friction_) {
        element.torque = signal_ * element.torque;
      }
    }
  }

  void control(const ControlInput& input, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    v_tau = offset_;
    for (Index j = 0; j < v_tau.size(); ++j) {
      v_tau += acceleration(input, j) * rotor_.col(j) + input.qd[j] * viscous_.col(j);
    }
    for (const DryFriction& element : dry_friction_) {
      const double speed = element.direction.dot(input.qd);
      const double part = std::tanh(element.direction.dot(input.qd_r) / coulomb_velocity_);
      const double coulomb = part * (part > 0.0 ? element.Fc_plus : element.Fc_minus);
      const double viscous = speed * (speed > 0.0 ? element.Fv_plus : element.Fv_minus);
      v_tau += (coulomb + viscous) * element.torque;
    }
    static_cast<void>(wrench(0, detail::base_motion<double>(model_->chain()), input, v_tau));
    v_tau = v_tau.cwiseMin(v_tau_max_).cwiseMax(-v_tau_max_);
  }

  [[nodiscard]] ControlDescription description() const override {
    return {.law = "computed torque", .gains = {{"k_p", k_p_}, {"k_d", k_d_}}};
  }

 private:
  [[nodiscard]] double acceleration(const ControlInput& input, Index j) const {
    return input.qdd_r[j] + k_d_[j] * (input.qd_r[j] - input.qd[j]) + k_p_[j] * (input.q_r[j] - input.q[j]);
  }

  // Recursive Newton-Euler: what the links from j on need of the link before them, in its frame, while the signals of
  // their joints are added. Its intermediate results stand in the calls, so that the law itself has no scratch.
  Wrench<double> wrench(Index j, const FrameMotion<double>& before, const ControlInput& input,
                        Eigen::Ref<Vector>& v_tau) const {
    const auto i = static_cast<std::size_t>(j);
    const Chain::Link& link = model_->chain().links[i];
    const detail::Passage<double> passage(link, input.q[j]);
    const FrameMotion<double> motion = passage.carried(before, input.qd[j], acceleration(input, j));
    Wrench<double> sum = detail::Body<double>::of(model_->inertials()[i]).wrench(motion);
    if (j + 1 < model_->size()) {
      sum = sum + wrench(j + 1, motion, input, v_tau);
    }
    v_tau += (link.type == JointType::revolute ? sum.moment.z : sum.force.z) * signal_.col(j);
    return sum.before(passage);
  }

  std::shared_ptr<const DynamicModel> model_;
  Vector k_p_;
  Vector k_d_;
  Matrix signal_;  // G⁻¹, which all that follows is multiplied with
  Matrix rotor_;
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
  const Complaint gains = poles > 0
                              ? first({positive(robot, "omega_n", omega_n), positive(robot, "zeta", zeta)})
                              : first({positive(robot, "k_p", k_p), positive(robot, "k_d", k_d)});
  if (gains) {
    return gains;
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
  return std::make_unique<ComputedTorqueLaw>(*this, plant);
}

}  // namespace rivid
