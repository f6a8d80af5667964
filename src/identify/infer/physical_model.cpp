#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "dense.hpp"
#include "identify/infer/infer.hpp"
#include "identify/rows/factors.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Condition index of columns of unit length from which [Belsley 1980] calls collinearity severe; and the
// part of a parameter's variance that must come from such directions for it to suffer.
constexpr double severe = 100.0;
constexpr double most_of_the_variance = 0.5;
// They suffer where the index takes a residual of this part of the torques to that size: small errors of the
// model are multiplied by it at most.
constexpr double harmful = 10.0;

void warn_of_weak_excitation(const BaseParameters& base, const Matrix& root, Inference& out) {
  const Matrix scaled = root * root.colwise().norm().cwiseInverse().asDiagonal();
  const Svd factors = svd(scaled, Eigen::ComputeThinV);
  const Vector& s = factors.values;
  const Index size = s.size();
  const double index = s[0] / s[size - 1];
  if (!(index > severe) || !(index * out.fit.centred_relative_error > harmful)) {
    return;
  }
  const Index weak = (s.array() * severe < s[0]).count();
  const Matrix shares = (factors.V * s.cwiseInverse().asDiagonal()).cwiseAbs2();
  std::vector<std::string> names;
  for (Index i = 0; i < size; ++i) {
    if (shares.row(i).tail(weak).sum() > most_of_the_variance * shares.row(i).sum()) {
      names.push_back(base.parameters[static_cast<std::size_t>(i)].name);
    }
  }
  out.warnings.push_back(
      Finding{"weak_excitation",
              {},
              "weak excitation: the data hardly distinguish " + listed(names) + " (condition " +
                  number(index, 3) + " with columns of unit length, severe above " + number(severe) +
                  "), so the model may not carry over to other motions; more exciting logs, or the "
                  "physically consistent parameters near the robot description, would settle them"});
}

// The pull of the description may cost this part of the residual sum of squares.
constexpr double tolerable_price = 0.1;
constexpr double least_weight = 1e-6;
// Where a tenth of the weight does not lower the price by so much, it is not the pull that costs.
constexpr double worth_it = 0.9;

// Weights of the prior that are validated, over the one that was given.
constexpr std::array<double, 7> tried_weights = {1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3};

// By what the sum of squares of each block grows when parameters come from the other blocks, with the prior's
// weight: for each block one entry; none where the others do not determine the parameters.
std::vector<double> validated(const EstimationProblem& problem, const Physical& options,
                              const Estimate& estimate, std::span<const BlockSums> blocks) {
  const Index b = problem.base.size();
  const double sigma = estimate.sigma;
  Matrix all = Matrix::Zero(b, b);
  for (const BlockSums& block : blocks) {
    all += 0.5 * (block.ZW + block.ZW.transpose());
  }
  std::vector<double> out;
  for (const BlockSums& block : blocks) {
    const Matrix own = 0.5 * (block.ZW + block.ZW.transpose());
    const SymmetricEigen others = symmetric_eigen(all - own);
    if (!(others.values[0] > 0.0)) {
      return {};
    }
    const Matrix root = others.values.cwiseSqrt().asDiagonal() * others.vectors.transpose() / sigma;
    const Vector chi = estimate.chi - solve(all - own, block.Z_rho);
    const Vector change = physical(problem.robot, problem.base, chi, root, options).chi - estimate.chi;
    out.push_back((change.dot(own * change) - 2.0 * change.dot(block.Z_rho)) / (sigma * sigma));
  }
  return out;
}

// The weight with which blocks of time are predicted best by the others; the largest one of those that do
// hardly worse. Nothing where blocks can not say.
std::optional<double> weight_by_prediction(const EstimationProblem& problem, const Physical& options,
                                           const Estimated& found, std::span<const BlockSums> blocks) {
  if (blocks.size() < 4 || found.status != Status::identified) {
    return std::nullopt;
  }
  std::vector<std::vector<double>> errors;
  for (const double factor : tried_weights) {
    Physical tried = options;
    tried.weight = factor * options.weight;
    errors.push_back(validated(problem, tried, *found.estimate, blocks));
    if (errors.back().empty()) {
      return std::nullopt;
    }
  }
  const auto sum = [](const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); };
  const auto best = std::ranges::min_element(errors, {}, sum);
  std::size_t chosen = static_cast<std::size_t>(best - errors.begin());
  for (std::size_t w = chosen + 1; w < errors.size(); ++w) {
    // The differences of the blocks, and what their sum scatters by.
    double difference = 0.0;
    double squares = 0.0;
    for (std::size_t g = 0; g < blocks.size(); ++g) {
      const double d = errors[w][g] - (*best)[g];
      difference += d;
      squares += d * d;
    }
    if (difference <= std::sqrt(squares)) {
      chosen = w;
    }
  }
  return tried_weights[chosen] * options.weight;
}

// The parameters, and the options with the weight that they were found with.
PhysicalModel found_model(const EstimationProblem& problem, Physical options, const Estimated& found,
                          std::span<const BlockSums> blocks) {
  const Matrix root = found.estimate->root / found.estimate->sigma;
  const auto freedom = static_cast<double>(rows_of(problem.data.groups) - problem.base.size());
  const auto with = [&](const Physical& some) {
    return physical(problem.robot, problem.base, found.estimate->chi, root, some);
  };
  PhysicalModel out;
  if (options.weight_may_fall) {
    if (const auto weight = weight_by_prediction(problem, options, found, blocks)) {
      options.weight = *weight;
      options.weight_may_fall = false;
    }
  }
  out.options = options;
  out.parameters = with(options);
  while (options.weight_may_fall && out.parameters.distance > 0.5 * tolerable_price * freedom &&
         out.options.weight > least_weight) {
    Physical lower = out.options;
    lower.weight *= 0.1;
    PhysicalParameters weaker = with(lower);
    if (weaker.distance > worth_it * out.parameters.distance) {
      break;
    }
    out.options = lower;
    out.parameters = std::move(weaker);
  }
  return out;
}

}  // namespace

void add_physical(const EstimationProblem& problem, const Estimated& found, std::span<const BlockSums> blocks,
                  Inference& out) {
  const std::optional<Physical>& options = problem.estimation.physical;
  if (!options) {
    if (found.status != Status::rank_deficient) {
      warn_of_weak_excitation(problem.base, found.estimate->root / found.estimate->sigma, out);
    }
    return;
  }
  PhysicalModel model = found_model(problem, *options, found, blocks);
  if (model.options.weight != options->weight && model.options.weight_may_fall) {
    out.notes.push_back(
        "the robot description is far from what the data say: the physically consistent "
        "parameters follow it with the weight " +
        number(model.options.weight, 3) + " instead of " + number(options->weight, 3));
  }
  if (options->weight_may_fall && !model.options.weight_may_fall) {
    out.notes.push_back("the physically consistent parameters follow the robot description with the weight " +
                        number(model.options.weight, 3) +
                        ", with which the logs predict their own blocks of time best");
  }
  model.fit = fit_to(problem.robot, problem.rows_to_judge(), model.parameters.chi, problem.base.size(),
                     problem.estimation.signal.convention);
  out.notes.insert(out.notes.end(), model.parameters.notes.begin(), model.parameters.notes.end());
  if (!model.parameters.reached) {
    out.warnings.push_back(Finding{"physical_unsettled",
                                   {},
                                   "the search for the physically consistent parameters ended after " +
                                       counted(model.parameters.steps, "step") +
                                       ", before their cost was known to be the least to within " +
                                       number(options->tolerance) + " of itself; larger max_steps may help"});
  }
  out.physical = std::move(model);
}

}  // namespace rivid::detail
