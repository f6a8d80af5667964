#include "rivid/signal/decimate.hpp"

#include <cmath>
#include <utility>

#include "forward_backward.hpp"
#include "message.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

constexpr int order = 8;
constexpr double ripple_db = 0.05;
constexpr double band = 0.8;

void check(const char* function, int n_d) {
  if (n_d < 1) {
    throw InputError(detail::message(function, ": n_d is ", n_d, ", must be at least 1"));
  }
}

Index first_kept(Index n_m, int n_d, Convention convention) {
  return convention == Convention::matlab ? (n_m + n_d - 1) % n_d : 0;
}

}  // namespace

Filter decimation_filter(int n_d, Convention convention) {
  check("decimation_filter", n_d);
  if (n_d == 1) {
    return {};
  }
  Filter filter = chebyshev1(order, ripple_db, band / (2.0 * n_d), 1.0);
  if (convention == Convention::standard) {
    const double at_rest = gain(filter, 0.0, 1.0);
    SecondOrderSection& first = filter.sections.front();
    first.b0 /= at_rest;
    first.b1 /= at_rest;
    first.b2 /= at_rest;
  }
  return filter;
}

std::vector<Index> kept_samples(Index n_m, int n_d, Convention convention) {
  check("kept_samples", n_d);
  std::vector<Index> kept;
  for (Index k = first_kept(n_m, n_d, convention); k < n_m; k += n_d) {
    kept.push_back(k);
  }
  return kept;
}

std::vector<Index> kept_samples(Index n_m, const std::vector<int>& stages, Convention convention) {
  std::vector<Index> kept = kept_samples(n_m, 1, convention);
  for (const int n_d : stages) {
    std::vector<Index> still;
    for (const Index k : kept_samples(static_cast<Index>(kept.size()), n_d, convention)) {
      still.push_back(kept[static_cast<std::size_t>(k)]);
    }
    kept = std::move(still);
  }
  return kept;
}

Matrix decimate(const Eigen::Ref<const Matrix>& x, int n_d, Convention convention) {
  check("decimate", n_d);
  if (n_d == 1) {
    return x;
  }
  if (convention == Convention::standard) {
    StreamingDecimator decimator(x.cols(), n_d);
    const Matrix finished = decimator.add(x);
    const Matrix open = decimator.finish();
    Matrix out(finished.rows() + open.rows(), x.cols());
    out << finished, open;
    return out;
  }
  return detail::forward_backward("decimate", x, decimation_filter(n_d, convention), convention,
                                  first_kept(x.rows(), n_d, convention), n_d);
}

Matrix decimate(const Eigen::Ref<const Matrix>& x, const std::vector<int>& stages, Convention convention) {
  Matrix out = x;
  for (const int n_d : stages) {
    out = decimate(out, n_d, convention);
  }
  return out;
}

double deviation_factor(const std::vector<int>& stages, Convention convention) {
  struct Pass {
    Filter filter;
    double f_m;  // per rate of the first stage
  };
  constexpr int points_of_a_row = 64;  // |H|⁴ is smooth over the band of the rows
  std::vector<Pass> passes;
  int n_d = 1;
  for (const int stage : stages) {
    passes.push_back({decimation_filter(stage, convention), 1.0 / n_d});
    n_d *= stage;
  }
  const int points = points_of_a_row * n_d;
  double sum = 0.0;
  for (int k = 0; k < points; ++k) {
    const double f = 0.5 * (k + 0.5) / points;
    double H = 1.0;
    for (const Pass& pass : passes) {
      // Above half the rate of a stage what is left of a frequency shows as its alias.
      const double alias = std::abs(std::remainder(f, pass.f_m));
      H *= gain(pass.filter, alias, pass.f_m);
    }
    sum += H * H * H * H;
  }
  return std::sqrt(n_d * sum / points);
}

}  // namespace rivid
