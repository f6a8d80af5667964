#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "rivid/identify/covariance.hpp"
#include "rivid/identify/diagnostics.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid::detail {

struct Scores;

// Whether the torques are as old as the motion. Torques that are d samples late are Y = W χ − d D with their rate D, and
// what is left of an estimate with the instruments Z is ρ = −d (D − W B Zᵀ D), B = (Zᵀ W)⁻¹. The rate P of Z χ̂, which knows
// no noise of the torques, picks d out of it: Pᵀ ρ = −d H.

// Interval of time that a sample belongs to.
[[nodiscard]] inline Index interval_of(Index sample, double samples_per_interval) {
  constexpr double rounding = 1e-9;
  return static_cast<Index>(static_cast<double>(sample) / samples_per_interval + rounding);
}

// Sums over the rows of a joint.
class LagSums {
 public:
  // Rows that come before those of a call, from the calls before.
  static constexpr Index lead = 4;

  // stride     samples from one row to the next where none is left out
  // intervals  of time that sums are told for
  LagSums(Index own, Index stride, Index intervals, double samples_per_interval);

  // Rows lead … lead + samples.size() − 1; those before them are the last of the call before. The last two are
  // counted with the next call.
  //
  // Z, W    (lead + count × own)
  // Y, rho  torques and residual, (lead + count)
  // chi     (own)
  void add(const Eigen::Ref<const Matrix>& Z, const Eigen::Ref<const Matrix>& W,
           const Eigen::Ref<const Vector>& Y, const Eigen::Ref<const Vector>& rho,
           const Eigen::Ref<const Vector>& chi, std::span<const Index> samples);

  Vector PD;     // Pᵀ D of each interval of time
  Vector P_rho;  // Pᵀ ρ of each
  Vector WP;     // Wᵀ P, (own)
  Matrix ZD;     // Zᵀ D of each, (intervals × own)

 private:
  static constexpr Index none = std::numeric_limits<Index>::min() / 2;

  // Whether no row is missing from so many before row i to so many after it.
  [[nodiscard]] bool beside(Index i, Index before, Index after) const;
  // Rate at row i, from one row to the next: by two rows on each side where they are, else by one, or by two on one side.
  [[nodiscard]] double rate(const Eigen::Ref<const Vector>& x, Index i) const;
  // Slope of the straight line through five rows, 0 where they are not there.
  [[nodiscard]] double slope(const Eigen::Ref<const Vector>& x, Index i) const;

  Index stride_;
  double samples_per_interval_;
  std::vector<Index> samples_;  // of the last rows
};

// The sums of all joints and logs, weighted.
struct RateSums {
  Matrix WP;  // (b × n)
  Matrix ZD;  // (b × n)
  // One of each log.
  std::vector<Matrix> P_rho;       // (intervals × n)
  std::vector<Matrix> PD;          // (intervals × n)
  std::vector<Matrix> ZD_by_time;  // of all joints together, (intervals × b)
};

// One lag of all joints, and what it does to the estimate; its deviation is widened where the joints do not agree.
//
// scores   of the estimate, its own the first
// options  of its covariance
// bread    (Zᵀ Ω⁻¹ W)⁻¹, (b × b)
// sigma    deviations that are told of the estimate, (b)
//
// Nothing where no joint's torques change.
[[nodiscard]] std::optional<TorqueLag> torque_lag(const BaseParameters& base, const Scores& scores,
                                                  const CovarianceOptions& options, const Matrix& bread,
                                                  const Vector& sigma);

// A warning where the lag is there and takes a parameter out of its interval.
void judge_torque_lag(Identification& out);

}  // namespace rivid::detail
