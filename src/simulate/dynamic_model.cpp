#include "rivid/simulate/dynamic_model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
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
};

// Sums up the parameters of a robot before signs are looked at.
struct Sums {
  explicit Sums(Index n)
      : rotor(Matrix::Zero(n, n)),
        viscous(Matrix::Zero(n, n)),
        single_signs(Matrix::Zero(n, n)),
        offset(Vector::Zero(n)),
        Fv(static_cast<std::size_t>(n)),
        Fc(static_cast<std::size_t>(n)),
        inertials(static_cast<std::size_t>(n), Inertial::Zero()) {}

  void take(const Robot& robot, const StandardParameter& parameter, double value);

  Matrix rotor;
  Matrix viscous;
  Matrix single_signs;  // torque of joint i per sign of q̇_k
  Vector offset;
  std::vector<Directions> Fv;  // asymmetric laws alone
  std::vector<Directions> Fc;
  std::vector<Inertial> inertials;  // in frames j
  struct Motor {
    const Coupling* coupling;
    double Fcm;
  };
  std::vector<Motor> motors;  // with the sign of their own velocity
};

void Sums::take(const Robot& robot, const StandardParameter& parameter, double value) {
  const Index n = robot.size();
  const Index j = parameter.joint;
  const auto at = static_cast<std::size_t>(j);
  const auto coupling = std::ranges::find(robot.couplings, parameter.joint, &Coupling::motor);
  const auto entries = [&] { return coupled_entries(*coupling, parameter.kind, n); };
  switch (parameter.kind) {
    case Ia:
      if (coupling != robot.couplings.end() && coupling->inertia == Coupling::Inertia::tied) {
        add(rotor, entries(), value);
      } else {
        rotor(j, j) += value;
      }
      break;
    case Iam:
      add(rotor, entries(), value);
      break;
    case ParameterKind::Fv:
      viscous(j, j) += value;
      break;
    case Fvm:
      add(viscous, entries(), value);
      break;
    case ParameterKind::Fc:
      Fc[at] = {value, value};
      break;
    case Fcm:
      if (coupling->coulomb == Coupling::Coulomb::sum) {
        motors.push_back({&*coupling, value});
      } else {
        add(single_signs, entries(), value);
      }
      break;
    case off:
      offset[j] = value;
      break;
    case Fv_plus:
      Fv[at].plus = value;
      break;
    case Fv_minus:
      Fv[at].minus = value;
      break;
    case Fc_plus:
      Fc[at].plus = value;
      break;
    case Fc_minus:
      Fc[at].minus = value;
      break;
    default: {
      const InertialColumn column = inertial_column(robot.chain.links[at], parameter.kind);
      inertials[at][column.index] = column.sign * value;
    }
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
std::vector<std::string> clamp_viscous(Matrix& viscous, const Robot& robot, std::span<const Directions> Fv) {
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
    for (const ParameterKind kind : {ParameterKind::Fv, Fv[at].plus > 0.0 ? Fv_minus : Fv_plus}) {
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
  inertials_ = std::move(sums.inertials);
  rotor_ = std::move(sums.rotor);
  viscous_ = std::move(sums.viscous);
  offset_ = std::move(sums.offset);

  // What both directions of an asymmetric law have is viscous friction like any other: the coupled friction of a motor
  // has its diagonal there.
  for (Index j = 0; j < n; ++j) {
    Directions& Fv = sums.Fv[static_cast<std::size_t>(j)];
    const double common = std::min(Fv.plus, Fv.minus);
    viscous_(j, j) += common;
    Fv = {Fv.plus - common, Fv.minus - common};
  }
  clamped_ = clamp_viscous(viscous_, robot, sums.Fv);

  for (Index k = 0; k < n; ++k) {
    const auto joint = static_cast<std::size_t>(k);
    const bool coupled = !sums.single_signs.col(k).isZero(0.0);
    const bool asymmetric = joints_[joint].friction == Friction::asymmetric;
    if (coupled && asymmetric) {
      throw InputError(
          "DynamicModel: joint \"" + joints_[joint].name +
          "\" has asymmetric friction, and a coupled motor follows the sign of its velocity; take "
          "symmetric friction or coulomb = \"sum\"");
    }
    Vector torque = sums.single_signs.col(k);
    Directions Fc = {sums.Fc[joint].plus + torque[k], sums.Fc[joint].minus + torque[k]};
    if (Fc.plus < 0.0 || Fc.minus < 0.0) {
      offset_[k] += 0.5 * (Fc.plus - Fc.minus);
      const double mean = Fc.mean();
      Fc = {std::max(mean, 0.0), std::max(mean, 0.0)};
      for (const ParameterKind kind : {ParameterKind::Fc, sums.Fc[joint].plus < 0.0 ? Fc_plus : Fc_minus}) {
        if (mean < 0.0 && has(joints_[joint].friction, kind)) {
          clamped_.push_back(parameter_name(kind, k));
        }
      }
    }
    const Directions& Fv = sums.Fv[joint];
    if (Fc.mean() > 0.0 || Fv.mean() > 0.0) {
      // Only a symmetric law is coupled: its two coefficients are the same.
      torque = coupled ? Vector(torque / Fc.plus) : Vector(Vector::Zero(n));
      torque[k] = 1.0;
      dry_friction_.push_back({joints_[joint].name, Vector::Unit(n, k), std::move(torque), Fc.plus, Fc.minus,
                               Fv.plus, Fv.minus, joints_[joint].sign_speed});
    }
  }
  for (const Sums::Motor& motor : sums.motors) {
    if (motor.Fcm < 0.0) {
      clamped_.push_back(parameter_name(Fcm, motor.coupling->motor));
    } else if (motor.Fcm > 0.0) {
      const Vector c = motor.coupling->row(n);
      const Joint& joint = joints_[static_cast<std::size_t>(motor.coupling->motor)];
      dry_friction_.push_back(
          {"motor of " + joint.name, c, c, motor.Fcm, motor.Fcm, 0.0, 0.0, joint.sign_speed});
    }
  }
}

DynamicModel::DynamicModel(const Robot& robot, const BaseParameters& base,
                           const Eigen::Ref<const Vector>& chi)
    : DynamicModel(robot, standard_of(robot, base, chi)) {}

}  // namespace rivid
