#pragma once

#include <cstdint>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "identify/infer/findings.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/regressor/base.hpp"

// The fourth stage: rows → estimate → infer → judge → describe.
namespace rivid::detail {

class TorqueProbe;
struct Reading;

inline constexpr double degree = std::numbers::pi / 180.0;  // [rad]

// "joint_2" or "scara.csv: joint_2" where there are several logs.
[[nodiscard]] std::string place(const Robot& robot, std::span<const Log> logs, const Log& log, Index joint);

// A cut-off frequency that keeps the motion of a log and takes its noise away, by its spectrum alone [Hz].
[[nodiscard]] double suitable_cutoff(const Log& log);

// Each log by itself: units, columns, saturation, standstill, encoders, cut-off, reference.
void check_series(const Robot& robot, std::span<const Log> logs, const CheckOptions& options, Findings& out);

// Resolution and noise of the encoders of a log: a note.
void check_encoders(const Robot& robot, std::span<const Log> logs, const Log& log, Findings& out);

// The position filter against the motion and the noise of a log.
void check_cutoff(const Robot& robot, std::span<const Log> logs, const Log& log, const CheckOptions& options,
                  Findings& out);

// The motion of a log against its reference, with the delay between them.
//
// used  whether the estimate follows the reference; else it can be what it likes
void check_reference(const Robot& robot, std::span<const Log> logs, const Log& log, bool used, Findings& out);

// Torques against the motion.
void check_torques(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base, Findings& out);

// Sizes of the torques, and the clock, under the reading of the logs that fits.
void check_sizes(const TorqueProbe& probe, const Robot& robot, const BaseParameters& base,
                 const Reading& reading, const Vector& chi, Findings& out);

// Values that physics forbids, beyond doubt or almost: friction that drives, inertias that are negative; and
// where nothing else is wrong, torques that the result does not explain.
//
// logs  of the probe
void check_physics(const TorqueProbe& probe, const Robot& robot, std::span<const Log> logs,
                   const Identification& result, Findings& out);

// The same of the torques of a validation log. Worth a probe where the fit to it looks poor.
void check_poor_validation(const TorqueProbe& probe, const Robot& robot, const Validation& found,
                           const Identification& result, Findings& out);
[[nodiscard]] bool looks_poor(const Fit& fit);

// Rows enough to tell deviations from.
void check_rows(const Identification& result, Findings& out);

// The same of logs and a validation that they do not predict, taken together.
void check_together(const Robot& robot, std::span<const Log> logs, const Log& validation,
                    const Identification& result, Findings& out);

// The residual of validations against that of a fit to these logs and what the covariance of the parameters
// lets expect.
//
// validation  logs that result.validation is of
void check_validation(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                      const Identification& result, Findings& out);

// What the alternatives to the model behind a result say.
struct Alternatives {
  std::vector<ModelTest> believed;  // the likeliest first
  Vector shift;                     // of the parameters by that one, (b); empty where there is none
};

// The model behind a result against its nearest alternatives. One that explains a validation worse is none.
[[nodiscard]] Alternatives check_model(const TorqueProbe& probe, const Robot& robot,
                                       std::span<const Log> logs, std::span<const Log> validation,
                                       const Identification& result, Findings& out);

// Robot, logs and model, as far as a result can be wrong by them; the alternatives to the model that are
// believed.
[[nodiscard]] Alternatives check_logs(const Robot& robot, std::span<const Log> logs,
                                      std::span<const Log> validation, const Identification& result,
                                      const CheckOptions& options, Findings& out);

// What the result says of itself.
void check_result(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                  const Identification& result, Findings& out);

// What speaks against a result beside its own figures, and by what it should be wider.
struct Judgement {
  std::vector<Finding> findings;  // in the order in which they came
  Alternatives alternatives;      // without a shift where deviations are not to know the errors of the model
};

// Looks at robot, logs, model and result for what makes it wrong, see identify().
//
// logs        that the result is of, and that result.validation is of, as they were given
// throws InputError where logs and robot do not fit together
[[nodiscard]] Judgement judged(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                               const Identification& result);

// That a joint, or all, were not tested for something, since they move in so few rows.
void add_not_tested(const std::string& subject, const std::string& what, Index rows, Index wanted,
                    Findings& out);

// A number with as many digits, from `digits` on, as tell it from another one.
[[nodiscard]] std::string number_beside(double value, double other, int digits);

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
