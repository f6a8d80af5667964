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

  // Nothing where a joint has too few rows or the rows do not determine the parameters.
  //
  // result  whose base parameters and weights are taken
  static std::optional<ProbedRows> of(const TorqueProbe& probe, const Robot& robot,
                                      const Identification& result);

  // Takes columns of an alternative that is believed behind those of the parameters, and fits them as well;
  // false where these are no news beside what is there, and nothing more can be tested.
  [[nodiscard]] bool take(const Matrix& columns);
  // R and the residual of W as it is, and the solution of the first columns into chi where `with_chi`; false
  // where W has not full rank.
  [[nodiscard]] bool fit(bool with_chi);

  std::vector<PickedLog> logs;
  std::vector<Piece> pieces;
  Vector weights;               // (n)
  Matrix W;                     // (rows × b and those taken)
  Vector Y;                     // (rows)
  std::vector<Index> block_of;  // of time, of each row
  Index blocks = 0;
  Matrix R;    // of W = Q R
  Vector chi;  // argmin ‖Y − W χ‖ before anything is taken
  Vector residual;

 private:
  void pick_instants(const TorqueProbe& probe);
  // Rows of each joint where it moves.
  void cut_pieces(Index joints);
  // Rows of a joint, of all logs.
  [[nodiscard]] Index rows_of(Index joint) const;
  // W and Y, from the rows of each log.
  void stack(const std::vector<Observation>& of_logs, Index parameters);
};

}  // namespace rivid::detail
