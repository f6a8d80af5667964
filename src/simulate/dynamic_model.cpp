#include "rivid/simulate/dynamic_model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using enum ParameterKind;

std::string parameter_name(ParameterKind kind, Index joint) {
  return StandardParameter{kind, static_cast<int>(joint)}.name();
}

// Adds `value` times the weights of a coupled parameter; row: the joint that feels it, column: whose motion it is.
void add(Matrix& A, std::span<const CoupledEntry> entries, double value) {
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

constexpr auto at_speed = static_cast<std::size_t>(Basis::speed);
constexpr auto at_sign = static_cast<std::size_t>(Basis::sign);

// Sums up the parameters of a robot before signs are looked at.
struct Sums {
  explicit Sums(Index n)
      : rotor(Matrix::Zero(n, n)),
        viscous(Matrix::Zero(n, n)),
        single_signs(Matrix::Zero(n, n)),
        offset(Vector::Zero(n)),
        friction(static_cast<std::size_t>(n)),
        inertials(static_cast<std::size_t>(n), Inertial::Zero()) {}

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

const Coupling& coupling_of(const Robot& robot, int motor) {
  return *std::ranges::find(robot.couplings, motor, &Coupling::motor);
}

void Sums::take(const Robot& robot, const StandardParameter& parameter, double value) {
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

void Sums::take_friction(const Robot& robot, const StandardParameter& parameter, double value) {
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
bool clamp_eigenvalues(Matrix& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A);
  const Vector& values = eigen.eigenvalues();
  const double rounding = 1e-14 * values.cwiseAbs().maxCoeff();
  bool clamped = false;
  for (Index k = 0; k < values.size(); ++k) {
    if (values[k] < -rounding) {
      A -= values[k] * eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).transpose();
      clamped = true;
    }
  }
  return clamped;
}

bool has(Friction law, ParameterKind kind) { return std::ranges::count(parameters(law), kind) > 0; }

// Positive semidefinite viscous friction, and the names of what had to change for it.
std::vector<std::string> clamp_viscous(Matrix& viscous, const Robot& robot, const Sums& sums) {
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
    for (const ParameterKind kind : {Fv, sums.friction[at][at_speed].plus > 0.0 ? Fv_minus : Fv_plus}) {
      if (change(j, j) > rounding && has(robot.joints[at].friction, kind)) {
        names.push_back(parameter_name(kind, j));
      }
    }
  }
  for (const Coupling& coupling : robot.couplings) {
    const bool changed =
        std::ranges::any_of(coupling.joints, [&](int k) { return change(coupling.motor, k) > rounding; });
    if (coupling.viscous && changed) {
      names.push_back(parameter_name(Fvm, coupling.motor));
    }
  }
  return names;
}

// Whether all that a law has beside Fv is Fc and off.
bool follows_one_sign(Friction law) {
  return std::ranges::all_of(parameters(law), [](ParameterKind kind) {
    const KindRow& row = about(kind);
    return row.direction == Direction::both &&
           (row.basis == Basis::speed || row.basis == Basis::sign || row.basis == Basis::one);
  });
}

// Friction without what would drive, and the names of that. Directions of dry friction may be shifted by an offset.
std::vector<std::string> clamp_friction(Sums& sums, Friction law, Index joint) {
  std::vector<std::string> names;
  for (const BasisRow& row : basis_rows) {
    Directions& own = sums.friction[static_cast<std::size_t>(joint)][static_cast<std::size_t>(row.basis)];
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

std::string fault_of(const Robot& robot, const Eigen::Ref<const Vector>& chi_st,
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

Vector standard_of(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi) {
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
std::optional<DryFriction> element(const Joint& joint, Index k, const Sums& sums, Vector single_signs) {
  DryFriction out{joint.name, Vector::Unit(single_signs.size(), k), {}, {}, 0.0, 0.0, joint.sign_speed};
  const auto& own = sums.friction[static_cast<std::size_t>(k)];
  for (const BasisRow& row : basis_rows) {
    const Directions& c = own[static_cast<std::size_t>(row.basis)];
    if (c.plus > 0.0 || c.minus > 0.0) {
      out.terms.push_back({row.basis, c.plus, c.minus});
    }
  }
  if (out.terms.empty()) {
    return std::nullopt;
  }
  out.Fc_plus = out.dry(true, 0.0, 1.0);
  out.Fc_minus = -out.dry(false, 0.0, -1.0);
  // Only the sign alone is coupled: its two coefficients are the same.
  out.torque = single_signs.isZero(0.0) ? std::move(single_signs) : Vector(single_signs / out.Fc_plus);
  out.torque[k] = 1.0;
  return out;
}

}  // namespace

DynamicModel::DynamicModel(const Robot& robot, const Eigen::Ref<const Vector>& chi_st)
    : chain_(robot.chain), joints_(robot.joints) {
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  if (const std::string fault = fault_of(robot, chi_st, parameters); !fault.empty()) {
    throw InputError("DynamicModel: " + fault);
  }
  const Index n = robot.size();
  Sums sums(n);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    sums.take(robot, parameters[i], chi_st[static_cast<Index>(i)]);
  }
  // What both directions of an asymmetric law have is viscous friction like any other: the coupled friction of a motor
  // has its diagonal there.
  for (Index j = 0; j < n; ++j) {
    Directions& Fv = sums.friction[static_cast<std::size_t>(j)][at_speed];
    const double common = std::min(Fv.plus, Fv.minus);
    sums.viscous(j, j) += common;
    Fv = {Fv.plus - common, Fv.minus - common};
  }
  clamped_ = clamp_viscous(sums.viscous, robot, sums);
  for (Index k = 0; k < n; ++k) {
    const Joint& joint = joints_[static_cast<std::size_t>(k)];
    const Vector torque = sums.single_signs.col(k);
    if (!torque.isZero(0.0) && !follows_one_sign(joint.friction)) {
      throw InputError("DynamicModel: joint \"" + joint.name + "\" has " + std::string(name(joint.friction)) +
                       " friction, and a coupled motor follows the sign of its velocity; take "
                       "symmetric friction or coulomb = \"sum\"");
    }
    Directions& Fc = sums.friction[static_cast<std::size_t>(k)][at_sign];
    Fc = {Fc.plus + torque[k], Fc.minus + torque[k]};
    std::ranges::move(clamp_friction(sums, joint.friction, k), std::back_inserter(clamped_));
    if (auto dry = element(joint, k, sums, torque)) {
      dry_friction_.push_back(std::move(*dry));
    }
  }
  for (const Sums::Motor& motor : sums.motors) {
    if (motor.Fcm < 0.0) {
      clamped_.push_back(parameter_name(Fcm, motor.coupling->motor));
    } else if (motor.Fcm > 0.0) {
      const Vector c = motor.coupling->row(n);
      const Joint& joint = joints_[static_cast<std::size_t>(motor.coupling->motor)];
      dry_friction_.push_back({"motor of " + joint.name,
                               c,
                               c,
                               {{Basis::sign, motor.Fcm, motor.Fcm}},
                               motor.Fcm,
                               motor.Fcm,
                               joint.sign_speed});
    }
  }
  inertials_ = std::move(sums.inertials);
  rotor_ = std::move(sums.rotor);
  viscous_ = std::move(sums.viscous);
  offset_ = std::move(sums.offset);
}

DynamicModel::DynamicModel(const Robot& robot, const BaseParameters& base,
                           const Eigen::Ref<const Vector>& chi)
    : DynamicModel(robot, standard_of(robot, base, chi)) {}

}  // namespace rivid
