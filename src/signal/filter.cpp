#include "rivid/signal/filter.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "message.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

// Below, 1 + a1 + a2 has lost so many digits that the sections are no longer the asked filter.
constexpr double lowest_cutoff = 1e-5;

void check(const char* function, int order, double cutoff_hz, double f_m) {
  if (order < 1) {
    throw InputError(detail::message(function, ": order is ", order, ", must be at least 1"));
  }
  if (!std::isfinite(f_m) || f_m <= 0.0) {
    throw InputError(detail::message(function, ": f_m is ", f_m, " Hz, must be positive and finite"));
  }
  const bool between = cutoff_hz > 0.0 && cutoff_hz < 0.5 * f_m;
  if (!between) {
    throw InputError(detail::message(function, ": cutoff_hz is ", cutoff_hz,
                                     " Hz, must lie between 0 and f_m / 2 = ", 0.5 * f_m, " Hz"));
  }
  if (cutoff_hz < lowest_cutoff * f_m) {
    throw InputError(detail::message(function, ": cutoff_hz is ", cutoff_hz,
                                     " Hz, must be at least 1e-5 f_m = ", lowest_cutoff * f_m,
                                     " Hz; decimate first"));
  }
}

// b from the rounded a, so that the gain at f = 0 is 1 to the last digit although a1 and a2 nearly cancel.
SecondOrderSection second_order(double a1, double a2) {
  const double b = 0.25 * ((1.0 + a1) + a2);
  return {.b0 = b, .b1 = 2.0 * b, .b2 = b, .a1 = a1, .a2 = a2};
}

SecondOrderSection first_order(double a1) {
  const double b = 0.5 * (1.0 + a1);
  return {.b0 = b, .b1 = b, .b2 = 0.0, .a1 = a1, .a2 = 0.0};
}

// Bilinear transform of the all-pole prototype with poles −width sin θ ± i height cos θ,
// θ = (2k + 1) π / (2 order), scaled by the prewarped cut-off tan(π f_c / f_m).
Filter low_pass(int order, double width, double height, double cutoff_hz, double f_m) {
  const double warped = std::tan(std::numbers::pi * cutoff_hz / f_m);
  Filter filter{.sections = {}, .order = order};
  if (order % 2 == 1) {
    const double pole = warped * width;
    filter.sections.push_back(first_order((pole - 1.0) / (pole + 1.0)));
  }
  for (int k = order / 2 - 1; k >= 0; --k) {
    const double theta = std::numbers::pi * (2 * k + 1) / (2 * order);
    const double damping = 2.0 * warped * width * std::sin(theta);
    const double modulus =
        std::pow(warped * std::hypot(width * std::sin(theta), height * std::cos(theta)), 2);
    const double a0 = 1.0 + damping + modulus;
    filter.sections.push_back(second_order(2.0 * (modulus - 1.0) / a0, (1.0 - damping + modulus) / a0));
  }
  return filter;
}

double pole_modulus(const SecondOrderSection& section) {
  const double half = 0.5 * section.a1;
  const double discriminant = half * half - section.a2;
  return discriminant < 0.0 ? std::sqrt(section.a2) : std::abs(half) + std::sqrt(discriminant);
}

}  // namespace

Filter butterworth(int order, double cutoff_hz, double f_m) {
  check("butterworth", order, cutoff_hz, f_m);
  return low_pass(order, 1.0, 1.0, cutoff_hz, f_m);
}

Filter chebyshev1(int order, double ripple_db, double cutoff_hz, double f_m) {
  check("chebyshev1", order, cutoff_hz, f_m);
  if (!std::isfinite(ripple_db) || ripple_db <= 0.0) {
    throw InputError(
        detail::message("chebyshev1: ripple_db is ", ripple_db, " dB, must be positive and finite"));
  }
  const double epsilon = std::sqrt(std::expm1(0.1 * ripple_db * std::numbers::ln10));
  const double mu = std::asinh(1.0 / epsilon) / order;
  Filter filter = low_pass(order, std::sinh(mu), std::cosh(mu), cutoff_hz, f_m);
  if (order % 2 == 0) {
    const double at_rest = std::pow(10.0, -0.05 * ripple_db);
    SecondOrderSection& first = filter.sections.front();
    first.b0 *= at_rest;
    first.b1 *= at_rest;
    first.b2 *= at_rest;
  }
  return filter;
}

double gain(const Filter& filter, double f_hz, double f_m) {
  const std::complex<double> delay = std::polar(1.0, -2.0 * std::numbers::pi * f_hz / f_m);
  double product = 1.0;
  for (const SecondOrderSection& s : filter.sections) {
    product *= std::abs((s.b0 + delay * (s.b1 + delay * s.b2)) / (1.0 + delay * (s.a1 + delay * s.a2)));
  }
  return product;
}

Index settling_samples(const Filter& filter, double level) {
  const bool between = level > 0.0 && level < 1.0;
  if (!between) {
    throw InputError(detail::message("settling_samples: level is ", level, ", must lie between 0 and 1"));
  }
  double r = 0.0;
  for (const SecondOrderSection& section : filter.sections) {
    r = std::max(r, pole_modulus(section));
  }
  const double samples = r > 0.0 ? std::ceil(std::log(level) / std::log(r)) : 0.0;
  return std::max(static_cast<Index>(samples), static_cast<Index>(filter.order));
}

}  // namespace rivid
