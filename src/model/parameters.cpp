#include "rivid/model/parameters.hpp"

namespace rivid {

std::string_view symbol(ParameterKind kind) {
  static constexpr std::array<std::string_view, 21> names = {"XX",  "XY",  "XZ",  "YY",  "YZ",  "ZZ",  "MX",
                                                             "MY",  "MZ",  "M",   "Ia",  "Fv",  "Fc",  "off",
                                                             "Fv+", "Fc+", "Fv-", "Fc-", "Iam", "Fvm", "Fcm"};
  return names[static_cast<std::size_t>(kind)];
}

std::string StandardParameter::name() const { return std::string(symbol(kind)) + std::to_string(joint + 1); }

std::string_view unit(ParameterKind kind, JointType type) {
  const bool revolute = type == JointType::revolute;
  switch (kind) {
    case ParameterKind::MX:
    case ParameterKind::MY:
    case ParameterKind::MZ:
      return "kg·m";
    case ParameterKind::M:
      return "kg";
    case ParameterKind::Ia:
    case ParameterKind::Iam:
      return revolute ? "kg·m²" : "kg";
    case ParameterKind::Fv:
    case ParameterKind::Fv_plus:
    case ParameterKind::Fv_minus:
    case ParameterKind::Fvm:
      return revolute ? "N·m·s/rad" : "N·s/m";
    case ParameterKind::Fc:
    case ParameterKind::Fc_plus:
    case ParameterKind::Fc_minus:
    case ParameterKind::Fcm:
    case ParameterKind::off:
      return revolute ? "N·m" : "N";
    default:
      return "kg·m²";
  }
}

namespace {

// Parallel-axis term: inertia of a point mass m at c about the origin.
Eigen::Matrix3d point_mass(double m, const Eigen::Vector3d& c) {
  return m * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
}

Inertial packed(const Eigen::Matrix3d& I, const Eigen::Vector3d& first_moment, double mass) {
  Inertial out;
  out << I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2), first_moment, mass;
  return out;
}

}  // namespace

Inertial inertial_from_com(double mass, const Eigen::Vector3d& com, const Eigen::Matrix3d& I_com) {
  return packed(I_com + point_mass(mass, com), mass * com, mass);
}

Inertial transformed(const Inertial& inertial, const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
  Eigen::Matrix3d I;
  I << inertial[0], inertial[1], inertial[2], inertial[1], inertial[3], inertial[4], inertial[2], inertial[4],
      inertial[5];
  const double m = inertial[9];
  const Eigen::Vector3d h = R * inertial.segment<3>(6);
  // ∫(|r + p|² 1 − (r + p)(r + p)ᵀ) dm, opened so that a body without mass (m = 0, h ≠ 0) transforms as well.
  const Eigen::Matrix3d cross =
      2.0 * p.dot(h) * Eigen::Matrix3d::Identity() - p * h.transpose() - h * p.transpose();
  return packed(R * I * R.transpose() + cross + point_mass(m, p), h + m * p, m);
}

}  // namespace rivid
