#include "rivid/identify/physical.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "identify/physical/physical_problem.hpp"
#include "model/link_poses.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Bounds of single masses, and their sums.
std::optional<std::string> masses_complaint(const Robot& robot, const Physical& options) {
  double least = 0.0;
  double most = 0.0;
  const std::vector<std::string> links = detail::link_names(robot);
  std::vector<std::string> bounded;
  for (const Physical::MassBounds& bounds : options.masses) {
    const std::string what = "masses of link \"" + bounds.link + "\": ";
    if (std::ranges::find(links, bounds.link) == links.end()) {
      return what + "no moving link has this name; they are " + quoted_list(links) +
             did_you_mean(bounds.link, links);
    }
    if (std::ranges::find(bounded, bounds.link) != bounded.end()) {
      return what + "bounded twice";
    }
    if (!(bounds.least >= 0.0) || !(bounds.most > bounds.least) || !std::isfinite(bounds.least)) {
      return what + number(bounds.least) + " to " + number(bounds.most) +
             " kg, must not be negative, and the second one must be larger than the first";
    }
    bounded.push_back(bounds.link);
    least += bounds.least;
    most += bounds.most;
  }
  if (bounded.size() < links.size()) {
    most = std::numeric_limits<double>::infinity();
  }
  if (!options.total_mass) {
    return std::nullopt;
  }
  const auto [total_least, total_most] = *options.total_mass;
  if (!(total_least >= 0.0) || !(total_most > total_least) || !std::isfinite(total_least)) {
    return "total_mass is " + number(total_least) + " to " + number(total_most) +
           " kg, must not be negative, and the second one must be larger than the first";
  }
  if (total_most <= least || total_least >= most) {
    return "total_mass of " + number(total_least) + " to " + number(total_most) +
           " kg can not be reached: the links' own bounds allow " + number(least) + " to " + number(most) +
           " kg";
  }
  return std::nullopt;
}

void check(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi,
           const Eigen::Ref<const Matrix>& root, const Physical& options) {
  const auto refuse = [](const std::string& why) { throw InputError("physical: " + why); };
  if (const auto fault = robot.complaint()) {
    refuse(*fault);
  }
  if (base.standard.size() != robot.standard_parameters().size()) {
    refuse("the base parameters are those of a robot with " +
           counted(std::ssize(base.standard), "parameter") + ", not of \"" + robot.name + "\"");
  }
  if (const auto fault = options.complaint(robot)) {
    refuse(*fault);
  }
  if (chi.size() != base.size() || !chi.allFinite()) {
    refuse("chi has " + counted(chi.size(), "value") + ", must have one, finite, for each of " +
           counted(base.size(), "base parameter"));
  }
  if (root.cols() != base.size() || !root.allFinite()) {
    refuse("root has " + counted(root.cols(), "column") + ", must have one, finite, for each of " +
           counted(base.size(), "base parameter"));
  }
}

}  // namespace

std::optional<std::string> Physical::complaint(const Robot& robot) const {
  if (auto fault = range_fault(*this)) {
    return fault;
  }
  const auto size = std::ssize(robot.standard_parameters());
  if (start.size() > 0 && (start.size() != size || !start.allFinite())) {
    return "start has " + counted(start.size(), "value") + ", must have one, finite, for each of " +
           counted(size, "standard parameter");
  }
  return masses_complaint(robot, *this);
}

PhysicalParameters physical(const Robot& robot, const BaseParameters& base,
                            const Eigen::Ref<const Vector>& chi, const Eigen::Ref<const Matrix>& root,
                            const Physical& options) {
  check(robot, base, chi, root, options);
  detail::PhysicalProblem problem = detail::physical_problem(robot, base, chi, root, options);
  const detail::BarrierSolution solution =
      detail::minimise(problem.barrier, problem.start, problem.offset, options.tolerance, options.max_steps);
  PhysicalParameters out;
  out.chi_st = solution.x;
  out.chi = base.from_standard(out.chi_st);
  out.C_prior = detail::covariance_of_prior(problem, base, out.chi_st);
  out.cost = problem.barrier.cost(out.chi_st) + problem.offset;
  out.distance = 0.5 * (root * (chi - out.chi)).squaredNorm();
  out.divergence = (out.cost - out.distance) / options.weight;
  out.gap = solution.gap;
  out.steps = solution.steps;
  out.reached = solution.reached;
  out.notes = std::move(problem.notes);
  return out;
}

}  // namespace rivid
