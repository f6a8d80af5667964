#pragma once

#include <optional>
#include <vector>

#include "identify/check/torque_probe.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Some instants of a probed log.
struct PickedLog {
  const ProbedLog* log = nullptr;
  std::vector<Index> instants;  // places in the probed log
  Motion motion;                // (instants × n)
};

// The rows of all joints at some instants of a probe, one joint after the other, weighted as those of a
// result, and the fit of the model to them.
struct ProbedRows {
  // Rows of a joint from a log.
  struct Piece {
    Index joint = 0;
    std::size_t log = 0;
    std::vector<Index> instants;  // places in the picked log
    Index first = 0;              // row

    [[nodiscard]] Index size() const { return static_cast<Index>(instants.size()); }
  };

  // Rows at instants that are spread over the motion, and more of them of a joint that has its turn for a
  // short time.
  //
  // result  whose base parameters and weights are taken
  ProbedRows(const TorqueProbe& probe, const Robot& robot, const Identification& result);

  // The same with their fit; nothing where they do not determine the parameters.
  static std::optional<ProbedRows> fitted(const TorqueProbe& probe, const Robot& robot,
                                          const Identification& result);

  // Rows of a joint, of all logs; and how many it takes to test it.
  [[nodiscard]] Index rows_of(Index joint) const;
  [[nodiscard]] bool tested(Index joint) const {
    return rows_of(joint) >= wanted[static_cast<std::size_t>(joint)];
  }

  // Takes columns of an alternative behind those of the parameters.
  void take(const Matrix& columns);
  // R, solution and residual of W as it is; false where W has not full rank, and nothing more can be tested.
  [[nodiscard]] bool fit();

  std::vector<PickedLog> logs;
  std::vector<Piece> pieces;
  std::vector<Index> wanted;    // (n)
  Vector weights;               // (n)
  Matrix W;                     // (rows × b and those taken)
  Vector Y;                     // (rows)
  std::vector<Index> block_of;  // of time, of each row
  Index blocks = 0;
  Matrix R;         // of W = Q R
  Vector chi;       // argmin ‖Y − W χ‖ before anything is taken
  Vector solution;  // as it is now
  Vector residual;

 private:
  void pick_instants(const TorqueProbe& probe);
  // Rows of each joint where it moves.
  void cut_pieces(Index joints);
  // W and Y, from the rows of each log.
  void stack(const std::vector<Observation>& of_logs, Index parameters);
};

}  // namespace rivid::detail
