#include "identify/feasible.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace rivid::detail {

namespace {

constexpr int rounds = 100;
// Least eigenvalue of a pseudo-inertia and least rotor inertia, as fractions of the largest.
constexpr double least = 1e-4;

Eigen::Matrix4d pseudo_inertia(const Eigen::Ref<const Vector>& p) {
  Eigen::Matrix3d I;
  I << p[0], p[1], p[2], p[1], p[3], p[4], p[2], p[4], p[5];
  Eigen::Matrix4d P;
  P.topLeftCorner<3, 3>() = 0.5 * I.trace() * Eigen::Matrix3d::Identity() - I;
  P.topRightCorner<3, 1>() = p.segment<3>(6);
  P.bottomLeftCorner<1, 3>() = p.segment<3>(6).transpose();
  P(3, 3) = p[9];
  return P;
}

void set_inertial(const Eigen::Matrix4d& P, Eigen::Ref<Vector> p) {
  const Eigen::Matrix3d second = P.topLeftCorner<3, 3>();
  const Eigen::Matrix3d I = second.trace() * Eigen::Matrix3d::Identity() - second;
  p.head<6>() << I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2);
  p.segment<3>(6) = P.topRightCorner<3, 1>();
  p[9] = P(3, 3);
}

// The nearest physical set: eigenvalues clipped link by link.
void make_physical(const BaseParameters& base, double floor, Vector& chi_st) {
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const auto at = static_cast<Index>(i);
    if (base.standard[i].kind == ParameterKind::XX) {
      auto p = chi_st.segment<inertial_count>(at);
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(pseudo_inertia(p));
      const Eigen::Vector4d clipped = eigen.eigenvalues().cwiseMax(floor);
      set_inertial(eigen.eigenvectors() * clipped.asDiagonal() * eigen.eigenvectors().transpose(), p);
    } else if (base.standard[i].kind == ParameterKind::Ia) {
      chi_st[at] = std::max(chi_st[at], floor);
    }
  }
}

}  // namespace

Vector feasible_near(const Robot& robot, const BaseParameters& base, const Vector& chi) {
  const auto standard = static_cast<Index>(base.standard.size());
  Matrix A(base.size(), standard);
  for (Index i = 0; i < standard; ++i) {
    A.col(i) = base.from_standard(Vector::Unit(standard, i));
  }
  const Eigen::LDLT<Matrix> AAt(A * A.transpose());
  double largest = 0.0;
  for (Index i = 0; i < base.size(); ++i) {
    if (base.parameters[static_cast<std::size_t>(i)].leading.kind <= ParameterKind::Ia) {
      largest = std::max(largest, std::abs(chi[i]));
    }
  }
  // The a-priori values, where there are any, say which of the many standard sets to begin with.
  Vector chi_st = robot.chi_st();
  for (int round = 0; round < rounds; ++round) {
    chi_st += A.transpose() * AAt.solve(chi - A * chi_st);
    make_physical(base, least * largest, chi_st);
  }
  return A * chi_st;
}

}  // namespace rivid::detail
