#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "identify/rows/exact_rows.hpp"
#include "rivid/data/log.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

using Moves = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

// Where a condition holds.
[[nodiscard]] std::vector<Index> rows_that(
    const Eigen::Ref<const Eigen::Array<bool, Eigen::Dynamic, 1>>& hold);

// About so many of some samples or more, evenly spread.
[[nodiscard]] std::vector<Index> spread(const std::vector<Index>& samples, Index most);

// Instants of a log, evenly spread: motion and torques as windows around them see them.
struct ProbedLog {
  const Log* log = nullptr;
  std::vector<Index> samples;  // in the middle of the windows
  Motion motion;               // (samples × n)
  Matrix tau;                  // (samples × n)
  // Whether a joint moves one way throughout the window, by the column of its position, (samples × n).
  Moves moves;

  [[nodiscard]] Index size() const { return static_cast<Index>(samples.size()); }
};

// Instants that rows are made of: all, some for a first look, or those of one half of each log.
enum class Part { all, some, first_half, second_half };

// A way to read the log: which column is which joint, with which sign and unit, and where gravity points.
struct Reading {
  std::vector<Index> position;  // column of each joint
  Vector position_scale;
  Vector position_offset;  // added after the scale [rad | m]
  std::vector<Index> torque;
  Vector torque_sign;  // and unit
  Eigen::Vector3d gravity;
};

// The rows of one joint, with the torque columns of all joints.
struct JointFactor {
  std::vector<Index> columns;
  Matrix R;
  Matrix Z;        // Qᵀ tau, (columns × n)
  Vector rest;     // squared norm of what no parameters reach, (n)
  Vector centred;  // squared norm of each torque with its mean taken off, (n)
  Index rows = 0;
};

// How well a reading fits.
struct ProbeScore {
  Vector chi;
  Vector left;                      // squared part of each joint's torque that is left, (n); −1 without rows
  std::vector<std::uint8_t> wrong;  // joints whose inertia and friction are negative
  double total = 0.0;               // mean of `left`

  [[nodiscard]] Index faults() const { return std::ranges::count(wrong, 1); }
};

// How well a reading fits the halves of the logs.
struct HalfScores {
  double left = 0.0;  // squared part of the torques with the parameters of the other half, mean over joints
  Index faults = 0;   // joints that are wrong in both
};

// Torques of some logs beside what the model can make of their motion, under one reading of the logs or
// another.
class TorqueProbe {
 public:
  // Robot and base parameters are referred to, not copied.
  TorqueProbe(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
              const SignalOptions& signal);

  // The logs as the experiment says.
  [[nodiscard]] Reading as_told() const;
  [[nodiscard]] std::vector<JointFactor> factors(const Reading& reading, Part part = Part::all) const;
  // Those of all instants as the experiment says, which are made once.
  [[nodiscard]] const std::vector<JointFactor>& told_factors() const { return told_factors_; }
  [[nodiscard]] ProbeScore score(const Reading& reading, const std::vector<JointFactor>& factors) const;
  [[nodiscard]] ProbeScore score(const Reading& reading) const { return score(reading, factors(reading)); }
  // The score by those rows if its total is below `most`. What each joint leaves with parameters of its own
  // bounds it from below, so that most readings cost the factor of one joint or two.
  //
  // order  joints, those that leave most first
  [[nodiscard]] std::optional<ProbeScore> score_below(const Reading& reading, Part part, double most,
                                                      std::span<const Index> order) const;
  // The same by factors that are there.
  [[nodiscard]] std::optional<ProbeScore> score_below(const Reading& reading, double most,
                                                      const std::vector<JointFactor>& factors) const;
  [[nodiscard]] HalfScores halves(const Reading& reading) const;
  // Rows that a joint must have to be tested.
  [[nodiscard]] static Index wanted(const JointFactor& factor);
  // Squared part of its torque that each joint leaves by itself, geometric mean over joints, for torques that
  // come `shift` samples later; a number for each shift. So each joint says how much better a shift fits,
  // however well it fits.
  [[nodiscard]] Vector left_at(const Reading& reading, const std::vector<Index>& shifts, Part part) const;
  [[nodiscard]] const std::vector<ProbedLog>& logs() const { return probed_; }
  // W at some instants of a log, averaged by the window as the torques are; `log.motion` goes through the
  // model averaged, which is the same but for curvature.
  [[nodiscard]] Observation averaged_observation(const ProbedLog& log, std::span<const Index> instants) const;
  // Mean of M(q) over random poses, (n × n).
  [[nodiscard]] Matrix inertias(const Vector& chi) const;
  [[nodiscard]] Robot robot_with(const Eigen::Vector3d& gravity) const;
  [[nodiscard]] Motion motion_at(const ProbedLog& log, const Reading& reading) const;
  // Places among the instants of a log that belong to a part of them.
  [[nodiscard]] std::vector<Index> instants_of(const ProbedLog& log, Part part) const;

 private:
  // A part of the instants of each log, with W as a reading has it.
  struct Rows {
    std::vector<Observation> W;
    std::vector<Matrix> tau;
    std::vector<Moves> moves;

    // Places among them at which the joint of that column moves.
    [[nodiscard]] std::vector<Index> moving(std::size_t log, Index position_column) const;
  };
  [[nodiscard]] Rows rows(const Reading& reading, Part part) const;
  // Whether a joint has its turn in one half of the logs: halves are then every other stretch of them.
  [[nodiscard]] bool by_turns() const;
  [[nodiscard]] JointFactor factor(const Reading& reading, const Rows& rows, std::size_t joint) const;
  void add(const Log& log, const SignalOptions& signal);
  // Torques around some instants, so many samples later, (instants × n).
  [[nodiscard]] Matrix torques_at(const ProbedLog& log, std::span<const Index> instants, Index shift) const;
  [[nodiscard]] static bool usable(const JointFactor& factor, Index torque);
  // Whether a joint's inertia makes up a part of its torque that can be seen.
  [[nodiscard]] bool shows(double inertia, Index joint, const Reading& reading,
                           const JointFactor& factor) const;
  // Whether friction takes power from a joint's motion; a joint without friction does not say no.
  [[nodiscard]] bool dissipates(const Vector& chi, Index joint, const Reading& reading) const;

  const Robot& robot_;
  const BaseParameters& base_;
  Index half_width_ =
      1;  // samples from the middle of a window to its end, and of the differences and averages at both ends
  Vector window_;
  // What window, averages and differences make of the samples around an instant, at 1 Hz, (2 half_width_ +
  // 1).
  Vector position_kernel_;
  Vector velocity_kernel_;
  Vector acceleration_kernel_;
  Vector torque_kernel_;
  Index samples_of_log_;
  bool by_turns_ = false;
  std::vector<ProbedLog> probed_;
  std::vector<JointFactor> told_factors_;
};

}  // namespace rivid::detail
