#pragma once

#include <cstdint>

#include "paper_study/paper_tables.hpp"
#include "rivid/rivid.hpp"

namespace rivid::study {

/// Size of the moves: S1, and S2 with its via points doubled.
inline constexpr double S1 = 1.0;
inline constexpr double S2 = 2.0;

/// The robot of the case study in its closed loop: 2 joints, no gravity, PD law (40) at 200 Hz.
struct Scara {
  static constexpr double f_m = 200.0;       // Hz
  static constexpr double move_time = 2.5;   // s
  static constexpr double L = paper_length;  // length of the first link [m]

  /// What differs from the controller that was designed with the true parameters.
  struct Design {
    Eigen::Array2d J_ratio = {1.0, 1.0};  ///< a-priori inertia over the true one, (45)
    double noise = 1.0;                   ///< of encoders and torques, as a multiple
  };

  Robot robot;
  BaseParameters base;
  Vector chi = Vector(b);  ///< true values of the base parameters
  PdControl control{.omega_n = Eigen::Vector2d(1, 10), .zeta = Eigen::Vector2d(1, 1)};
  Sampling sampling{.period = 1.0 / f_m};

  Scara();

  /// Design inertias (38) of the true robot.
  [[nodiscard]] static Vector J();

  /// Moves through nine points, `rounds` times.
  [[nodiscard]] static PointToPointReference moves(double size, int rounds = 1);
  /// Moves through other points.
  [[nodiscard]] static PointToPointReference unused_moves();

  /// What the computer of the controller records: encoder noise goes through the control law, disturbances act on the
  /// joints.
  [[nodiscard]] Log log(const PointToPointReference& reference, std::uint64_t seed,
                        const Design& design) const;
  [[nodiscard]] Log log(double size, std::uint64_t seed) const { return log(moves(size), seed, {}); }

  /// IDIM-IV that knows the control law, its bandwidth scaled.
  [[nodiscard]] Estimation iv(const SignalOptions& signal, double bandwidth = 1.0) const;
};

/// The signal chain of section 4.2: Butterworth at 20 Hz, decimation by 20.
[[nodiscard]] SignalOptions filtered();
/// That of section 4.4: nothing.
[[nodiscard]] inline SignalOptions raw() { return {.rows = RowScheme::paper}; }

}  // namespace rivid::study
