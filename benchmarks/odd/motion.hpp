#pragma once

#include <vector>

#include "odd/arm.hpp"
#include "odd/recipe.hpp"

namespace rivid::odd {

/// A reference and its derivatives at an instant, (n) each.
struct ReferencePoint {
  Numbers q, qd, qdd;
};

/// A random motion that the controller is asked for: a finite Fourier series, or moves between random points
/// by quintics, with rests.
class RandomMotion {
 public:
  RandomMotion(const Recipe& recipe, const Arm& arm, Random& random);

  [[nodiscard]] ReferencePoint at(double t) const;
  [[nodiscard]] double duration() const { return duration_; }

 private:
  static constexpr int harmonics = 5;
  struct Move {
    double start = 0.0;
    double length = 1.0;
    Numbers from, to;
  };

  void draw_series(const Recipe& recipe, Random& random);
  void draw_moves(const Recipe& recipe, Random& random);

  double duration_;
  Recipe::Motion kind_;
  double omega_ = 0.0;  // of the series [rad/s]
  Numbers centre_;
  Numbers amplitude_;
  Matrix sine_, cosine_;  // (harmonics × n)
  std::vector<Move> moves_;
};

}  // namespace rivid::odd
