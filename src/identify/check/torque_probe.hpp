#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "identify/rows/exact_rows.hpp"
#include "rivid/data/log.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// The motion of a log, filtered, and its torques, at all samples.
struct ProbedLog {
  Motion motion;
  Matrix tau;                     // (n_m × n)
  std::vector<MotionMask> masks;  // where each joint moves
  std::vector<Index> samples;     // that rows are made of
  double f_m = 0.0;
};

// A way to read the log: which column is which joint, with which sign and unit, and where gravity points.
struct Reading {
  std::vector<Index> position;  // column of each joint
  Vector position_scale;
  std::vector<Index> torque;
  Vector torque_sign;
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

// Torques of some logs beside what the model can make of their motion, under one reading of the logs or another.
class TorqueProbe {
 public:
  // Robot and base parameters are referred to, not copied.
  TorqueProbe(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
              const CheckOptions& options);

  // The logs as the experiment says.
  [[nodiscard]] Reading as_told() const;
  [[nodiscard]] std::vector<JointFactor> factors(const Reading& reading) const;
  [[nodiscard]] ProbeScore score(const Reading& reading, const std::vector<JointFactor>& factors) const;
  [[nodiscard]] ProbeScore score(const Reading& reading) const { return score(reading, factors(reading)); }
  // Squared part of its torque that each joint leaves by itself, mean over joints, for torques that come `shift` samples
  // later; a number for each shift.
  [[nodiscard]] Vector left_at(const Reading& reading, const std::vector<Index>& shifts) const;
  [[nodiscard]] const std::vector<ProbedLog>& logs() const { return probed_; }
  // Mean of M(q) over random poses, (n × n).
  [[nodiscard]] Matrix inertias(const Vector& chi) const;
  [[nodiscard]] Robot robot_with(const Eigen::Vector3d& gravity) const;
  [[nodiscard]] Motion motion_at(const ProbedLog& log, const Reading& reading) const;
  // Places in log.samples where the joint of that column moves.
  [[nodiscard]] std::vector<Index> moving_rows(const ProbedLog& log, Index position_column) const;

 private:
  void add(const Log& log, const CheckOptions& options);
  // Whether friction takes power from a joint's motion; a joint without friction does not say no.
  [[nodiscard]] bool dissipates(const Vector& chi, Index joint, const Reading& reading) const;

  const Robot& robot_;
  const BaseParameters& base_;
  Index samples_of_log_;
  std::vector<ProbedLog> probed_;
};

}  // namespace rivid::detail
