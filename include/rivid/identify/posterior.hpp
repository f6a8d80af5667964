#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

struct PosteriorOptions {
  int count = 64;
  std::uint64_t seed = 1;  ///< draw k is the same of whatever count

  template <typename P = PosteriorOptions>
  static constexpr auto fields() {
    return std::tuple(Field{"count", &P::count, "of draws", {.range = Range::from(1, 1e5)}},
                      Field{"seed", &P::seed, "of the draws", {.range = seed_range}});
  }
};

/// Draws from the distribution of a result's parameters, each a robot of physical bodies.
struct PosteriorSamples {
  Matrix chi_st;  ///< one row a draw, (count × N_s) [SI, joint side]
  Matrix chi;     ///< their base parameters, (count × b)
  /// Base parameters that the result leaves undetermined: draws keep them near its physically consistent set.
  std::vector<std::string> held;
};

/// Draws from N(χ̂, C) of the answer of a result, with the C that contains what the program chose (rows, laws,
/// gains) and deviations scaled to the 95 % intervals of the result (Student's t), each projected to the
/// physically consistent parameters that are nearest in the metric of C, see physical(): positive definite
/// pseudo-inertias, friction that brakes, and the bounds of the masses that the result was found with. What
/// base parameters leave open of the standard ones follows the physically consistent set of the result.
///
/// Equal results and options give the same bits.
///
/// @param robot  of the result
/// @throws InputError  where an option is out of its range; for a result of another robot, one without a
///                     physically consistent set, or without a covariance
[[nodiscard]] PosteriorSamples posterior_samples(const Robot& robot, const Identification& result,
                                                 const PosteriorOptions& options = {});

}  // namespace rivid
