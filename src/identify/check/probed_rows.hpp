#pragma once

#include <optional>
#include <span>
#include <vector>

#include "identify/check/torque_probe.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Some instants of a probed log.
struct PickedLog {
  const ProbedLog* log = nullptr;
  std::vector<Index> instants;  // places in the probed log, ascending
  Motion motion;                // (instants × n)
};

// A joint that moves at fewer instants than its parameters ask for, and has no rows.
struct UntestedJoint {
  Index joint = 0;
  Index instants = 0;
  Index wanted = 0;
};

// The rows of the joints at some instants of a probe, one joint after the other, weighted as those of a
// result, and the fit of the model to them. A joint has its own instants as far as those that all share are
// too few, so that joints which move one at a time have rows as well.
struct ProbedRows {
  // Rows of a joint from a log.
  struct Piece {
    Index joint = 0;
    std::size_t log = 0;
    std::vector<Index> instants;  // places in the picked log
    Index first = 0;              // row

    [[nodiscard]] Index size() const { return static_cast<Index>(instants.size()); }
  };

  // Nothing where no joint has rows enough, or nothing is left of its torques.
  //
  // result    whose base parameters and weights are taken
  // untested  joints that have no rows, for whoever asks
  static std::optional<ProbedRows> of(const TorqueProbe& probe, const Robot& robot,
                                      const Identification& result,
                                      std::vector<UntestedJoint>* untested = nullptr);

  // Takes columns of an alternative that is believed behind those of the parameters, and fits them as well.
  void take(const Matrix& columns);
  // R and the residual of W as it is, and the solution of the first columns into chi where `with_chi`. What
  // the rows do not determine stays with the result.
  void fit(bool with_chi);
  // Those of some blocks of time, fitted apart.
  //
  // kept  places of its rows among these, ascending
  [[nodiscard]] ProbedRows of_blocks(Index first, Index count, std::vector<Index>& kept) const;

  std::vector<PickedLog> logs;
  std::vector<Piece> pieces;
  Vector weights;               // (n)
  Matrix W;                     // (rows × b and those taken)
  Vector Y;                     // (rows)
  std::vector<Index> block_of;  // of motion, of each row, ascending in time
  Index blocks = 0;
  Matrix R;       // of W = Q R
  Vector chi;     // argmin ‖Y − W χ‖ before anything is taken
  Vector beside;  // χ beside what was taken
  Vector residual;

 private:
  void pick_instants(const TorqueProbe& probe, std::span<const Index> wanted);
  // Rows of each joint where it moves.
  void cut_pieces(Index joints);
  // Rows of a joint, of all logs.
  [[nodiscard]] Index rows_of(Index joint) const;
  // W and Y, from the rows of each log.
  void stack(const std::vector<Observation>& of_logs, Index parameters);
  // Blocks of time in motion: as many instants each, and rows of each joint in a few of them.
  void divide();

  Vector of_result_;  // χ̂, as far as it is a number
};

}  // namespace rivid::detail
