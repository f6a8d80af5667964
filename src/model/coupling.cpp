#include <array>

#include "rivid/model/robot.hpp"

namespace rivid {

namespace {

constexpr std::array<std::string_view, 3> inertia_names = {"none", "free", "tied"};
constexpr std::array<std::string_view, 3> coulomb_names = {"none", "sum", "single"};
constexpr std::array<std::string_view, 2> terms_names = {"cross", "all"};

// Weights of q̈, q̇ or their signs in the torques: c cᵀ, or what of it the parameter stands for.
Matrix weights(const Coupling& coupling, const Vector& c, ParameterKind kind) {
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

CoupledEntry::Quantity quantity(ParameterKind kind) {
  return role(kind) == Role::rotor     ? CoupledEntry::Quantity::acceleration
         : role(kind) == Role::viscous ? CoupledEntry::Quantity::velocity
                                       : CoupledEntry::Quantity::single_signs;
}

std::vector<CoupledEntry::Term> terms(const auto& weights) {
  std::vector<CoupledEntry::Term> out;
  for (Index k = 0; k < weights.size(); ++k) {
    if (weights[k] != 0.0) {
      out.push_back({static_cast<std::size_t>(k), weights[k]});
    }
  }
  return out;
}

}  // namespace

Vector Coupling::row(Index n) const {
  Vector c = Vector::Zero(n);
  c[motor] = 1.0;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    c[joints[k]] = ratios[k];
  }
  return c;
}

std::vector<ParameterKind> Coupling::parameters() const {
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

std::vector<CoupledEntry> coupled_entries(const Coupling& coupling, ParameterKind kind, Index n) {
  const Vector c = coupling.row(n);
  std::vector<CoupledEntry> out;
  if (kind == ParameterKind::Fcm && coupling.coulomb == Coupling::Coulomb::sum) {
    for (const CoupledEntry::Term& at : terms(c)) {
      out.push_back({at.joint, CoupledEntry::Quantity::sign_of_motion, at.weight, terms(c)});
    }
    return out;
  }
  const Matrix A = weights(coupling, c, kind);
  for (Index i = 0; i < n; ++i) {
    auto row = terms(A.row(i));
    if (!row.empty()) {
      out.push_back({static_cast<std::size_t>(i), quantity(kind), 1.0, std::move(row)});
    }
  }
  return out;
}

Matrix coupling_matrix(std::span<const Coupling> couplings, Index n) {
  Matrix C = Matrix::Identity(n, n);
  for (const Coupling& coupling : couplings) {
    C.row(coupling.motor) = coupling.row(n);
  }
  return C;
}

std::string_view name(Coupling::Inertia inertia) { return inertia_names[static_cast<std::size_t>(inertia)]; }
std::string_view name(Coupling::Coulomb coulomb) { return coulomb_names[static_cast<std::size_t>(coulomb)]; }
std::string_view name(Coupling::Terms terms) { return terms_names[static_cast<std::size_t>(terms)]; }

}  // namespace rivid
