#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// Derivatives of a quantity of each sample by that sample's positions, velocities and accelerations, (samples × n).
struct Slopes {
  Matrix q;
  Matrix qd;
  Matrix qdd;

  void set_zero(Index samples, Index joints);
};

/// Observation matrix of a motion joint by joint, and exact derivatives of what is made of it.
///
/// Rows of a sample depend on that sample alone. By the position of a revolute joint they are trigonometric polynomials of
/// second degree, by velocities, and by the position of a prismatic joint, quadratic, by accelerations linear: differences
/// of large steps give all derivatives to rounding. Friction and coupled motors, which are none of these, are derived by
/// dual numbers.
class SampledRegressor {
 public:
  SampledRegressor(const Robot& robot, const BaseParameters& base);
  SampledRegressor(const SampledRegressor&) = delete;
  SampledRegressor& operator=(const SampledRegressor&) = delete;

  [[nodiscard]] Index joints() const { return static_cast<Index>(columns_.size()); }
  [[nodiscard]] Index size() const { return size_; }
  /// Base parameters that joint i's rows touch, in the order of the columns of W.
  [[nodiscard]] const std::vector<Index>& columns(std::size_t i) const { return columns_[i]; }

  /// Rows of all joints, (samples × columns(i).size()) each.
  void rows(const Motion& motion, std::vector<Matrix>& W);
  /// The same of a long motion, some samples at a time: `take` gets the first of them and their rows.
  void pieces(const Motion& motion, const std::function<void(Index first, std::span<const Matrix> W)>& take);

  /// Derivatives of
  ///
  ///   s = Σ_i Σ_c G_i(k, c) W_i(k, c)   and   τ_i = W_i χ
  ///
  /// at each sample k.
  ///
  /// @param G           like the rows
  /// @param chi         base parameters, (b); empty: no derivatives of torques are wanted
  /// @param of_torque   one a joint, where they are wanted
  void slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi, Slopes& of_sum,
              std::vector<Slopes>& of_torque);

 private:
  // A column that the kernels of links do not make: friction, and motors that several joints turn.
  struct DirectEntry {
    std::size_t joint = 0;
    Index column = 0;  // of W
    StandardParameter parameter;
    double sign_speed = 0.0;
    std::optional<CoupledEntry> coupled = {};
  };
  // The columns of links k, k + 1 …, which are all that the motion of joint k moves.
  struct Branch {
    RegressorBatch batch;
    RegressorBatch
        weightless;  // the same without gravity, whose rows at q̇ = 0 are the derivatives by accelerations
    BatchWorkspace workspace;
    BatchWorkspace weightless_workspace;
    std::vector<Index> skipped;  // columns of W before the branch's, by joint
    std::vector<Index> widths;   // by joint
    bool revolute = true;
  };
  // What a sweep adds to.
  struct Sums;

  void add_direct(const Robot& robot, const StandardParameter& parameter, Index column);
  void sweep(const RegressorBatch& batch, const Branch& branch, BatchWorkspace& workspace,
             const Motion& motion, Index count, double weight, const Sums& sums);
  void direct_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi, Slopes& of_sum,
                     std::vector<Slopes>& of_torque) const;

  Index size_ = 0;
  std::vector<std::vector<Index>> columns_;  // by joint
  std::vector<Index> link_columns_;          // by joint: how many come from the kernels
  std::vector<DirectEntry> direct_;
  std::vector<Branch> branches_;    // one a joint; the first makes the rows
  std::vector<Matrix> block_rows_;  // of a sweep, by joint
  std::vector<RowsTarget> block_targets_;
};

}  // namespace rivid::detail
