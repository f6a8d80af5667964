#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/identify/check.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid::detail {

class TorqueProbe;
struct Reading;

// What check() has found so far.
class Findings {
 public:
  void add(std::string_view code, std::string subject, std::string text);

  [[nodiscard]] bool has(std::string_view code, std::string_view subject = {}) const;
  // Sorted by severity, in the order in which they came.
  [[nodiscard]] std::vector<Finding> sorted() &&;

 private:
  std::vector<Finding> all_;
};

// "joint_2" or "scara.csv: joint_2" where there are several logs.
[[nodiscard]] std::string place(const Robot& robot, std::span<const Log> logs, const Log& log, Index joint);

// A cut-off frequency that keeps the motion of a log and takes its noise away, by its spectrum alone [Hz].
[[nodiscard]] double suitable_cutoff(const Log& log);

// Whether the options' own cut-off keeps the motion, and leaves more of it than of noise.
[[nodiscard]] bool cutoff_serves(const Log& log, const SignalOptions& signal);

// Each log by itself: units, columns, saturation, standstill, encoders, cut-off, reference.
void check_series(const Robot& robot, std::span<const Log> logs, const CheckOptions& options, Findings& out);

// The position filter against the motion and the noise of a log.
void check_cutoff(const Robot& robot, std::span<const Log> logs, const Log& log, const CheckOptions& options,
                  Findings& out);

// The motion of a log against its reference, with the delay between them.
void check_reference(const Robot& robot, std::span<const Log> logs, const Log& log, Findings& out);

// The same data twice.
void check_duplicates(std::span<const Log> logs, std::span<const Log> validation, Findings& out);

// Torques against the motion.
void check_torques(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                   const CheckOptions& options, Findings& out);

// Sizes of the torques, and the clock, under the reading of the logs that fits.
void check_sizes(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base,
                 const Reading& reading, Findings& out);

// What the rows of the signal chain show.
void check_excitation(const Robot& robot, std::span<const Log> logs, const CheckOptions& options,
                      Findings& out);

// Figures of single columns of a log.

[[nodiscard]] double rms(const Eigen::Ref<const Vector>& x);

[[nodiscard]] Vector centred(const Eigen::Ref<const Vector>& x);

/// Largest less smallest value.
[[nodiscard]] double range(const Eigen::Ref<const Vector>& x);

/// Whether positions [rad | m] stay within their noise, or within what is no motion.
[[nodiscard]] bool stands_still(const Eigen::Ref<const Vector>& q);

/// How well y = factor x + constant holds.
struct Likeness {
  /// Below this correlation two columns do not belong together.
  static constexpr double alike = 0.8;

  double factor = 0.0;
  double correlation = 0.0;
};

/// Zeros where one of both is constant.
[[nodiscard]] Likeness likeness(const Eigen::Ref<const Vector>& x, const Eigen::Ref<const Vector>& y);

}  // namespace rivid::detail
