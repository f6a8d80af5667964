#include <algorithm>
#include <cmath>
#include <string>

#include "gram.hpp"
#include "rivid/error.hpp"
#include "rivid/solve/inference.hpp"

namespace rivid {

namespace {

void require_equal_columns(std::span<const Matrix> series, const char* who) {
  for (const Matrix& s : series) {
    if (s.cols() != series.front().cols()) {
      throw InputError(std::string(who) + ": a series has " + std::to_string(s.cols()) +
                       " columns, the first has " + std::to_string(series.front().cols()) +
                       "; all must have the same");
    }
  }
}

}  // namespace

// The weights are those of overlapping sums: with b_t = s_t + … + s_{t+L}, zeros beyond the ends, S = Σ_t b_t
// b_tᵀ / (L + 1).
Matrix long_run_covariance(std::span<const Matrix> series, Index lag) {
  require_equal_columns(series, "long_run_covariance");
  constexpr Index most_lag = 100'000'000;  // instants; more is a mistake: 0.8 GB for each column
  if (lag < 0 || lag > most_lag) {
    throw InputError("long_run_covariance: lag is " + std::to_string(lag) + ", must be at least 0" +
                     (lag > most_lag ? " and at most " + std::to_string(most_lag) : ""));
  }
  const Index columns = series.empty() ? 0 : series.front().cols();
  Matrix out = Matrix::Zero(columns, columns);
  for (const Matrix& s : series) {
    const Index T = s.rows();
    Matrix sums(T + lag, columns);
    Vector sum = Vector::Zero(columns);
    for (Index t = 0; t < T + lag; ++t) {
      if (t < T) {
        sum += s.row(t).transpose();
      }
      if (t > lag) {
        sum -= s.row(t - lag - 1).transpose();
      }
      sums.row(t) = sum;
    }
    detail::add_gram(out, sums, 1.0 / static_cast<double>(lag + 1));
  }
  return out.selfadjointView<Eigen::Lower>();
}

Index bartlett_lag(std::span<const Matrix> series) {
  if (series.empty()) {
    return 0;
  }
  require_equal_columns(series, "bartlett_lag");
  // bound of ρ, the 0.97 of [Andrews & Monahan 1992]: at 1 the lag is infinite
  constexpr double most_correlated = 0.97;
  Index instants = 0;
  double numerator = 0.0;
  double denominator = 0.0;
  for (const Matrix& s : series) {
    instants += s.rows();
  }
  for (Index c = 0; c < series.front().cols(); ++c) {
    double squares = 0.0;
    double products = 0.0;
    for (const Matrix& s : series) {
      const Index m = std::max<Index>(s.rows() - 1, 0);
      squares += s.col(c).squaredNorm();
      products += s.col(c).head(m).dot(s.col(c).tail(m));
    }
    if (!(squares > 0.0)) {
      continue;
    }
    const double rho = std::clamp(products / squares, -most_correlated, most_correlated);
    // Per unit of the innovation's variance, which the weights cancel.
    numerator += 4.0 * rho * rho / (std::pow(1.0 - rho, 6.0) * std::pow(1.0 + rho, 2.0));
    denominator += 1.0 / std::pow(1.0 - rho, 4.0);
  }
  if (!(denominator > 0.0)) {
    return 0;
  }
  const double alpha = numerator / denominator;
  const double lag = 1.1447 * std::cbrt(alpha * static_cast<double>(instants));
  return std::clamp<Index>(static_cast<Index>(std::ceil(lag)), 0, instants / 4);
}

double fixed_lag_widening(double part) {
  return (1.9600 + part * (2.9694 + part * (0.4160 - 0.5324 * part))) / 1.9600;
}

}  // namespace rivid
