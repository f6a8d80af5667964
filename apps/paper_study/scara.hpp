#pragma once

#include <array>
#include <cstdint>

#include "rivid/rivid.hpp"

namespace rivid::study {

inline constexpr std::size_t b = 8;  // base parameters of [RIV]
inline constexpr std::array<const char*, b> names = {"ZZ1R", "Fv1",  "Fc1", "ZZ2",
                                                     "LMX2", "LMY2", "Fv2", "Fc2"};
inline constexpr std::array<const char*, b> units = {"kg·m²", "N·m·s/rad", "N·m",       "kg·m²",
                                                     "kg·m²", "kg·m²",     "N·m·s/rad", "N·m"};
/// Indices of the four that short tables show.
inline constexpr std::array<std::size_t, 4> shown = {0, 3, 4, 2};

/// A table of [RIV], section 4: estimate, 2 σ and 100 σ / χ as printed, and the relative error ‖Y − Wχ‖ /
/// ‖Y‖, zero where it has none.
struct PaperTable {
  std::array<double, b> chi;
  std::array<double, b> two_sigma;
  std::array<double, b> percent_sigma;
  double relative_error;
};
/// Tables 1 to 3 and 5 to 7.
[[nodiscard]] const PaperTable& paper_table(int number);
/// Iterates of Table 4.
[[nodiscard]] const std::array<std::array<double, b>, 4>& paper_iterates();

/// Size of the moves: S1, and S2 with its via points doubled.
inline constexpr double S1 = 1.0;
inline constexpr double S2 = 2.0;

/// The robot of the case study in its closed loop: 2 joints, no gravity, PD law (40) at 200 Hz.
struct Scara {
  static constexpr double f_m = 200.0;      // Hz
  static constexpr double move_time = 2.5;  // s
  static constexpr double L = 0.5;          // length of the first link [m]

  /// What differs from the study's usual logs.
  struct Conditions {
    Eigen::Array2d J_ratio = {1.0,
                              1.0};  ///< a-priori inertia of the controller's design over the true one, (45)
    double noise = 1.0;              ///< of encoders and torques, as a multiple
  };

  Robot robot;
  BaseParameters base;
  Vector chi = Vector(b);  ///< true values of the base parameters
  PdControl control{.omega_n = Eigen::Vector2d(1, 10), .zeta = Eigen::Vector2d(1, 1)};
  Sampling sampling{.period = 1.0 / f_m};

  Scara();

  /// Moves through nine points, `rounds` times.
  [[nodiscard]] static PointToPointReference moves(double size, int rounds = 1, double time = move_time);
  /// Moves through other points.
  [[nodiscard]] static PointToPointReference unused_moves();

  /// What the computer of the controller records: encoder noise goes through the control law, disturbances
  /// act on the joints.
  [[nodiscard]] Log log(const PointToPointReference& reference, std::uint64_t seed,
                        const Conditions& conditions) const;
  [[nodiscard]] Log log(double size, std::uint64_t seed) const { return log(moves(size), seed, {}); }

  /// IDIM-IV that knows the control law, its bandwidth scaled; not judged, as the study shows what fails. The simulation starts in the measured state,
  /// and all samples count.
  [[nodiscard]] Estimation iv(const SignalOptions& signal, double bandwidth = 1.0) const;
  /// The same by section 3.4: the simulation starts on the reference, and samples with t < 5 / min ω_n are
  /// dropped.
  [[nodiscard]] Estimation iv_of_section_3_4(const SignalOptions& signal, double bandwidth = 1.0) const;
  /// Time until the simulated loop has forgotten where it began, section 3.4 [s].
  [[nodiscard]] double transient(double bandwidth = 1.0) const;
  /// Without the samples that section 3.4 drops.
  [[nodiscard]] SignalOptions without_transient(SignalOptions signal) const;
};

[[nodiscard]] inline Estimation ols(const SignalOptions& signal) {
  return {.method = Ols{}, .signal = signal, .judge = false};
}

/// True values in the units of the paper, which has L MX2 and L MY2 where rivid has MX2 and MY2.
[[nodiscard]] inline double truth(std::size_t i) { return paper_table(1).chi[i]; }
inline constexpr std::array<double, b> in_paper = {1, 1, 1, 1, Scara::L, Scara::L, 1, 1};

/// The signal chain of section 4.2: Butterworth at 20 Hz, decimation by 20.
[[nodiscard]] SignalOptions filtered();
/// That of section 4.4: nothing.
[[nodiscard]] inline SignalOptions raw() { return {.rows = RowScheme::paper}; }

}  // namespace rivid::study
