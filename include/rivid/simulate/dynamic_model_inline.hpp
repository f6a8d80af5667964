#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/chain.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/text.hpp"

// What dynamic_model.hpp declares, for users of rivid::headers; rivid::rivid has it in its archive.
namespace rivid {

namespace detail {

inline std::string parameter_name(ParameterKind kind, Index joint) {
  return StandardParameter{kind, static_cast<int>(joint)}.name();
}

// Adds `value` times the weights of a coupled parameter; row: the joint that feels it, column: whose motion
// it is.
inline void add(Matrix& A, std::span<const CoupledEntry> entries, double value) {
  for (const CoupledEntry& entry : entries) {
    for (const CoupledEntry::Term& term : entry.terms) {
      A(static_cast<Index>(entry.joint), static_cast<Index>(term.joint)) += value * term.weight;
    }
  }
}

// Friction of one direction of motion and of the other.
struct Directions {
  double plus = 0.0;
  double minus = 0.0;

  [[nodiscard]] double mean() const { return 0.5 * (plus + minus); }
  [[nodiscard]] bool drive() const { return plus < 0.0 || minus < 0.0; }
};

inline constexpr auto at_speed = static_cast<std::size_t>(Basis::speed);
inline constexpr auto at_sign = static_cast<std::size_t>(Basis::sign);

// Sums up the parameters of a robot before signs are looked at.
struct Sums {
  Sums(Index n, std::size_t links)
      : rotor(Matrix::Zero(n, n)),
        viscous(Matrix::Zero(n, n)),
        single_signs(Matrix::Zero(n, n)),
        offset(Vector::Zero(n)),
        friction(static_cast<std::size_t>(n)),
        inertials(links, Inertial::Zero()) {}

  void take(const Robot& robot, const StandardParameter& parameter, double value);
  void take_friction(const Robot& robot, const StandardParameter& parameter, double value);

  Matrix rotor;
  Matrix viscous;
  Matrix single_signs;  // torque of joint i per sign of q̇_k
  Vector offset;
  // By Basis; of Basis::speed that which differs by direction alone.
  std::vector<std::array<Directions, basis_rows.size()>> friction;
  std::vector<Inertial> inertials;  // in frames j
  struct Motor {
    const Coupling* coupling;
    double Fcm;
  };
  std::vector<Motor> motors;  // with the sign of their own velocity
};

inline const Coupling& coupling_of(const Robot& robot, int motor) {
  return *std::ranges::find(robot.couplings, motor, &Coupling::motor);
}

inline void Sums::take(const Robot& robot, const StandardParameter& parameter, double value) {
  const Index j = parameter.joint;
  switch (role(parameter.kind)) {
    case Role::inertial: {
      const auto at = static_cast<std::size_t>(j);
      const InertialColumn column = inertial_column(robot.chain.links[at], parameter.kind);
      inertials[at][column.index] = column.sign * value;
      break;
    }
    case Role::rotor: {
      const bool tied = std::ranges::any_of(robot.couplings, [&](const Coupling& coupling) {
        return coupling.motor == j && coupling.inertia == Coupling::Inertia::tied;
      });
      if (tied || about(parameter.kind).coupled) {
        add(rotor, coupled_entries(coupling_of(robot, parameter.joint), parameter.kind, robot.size()), value);
      } else {
        rotor(j, j) += value;
      }
      break;
    }
    case Role::viscous:
    case Role::dry:
    case Role::constant:
      take_friction(robot, parameter, value);
      break;
  }
}

inline void Sums::take_friction(const Robot& robot, const StandardParameter& parameter, double value) {
  const Index j = parameter.joint;
  const KindRow& row = about(parameter.kind);
  if (row.coupled) {
    const Coupling& coupling = coupling_of(robot, parameter.joint);
    if (row.basis == Basis::sign && coupling.coulomb == Coupling::Coulomb::sum) {
      motors.push_back({&coupling, value});
    } else {
      add(row.basis == Basis::sign ? single_signs : viscous,
          coupled_entries(coupling, parameter.kind, robot.size()), value);
    }
  } else if (row.basis == Basis::one) {
    offset[j] += value;
  } else if (row.basis == Basis::speed && row.direction == Direction::both) {
    viscous(j, j) += value;
  } else {
    Directions& to = friction[static_cast<std::size_t>(j)][static_cast<std::size_t>(row.basis)];
    to.plus += row.direction != Direction::negative ? value : 0.0;
    to.minus += row.direction != Direction::positive ? value : 0.0;
  }
}

// Nearest positive semidefinite matrix; returns whether that was another one.
inline bool clamp_eigenvalues(Matrix& A) {
  const auto [values, vectors] = jacobi_eigen(A);
  const double rounding = 1e-14 * values.cwiseAbs().maxCoeff();
  bool clamped = false;
  for (Index k = 0; k < values.size(); ++k) {
    if (values[k] < -rounding) {
      const Vector v = vectors.col(k);
      A -= values[k] * v * v.transpose();
      clamped = true;
    }
  }
  return clamped;
}

inline bool has(Friction law, ParameterKind kind) { return std::ranges::count(parameters(law), kind) > 0; }

// Positive semidefinite viscous friction, and the names of what had to change for it.
inline std::vector<std::string> clamp_viscous(Matrix& viscous, const Robot& robot, const Sums& sums) {
  const Matrix before = viscous;
  std::vector<std::string> names;
  if (!clamp_eigenvalues(viscous)) {
    return names;
  }
  const Matrix change = (viscous - before).cwiseAbs();
  const double rounding = 1e-12 * before.cwiseAbs().maxCoeff();
  for (Index j = 0; j < robot.size(); ++j) {
    const auto at = static_cast<std::size_t>(j);
    // Of an asymmetric law, the direction that has nothing beside what is in the matrix.
    for (const ParameterKind kind :
         {ParameterKind::Fv,
          sums.friction[at][at_speed].plus > 0.0 ? ParameterKind::Fv_minus : ParameterKind::Fv_plus}) {
      if (change(j, j) > rounding && has(robot.joints[at].friction, kind)) {
        names.push_back(parameter_name(kind, j));
      }
    }
  }
  for (const Coupling& coupling : robot.couplings) {
    const bool changed =
        std::ranges::any_of(coupling.joints, [&](int k) { return change(coupling.motor, k) > rounding; });
    if (coupling.viscous && changed) {
      names.push_back(parameter_name(ParameterKind::Fvm, coupling.motor));
    }
  }
  return names;
}

// Whether all that a law has beside Fv is Fc and off.
inline bool follows_one_sign(Friction law) {
  return std::ranges::all_of(parameters(law), [](ParameterKind kind) {
    const KindRow& row = about(kind);
    return row.direction == Direction::both &&
           (row.basis == Basis::speed || row.basis == Basis::sign || row.basis == Basis::one);
  });
}

// A gear whose friction eats more of its load can not be driven by it, and a simulation would have no unique
// motion.
inline constexpr double largest_load = 0.95;

// Friction without what would drive, and the names of that. Directions of dry friction may be shifted by an
// offset.
inline std::vector<std::string> clamp_friction(Sums& sums, Friction law, Index joint) {
  std::vector<std::string> names;
  for (const BasisRow& row : basis_rows) {
    Directions& own = sums.friction[static_cast<std::size_t>(joint)][static_cast<std::size_t>(row.basis)];
    if (row.basis == Basis::load && own.plus > largest_load) {
      own = {largest_load, largest_load};
      names.push_back(parameter_name(ParameterKind::Fl, joint));
    }
    if (!own.drive()) {
      continue;
    }
    const Directions before = own;
    if (row.basis == Basis::sign) {
      sums.offset[joint] += 0.5 * (own.plus - own.minus);
      own = {std::max(own.mean(), 0.0), std::max(own.mean(), 0.0)};
    } else {
      own = {std::max(own.plus, 0.0), std::max(own.minus, 0.0)};
    }
    for (const ParameterKind kind : parameters(law)) {
      const KindRow& k = about(kind);
      const double value = k.direction == Direction::negative ? before.minus : before.plus;
      const bool brakes = k.bound == Bound::mean_zero && before.mean() >= 0.0;
      if (k.basis == row.basis && value < 0.0 && !brakes) {
        names.push_back(parameter_name(kind, joint));
      }
    }
  }
  return names;
}

inline std::string fault_of(const Robot& robot, const Eigen::Ref<const Vector>& chi_st,
                            std::span<const StandardParameter> parameters) {
  if (auto complaint = robot.complaint()) {
    return *complaint;
  }
  if (chi_st.size() != static_cast<Index>(parameters.size())) {
    return "chi_st has " + std::to_string(chi_st.size()) + " values, the robot has " +
           std::to_string(parameters.size()) + " standard parameters";
  }
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = chi_st[static_cast<Index>(i)];
    if (!std::isfinite(value)) {
      return parameters[i].name() + " is " + number(value) + ", must be finite";
    }
  }
  return {};
}

inline Vector standard_of(const Robot& robot, const BaseParameters& base,
                          const Eigen::Ref<const Vector>& chi) {
  const auto same = [](const StandardParameter& a, const StandardParameter& b) {
    return a.kind == b.kind && a.joint == b.joint;
  };
  if (!std::ranges::equal(base.standard, robot.standard_parameters(), same)) {
    throw InputError("DynamicModel: the base parameters are those of another robot than \"" + robot.name +
                     "\"; take base_parameters(robot)");
  }
  return base.to_standard(chi);
}

// The friction of a joint that is not in the viscous matrix.
//
// single_signs: torques on all joints that follow the sign of this joint's velocity, beside its own
inline std::optional<DryFriction> element(const Joint& joint, Index k, const Sums& sums,
                                          Vector single_signs) {
  DryFriction out{joint.name, Vector::Unit(single_signs.size(), k), {}, {}, 0.0, 0.0, joint.sign_speed, 0.0};
  const auto& own = sums.friction[static_cast<std::size_t>(k)];
  for (const BasisRow& row : basis_rows) {
    const Directions& c = own[static_cast<std::size_t>(row.basis)];
    if (row.basis == Basis::load) {
      out.load = c.plus;
    } else if (c.plus > 0.0 || c.minus > 0.0) {
      out.terms.push_back({row.basis, c.plus, c.minus});
    }
  }
  if (out.terms.empty() && out.load == 0.0) {
    return std::nullopt;
  }
  out.Fc_plus = out.dry(true, 0.0, 1.0);
  out.Fc_minus = -out.dry(false, 0.0, -1.0);
  // Only the sign alone is coupled: its two coefficients are the same.
  out.torque = single_signs.isZero(0.0) ? std::move(single_signs) : Vector(single_signs / out.Fc_plus);
  out.torque[k] = 1.0;
  return out;
}

inline void require_values(std::string_view who, std::string_view what, const Eigen::Ref<const Vector>& x,
                           const DynamicModel& model) {
  if (x.size() != model.size()) {
    throw InputError(std::string(who) + ": " + std::string(what) + " has " + std::to_string(x.size()) +
                     " values, the robot has " + std::to_string(model.size()) + " joints");
  }
}

inline std::span<const double> span_of(const Eigen::Ref<const Vector>& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

inline Matrix dense(const Dynamics<double>& dynamics) {
  const Index n = dynamics.size();
  return Matrix::NullaryExpr(n, n, [&](Index i, Index j) { return dynamics.M(i, j); });
}

inline Vector bias_of(const Dynamics<double>& dynamics) {
  return Vector::Map(dynamics.N().data(), dynamics.size());
}

}  // namespace detail

RIVID_INLINE DynamicModel::DynamicModel(const Robot& robot, const Eigen::Ref<const Vector>& chi_st)
    : joints_(robot.joints) {
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  if (const std::string fault = detail::fault_of(robot, chi_st, parameters); !fault.empty()) {
    throw InputError("DynamicModel: " + fault);
  }
  const Index n = robot.size();
  detail::Sums sums(n, robot.chain.links.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    sums.take(robot, parameters[i], chi_st[static_cast<Index>(i)]);
  }
  // What both directions of an asymmetric law have is viscous friction like any other: the coupled friction
  // of a motor has its diagonal there.
  for (Index j = 0; j < n; ++j) {
    detail::Directions& Fv = sums.friction[static_cast<std::size_t>(j)][detail::at_speed];
    const double common = std::min(Fv.plus, Fv.minus);
    sums.viscous(j, j) += common;
    Fv = {Fv.plus - common, Fv.minus - common};
  }
  clamped_ = detail::clamp_viscous(sums.viscous, robot, sums);
  for (Index k = 0; k < n; ++k) {
    const Joint& joint = joints_[static_cast<std::size_t>(k)];
    const Vector torque = sums.single_signs.col(k);
    if (!torque.isZero(0.0) && !detail::follows_one_sign(joint.friction)) {
      throw InputError("DynamicModel: joint \"" + joint.name + "\" has " + std::string(name(joint.friction)) +
                       " friction, and a coupled motor follows the sign of its velocity; take "
                       "symmetric friction or coulomb = \"sum\"");
    }
    detail::Directions& Fc = sums.friction[static_cast<std::size_t>(k)][detail::at_sign];
    Fc = {Fc.plus + torque[k], Fc.minus + torque[k]};
    std::ranges::move(detail::clamp_friction(sums, joint.friction, k), std::back_inserter(clamped_));
    if (auto dry = detail::element(joint, k, sums, torque)) {
      data_.dry_friction.push_back(std::move(*dry));
    }
  }
  for (const detail::Sums::Motor& motor : sums.motors) {
    if (motor.Fcm < 0.0) {
      clamped_.push_back(detail::parameter_name(ParameterKind::Fcm, motor.coupling->motor));
    } else if (motor.Fcm > 0.0) {
      const Vector c = motor.coupling->row(n);
      const Joint& joint = joints_[static_cast<std::size_t>(motor.coupling->motor)];
      data_.dry_friction.push_back({"motor of " + joint.name,
                                    c,
                                    c,
                                    {{Basis::sign, motor.Fcm, motor.Fcm}},
                                    motor.Fcm,
                                    motor.Fcm,
                                    joint.sign_speed,
                                    0.0});
    }
  }
  data_.chain = robot.chain;
  for (const Joint& joint : joints_) {
    data_.names.push_back(joint.name);
  }
  data_.inertials = std::move(sums.inertials);
  data_.rotor = std::move(sums.rotor);
  data_.viscous = std::move(sums.viscous);
  data_.offset = std::move(sums.offset);
}

RIVID_INLINE DynamicModel::DynamicModel(const Robot& robot, const BaseParameters& base,
                                        const Eigen::Ref<const Vector>& chi)
    : DynamicModel(robot, detail::standard_of(robot, base, chi)) {}

RIVID_INLINE Matrix mass_matrix(const DynamicModel& model, const Eigen::Ref<const Vector>& q) {
  detail::require_values("mass_matrix", "q", q, model);
  Dynamics<double> dynamics(model);
  static_cast<void>(dynamics.set_state(detail::span_of(q), detail::span_of(Vector::Zero(q.size()))));
  return detail::dense(dynamics);
}

RIVID_INLINE Vector bias(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                         const Eigen::Ref<const Vector>& qd) {
  detail::require_values("bias", "q", q, model);
  detail::require_values("bias", "qd", qd, model);
  Dynamics<double> dynamics(model);
  static_cast<void>(dynamics.set_state(detail::span_of(q), detail::span_of(qd)));
  return detail::bias_of(dynamics);
}

RIVID_INLINE Vector friction_torque(const DynamicModel& model, const Eigen::Ref<const Vector>& qd) {
  detail::require_values("friction_torque", "qd", qd, model);
  Vector tau = model.viscous() * qd + model.offset();
  for (const DryFriction& element : model.dry_friction()) {
    tau += element.torque * element.lambda(element.direction.dot(qd));
  }
  return tau;
}

RIVID_INLINE Vector inverse_dynamics(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                                     const Eigen::Ref<const Vector>& qd,
                                     const Eigen::Ref<const Vector>& qdd) {
  detail::require_values("inverse_dynamics", "q", q, model);
  detail::require_values("inverse_dynamics", "qd", qd, model);
  detail::require_values("inverse_dynamics", "qdd", qdd, model);
  Dynamics<double> dynamics(model);
  static_cast<void>(dynamics.set_state(detail::span_of(q), detail::span_of(qd)));
  const Vector load = detail::dense(dynamics) * qdd + detail::bias_of(dynamics);
  Vector tau = load + friction_torque(model, qd);
  for (const DryFriction& element : model.dry_friction()) {
    if (element.load > 0.0) {
      const Index j = element.joint();
      tau[j] += element.load * std::abs(load[j]) * sign(qd[j], element.sign_speed);
    }
  }
  return tau;
}

RIVID_INLINE Vector direct_dynamics(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                                    const Eigen::Ref<const Vector>& qd, const Eigen::Ref<const Vector>& tau) {
  detail::require_values("direct_dynamics", "q", q, model);
  detail::require_values("direct_dynamics", "qd", qd, model);
  detail::require_values("direct_dynamics", "tau", tau, model);
  Dynamics<double> dynamics(model);
  if (!dynamics.set_state(detail::span_of(q), detail::span_of(qd))) {
    const auto joint = static_cast<std::size_t>(dynamics.failed_joint());
    throw NumericsError("direct_dynamics: M(q) is not positive definite, its smallest eigenvalue is " +
                        number(smallest_eigenvalue(model, q), 3) + "; joint \"" + model.joints()[joint].name +
                        "\" would have no positive inertia while those behind it are free");
  }
  Vector qdd = tau - friction_torque(model, qd);
  for (const DryFriction& element : model.dry_friction()) {
    if (element.load > 0.0) {
      const Index j = element.joint();
      qdd[j] = DryFriction::carried(qdd[j], element.load * sign(qd[j], element.sign_speed));
    }
  }
  qdd -= detail::bias_of(dynamics);
  dynamics.solve({qdd.data(), static_cast<std::size_t>(qdd.size())});
  return qdd;
}

RIVID_INLINE double smallest_eigenvalue(const DynamicModel& model, const Eigen::Ref<const Vector>& q) {
  return detail::jacobi_eigen(mass_matrix(model, q)).values.minCoeff();
}

}  // namespace rivid
