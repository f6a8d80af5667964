#include "identify/figures/friction_curves.hpp"

#include <algorithm>
#include <limits>

#include "csv_columns.hpp"
#include "ranges.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

// Place of the point that is nearest.
Index nearest_point(const Vector& points, double x) {
  const Index after = std::ranges::lower_bound(points, x) - points.begin();
  if (after == 0 || after == points.size()) {
    return std::min(after, points.size() - 1);
  }
  return x - points[after - 1] < points[after] - x ? after - 1 : after;
}

// A cell of a table whose text may hold commas.
std::string quoted_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) {
    return text;
  }
  std::string out = "\"";
  for (const char c : text) {
    out += c == '"' ? "\"\"" : std::string(1, c);
  }
  return out + '"';
}

}  // namespace

FrictionCurve friction_law(const Robot& robot, const Identification& result, std::size_t joint,
                           double most_speed, double load) {
  constexpr Index points = 61;  // to either side
  // of the largest speed; any small value: points at both sides of the jump at rest
  constexpr double beside_rest = 1e-6;
  const Joint& of = robot.joints[joint];
  FrictionCurve out;
  out.joint = of.name;
  out.load = load;
  out.velocity.resize(2 * points);
  out.velocity.head(points) = Vector::LinSpaced(points, -most_speed, -beside_rest * most_speed);
  out.velocity.tail(points) = -out.velocity.head(points).reverse();
  const std::vector<Index> columns = places_where(result.base.size(), [&](Index i) {
    const StandardParameter& parameter = result.base.parameters[static_cast<std::size_t>(i)].leading;
    return is_friction(parameter.kind) && !about(parameter.kind).coupled &&
           parameter.joint == static_cast<int>(joint);
  });
  Matrix phi(out.velocity.size(), std::ssize(columns));
  for (Index c = 0; c < phi.cols(); ++c) {
    const ParameterKind kind =
        result.base.parameters[static_cast<std::size_t>(columns[static_cast<std::size_t>(c)])].leading.kind;
    const double factor = about(kind).basis == Basis::load ? load : 1.0;
    for (Index k = 0; k < phi.rows(); ++k) {
      phi(k, c) = factor * friction_entry(kind, out.velocity[k], of.sign_speed);
    }
  }
  out.torque = phi * result.answer()(columns);
  out.a_priori = phi * result.base.from_standard(robot.chi_st())(columns);
  if (const Matrix& all = result.answer_covariance(); all.rows() == result.chi.size()) {
    const Matrix C = all(columns, columns);
    out.sigma = (phi * C).cwiseProduct(phi).rowwise().sum().cwiseMax(0.0).cwiseSqrt();
  } else {
    out.sigma = Vector::Constant(out.velocity.size(), std::numeric_limits<double>::quiet_NaN());
  }
  out.half_width = result.covariance.quantile_975 * out.sigma;
  return out;
}

FrictionCurve friction_curve(const Robot& robot, const Identification& result, std::size_t joint,
                             const StackedRows& rows) {
  constexpr double past_rows = 1.05;  // of the largest speed of a row, so that curves end beyond the points
  const double load = (rows.predicted - (rows.friction - rows.residual)).cwiseAbs().mean();
  FrictionCurve out =
      friction_law(robot, result, joint, past_rows * rows.velocity.cwiseAbs().maxCoeff(), load);
  out.measured = Vector::Zero(out.velocity.size());
  out.rows = out.measured;
  for (Index k = 0; k < rows.velocity.size(); ++k) {
    const Index point = nearest_point(out.velocity, rows.velocity[k]);
    out.measured[point] += rows.friction[k];
    out.rows[point] += 1.0;
  }
  out.measured =
      (out.rows.array() > 0.0)
          .select(out.measured.array() / out.rows.array(), std::numeric_limits<double>::quiet_NaN());
  return out;
}

}  // namespace detail

std::vector<FrictionCurve> friction_curves(const Robot& robot, const Identification& result,
                                           std::span<const Prediction> logs) {
  detail::require_fitting("friction_curves", robot, result, logs);
  std::vector<FrictionCurve> out;
  for (std::size_t j = 0; j < result.fit.joints.size() && detail::predicted(result); ++j) {
    const detail::StackedRows rows = detail::stacked_rows(detail::fitted_logs(logs), j);
    if (!parameters(robot.joints[j].friction).empty() && rows.velocity.size() > 0) {
      out.push_back(detail::friction_curve(robot, result, j, rows));
    }
  }
  return out;
}

std::string to_csv(std::span<const FrictionCurve> curves) {
  std::string out = "joint,velocity,friction,sigma,low_95,high_95,a_priori,measured,rows\n";
  for (const FrictionCurve& curve : curves) {
    const Vector low = curve.torque - curve.half_width;
    const Vector high = curve.torque + curve.half_width;
    detail::CsvColumns columns(curve.velocity.size());
    for (const Vector* const each : {&curve.velocity, &curve.torque, &curve.sigma, &low, &high,
                                     &curve.a_priori, &curve.measured, &curve.rows}) {
      columns.add("", each->data());
    }
    out += columns.lines(detail::quoted_cell(curve.joint) + ',');
  }
  return out;
}

}  // namespace rivid
