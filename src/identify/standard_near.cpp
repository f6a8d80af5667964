#include "rivid/identify/standard_near.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

struct Size {
  double mass = 0.0;
  double length = 0.0;  // radius of gyration about the link's origin
};

Size size_of(const Inertial& inertial) {
  const double mass = inertial[9];
  const double second_moments = 0.5 * (inertial[0] + inertial[3] + inertial[5]);
  return mass > 0.0 && second_moments > 0.0 ? Size{mass, std::sqrt(second_moments / mass)} : Size{};
}

// Of each link; what a link does not tell is that of the mean link.
std::vector<Size> sizes(const Robot& robot) {
  constexpr Size unknown = {1.0, 0.1};
  std::vector<Size> out;
  Size sum;
  double count = 0.0;
  for (const Inertial& inertial : robot.inertials) {
    out.push_back(size_of(inertial));
    if (out.back().mass > 0.0) {
      sum = {sum.mass + out.back().mass, sum.length + out.back().length};
      count += 1.0;
    }
  }
  const Size mean = count > 0.0 ? Size{sum.mass / count, sum.length / count} : unknown;
  std::ranges::replace_if(out, [](const Size& size) { return size.mass == 0.0; }, mean);
  return out;
}

double scale_of(ParameterKind kind, JointType type, const Size& size) {
  const double inertia = size.mass * size.length * size.length;
  switch (kind) {
    case ParameterKind::MX:
    case ParameterKind::MY:
    case ParameterKind::MZ:
      return size.mass * size.length;
    case ParameterKind::M:
      return size.mass;
    case ParameterKind::Ia:
    case ParameterKind::Iam:
      return type == JointType::revolute ? inertia : size.mass;
    default:
      return static_cast<int>(kind) < inertial_count ? inertia : 1.0;
  }
}

}  // namespace

Vector standard_near(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi) {
  const auto same = [](const StandardParameter& a, const StandardParameter& b) {
    return a.kind == b.kind && a.joint == b.joint;
  };
  if (!std::ranges::equal(base.standard, robot.standard_parameters(), same)) {
    throw InputError("standard_near: the base parameters are those of another robot than \"" + robot.name +
                     "\"; take base_parameters(robot)");
  }
  if (chi.size() != base.size()) {
    throw InputError("standard_near: chi has " + std::to_string(chi.size()) + " values, the robot has " +
                     std::to_string(base.size()) + " base parameters");
  }
  for (Index i = 0; i < chi.size(); ++i) {
    if (!std::isfinite(chi[i])) {
      throw InputError("standard_near: " + base.parameters[static_cast<std::size_t>(i)].name + " is " +
                       number(chi[i]) + ", must be finite");
    }
  }
  const auto N_s = static_cast<Index>(base.standard.size());
  const std::vector<Size> link = sizes(robot);
  Vector D(N_s);
  for (Index i = 0; i < N_s; ++i) {
    const StandardParameter& p = base.standard[static_cast<std::size_t>(i)];
    const auto joint = static_cast<std::size_t>(p.joint);
    D[i] = scale_of(p.kind, robot.joints[joint].type, link[joint]);
  }
  // The least change of D⁻¹ χ_st lies in the rows of B D, which are (B D)ᵀ = Q R: it is Q R⁻ᵀ (χ − B χ_st,0). Rows are
  // scaled to length one, so that no unit outweighs another in R.
  const Vector a_priori = robot.chi_st();
  Matrix BD = Matrix::Zero(base.size(), N_s);
  for (Index i = 0; i < base.size(); ++i) {
    BD(i, base.leading[static_cast<std::size_t>(i)]) = 1.0;
  }
  for (std::size_t k = 0; k < base.dependent.size(); ++k) {
    BD.col(base.dependent[k]) = base.K.col(static_cast<Index>(k));
  }
  BD = BD * D.asDiagonal();
  const Vector row = BD.rowwise().norm();
  BD = row.cwiseInverse().asDiagonal() * BD;
  const Vector rest = (chi - base.from_standard(a_priori)).cwiseQuotient(row);
  const Eigen::HouseholderQR<Matrix> qr(BD.transpose());
  Vector change = Vector::Zero(N_s);
  change.head(base.size()) =
      qr.matrixQR().topRows(base.size()).triangularView<Eigen::Upper>().transpose().solve(rest);
  change.applyOnTheLeft(qr.householderQ());
  return a_priori + D.cwiseProduct(change);
}

}  // namespace rivid
