#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Random numbers by counter: number i of a stream is a function of (seed, stream, i) and of nothing else, so
/// that run k of a study gives the same numbers alone, in any order and on any number of threads. The
/// generator is Philox4x32-10 [Salmon 2011]; streams and seeds are independent of each other.
///
/// Normal deviates are the inverse of the normal distribution at a uniform one, by algorithm AS 241 [Wichura
/// 1988] and a logarithm of our own: additions, multiplications, divisions and square roots, which IEEE 754
/// rounds in one way. Other than with std::normal_distribution and the machine's own logarithm, a seed gives
/// the same bits on every platform.
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

/// White Gaussian noise, (rows × n): column j is sigma_j times the normal deviates 0 … rows − 1 of a stream
/// of its own. Neither more rows nor more columns change those that were there.
///
/// @param purpose  distinguishes noises of one seed, < 2³²
/// @param sigma    standard deviations, (n)
[[nodiscard]] Matrix white_noise(std::uint64_t seed, std::uint64_t purpose, Index rows,
                                 const Eigen::Ref<const Vector>& sigma);

/// Quantile of the standard normal distribution by algorithm AS 241, accurate to some 1e-16 of its value.
///
/// @param p  in (0, 1)
/// @return   not a number outside of it
[[nodiscard]] double normal_quantile(double p);

/// Random errors of a simulated experiment: white, Gaussian, by CounterNoise.
struct NoiseOptions {
  Vector position = {};  ///< standard deviation of measured positions, (n) or empty [rad | m]
  Vector torque = {};    ///< of recorded torques; the drives never feel it, (n) or empty [N·m | N]
  Vector disturbance =
      {};  ///< of torques beside the drives, held for a period, not recorded, (n) or empty [N·m | N]
  /// Whether position noise and the quantum of the sampling go through the controller; else they are in the
  /// log alone.
  bool feedback = true;
  std::uint64_t seed = 1;

  /// The first fault found, nothing if the options can be used.
  ///
  /// @param n  joints
  [[nodiscard]] std::optional<std::string> complaint(Index n) const;

  template <typename N = NoiseOptions>
  static constexpr auto fields() {
    return std::tuple(
        Field{"position_noise",
              &N::position,
              "standard deviation of measured positions",
              {.otherwise = "0", .unit = "rad, m"}},
        Field{
            "noise_feedback",
            &N::feedback,
            "whether position noise and `quantum` go through the controller; else they are in the log alone",
            {.otherwise = "`true` if sampled"}},
        Field{"torque_noise",
              &N::torque,
              "standard deviation of recorded torques, with `record` of `\"torque\"`",
              {.otherwise = "0", .unit = "N·m, N"}},
        Field{"disturbance",
              &N::disturbance,
              "standard deviation of torques beside the drives, held for a period, not recorded",
              {.otherwise = "0", .unit = "N·m, N"}},
        Field{"seed", &N::seed, "of all noise", {.range = seed_range}});
  }
};

/// Options of a simulation with the errors that act while the robot moves: disturbance, and position noise
/// where it is fed back. Without feedback the controller measures without an error.
///
/// @param options  what is simulated, position_noise and disturbance empty; samples not 0
/// @param n        joints
/// @throws InputError  the noise's complaint(); where feedback is asked for of errors of the measurement and
///                     the law is continuous, or samples of the log fall between the instants of the
///                     controller; where the periods are too many to draw noise for
[[nodiscard]] SimulationOptions with_noise(SimulationOptions options, const NoiseOptions& noise, Index n);

/// What a recorder keeps of a simulation, a Log as read_csv() reads it: measured positions, control signals
/// and torques that act from t_k on, references. Rows from the first one that is not finite are left out: a
/// loop that diverges may end in such.
///
/// @param options  those of the simulation before with_noise()
/// @param noise    errors of the record: torque noise, and position noise where it is not fed back
/// @throws InputError  the noise's complaint(); where the quantum is not that of the joints
[[nodiscard]] Log measured_log(const Simulation& simulation, const SimulationOptions& options,
                               const NoiseOptions& noise);

}  // namespace rivid
