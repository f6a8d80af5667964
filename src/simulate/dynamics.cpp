#include "rivid/simulate/dynamics.hpp"

#include <Eigen/Eigenvalues>
#include <string>
#include <string_view>

#include "regressor/turn_and_angle.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

template class Dynamics<double>;

namespace {

// Parameters in frame j that joint j turns or slides without showing it, by the rules of Gautier & Khalil (1990).
Inertial unseen(const Inertial& inertial, JointType type) {
  constexpr Index XX = 0, YY = 3, MZ = 8, M = 9;
  Inertial out = Inertial::Zero();
  if (type == JointType::prismatic) {
    out.head<6>() = inertial.head<6>();
  } else {
    out[XX] = out[YY] = inertial[YY];
    out[MZ] = inertial[MZ];
    out[M] = inertial[M];
  }
  return out;
}

struct Bodies {
  Chain chain;
  std::vector<Inertial> inertials;
};

// The same robot in frames that are turned about their own z axes, so that the z axis of each lies in the y-z plane of the
// one before: no joint notices, and rotations between frames become R = Rx(α) Rz(θ).
Bodies turned_about_z(const DynamicModel& model) {
  Bodies out{model.chain(), model.inertials()};
  for (std::size_t j = 0; j < out.chain.links.size(); ++j) {
    Chain::Link& link = out.chain.links[j];
    if (detail::turn_and_angle(link.R).turn != detail::Turn::any) {
      continue;
    }
    // Frame j−1 turns until the axis of joint j has no x component.
    const Eigen::Vector3d z = link.R.col(2);
    const double length = z.head<2>().norm();
    const double c = z.y() / length;
    const double s = -z.x() / length;
    const Eigen::Matrix3d turn = (Eigen::Matrix3d() << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0).finished();
    link.R = turn.transpose() * link.R;
    link.R(0, 2) = 0.0;
    link.p = turn.transpose() * link.p;
    if (j == 0) {
      out.chain.gravity = turn.transpose() * out.chain.gravity;
    } else {
      out.chain.links[j - 1].R *= turn;
      Inertial& inertial = out.inertials[j - 1];
      inertial = transformed(inertial, turn.transpose(), Eigen::Vector3d::Zero());
    }
  }
  return out;
}

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

Vector bias_of(const Dynamics<double>& dynamics) { return Vector::Map(dynamics.N().data(), dynamics.size()); }

}  // namespace

detail::DynamicsTables::DynamicsTables(const DynamicModel& model) {
  auto [chain, inertials] = turned_about_z(model);
  const std::size_t n = chain.links.size();
  links.resize(n);
  bool with_mass = false;
  for (std::size_t j = n; j-- > 0;) {
    const Chain::Link& from = chain.links[j];
    DynamicsLink& to = links[j];
    const Inertial moved = unseen(inertials[j], from.type);
    inertials[j] -= moved;
    if (j > 0) {
      inertials[j - 1] += transformed(moved, from.R, from.p);
    }
    Inertial::Map(to.inertial) = inertials[j];

    const TurnAndAngle turn = turn_and_angle(from.R);
    const Eigen::Matrix3d turned = turn.R.transpose();
    Eigen::Matrix3d::Map(to.R) = turned;
    Eigen::Vector3d::Map(to.p) = from.p;
    to.cos_theta = turn.cos_theta;
    to.sin_theta = turn.sin_theta;
    to.shifted_angle = turn.sin_theta != 0.0 || turn.cos_theta != 1.0;
    to.revolute = from.type == JointType::revolute;
    with_mass = with_mass || !to.revolute;
    unsigned offsets = 0;
    for (unsigned k = 0; k < 3; ++k) {
      offsets |= to.p[k] != 0.0 ? 1U << k : 0U;
    }
    to.step = !to.revolute ? prismatic_step : with_mass ? revolute_step : dynamics_step(turn.turn, offsets);
    if (j == 0) {
      Eigen::Vector3d::Map(accel.data()) = turned * -chain.gravity;
    }
  }
  const std::size_t stride = dynamics_stride(n);
  rotor.assign(n * stride, 0.0);
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t k = 0; k <= r; ++k) {
      rotor[r * stride + k] = model.rotor()(static_cast<Index>(n - 1 - r), static_cast<Index>(n - 1 - k));
    }
  }
}

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
  return bias_of(dynamics);
}

Vector friction_torque(const DynamicModel& model, const Values& qd) {
  require("friction_torque", "qd", qd, model);
  Vector tau = model.viscous() * qd + model.offset();
  for (const DryFriction& element : model.dry_friction()) {
    tau += element.torque * element.lambda(element.direction.dot(qd));
  }
  return tau;
}

Vector inverse_dynamics(const DynamicModel& model, const Values& q, const Values& qd, const Values& qdd) {
  require("inverse_dynamics", "q", q, model);
  require("inverse_dynamics", "qd", qd, model);
  require("inverse_dynamics", "qdd", qdd, model);
  Dynamics<double> dynamics(model);
  static_cast<void>(dynamics.set_state(span_of(q), span_of(qd)));
  return dense(dynamics) * qdd + bias_of(dynamics) + friction_torque(model, qd);
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
  Vector qdd = tau - bias_of(dynamics) - friction_torque(model, qd);
  dynamics.solve({qdd.data(), static_cast<std::size_t>(qdd.size())});
  return qdd;
}

double smallest_eigenvalue(const DynamicModel& model, const Values& q) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(mass_matrix(model, q), Eigen::EigenvaluesOnly)
      .eigenvalues()
      .minCoeff();
}

}  // namespace rivid
