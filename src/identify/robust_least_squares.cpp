#include "identify/robust_least_squares.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "identify/factor_sink.hpp"
#include "identify/robust_covariance.hpp"
#include "identify/thread_team.hpp"

namespace rivid::detail {

namespace {

// A⁻¹ B A⁻¹ on what is determined.
Matrix sandwich(const LeastSquares& A, const Matrix& root_B) {
  const Vector undetermined =
      A.unit_covariance.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? 0.0 : x; });
  Matrix bread = A.unit_covariance;
  bread.diagonal() = bread.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
  const Matrix half = root_B * bread;
  Matrix out = half.transpose() * half;
  out.diagonal() += undetermined;
  return out;
}

}  // namespace

RobustLeastSquares robust_least_squares(const Robot& robot, const BaseParameters& base,
                                        std::span<const Log> logs, const SignalOptions& signal,
                                        const RowFactors& data, const Vector& chi, bool by_joint,
                                        const Robust& options, int threads, const Progress& progress) {
  ThreadTeam team(threads);
  Reweighting reweighting(options, chi, data.groups.size());
  std::vector<RowGroup> groups;
  const auto make_rows = [&] {
    groups = empty_groups(data.groups);
    for (std::size_t k = 0; k < logs.size(); ++k) {
      RowSource source(robot, base, logs[k], signal, team);
      const FactorSinks factors(groups);
      const ReweightedSinks weighted(factors.sinks(), &reweighting, groups, {});
      source.send(weighted.sinks());
      if (progress) {
        progress("round " + std::to_string(reweighting.rounds() + 1),
                 static_cast<double>(k + 1) / static_cast<double>(logs.size()));
      }
    }
  };
  RobustLeastSquares out;
  const auto solve = [&] {
    out.weights = by_joint ? reweighting.weights() : std::vector<double>(groups.size(), 1.0);
    const LeastSquares solution = least_squares(groups, base.size(), out.weights);
    const double sigma = robust_deviation(reweighting.sums(), reweighting.loss(), out.weights);
    return Reweighting::Solution{solution.chi, sigma * solution.unit_covariance.diagonal().cwiseSqrt()};
  };
  reweighting.settle(make_rows, solve);
  out.settled = reweighting.settled();
  out.chi = reweighting.chi();
  out.loss = reweighting.loss();
  out.sums = reweighting.sums();
  out.rounds = reweighting.rounds();
  const RobustInformation information = robust_information(out.sums, out.loss, out.weights, base.size());
  out.information = least_squares(data.groups, base.size(), information.bread);
  out.C = sandwich(out.information, combined(data.groups, base.size(), information.meat).R());
  out.sigma = information.sigma;
  out.deviation = robust_deviation(out.sums, out.loss, out.weights);
  return out;
}

}  // namespace rivid::detail
