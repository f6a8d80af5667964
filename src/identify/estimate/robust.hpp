#pragma once

#include <functional>
#include <span>
#include <vector>

#include "identify/rows/row_source.hpp"
#include "rivid/identify/robust.hpp"
#include "rivid/solve/least_squares.hpp"

namespace rivid::detail {

// The loss of the residuals of rows, and the scale of each joint's.
struct RowLoss {
  RobustLoss loss;
  std::vector<double> scales;  // one a joint
};

// What the residuals of a joint's rows come to, in units of their scale.
struct RobustSums {
  Index rows = 0;
  double psi_squares = 0.0;    // Σ ψ²
  double slopes = 0.0;         // Σ ψ'
  double slope_squares = 0.0;  // Σ ψ'²
  Index below_one = 0;         // weights
  Index below_half = 0;
  Index rejected = 0;
};

// What a pass over the rows of a joint leaves.
struct ReweightedJoint {
  RobustSums sums;
  std::vector<double> residuals;  // of all rows, 8 bytes each
  double y_squares = 0.0;
};

// Reweighting of rows and parameters in turn, until they agree.
class Reweighting {
 public:
  // chi  (b) that the first residuals are of
  Reweighting(const Robust& options, Vector chi, std::size_t joints);

  // Parameters that weighted rows have for their solution, and their deviations; not finite where there is
  // none.
  struct Solution {
    Vector chi;
    Vector sigma;
  };
  // Makes the rows of all logs, by way of ReweightedSinks, and solves for what these determine, again and
  // again.
  void settle(const std::function<void()>& make_rows, const std::function<Solution()>& solve);

  // Of the last pass.
  [[nodiscard]] const RowLoss& loss() const { return loss_; }
  [[nodiscard]] const Vector& chi() const { return chi_; }
  [[nodiscard]] std::vector<RobustSums> sums() const;
  // 1 / s_j.
  [[nodiscard]] std::vector<double> weights() const;
  [[nodiscard]] int rounds() const { return rounds_; }
  [[nodiscard]] bool settled() const { return settled_; }

 private:
  friend class ReweightedSinks;

  void pass(const std::function<void()>& make_rows);
  [[nodiscard]] bool settle_with_loss(const std::function<void()>& make_rows,
                                      const std::function<Solution()>& solve);

  Robust options_;
  RowLoss loss_;
  std::vector<double> next_scales_;
  Vector chi_;
  std::vector<ReweightedJoint> joints_;
  bool begun_ = false;
  int rounds_ = 0;
  bool settled_ = false;
};

// Weights the rows [V W Y] or [W Y] of a joint on their way to another sink by the square roots of their
// weights.
class ReweightedSink final : public RowSink {
 public:
  // chi    of the joint's own columns
  // from_V  columns of W that are taken from V
  ReweightedSink(RowSink& to, const RobustLoss& loss, double scale, Vector chi, bool with_V,
                 std::vector<Index> from_V, ReweightedJoint& joint);

  RowsRoom room(Index wanted) override { return room_ = to_.room(wanted); }
  void commit(std::span<const Index> samples) override;

 private:
  RowSink& to_;
  RobustLoss loss_;
  double scale_;
  Vector chi_;
  Index W_at_;
  std::vector<Index> from_V_;
  ReweightedJoint& joint_;
  RowsRoom room_{};
};

// Sinks that weight the rows of each joint on their way to other ones.
class ReweightedSinks {
 public:
  // by       nullptr for none: the sinks are the other ones then
  // columns  of W that the rows of each joint touch
  // from_V    columns of W, within each joint's own, that are taken from V; empty without V
  ReweightedSinks(std::span<RowSink* const> to, Reweighting* by, std::span<const RowGroup> columns,
                  std::span<const std::vector<Index>> from_V);

  [[nodiscard]] std::span<RowSink* const> sinks() const { return sinks_; }

 private:
  std::vector<ReweightedSink> reweighted_;
  std::vector<RowSink*> sinks_;
};

// What a loss makes of the information in the rows of each joint, [Huber 1981], section 7.6: an estimate errs
// by A⁻¹ Σ_t Z_tᵀ ω² s ψ_t with A = Σ_j ω² E[ψ'] Z_jᵀ W_j, where ω are the weights by joint, and the variance
// of the sum is B = Σ_j ω⁴ s² E[ψ²] Z_jᵀ Z_j if the errors of rows are independent of each other and of Z.
struct RobustInformation {
  std::vector<double> bread;  // by which the rows of each joint are scaled for A …
  std::vector<double> meat;   // … and for B
  double sigma = 0.0;         // A / σ² is about the information on the parameters
};

// weights  ω, one a joint
// b        parameters
[[nodiscard]] RobustInformation robust_information(std::span<const RobustSums> sums, const RowLoss& loss,
                                                   std::span<const double> weights, Index b);

// A⁻¹ from the slopes of the rows as they are, Σ_t Z_tᵀ ω² ψ'_t W_t.
//
// bread  A⁻¹ as information tells, which that is near to
[[nodiscard]] Matrix bread_from_slopes(const Matrix& curvature, const Matrix& bread);

// Standard deviation of the weighted errors of the inliers.
[[nodiscard]] double robust_deviation(std::span<const RobustSums> sums, const RowLoss& loss,
                                      std::span<const double> weights);

}  // namespace rivid::detail
