#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>

#include "rivid/types.hpp"

namespace rivid::odd {

/// Random numbers of one experiment. They follow from seed, name and number alone, so that an experiment is
/// the same whatever runs beside it, and are drawn by formulas of our own, so that every standard library
/// gives the same ones.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view name, std::uint64_t number) {
    std::uint64_t key = mixed(seed);
    for (const char c : name) {
      key = mixed(key ^ static_cast<unsigned char>(c));
    }
    engine_.seed(mixed(key ^ number));
  }

  /// Between low and high.
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  /// The same with a uniform logarithm.
  double log_uniform(double low, double high) { return low * std::pow(high / low, unit()); }
  /// Standard normal, by Box and Muller.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - unit()));
    return radius * std::cos(2.0 * std::numbers::pi * unit());
  }
  /// low … high, both included.
  int integer(int low, int high) { return low + static_cast<int>(unit() * (high - low + 1)); }
  bool chance(double probability) { return unit() < probability; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  template <typename T, std::size_t n>
  T one_of(const std::array<T, n>& choices) {
    return choices[static_cast<std::size_t>(integer(0, static_cast<int>(n) - 1))];
  }
  Eigen::Vector3d direction() {
    const double x = normal();
    const double y = normal();
    return Eigen::Vector3d(x, y, normal()).normalized();
  }

 private:
  // splitmix64
  static std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15U;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31U);
  }
  double unit() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }

  std::mt19937_64 engine_;
};

}  // namespace rivid::odd
