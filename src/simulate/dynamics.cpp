#include "rivid/simulate/dynamics.hpp"

#include <Eigen/Eigenvalues>
#include <string>
#include <string_view>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

template class Dynamics<double>;

namespace {

using Values = Eigen::Ref<const Vector>;

void require(std::string_view who, std::string_view what, const Values& x, const DynamicModel& model) {
  if (x.size() != model.size()) {
    throw InputError(std::string(who) + ": " + std::string(what) + " has " + std::to_string(x.size()) +
                     " values, the robot has " + std::to_string(model.size()) + " joints");
  }
}

std::span<const double> span_of(const Values& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

Matrix dense(const Dynamics<double>& dynamics) {
  const Index n = dynamics.size();
  return Matrix::NullaryExpr(n, n, [&](Index i, Index j) { return dynamics.M(i, j); });
}

Vector N_of(const Dynamics<double>& dynamics) { return Vector::Map(dynamics.N().data(), dynamics.size()); }

}  // namespace

Matrix mass_matrix(const DynamicModel& model, const Values& q) {
  require("mass_matrix", "q", q, model);
  Dynamics<double> dynamics(model);
  static_cast<void>(dynamics.set_state(span_of(q), span_of(Vector::Zero(q.size()))));
  return dense(dynamics);
}

Vector bias(const DynamicModel& model, const Values& q, const Values& qd) {
  require("bias", "q", q, model);
  require("bias", "qd", qd, model);
  Dynamics<double> dynamics(model);
  static_cast<void>(dynamics.set_state(span_of(q), span_of(qd)));
  return N_of(dynamics);
}

Vector friction_torque(const DynamicModel& model, const Values& qd) {
  require("friction_torque", "qd", qd, model);
  Vector tau = model.viscous() * qd + model.offset();
  for (const DryFriction& element : model.dry_friction()) {
    const double speed = element.direction.dot(qd);
    if (speed > 0.0) {
      tau += element.torque * (element.Fc_plus + element.Fv_plus * speed);
    } else if (speed < 0.0) {
      tau += element.torque * (-element.Fc_minus + element.Fv_minus * speed);
    }
  }
  return tau;
}

Vector inverse_dynamics(const DynamicModel& model, const Values& q, const Values& qd, const Values& qdd) {
  require("inverse_dynamics", "q", q, model);
  require("inverse_dynamics", "qd", qd, model);
  require("inverse_dynamics", "qdd", qdd, model);
  Dynamics<double> dynamics(model);
  static_cast<void>(dynamics.set_state(span_of(q), span_of(qd)));
  return dense(dynamics) * qdd + N_of(dynamics) + friction_torque(model, qd);
}

Vector direct_dynamics(const DynamicModel& model, const Values& q, const Values& qd, const Values& tau) {
  require("direct_dynamics", "q", q, model);
  require("direct_dynamics", "qd", qd, model);
  require("direct_dynamics", "tau", tau, model);
  Dynamics<double> dynamics(model);
  if (!dynamics.set_state(span_of(q), span_of(qd))) {
    const auto joint = static_cast<std::size_t>(dynamics.failed_joint());
    throw NumericsError("direct_dynamics: M(q) is not positive definite, its smallest eigenvalue is " +
                        number(smallest_eigenvalue(model, q), 3) + "; joint \"" + model.joints()[joint].name +
                        "\" would have no positive inertia while those behind it are free");
  }
  Vector qdd = tau - N_of(dynamics) - friction_torque(model, qd);
  dynamics.solve({qdd.data(), static_cast<std::size_t>(qdd.size())});
  return qdd;
}

double smallest_eigenvalue(const DynamicModel& model, const Values& q) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(mass_matrix(model, q), Eigen::EigenvaluesOnly)
      .eigenvalues()
      .minCoeff();
}

}  // namespace rivid
