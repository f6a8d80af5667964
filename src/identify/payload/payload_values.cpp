#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "dense.hpp"
#include "identify/payload/payload_model.hpp"
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

std::vector<Index> unknowns_of(const PayloadFit& fit, std::size_t k) {
  std::vector<Index> out(inertial_count);
  std::iota(out.begin(), out.end(), fit.payload_at(k));
  return out;
}

// Values of a body, less a second one where there are twice as many unknowns, in the flange frame, with the
// slopes of these by central differences.
Payload with_intervals(const std::vector<Index>& unknowns, const PayloadFit& fit,
                       const Uncertainty& uncertainty, const PayloadOptions& options) {
  const auto at = [&](const Vector& pi) -> Vector {
    Inertial body = pi.head<inertial_count>();
    if (pi.size() > inertial_count) {
      body -= pi.tail<inertial_count>();
    }
    return told(transformed(body, options.R.transpose(), -(options.R.transpose() * options.p)));
  };
  const Vector pi = fit.theta()(unknowns);
  const Vector value = at(pi);
  Matrix J(10, pi.size());
  for (Index k = 0; k < pi.size(); ++k) {
    const double step = 1e-6 * std::max(std::abs(pi[k]), 1e-2);
    const Vector by = step * Vector::Unit(pi.size(), k);
    J.col(k) = (at(pi + by) - at(pi - by)) / (2.0 * step);
  }
  const Matrix C = J * uncertainty.C(unknowns, unknowns) * J.transpose();
  constexpr std::array<const char*, 10> names = {"mass", "com_x", "com_y", "com_z", "Ixx",
                                                 "Iyy",  "Izz",   "Ixy",   "Ixz",   "Iyz"};
  Payload out;
  out.mass = value[0];
  out.com = value.segment<3>(1);
  const double t = uncertainty.report.quantile_975;
  for (Index k = 0; k < inertial_count; ++k) {
    const double sigma = std::sqrt(std::max(C(k, k), 0.0));
    out.values.push_back({names[static_cast<std::size_t>(k)],
                          k == 0  ? "kg"
                          : k < 4 ? "m"
                                  : "kg·m²",
                          value[k],
                          sigma,
                          {value[k] - t * sigma, value[k] + t * sigma}});
  }
  out.inertia << value[4], value[7], value[8], value[7], value[5], value[9], value[8], value[9], value[6];
  out.least_mass = visible_mass * out.values.front().sigma;
  return out;
}

// Where there is none: there is no centre of mass then.
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

// Why a body is none, or its inertia is not identifiable; empty where it is reported.
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

// Of a payload that there is what the motion shows.
void tell_what_is_seen(Payload& payload, const PayloadOptions& options) {
  payload.reason = options.model == PayloadModel::automatic ? hidden_inertia(payload) : "";
  if (!payload.reason.empty() || options.model == PayloadModel::point) {
    payload.model = PayloadModel::point;
    payload.values.resize(4);
    payload.inertia = payload.mass * usual_gyration * usual_gyration * Eigen::Matrix3d::Identity();
  }
}

// Whether a load is there whatever it weighs: a first moment differs from zero.
bool is_felt(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k) {
  const Index at = fit.payload_at(k) + 6;
  const auto h = fit.theta().segment<3>(at).array();
  return (h.square() > visible_mass * visible_mass * uncertainty.C.diagonal().segment<3>(at).array()).any();
}

}  // namespace

Payload payload_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k,
                   const PayloadOptions& options) {
  Payload out = with_intervals(unknowns_of(fit, k), fit, uncertainty, options);
  const PayloadFit::Rest rest = fit.rest_with(k);
  out.sigma_rho = rest.sigma_rho;
  if (std::abs(out.mass) < out.least_mass && rest.payload > visible_part_of_rest &&
      is_felt(fit, uncertainty, k)) {
    const PayloadValue& mass = out.values.front();
    out.unweighed = true;
    out.reason = "there is a payload, and the motion does not show its mass (" + number(mass.value, 2) +
                 " ± " + number(mass.sigma, 2) + " kg): joints must move that lift it, not the wrist alone";
    out.values.resize(1);
    return out;
  }
  out.least_mass = std::max(out.least_mass, visible_part_of_rest * rest.mass);
  if (out.none()) {
    tell_mass_alone(out);
  } else {
    tell_what_is_seen(out, options);
  }
  return out;
}

Payload difference_of(const PayloadFit& fit, const Uncertainty& uncertainty, std::size_t k, std::size_t from,
                      const PayloadOptions& options) {
  std::vector<Index> unknowns = unknowns_of(fit, k);
  std::ranges::copy(unknowns_of(fit, from), std::back_inserter(unknowns));
  Payload out = with_intervals(unknowns, fit, uncertainty, options);
  if (out.none()) {
    tell_mass_alone(out);
  } else {
    tell_what_is_seen(out, options);
  }
  return out;
}

}  // namespace rivid::detail

namespace rivid {

bool Payload::none() const { return !unweighed && std::abs(mass) < least_mass; }

}  // namespace rivid
