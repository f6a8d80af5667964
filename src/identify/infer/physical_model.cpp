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
// the weight falls by tenths to here; a choice that ends its fall
constexpr double least_weight = 1e-6;
// Where a tenth of the weight does not lower the price by so much, it is not the pull that costs.
constexpr double worth_it = 0.9;

// Blocks that are left out err by so much more than with them, of all squared residuals, where physically
// consistent parameters may predict better than the estimate.
constexpr double loose = 1.0;

// Weights of the prior that are validated, over the one that was given.
constexpr std::array<double, 7> tried_weights = {1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3};

// Directions of the rows of all blocks but one, of columns of unit length, that these do not determine: their
// part of the largest square.
constexpr double undetermined_part = 1e-12;

// What is left out one by one of the blocks of time, by what is left.
struct LeftOut {
  std::vector<double> growth;  // of each block's sum of squares over that with the estimate, in σ²
  Matrix chi;                  // without each block, (b × blocks)
};

// Of the estimate, or with options of the physically consistent parameters. What the other blocks leave open
// is the least solution there, as of the estimate itself, or the description's.
LeftOut without_blocks(const EstimationProblem& problem, const Estimate& estimate,
                       std::span<const BlockSums> blocks, const Physical* options = nullptr) {
  const Index b = problem.base.size();
  const double sigma = estimate.sigma;
  Matrix all = Matrix::Zero(b, b);
  for (const BlockSums& block : blocks) {
    all += 0.5 * (block.ZW + block.ZW.transpose());
  }
  const Vector norms = all.diagonal().cwiseSqrt().unaryExpr([](double x) { return x > 0.0 ? x : 1.0; });
  const Vector scale = norms.cwiseInverse();
  LeftOut out{.growth = {}, .chi = Matrix(b, std::ssize(blocks))};
  for (const BlockSums& block : blocks) {
    const Matrix own = 0.5 * (block.ZW + block.ZW.transpose());
    const SymmetricEigen others = symmetric_eigen(scale.asDiagonal() * (all - own) * scale.asDiagonal());
    const double least = undetermined_part * others.values[b - 1];
    const Vector inverse = others.values.unaryExpr([&](double x) { return x > least ? 1.0 / x : 0.0; });
    const Vector pull = (all - own) * estimate.chi - block.Z_rho;
    const Vector seen = others.vectors.transpose() * scale.asDiagonal() * pull;
    Vector chi = scale.asDiagonal() * (others.vectors * inverse.cwiseProduct(seen));
    if (options != nullptr) {
      const Vector roots = others.values.unaryExpr([&](double x) { return x > least ? std::sqrt(x) : 0.0; });
      const Matrix root = roots.asDiagonal() * others.vectors.transpose() * norms.asDiagonal() / sigma;
      chi = physical(problem.robot, problem.base, chi, root, *options).chi;
    }
    const Vector change = chi - estimate.chi;
    out.chi.col(std::ssize(out.growth)) = chi;
    out.growth.push_back((change.dot(own * change) - 2.0 * change.dot(block.Z_rho)) / (sigma * sigma));
  }
  return out;
}

double total(const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); }

// By what the blocks are predicted better than by another set, over what the sum of these differences
// scatters by.
double advantage(const LeftOut& of, const LeftOut& over) {
  double difference = 0.0;
  double squares = 0.0;
  for (std::size_t g = 0; g < of.growth.size(); ++g) {
    const double d = over.growth[g] - of.growth[g];
    difference += d;
    squares += d * d;
  }
  return squares > 0.0 ? difference / std::sqrt(squares) : 0.0;
}

// Covariance by the jackknife, as large at least as what the blocks that were left out err by: half of the
// growth is what the estimate with the block takes up of its errors.
Matrix covariance_by_blocks(const LeftOut& found, std::span<const BlockSums> blocks, double sigma) {
  const auto G = static_cast<double>(blocks.size());
  const Matrix apart = found.chi.colwise() - found.chi.rowwise().mean();
  const Matrix C = (G - 1.0) / G * apart * apart.transpose();
  double expected = 0.0;
  for (const BlockSums& block : blocks) {
    expected += 2.0 * block.ZW.cwiseProduct(C).sum() / (sigma * sigma);
  }
  return expected > 0.0 ? std::max(total(found.growth) / expected, 1.0) * C : C;
}

// The physically consistent parameters, and what the blocks say of them.
struct Consistent {
  PhysicalModel model;
  LeftOut blocks;  // empty where they can not say
};

// The options with the weight with which blocks of time are predicted best by the others: the largest one of
// those that do hardly worse.
Consistent by_prediction(const EstimationProblem& problem, const Physical& options, const Estimate& estimate,
                         std::span<const BlockSums> blocks) {
  std::vector<LeftOut> found;
  const auto with = [&](double factor) {
    Physical out = options;
    out.weight *= factor;
    out.weight_may_fall = false;
    return out;
  };
  const bool open = estimate.rank < estimate.chi.size();
  const std::span<const double> weights =
      std::span(tried_weights).subspan(open ? tried_weights.size() / 2 : 0);
  for (const double factor : weights) {
    const Physical tried = with(factor);
    found.push_back(without_blocks(problem, estimate, blocks, &tried));
  }
  const auto best = std::ranges::min_element(found, {}, [](const LeftOut& one) { return total(one.growth); });
  std::size_t chosen = static_cast<std::size_t>(best - found.begin());
  for (std::size_t w = chosen + 1; w < found.size(); ++w) {
    chosen = advantage(*best, found[w]) <= 1.0 ? w : chosen;
  }
  Consistent out;
  out.model.options = with(weights[chosen]);
  out.blocks = std::move(found[chosen]);
  return out;
}

// The parameters, and the options with the weight that they were found with.
//
// plain  what the blocks say of the estimate; empty where they can not say
PhysicalModel found_model(const EstimationProblem& problem, const Physical& options, const Estimated& found,
                          std::span<const BlockSums> blocks, const LeftOut& plain) {
  const Estimate& estimate = *found.estimate;
  const Matrix root = estimate.root / estimate.sigma;
  const auto freedom = static_cast<double>(rows_of(problem.data.groups) - problem.base.size());
  const auto with = [&](const Physical& some) {
    return physical(problem.robot, problem.base, estimate.chi, root, some);
  };
  Consistent out;
  out.model.options = options;
  if (!plain.growth.empty()) {
    if (options.weight_may_fall) {
      out = by_prediction(problem, options, estimate, blocks);
    } else {
      out.blocks = without_blocks(problem, estimate, blocks, &options);
    }
    // What rows leave open, the least solution says no better than the description does.
    out.model.better = found.status == Status::rank_deficient || advantage(out.blocks, plain) > 1.0;
  }
  PhysicalModel& model = out.model;
  model.parameters = with(model.options);
  while (model.options.weight_may_fall && model.parameters.distance > 0.5 * tolerable_price * freedom &&
         model.options.weight > least_weight) {
    Physical lower = model.options;
    lower.weight *= 0.1;
    PhysicalParameters weaker = with(lower);
    if (weaker.distance > worth_it * model.parameters.distance) {
      break;
    }
    model.options = lower;
    model.parameters = std::move(weaker);
  }
  model.better = model.better && model.parameters.reached;
  if (!out.blocks.growth.empty()) {
    model.C_chi = covariance_by_blocks(out.blocks, blocks, estimate.sigma) + model.parameters.C_prior;
  }
  model.fit = fit_to(problem.robot, problem.rows_to_judge(), model.parameters.chi, problem.base.size(),
                     problem.estimation.signal.convention);
  return std::move(out.model);
}

}  // namespace

void add_physical(const EstimationProblem& problem, const Estimated& found, std::span<const BlockSums> blocks,
                  Inference& out) {
  const std::optional<Physical>& options = problem.estimation.physical;
  const bool open = found.status == Status::rank_deficient;
  const bool says = blocks.size() >= 4 && (open || found.status == Status::identified);
  const LeftOut plain = says ? without_blocks(problem, *found.estimate, blocks) : LeftOut();
  if (!options) {
    if (!open) {
      warn_of_weak_excitation(problem.base, found.estimate->root / found.estimate->sigma, out);
    }
    const auto rows = static_cast<double>(found.estimate->rows);
    if (problem.estimation.judge && !plain.growth.empty() && (open || total(plain.growth) > loose * rows)) {
      PhysicalModel model = found_model(problem, Physical{}, found, blocks, plain);
      if (model.better) {
        out.physical = std::move(model);
      }
    }
    return;
  }
  PhysicalModel model = found_model(problem, *options, found, blocks, plain);
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
