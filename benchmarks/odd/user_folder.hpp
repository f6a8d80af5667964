#pragma once

#include <cstdint>
#include <filesystem>

#include "odd/machine.hpp"
#include "odd/recipe.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid::odd {

/// One experiment of many.
struct Name {
  std::uint64_t seed = 1;
  const Kind* kind = nullptr;
  std::uint64_t number = 0;  ///< among those of its kind
  const Way* way = nullptr;  ///< null: as it is drawn
  bool sound = false;        ///< without what is odd about it: the same arm, moved in the same way

  /// "coarse_encoder-17", "gain_20pct-jogging-3"; that of its sound twin is the same
  [[nodiscard]] std::string text() const;
};

/// What is known of an experiment that was written.
struct Truth {
  Recipe recipe;
  Machine machine;

  /// Base parameters of the robot that the user believes in, with the bodies and drives of the true one, (b).
  [[nodiscard]] Vector base_values(const BaseParameters& base) const;
};

/// Writes what a user would have: robot.urdf, log_1.csv, log_2.csv …, of which the last one is for
/// validation. They follow from the name alone.
Truth write_experiment(const Name& name, const std::filesystem::path& folder);

/// A URDF of the arm, with limits of torque that the motions keep.
[[nodiscard]] std::string urdf_of(const Arm& arm, const Numbers& largest_torque);

}  // namespace rivid::odd
