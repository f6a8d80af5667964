#pragma once

#include <span>
#include <utility>
#include <vector>

#include "identify/estimate/closed_loops.hpp"
#include "identify/estimate/estimate.hpp"
#include "rivid/solve/instrumental.hpp"

namespace rivid::detail {

// Columns of W that are taken from V.
enum class FromV {
  none,
  signs,  // those of dry friction
  all
};

// Makes the rows [V W Y] of all logs.
class Instruments {
 public:
  explicit Instruments(const EstimationProblem& problem);

  // Factors of [V | W Y] of each joint with the motions of simulated loops.
  //
  // loops_of  where logs that are elsewhere are asked
  [[nodiscard]] std::vector<InstrumentalGroup> factors(const ClosedLoops& loops_of,
                                                       const SimulatedLoops& loops, FromV which);

  // From now on factors() also fills blocks of equal time, of one log.
  void divide_into(std::vector<std::vector<InstrumentalGroup>>& blocks) { blocks_ = &blocks; }
  // No rows, for each joint.
  [[nodiscard]] std::vector<InstrumentalGroup> no_rows() const;

  // What V is built from: exact rows ask for the same differences as those of W.
  [[nodiscard]] std::vector<Motion> motions(std::span<const Motion> simulated) const;

  // From now on rows are not decimated.
  void keep_every_row();
  // From now on rows are whitened, by the coefficients of each joint's prefilter.
  void whiten(std::vector<Vector> ar) { whitening_ = std::move(ar); }

  // From now on rows are weighted by their residuals, or no longer: nullptr.
  void reweight(Reweighting* by) { reweighting_ = by; }
  [[nodiscard]] Reweighting* reweighting() const { return reweighting_; }

  // Of the last factors: [W Y] with the columns that they took, whitened or weighted; rows and ‖Y‖ of all
  // joints together; and the columns, within each joint's own, that were taken from V.
  [[nodiscard]] const std::vector<RowGroup>& used() const {
    return used_.empty() ? problem_.data.groups : used_;
  }
  [[nodiscard]] Index rows() const { return rows_; }
  [[nodiscard]] double y_norm() const { return y_norm_; }
  [[nodiscard]] const std::vector<std::vector<Index>>& from_V() const { return from_V_; }
  // Rows without the parameters.
  [[nodiscard]] double freedom() const { return static_cast<double>(rows_ - problem_.base.size()); }

  [[nodiscard]] const std::vector<SignalOptions>& signals() const { return signals_; }
  [[nodiscard]] const std::vector<Vector>& whitening() const { return whitening_; }

 private:
  [[nodiscard]] std::vector<InstrumentalGroup> made(std::span<const Motion> simulated, FromV which);
  [[nodiscard]] std::vector<std::vector<Index>> columns_from(FromV which) const;
  void count_rows();

  const EstimationProblem& problem_;
  std::vector<SignalOptions> signals_;  // one a log
  std::vector<Vector> whitening_;       // empty without
  Reweighting* reweighting_ = nullptr;
  std::vector<std::vector<InstrumentalGroup>>* blocks_ = nullptr;
  std::vector<RowGroup> used_;  // empty: those of the problem
  std::vector<std::vector<Index>> from_V_;
  Index rows_ = 0;
  double y_norm_ = 0.0;
};

}  // namespace rivid::detail
