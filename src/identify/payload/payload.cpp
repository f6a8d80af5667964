#include "rivid/identify/payload.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <utility>

#include "dense.hpp"
#include "identify/payload/gains.hpp"
#include "identify/payload/payload_model.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::PayloadFit;
using detail::PayloadLog;

// An inertia is reported where no principal moment's deviation exceeds this part of the largest moment.
constexpr double visible_inertia = 0.5;

void require(bool condition, const std::string& words) {
  if (!condition) {
    throw InputError("identify_payload: " + words);
  }
}

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

Vector in_flange(const PayloadFit& fit, const PayloadOptions& options, const Vector& pi) {
  return told(transformed(fit.body(pi), options.R.transpose(), -(options.R.transpose() * options.p)));
}

// Slopes of told() by the unknowns of the payload, by central differences.
Matrix slopes(const PayloadFit& fit, const PayloadOptions& options, const Vector& pi) {
  Matrix out(10, pi.size());
  for (Index k = 0; k < pi.size(); ++k) {
    const double step = 1e-6 * std::max(std::abs(pi[k]), 1e-2);
    const Vector by = step * Vector::Unit(pi.size(), k);
    out.col(k) = (in_flange(fit, options, pi + by) - in_flange(fit, options, pi - by)) / (2.0 * step);
  }
  return out;
}

void fill_values(const PayloadFit& fit, const PayloadOptions& options, const detail::Uncertainty& uncertainty,
                 Payload& out) {
  const Index at = fit.payload_at();
  const Index size = fit.payload_size();
  const Vector pi = fit.theta().segment(at, size);
  const Vector value = in_flange(fit, options, pi);
  const Matrix J = slopes(fit, options, pi);
  const Matrix C = J * uncertainty.C.block(at, at, size, size) * J.transpose();
  constexpr std::array<const char*, 10> names = {"mass", "com_x", "com_y", "com_z", "Ixx",
                                                 "Iyy",  "Izz",   "Ixy",   "Ixz",   "Iyz"};
  const Index count = out.model == PayloadModel::body ? 10 : 4;
  const double t = uncertainty.report.quantile_975;
  for (Index k = 0; k < count; ++k) {
    const double sigma = std::sqrt(std::max(C(k, k), 0.0));
    out.values.push_back({names[static_cast<std::size_t>(k)],
                          k == 0  ? "kg"
                          : k < 4 ? "m"
                                  : "kg·m²",
                          value[k],
                          sigma,
                          {value[k] - t * sigma, value[k] + t * sigma}});
  }
  out.mass = value[0];
  out.com = value.segment<3>(1);
  if (out.model == PayloadModel::body) {
    out.inertia << value[4], value[7], value[8], value[7], value[5], value[9], value[8], value[9], value[6];
  }
}

// Why a body is none, or its inertia is not identifiable; empty where it is reported.
std::string hidden_inertia(const Payload& body) {
  const Vector moments = detail::symmetric_eigenvalues(body.inertia);
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

struct PayloadData {
  detail::PayloadColumns columns;
  std::vector<PayloadLog> logs;
};

Payload fitted(const Robot& robot, const PayloadData& data, const Estimation& estimation,
               const PayloadOptions& options, PayloadModel model) {
  Payload out;
  out.model = model;
  PayloadFit fit(robot, data.columns, data.logs, options,
                 model == PayloadModel::point ? detail::PayloadShape::point : detail::PayloadShape::body);
  const bool settled = fit.solve();
  out.chi = fit.chi();
  out.Fl = fit.load_friction();
  out.rows = fit.rows();
  out.iterations = fit.iterations();
  out.relative_error = fit.relative_error();
  if (!settled || !fit.theta().allFinite()) {
    out.reason = "the iteration does not settle in " + std::to_string(fit.iterations()) + " steps";
    return out;
  }
  if (fit.rows() <= fit.theta().size()) {
    out.reason = std::to_string(fit.rows()) + " rows for " + std::to_string(fit.theta().size()) + " unknowns";
    return out;
  }
  const detail::Uncertainty uncertainty = fit.uncertainty(estimation.covariance);
  out.covariance = uncertainty.report;
  fill_values(fit, options, uncertainty, out);
  out.gains = detail::gain_estimates(robot, fit, uncertainty);
  out.identified = fit.full_rank();
  if (!out.identified) {
    out.reason = "the motion does not determine all parameters of arm and payload";
  }
  return out;
}

}  // namespace

std::optional<std::string> PayloadOptions::complaint(const Robot& robot) const {
  if (!R.isUnitary(1e-6) || R.col(0).cross(R.col(1)).dot(R.col(2)) < 0.0) {
    return "R is no rotation";
  }
  if (!p.allFinite()) {
    return "p must be finite";
  }
  if (mass && (!std::isfinite(*mass) || *mass <= 0.0)) {
    return "mass is " + number(*mass) + " kg, must be positive";
  }
  if (!std::isfinite(mass_sigma) || mass_sigma < 0.0) {
    return "mass_sigma is " + number(mass_sigma) + " kg, must not be negative";
  }
  if (gain_sigma.size() == 0) {
    return std::nullopt;
  }
  if (gain_sigma.size() != robot.size() || gain_sigma.hasNaN() || gain_sigma.minCoeff() < 0.0) {
    return "gain_sigma has " + counted(gain_sigma.size(), "value") +
           ", must have one, not negative, for each of the " + std::to_string(robot.size()) + " joints";
  }
  if (!mass && std::isinf(gain_sigma.minCoeff())) {
    return "no gain is known and no mass: torques determine only their ratios; give the mass of the "
           "payload, or "
           "what is known of one gain";
  }
  return std::nullopt;
}

Payload identify_payload(const Robot& its_robot, std::span<const Log> without, std::span<const Log> with,
                         const Estimation& asked, const PayloadOptions& its_options) {
  // Friction by load is an unknown of the fit itself.
  const Robot robot = without_load(its_robot);
  PayloadOptions options = its_options;
  options.load_friction = options.load_friction || has_load(its_robot);
  require(!without.empty(), "no log without the payload is given");
  require(!with.empty(), "no log with the payload is given");
  if (const auto fault = robot.complaint()) {
    throw InputError("identify_payload: " + *fault);
  }
  if (const auto fault = options.complaint(robot)) {
    throw InputError("identify_payload: " + *fault);
  }
  require(!std::holds_alternative<Iv>(asked.method) && !asked.robust,
          "it is weighted least squares: method \"iv\" and robust estimation are not for payloads");
  PayloadData data{detail::PayloadColumns(robot), {}};
  data.logs = detail::stacked_rows(robot, data.columns, without, with, asked);
  if (options.model == PayloadModel::point) {
    return fitted(robot, data, asked, options, PayloadModel::point);
  }
  Payload body = fitted(robot, data, asked, options, PayloadModel::body);
  if (options.model == PayloadModel::body) {
    return body;
  }
  std::string why = body.identified ? hidden_inertia(body) : "the inertia is not determined: " + body.reason;
  if (why.empty()) {
    return body;
  }
  Payload point = fitted(robot, data, asked, options, PayloadModel::point);
  if (point.identified) {
    point.reason = std::move(why);
  }
  return point;
}

std::string urscript_line(const Payload& payload) {
  const Eigen::Vector3d& c = payload.com;
  const Eigen::Matrix3d& I = payload.inertia;
  return "set_target_payload(" + number(payload.mass, 5) + ", [" + number(c[0], 5) + ", " + number(c[1], 5) +
         ", " + number(c[2], 5) + "], [" + number(I(0, 0), 5) + ", " + number(I(1, 1), 5) + ", " +
         number(I(2, 2), 5) + ", " + number(I(0, 1), 5) + ", " + number(I(0, 2), 5) + ", " +
         number(I(1, 2), 5) + "])";
}

std::string libfranka_line(const Payload& payload) {
  std::string out = "robot.setLoad(" + number(payload.mass, 5) + ", {";
  for (Index k = 0; k < 3; ++k) {
    out += (k > 0 ? ", " : "") + number(payload.com[k], 5);
  }
  out += "}, {";
  for (Index k = 0; k < 9; ++k) {
    out += (k > 0 ? ", " : "") + number(payload.inertia(k % 3, k / 3), 5);
  }
  return out + "});";
}

}  // namespace rivid
