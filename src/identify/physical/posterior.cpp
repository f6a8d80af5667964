#include "rivid/identify/posterior.hpp"

#include <cmath>

#include "accept.hpp"
#include "dense.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/physical.hpp"
#include "rivid/simulate/measurement.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Of the prior of a draw: it decides what base parameters leave open, and pulls less than a draw can show.
constexpr double slight = 1e-3;
// Directions that the covariance has with a smaller part of its largest variance, columns of unit length, are
// roundings.
constexpr double least_variance = 1e-13;

// A covariance as what draws and projections need of it. Undetermined parameters have rows and columns of
// zeros.
struct Distribution {
  Vector mean;
  Matrix spread;  // C = spread spreadᵀ, (b × kept)
  Matrix root;    // rootᵀ root = C⁻¹, (kept × b)
  std::vector<std::string> held;
};

Distribution distribution_of(const Identification& result) {
  const Matrix& C = result.answer_covariance();
  const Index b = result.base.size();
  if (C.rows() != b || C.cols() != b) {
    throw InputError("posterior_samples: the result has no covariance to draw from; identify again");
  }
  Distribution out;
  out.mean = result.answer();
  std::vector<Index> kept;
  for (Index i = 0; i < b; ++i) {
    if (std::isfinite(out.mean[i]) && std::isfinite(C(i, i)) && C(i, i) > 0.0) {
      kept.push_back(i);
    } else {
      out.held.push_back(result.base.parameters[static_cast<std::size_t>(i)].name);
      out.mean[i] = result.physical->parameters.chi[i];
    }
  }
  const double normal_975 = normal_quantile(0.975);
  const double quantile = result.covariance.quantile_975;
  const double widened = std::isfinite(quantile) && quantile > normal_975 ? quantile / normal_975 : 1.0;
  const Vector sigma = widened * C.diagonal()(kept).cwiseSqrt();
  const Vector scale = sigma.cwiseInverse();
  const Matrix own = widened * widened * C(kept, kept);
  const detail::SymmetricEigen correlation =
      detail::symmetric_eigen(scale.asDiagonal() * own * scale.asDiagonal());
  const Vector roots =
      correlation.values.cwiseMax(least_variance * correlation.values.maxCoeff()).cwiseSqrt();
  const auto size = static_cast<Index>(kept.size());
  out.spread = Matrix::Zero(b, size);
  out.spread(kept, Eigen::all) = sigma.asDiagonal() * correlation.vectors * roots.asDiagonal();
  out.root = Matrix::Zero(size, b);
  out.root(Eigen::all, kept) =
      roots.cwiseInverse().asDiagonal() * correlation.vectors.transpose() * scale.asDiagonal();
  return out;
}

// The robot with a set of parameters as its description.
Robot described_by(Robot robot, const Vector& chi_st) {
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  robot.inertials.assign(robot.chain.links.size(), Inertial::Zero());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto [kind, joint] = parameters[i];
    const double value = chi_st[static_cast<Index>(i)];
    const auto j = static_cast<std::size_t>(joint);
    switch (kind) {
      case ParameterKind::Ia:
        robot.joints[j].Ia = value;
        break;
      case ParameterKind::Fv:
        robot.joints[j].Fv = value;
        break;
      case ParameterKind::Fc:
        robot.joints[j].Fc = value;
        break;
      default:
        if (role(kind) == Role::inertial) {
          robot.inertials[j][static_cast<Index>(kind)] = value;
        }
    }
  }
  return robot;
}

void check_posterior(const Robot& robot, const Identification& result, const PosteriorOptions& options) {
  detail::accept("posterior_samples", range_fault(options));
  if (result.base.standard.size() != robot.standard_parameters().size() ||
      static_cast<std::size_t>(result.answer().size()) != result.base.parameters.size()) {
    throw InputError("posterior_samples: the result is that of another robot than \"" + robot.name + "\"");
  }
  if (!result.physical) {
    throw InputError(
        "posterior_samples: the result has no physically consistent parameters to draw bodies near; identify "
        "with --physical, or [method.physical]");
  }
}

}  // namespace

PosteriorSamples posterior_samples(const Robot& robot, const Identification& result,
                                   const PosteriorOptions& options) {
  check_posterior(robot, result, options);
  const PhysicalModel& set = *result.physical;
  const Distribution from = distribution_of(result);
  const Robot described = described_by(robot, set.parameters.chi_st);
  const Physical nearest{.weight = slight,
                         .weight_may_fall = false,
                         .masses = set.options.masses,
                         .total_mass = set.options.total_mass,
                         .start = set.parameters.chi_st};
  PosteriorSamples out{.chi_st = Matrix(options.count, set.parameters.chi_st.size()),
                       .chi = Matrix(options.count, result.base.size()),
                       .held = from.held};
  Vector z(from.spread.cols());
  for (int k = 0; k < options.count; ++k) {
    const CounterNoise noise(options.seed, static_cast<std::uint64_t>(k));
    for (Index i = 0; i < z.size(); ++i) {
      z[i] = noise.normal(static_cast<std::uint64_t>(i));
    }
    const PhysicalParameters draw =
        physical(described, result.base, from.mean + from.spread * z, from.root, nearest);
    out.chi_st.row(k) = draw.chi_st.transpose();
    out.chi.row(k) = draw.chi.transpose();
  }
  return out;
}

}  // namespace rivid
