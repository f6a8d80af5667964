#include "identify/payload/payload_values.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "dense.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// An inertia is reported where no principal moment's deviation exceeds this part of the largest moment.
constexpr double visible_inertia = 0.5;
// A centre of mass is a moment over a mass, which must be this many of its deviations; nor is a mass seen
// that weighs less than this part of what the model leaves of the torques, whose errors are not those of
// chance alone.
constexpr double visible_mass = 4.0;
constexpr double visible_part_of_rest = 0.1;

// Mass, centre of mass and inertia about it, Ixx Iyy Izz Ixy Ixz Iyz, of a body.
Vector told(const Inertial& body) {
  const double m = body[9];
  const Eigen::Vector3d c = body.segment<3>(6) / m;
  Eigen::Matrix3d I;
  I << body[0], body[1], body[2], body[1], body[3], body[4], body[2], body[4], body[5];
  I -= m * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  Vector out(10);
  out << m, c, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
  return out;
}

// Some of the unknowns, and the body in the last link's frame that they are.
struct BodyOfUnknowns {
  std::vector<Index> unknowns;
  std::function<Inertial(const Vector&)> body;
};

std::vector<Index> unknowns_of(const PayloadFit& fit, std::size_t k) {
  std::vector<Index> out;
  for (Index i = 0; i < inertial_count; ++i) {
    out.push_back(fit.payload_at(k) + i);
  }
  return out;
}

// Values of a body in the flange frame, with the slopes of these by central differences.
Payload with_intervals(const BodyOfUnknowns& of, const PayloadFit& fit, const Uncertainty& uncertainty,
                       PayloadModel shape, const PayloadOptions& options) {
  const auto at = [&](const Vector& pi) {
    return told(transformed(of.body(pi), options.R.transpose(), -(options.R.transpose() * options.p)));
  };
  const Vector pi = fit.theta()(of.unknowns);
  const Vector value = at(pi);
  Matrix J(10, pi.size());
  for (Index k = 0; k < pi.size(); ++k) {
    const double step = 1e-6 * std::max(std::abs(pi[k]), 1e-2);
    const Vector by = step * Vector::Unit(pi.size(), k);
    J.col(k) = (at(pi + by) - at(pi - by)) / (2.0 * step);
  }
  const Matrix C = J * uncertainty.C(of.unknowns, of.unknowns) * J.transpose();
  constexpr std::array<const char*, 10> names = {"mass", "com_x", "com_y", "com_z", "Ixx",
                                                 "Iyy",  "Izz",   "Ixy",   "Ixz",   "Iyz"};
  Payload out;
  out.model = shape;
  out.mass = value[0];
  out.com = value.segment<3>(1);
  const double t = uncertainty.report.quantile_975;
  for (Index k = 0; k < (shape == PayloadModel::body ? 10 : 4); ++k) {
    const double sigma = std::sqrt(std::max(C(k, k), 0.0));
    out.values.push_back({names[static_cast<std::size_t>(k)],
                          k == 0  ? "kg"
                          : k < 4 ? "m"
                                  : "kg·m²",
                          value[k],
                          sigma,
                          {value[k] - t * sigma, value[k] + t * sigma}});
  }
  if (shape == PayloadModel::body) {
    out.inertia << value[4], value[7], value[8], value[7], value[5], value[9], value[8], value[9], value[6];
  }
  out.least_mass = visible_mass * out.values.front().sigma;
  return out;
}

}  // namespace

Payload payload_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k, PayloadModel shape,
                   const PayloadOptions& options) {
  Payload out = with_intervals({unknowns_of(fit, k), [](const Vector& pi) { return Inertial(pi); }}, fit,
                               uncertainty, shape, options);
  const PayloadFit::Rest rest = fit.rest_with(k);
  out.sigma_rho = rest.sigma_rho;
  out.least_mass = std::max(out.least_mass, visible_part_of_rest * rest.mass);
  return out;
}

Payload difference_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k, std::size_t from,
                      PayloadModel shape, const PayloadOptions& options) {
  BodyOfUnknowns of{unknowns_of(fit, k), {}};
  std::ranges::copy(unknowns_of(fit, from), std::back_inserter(of.unknowns));
  of.body = [](const Vector& pi) -> Inertial { return pi.head(inertial_count) - pi.tail(inertial_count); };
  Payload out = with_intervals(of, fit, uncertainty, shape, options);
  if (out.none()) {
    tell_mass_alone(out);
  } else if (out.model == PayloadModel::body && !hidden_inertia(out).empty()) {
    out.model = PayloadModel::point;
    out.reason = hidden_inertia(out);
    out.values.resize(4);
    out.inertia.setZero();
  }
  return out;
}

void tell_mass_alone(Payload& payload) {
  const PayloadValue& mass = payload.values.front();
  payload.reason =
      payload.sigma_rho.size() > 0
          ? "no payload (less than " + number(std::max(mass.interval_95[1], payload.least_mass), 2) + " kg)"
          : "the mass differs from zero by less than " + number(visible_mass, 2) +
                " standard deviations: centre of mass and inertia are not determined";
  payload.values.resize(1);
  payload.com.setZero();
  payload.inertia.setZero();
}

std::string hidden_inertia(const Payload& body) {
  const Vector moments = symmetric_eigenvalues(body.inertia);
  const double largest = body.inertia.diagonal().maxCoeff();
  double worst = 0.0;
  for (std::size_t k = 4; k < 7; ++k) {
    worst = std::max(worst, body.values[k].sigma);
  }
  if (body.mass <= 0.0 || moments[0] <= 0.0 || moments[2] > moments[0] + moments[1]) {
    return "the inertia of the estimate is physically inconsistent; its standard deviations are up to " +
           number(worst, 2) +
           " kg·m²: the motion does not show it, only mass and centre of mass are reported";
  }
  if (worst > visible_inertia * largest) {
    return "deviations of the inertia are up to " + number(worst, 2) + " kg·m² of " + number(largest, 2) +
           ": the motion does not show it, only mass and centre of mass are reported";
  }
  return "";
}

}  // namespace rivid::detail

namespace rivid {

bool Payload::none() const { return std::abs(mass) < least_mass; }

}  // namespace rivid
