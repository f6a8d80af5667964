#pragma once

#include <array>
#include <cstdint>

#include "rivid/types.hpp"

namespace rivid {

/// Random numbers by counter: number i of a stream is a function of (seed, stream, i) and of nothing else, so that run k
/// of a study gives the same numbers alone, in any order and on any number of threads. The generator is Philox4x32-10
/// [Salmon 2011]; streams and seeds are independent of each other.
///
/// Normal deviates are the inverse of the normal distribution at a uniform one, by algorithm AS 241 [Wichura 1988] and a
/// logarithm of our own: additions, multiplications, divisions and square roots, which IEEE 754 rounds in one way. Other
/// than with std::normal_distribution and the machine's own logarithm, a seed gives the same bits on every platform.
class CounterNoise {
 public:
  explicit CounterNoise(std::uint64_t seed, std::uint64_t stream = 0) : seed_(seed), stream_(stream) {}

  /// 128 random bits.
  [[nodiscard]] std::array<std::uint32_t, 4> bits(std::uint64_t i) const;
  /// Uniform on (0, 1), both ends excluded.
  [[nodiscard]] double uniform(std::uint64_t i) const;
  /// Standard normal.
  [[nodiscard]] double normal(std::uint64_t i) const;

 private:
  std::uint64_t seed_;
  std::uint64_t stream_;
};

/// White Gaussian noise, (rows × n): column j is sigma_j times the normal deviates 0 … rows − 1 of a stream of its own.
/// Neither more rows nor more columns change those that were there.
///
/// @param purpose  tells noises of one seed apart, < 2³²
/// @param sigma    standard deviations, (n)
[[nodiscard]] Matrix white_noise(std::uint64_t seed, std::uint64_t purpose, Index rows,
                                 const Eigen::Ref<const Vector>& sigma);

/// Quantile of the standard normal distribution by algorithm AS 241, accurate to some 1e-16 of its value.
///
/// @param p  in (0, 1)
[[nodiscard]] double normal_quantile(double p);

}  // namespace rivid
