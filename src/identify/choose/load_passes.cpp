#include "identify/choose/load_passes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "identify/estimate/estimate.hpp"
#include "identify/infer/infer.hpp"
#include "rivid/regressor/load.hpp"

namespace rivid::detail {

namespace {

constexpr int most_passes = 100;  // a choice that ends what does not settle
// Step of a parameter, in its deviations for independent errors, with which the passes end.
constexpr double small_step = 0.02;
// … or relative to the largest parameter, where there is no noise.
constexpr double rounding_step = 1e-9;
// Steps that do not get smaller go round in a circle, where a load is hardly more than noise: they are
// shortened.
constexpr double least_part = 0.1;
// A tangent at a larger part of the load would divide by almost nothing.
constexpr double largest_slope = 0.9;

// An estimate and the deviations of independent errors; nothing where there is none.
struct Point {
  Vector chi;
  Vector sigma;
};

std::optional<Point> estimated_point(const EstimationProblem& problem) {
  const Estimated found = estimated(problem);
  if (!found.estimate || !found.estimate->chi.allFinite()) {
    return std::nullopt;
  }
  return Point{found.estimate->chi,
               found.estimate->sigma * finite_part(found.estimate->unit_covariance).diagonal().cwiseSqrt()};
}

// A point that a tangent can be taken at.
Vector bounded(const BaseParameters& base, Vector chi) {
  for (Index i = 0; i < base.size(); ++i) {
    if (about(base.parameters[static_cast<std::size_t>(i)].leading.kind).basis == Basis::load) {
      chi[i] = std::clamp(chi[i], -largest_slope, largest_slope);
    }
  }
  return chi;
}

// Standard deviation of what an estimate leaves of each joint's rows, (n).
Vector residuals(const RowFactors& data, const Vector& chi) {
  Vector out(static_cast<Index>(data.groups.size()));
  for (std::size_t j = 0; j < data.groups.size(); ++j) {
    const RowGroup& group = data.groups[j];
    out[static_cast<Index>(j)] = group.qr.residual_norm(chi(group.columns)) /
                                 std::sqrt(static_cast<double>(std::max<Index>(group.qr.rows(), 1)));
  }
  return out;
}

// The estimate without friction that follows the load, as parameters of the robot. What it leaves is where
// the kink of the tangents is rounded: a sharp one would let rows whose load is hardly more than noise jump
// to and fro.
LoadPoint first_point(const Robot& robot, std::span<const Log> logs, const Estimation& asked,
                      const BaseParameters& base) {
  const Robot plain = without_load(robot);
  Estimation estimation = asked;
  if (auto* const iv = std::get_if<Iv>(&estimation.method); iv != nullptr && iv->chi_0.size() > 0) {
    iv->chi_0 = carried_over(base, iv->chi_0, base_parameters(plain));
  }
  const EstimationProblem problem(plain, logs, estimation);
  const std::optional<Point> found = estimated_point(problem);
  const Vector chi = found ? found->chi : problem.base.from_standard(plain.chi_st());
  return {carried_over(problem.base, chi, base), residuals(problem.data, chi)};
}

}  // namespace

Vector carried_over(const BaseParameters& from, const Vector& chi, const BaseParameters& to) {
  Vector out = Vector::Zero(to.size());
  for (Index i = 0; i < to.size(); ++i) {
    const StandardParameter& wanted = to.parameters[static_cast<std::size_t>(i)].leading;
    for (Index k = 0; k < from.size(); ++k) {
      const StandardParameter& given = from.parameters[static_cast<std::size_t>(k)].leading;
      if (given.kind == wanted.kind && given.joint == wanted.joint) {
        out[i] = chi[k];
      }
    }
  }
  return out;
}

LoadPasses load_passes(const Robot& robot, std::span<const Log> logs, const Estimation& estimation) {
  const BaseParameters base = base_parameters(robot);
  LoadPasses out = {.point = first_point(robot, logs, estimation, base),
                    .fault = "the load of the joints and their friction do not settle on each other in " +
                             std::to_string(most_passes) + " passes"};
  Vector& chi = out.point.chi;
  double part = 1.0;
  double before = std::numeric_limits<double>::infinity();
  Vector unit;  // that steps are measured in
  for (int pass = 0; pass < most_passes; ++pass) {
    const std::optional<Point> next = estimated_point(EstimationProblem(robot, logs, estimation, out.point));
    if (!next) {
      out.fault.clear();  // the last step will say why
      break;
    }
    const Vector step = (next->chi - chi).cwiseAbs();
    unit = pass == 0 ? Vector(next->sigma.cwiseMax(1e-300)) : unit;
    const double size = step.cwiseQuotient(unit).maxCoeff();
    part = size > before ? std::max(0.5 * part, least_part) : std::min(1.2 * part, 1.0);
    before = size;
    chi = bounded(base, chi + part * (next->chi - chi));
    const double rounding = rounding_step * chi.cwiseAbs().maxCoeff();
    if ((step.array() <= (small_step * next->sigma).array().max(rounding)).all()) {
      out.fault.clear();
      break;
    }
  }
  return out;
}

}  // namespace rivid::detail
