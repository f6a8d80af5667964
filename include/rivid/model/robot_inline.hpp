#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rivid/model/robot.hpp"
#include "rivid/text.hpp"

// What the headers of this module declare, for users of rivid::headers; rivid::rivid has it in its archive.
namespace rivid {

namespace detail {

// Weights of q̈, q̇ or their signs in the torques: c cᵀ, or what of it the parameter stands for.
inline Matrix weights(const Coupling& coupling, const Vector& c, ParameterKind kind) {
  // Single signs: the motor's friction reaches joint i through c_i, its sign follows that of c_k q̇_k.
  Matrix A = kind == ParameterKind::Fcm ? Matrix(c * c.cwiseSign().transpose()) : Matrix(c * c.transpose());
  if (coupling.terms == Coupling::Terms::cross) {
    A.diagonal().setZero();
  }
  if (kind == ParameterKind::Ia) {
    A(coupling.motor, coupling.motor) = 1.0;  // the joint's own inertia, which it stays to be
  }
  return A;
}

inline CoupledEntry::Quantity quantity(ParameterKind kind) {
  return role(kind) == Role::rotor     ? CoupledEntry::Quantity::acceleration
         : role(kind) == Role::viscous ? CoupledEntry::Quantity::velocity
                                       : CoupledEntry::Quantity::single_signs;
}

inline std::vector<CoupledEntry::Term> terms(const auto& weights) {
  std::vector<CoupledEntry::Term> out;
  for (Index k = 0; k < weights.size(); ++k) {
    if (weights[k] != 0.0) {
      out.push_back({static_cast<std::size_t>(k), weights[k]});
    }
  }
  return out;
}

inline double a_priori(const Robot& robot, const StandardParameter& parameter) {
  const auto j = static_cast<std::size_t>(parameter.joint);
  const auto coupling = [&]() -> const Coupling& {
    return *std::ranges::find(robot.couplings, parameter.joint, &Coupling::motor);
  };
  switch (about(parameter.kind).a_priori) {
    case APriori::inertials:
      return robot.inertials[j][static_cast<Index>(parameter.kind)];
    case APriori::Ia:
      return robot.joints[j].Ia;
    case APriori::Fv:
      return robot.joints[j].Fv;
    case APriori::Fc:
      return robot.joints[j].Fc;
    case APriori::Iam:
      return coupling().Iam;
    case APriori::Fvm:
      return coupling().Fvm;
    case APriori::Fcm:
      return coupling().Fcm;
    case APriori::zero:
      break;
  }
  return 0.0;
}

// Rank of a small matrix by elimination with complete pivoting, to rounding.
inline Index rank_of(Matrix A) {
  const Index n = std::min(A.rows(), A.cols());
  double first = 0.0;
  for (Index k = 0; k < n; ++k) {
    Index row = k;
    Index column = k;
    for (Index j = k; j < A.cols(); ++j) {
      for (Index i = k; i < A.rows(); ++i) {
        if (std::abs(A(i, j)) > std::abs(A(row, column))) {
          row = i;
          column = j;
        }
      }
    }
    A.row(k).swap(A.row(row));
    A.col(k).swap(A.col(column));
    const double pivot = A(k, k);
    first = k == 0 ? std::abs(pivot) : first;
    if (std::abs(pivot) <= static_cast<double>(n) * std::numeric_limits<double>::epsilon() * first) {
      return k;
    }
    for (Index i = k + 1; i < A.rows(); ++i) {
      A.row(i) -= A(i, k) / pivot * A.row(k);
    }
  }
  return n;
}

inline std::string in_words(const Matrix& x) {
  return "(" + std::to_string(x.rows()) + " x " + std::to_string(x.cols()) + ")";
}

inline std::string quoted(const Joint& joint) { return "joint \"" + joint.name + "\""; }

// Joints and ratios of a coupling by themselves.
inline std::optional<std::string> layout_complaint(const Robot& robot, const Coupling& coupling) {
  const auto is_joint = [&](int j) { return j >= 0 && j < robot.size(); };
  if (!is_joint(coupling.motor)) {
    return "motor is joint " + std::to_string(coupling.motor + 1) + " of " + std::to_string(robot.size());
  }
  if (coupling.joints.empty()) {
    return "it names no other joint that turns the motor";
  }
  if (coupling.ratios.size() != coupling.joints.size()) {
    return "it has " + std::to_string(coupling.ratios.size()) + " ratios for " +
           std::to_string(coupling.joints.size()) + " joints";
  }
  for (std::size_t k = 0; k < coupling.joints.size(); ++k) {
    const int j = coupling.joints[k];
    if (!is_joint(j)) {
      return "it is turned by joint " + std::to_string(j + 1) + " of " + std::to_string(robot.size());
    }
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (j == coupling.motor || std::ranges::count(coupling.joints, j) > 1) {
      return quoted(joint) + " is named twice; joints are those beside the motor's own, each once";
    }
    if (!std::isfinite(coupling.ratios[k]) || coupling.ratios[k] == 0.0) {
      return "the ratio of " + quoted(joint) + " is " + number(coupling.ratios[k]) +
             ", must be finite and not zero";
    }
  }
  if (!is_value(coupling.inertia) || !is_value(coupling.coulomb) || !is_value(coupling.terms)) {
    return "inertia, coulomb or terms is none of the values of its enum";
  }
  if (!std::isfinite(coupling.Iam) || !std::isfinite(coupling.Fvm) || !std::isfinite(coupling.Fcm)) {
    return "Iam, Fvm and Fcm must be finite";
  }
  if (coupling.parameters().empty() && coupling.inertia != Coupling::Inertia::tied) {
    return "it has no parameter: inertia, viscous and coulomb are all off";
  }
  return std::nullopt;
}

// What a coupling leaves to the joints' own parameters must have a place there.
inline std::optional<std::string> own_terms_complaint(const Robot& robot, const Coupling& coupling) {
  const bool cross = coupling.terms == Coupling::Terms::cross;
  const auto without = [](const Joint& joint, const char* symbol, const char* remedy) {
    return quoted(joint) + " has no " + symbol +
           ", which the coupling leaves the joint's own share to: " + remedy + ", or terms = \"all\"";
  };
  std::vector<int> members = coupling.joints;
  members.push_back(coupling.motor);
  for (const int j : members) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (coupling.coulomb != Coupling::Coulomb::none && has(joint.friction, Basis::load)) {
      return quoted(joint) +
             " has friction that follows its load, and turns a motor with dry friction of its own: at "
             "rest the two can not be distinguished; take another friction law, or coulomb = \"none\"";
    }
    if (j == coupling.motor && coupling.inertia == Coupling::Inertia::tied && !joint.rotor_inertia) {
      return quoted(joint) + " has no Ia that the coupled inertia could be tied to: give it rotor_inertia";
    }
    if (!cross) {
      continue;
    }
    if (coupling.inertia != Coupling::Inertia::none && !joint.rotor_inertia) {
      return without(joint, "Ia", "give it rotor_inertia");
    }
    if (coupling.viscous && !has(joint.friction, Basis::speed)) {
      return without(joint, "Fv", "give it friction");
    }
    if (coupling.coulomb == Coupling::Coulomb::single && !has(joint.friction, Basis::sign)) {
      return without(joint, "Fc", "give it Coulomb friction");
    }
  }
  return std::nullopt;
}

// Whether two couplings' parameters of one kind move the robot alike; sign(cᵀ q̇) is distinguished by C.
inline bool alike(const Coupling& a, const Coupling& b, ParameterKind kind, Index n) {
  const auto weights = [&](const Coupling& coupling) {
    Matrix A = Matrix::Zero(n, n);
    for (const CoupledEntry& entry : coupled_entries(coupling, kind, n)) {
      for (const CoupledEntry::Term& term : entry.terms) {
        A(static_cast<Index>(entry.joint), static_cast<Index>(term.joint)) = entry.scale * term.weight;
      }
    }
    return Vector(A.reshaped().normalized());
  };
  if (kind == ParameterKind::Fcm && a.coulomb != b.coulomb) {
    return false;
  }
  constexpr double rounding = 1e-12;  // of directions of length 1, 4500 ε
  const Vector u = weights(a);
  const Vector v = weights(b);
  return (u - v).norm() < rounding || (u + v).norm() < rounding;
}

inline std::optional<std::string> couplings_complaint(const Robot& robot) {
  const std::vector<Coupling>& couplings = robot.couplings;
  const Index n = robot.size();
  for (std::size_t a = 0; a < couplings.size(); ++a) {
    const Coupling& coupling = couplings[a];
    const bool known = coupling.motor >= 0 && coupling.motor < n;
    const std::string who =
        "coupling" +
        (known ? " of motor \"" + robot.joints[static_cast<std::size_t>(coupling.motor)].name + "\"" : "") +
        ": ";
    if (const auto complaint = layout_complaint(robot, coupling)) {
      return who + *complaint;
    }
    if (const auto complaint = own_terms_complaint(robot, coupling)) {
      return who + *complaint;
    }
    for (std::size_t b = 0; b < a; ++b) {
      if (couplings[b].motor == coupling.motor) {
        return who + "the motor is described twice";
      }
      for (const ParameterKind kind : coupling.parameters()) {
        if (std::ranges::count(couplings[b].parameters(), kind) > 0 &&
            alike(coupling, couplings[b], kind, n)) {
          const std::string mine = StandardParameter{kind, coupling.motor}.name();
          const std::string other = StandardParameter{kind, couplings[b].motor}.name();
          return (who + mine + " moves the robot just as ")
              .append(other)
              .append(
                  " does, their motors being turned by the same joints: leave one out, or say terms = "
                  "\"all\" for both");
        }
      }
    }
  }
  if (!couplings.empty()) {
    const Index rank = rank_of(coupling_matrix(couplings, n));
    if (rank < n) {
      return "couplings: the matrix from joint to motor velocities is singular, rank " +
             std::to_string(rank) + " of " + std::to_string(n) +
             "; the motors could not move each joint by itself";
    }
  }
  return std::nullopt;
}

inline std::optional<std::string> gear_matrix_complaint(const Robot& robot) {
  const Matrix& R = robot.gear_matrix;
  const Index n = robot.size();
  if (R.size() == 0) {
    return std::nullopt;
  }
  if (R.rows() != n || R.cols() != n) {
    return "gear_matrix is " + in_words(R) + ", must be (" + std::to_string(n) + " x " + std::to_string(n) +
           "): one row a motor, one column a joint";
  }
  if (!R.allFinite()) {
    return "gear_matrix must be finite";
  }
  if (const Index rank = rank_of(R); rank < n) {
    return "gear_matrix is singular, rank " + std::to_string(rank) + " of " + std::to_string(n);
  }
  for (const Joint& joint : robot.joints) {
    if (joint.gear_ratio != 1.0) {
      return quoted(joint) + ": gear_ratio is " + number(joint.gear_ratio) +
             " beside a gear_matrix, which holds the gear ratios already; leave gear_ratio out";
    }
  }
  return std::nullopt;
}

}  // namespace detail

RIVID_INLINE Vector Coupling::row(Index n) const {
  Vector c = Vector::Zero(n);
  c[motor] = 1.0;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    c[joints[k]] = ratios[k];
  }
  return c;
}

RIVID_INLINE std::vector<ParameterKind> Coupling::parameters() const {
  std::vector<ParameterKind> out;
  if (inertia == Inertia::free) {
    out.push_back(ParameterKind::Iam);
  }
  if (viscous) {
    out.push_back(ParameterKind::Fvm);
  }
  if (coulomb != Coulomb::none) {
    out.push_back(ParameterKind::Fcm);
  }
  return out;
}

RIVID_INLINE std::vector<CoupledEntry> coupled_entries(const Coupling& coupling, ParameterKind kind,
                                                       Index n) {
  const Vector c = coupling.row(n);
  std::vector<CoupledEntry> out;
  if (kind == ParameterKind::Fcm && coupling.coulomb == Coupling::Coulomb::sum) {
    for (const CoupledEntry::Term& at : detail::terms(c)) {
      out.push_back({at.joint, CoupledEntry::Quantity::sign_of_motion, at.weight, detail::terms(c)});
    }
    return out;
  }
  const Matrix A = detail::weights(coupling, c, kind);
  for (Index i = 0; i < n; ++i) {
    auto row = detail::terms(A.row(i));
    if (!row.empty()) {
      out.push_back({static_cast<std::size_t>(i), detail::quantity(kind), 1.0, std::move(row)});
    }
  }
  return out;
}

RIVID_INLINE Matrix coupling_matrix(std::span<const Coupling> couplings, Index n) {
  Matrix C = Matrix::Identity(n, n);
  for (const Coupling& coupling : couplings) {
    C.row(coupling.motor) = coupling.row(n);
  }
  return C;
}

RIVID_INLINE std::optional<std::size_t> Robot::link_of(std::string_view joint) const {
  const auto at = std::ranges::find(joints, joint, &Joint::name);
  const auto dependent = std::ranges::find(chain.dependents, joint, &Chain::Dependent::joint);
  if (at == joints.end() && dependent == chain.dependents.end()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(at - joints.begin()) +
         (at == joints.end() ? static_cast<std::size_t>(dependent - chain.dependents.begin()) : 0);
}

RIVID_INLINE std::vector<StandardParameter> Robot::standard_parameters() const {
  std::vector<StandardParameter> out;
  for (int j = 0; j < size(); ++j) {
    for (int k = 0; j >= first_body() && k < inertial_count; ++k) {
      out.push_back({static_cast<ParameterKind>(k), j});
    }
    const Joint& joint = joints[static_cast<std::size_t>(j)];
    if (joint.rotor_inertia) {
      out.push_back({ParameterKind::Ia, j});
    }
    for (const ParameterKind kind : parameters(joint.friction)) {
      out.push_back({kind, j});
    }
    for (const Coupling& coupling : couplings) {
      if (coupling.motor == j) {
        for (const ParameterKind kind : coupling.parameters()) {
          out.push_back({kind, j});
        }
      }
    }
  }
  for (int j = static_cast<int>(size()); j < static_cast<int>(chain.links.size()); ++j) {
    for (int k = 0; k < inertial_count; ++k) {
      out.push_back({static_cast<ParameterKind>(k), j});
    }
  }
  return out;
}

RIVID_INLINE Vector Robot::chi_st() const {
  const std::vector<StandardParameter> list = standard_parameters();
  Vector chi(static_cast<Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    chi[static_cast<Index>(i)] = detail::a_priori(*this, list[i]);
  }
  return chi;
}

RIVID_INLINE Matrix Robot::gears() const {
  if (gear_matrix.size() > 0) {
    return gear_matrix;
  }
  Matrix R = Matrix::Zero(size(), size());
  for (Index j = 0; j < size(); ++j) {
    R(j, j) = joints[static_cast<std::size_t>(j)].gear_ratio;
  }
  return R;
}

RIVID_INLINE Matrix Robot::drive_matrix() const {
  Matrix G = gears().transpose();
  for (Index j = 0; j < size(); ++j) {
    G.col(j) *= joints[static_cast<std::size_t>(j)].drive_gain;
  }
  return G;
}

RIVID_INLINE std::optional<std::string> Robot::complaint() const {
  if (chain.links.empty()) {
    return "the robot has no moving joint";
  }
  if (std::ssize(joints) != size() || inertials.size() != chain.links.size()) {
    return "the chain has " + std::to_string(chain.links.size()) + " links, but " +
           std::to_string(joints.size() + chain.dependents.size()) + " joints and " +
           std::to_string(inertials.size()) + " inertials are given";
  }
  if (base_joints != 0 && (base_joints != 6 || size() < base_joints)) {
    return "base_joints is " + std::to_string(base_joints) + ", must be 0, or 6 of at least as many joints";
  }
  if (auto fault = detail::gravity_complaint(chain.gravity)) {
    return fault;
  }
  if (auto fault = detail::order_complaint(chain)) {
    return fault;
  }
  const auto slides = [](const Chain::Link& link) { return link.type == JointType::prismatic; };
  if (total_mass && (!(*total_mass > 0.0) || !std::isfinite(*total_mass) || base_joints == 0 ||
                     std::any_of(chain.links.begin() + base_joints, chain.links.end(), slides))) {
    return "total_mass is " + number(*total_mass) +
           " kg, must be positive, of a floating base without sliding links";
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    const std::string who = "joint \"" + joint.name + "\": ";
    const auto same_name = [&](const Joint& other) { return other.name == joint.name; };
    if (std::any_of(joints.begin(), joints.begin() + static_cast<std::ptrdiff_t>(j), same_name)) {
      return "two joints are called \"" + joint.name + "\"; names must differ";
    }
    if (joint.type != chain.links[j].type) {
      return who + "its type differs from that of the chain";
    }
    if (const auto fault = detail::frame_complaint(chain.links[j])) {
      return who + *fault;
    }
    if (!is_value(joint.friction)) {
      return who + "its friction is none of Friction";
    }
    if (std::isnan(joint.lower) || std::isnan(joint.upper) || std::isnan(joint.max_velocity) ||
        std::isnan(joint.max_effort)) {
      return who + "lower, upper, max_velocity or max_effort is nan; infinity is no limit";
    }
    if (!std::isfinite(joint.sign_speed) || joint.sign_speed < 0.0) {
      return who + "sign_speed is " + number(joint.sign_speed) + ", must be finite and not negative";
    }
    if (!std::isfinite(joint.g_tau()) || joint.g_tau() == 0.0) {
      return who + "drive_gain × gear_ratio is " + std::to_string(joint.g_tau()) +
             ", must be finite and not zero";
    }
    if (!inertials[j].allFinite()) {
      return who + "the inertial parameters of link \"" + joint.link + "\" are not finite";
    }
  }
  for (std::size_t j = joints.size(); j < inertials.size(); ++j) {
    const std::string& dependent = chain.dependents[j - joints.size()].joint;
    if (const auto fault = detail::frame_complaint(chain.links[j])) {
      return "joint \"" + dependent + "\": " + *fault;
    }
    if (std::ranges::find(joints, dependent, &Joint::name) != joints.end() || !inertials[j].allFinite()) {
      return "dependent joint \"" + dependent +
             "\": its name is that of another joint, or the inertial parameters " +
             "of its link are not finite";
    }
  }
  if (!(tolerance.length >= 0.0) || !(tolerance.angle >= 0.0)) {
    return "tolerance has length " + number(tolerance.length) + " and angle " + number(tolerance.angle) +
           ", must not be negative";
  }
  if (std::isnan(base_tolerance) || base_tolerance <= 0.0 || base_tolerance >= 1.0) {
    return "base_tolerance is " + number(base_tolerance) + ", must lie between 0 and 1";
  }
  if (auto fault = detail::couplings_complaint(*this)) {
    return fault;
  }
  return detail::gear_matrix_complaint(*this);
}

}  // namespace rivid
