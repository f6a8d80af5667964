#include <cmath>
#include <limits>
#include <numbers>

#include "normal_quantile.hpp"
#include "rivid/solve/inference.hpp"

namespace rivid {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double none = std::numeric_limits<double>::quiet_NaN();
// Differences of ln Γ have no digits beyond.
constexpr double most_freedom = 1e12;
bool usable(double freedom) { return freedom > 0.0 && freedom <= most_freedom; }
// Stands for a zero in a continued fraction, after Lentz.
constexpr double tiny = 1e-300;
// of a continued fraction or a series; a choice that ends any
constexpr int most_terms = 10'000;

// A continued fraction b_0 + a_1 / (b_1 + a_2 / (b_2 + …)), by Lentz's method; term(k) gives a_k and b_k from
// k = 1 on.
struct Term {
  double a;
  double b;
};
template <typename Terms>
double continued_fraction(double b_0, const Terms& term) {
  double f = b_0 == 0.0 ? tiny : b_0;
  double c = f;
  double d = 0.0;
  for (int k = 1; k < most_terms; ++k) {
    const auto [a, b] = term(k);
    d = b + a * d;
    d = 1.0 / (d == 0.0 ? tiny : d);
    c = b + a / c;
    c = c == 0.0 ? tiny : c;
    f *= c * d;
    if (std::abs(c * d - 1.0) < epsilon) {
      return f;
    }
  }
  return none;
}

// ln Γ(a) for a > 0. std::lgamma() writes the sign to a variable that all threads share.
double log_gamma(double a) {
  int sign = 0;
  return ::lgamma_r(a, &sign);
}

// Γ(a, x) / Γ(a), Abramowitz and Stegun 6.5.29 and 6.5.31.
double upper_gamma(double a, double x) {
  const double front = std::exp(a * std::log(x) - x - log_gamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a;
    double sum = term;
    for (int k = 1; k < most_terms && term > epsilon * sum; ++k) {
      term *= x / (a + k);
      sum += term;
    }
    return term > epsilon * sum ? none : 1.0 - front * sum;
  }
  return front /
         continued_fraction(x + 1.0 - a, [&](int k) { return Term{-k * (k - a), x + 1.0 - a + 2.0 * k}; });
}

// I_x(a, b), Abramowitz and Stegun 26.5.8.
double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0 || x >= 1.0) {
    return x <= 0.0 ? 0.0 : 1.0;
  }
  if (x > (a + 1.0) / (a + b + 2.0)) {
    return 1.0 - incomplete_beta(b, a, 1.0 - x);
  }
  const double front =
      std::exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
  return front / continued_fraction(1.0, [&](int k) {
           const double m = std::floor(0.5 * k);
           const double numerator = k % 2 == 0
                                        ? m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
                                        : -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
           return Term{numerator, 1.0};
         });
}

}  // namespace

double chi_square_tail(double x, double freedom) {
  if (std::isnan(x) || !usable(freedom)) {
    return none;
  }
  return x > 0.0 ? upper_gamma(0.5 * freedom, 0.5 * x) : 1.0;
}

double f_tail(double x, double freedom_1, double freedom_2) {
  if (std::isnan(x) || !usable(freedom_1) || !usable(freedom_2)) {
    return none;
  }
  return x > 0.0 ? incomplete_beta(0.5 * freedom_2, 0.5 * freedom_1, freedom_2 / (freedom_2 + freedom_1 * x))
                 : 1.0;
}

double student_quantile_975(double freedom) {
  if (!(freedom >= 1.0)) {
    return none;
  }
  // Exact for one and two degrees of freedom; above, the expansion of Fisher and Cornish in 1/freedom
  // (Abramowitz and Stegun 26.7.5), whose error is 0.12 % at 3 degrees of freedom and 1e-5 at 8.
  if (freedom < 1.5) {
    return std::tan(0.475 * std::numbers::pi);
  }
  if (freedom < 2.5) {
    return 0.95 * std::sqrt(2.0 / (1.0 - 0.95 * 0.95));
  }
  const double z = detail::normal_quantile_975;
  const double z2 = z * z;
  const double g1 = z * (z2 + 1.0) / 4.0;
  const double g2 = z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
  const double g3 = z * (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
  const double g4 = z * ((((79.0 * z2 + 776.0) * z2 + 1482.0) * z2 - 1920.0) * z2 - 945.0) / 92160.0;
  return z + (g1 + (g2 + (g3 + g4 / freedom) / freedom) / freedom) / freedom;
}

}  // namespace rivid
