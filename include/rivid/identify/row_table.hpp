#pragma once

#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// The rows of a fit, for programs of one's own: R rows, b base parameters.
struct RowTable {
  std::vector<std::string> parameters;  ///< names of the columns of W, (b)
  std::vector<std::string> joints;      ///< names, (n)
  std::vector<std::string> logs;        ///< files, one each
  Vector t;                             ///< time of the sample that the row stands for, (R) [s]
  Vector log;                           ///< place in `logs`, counted from 0, (R)
  Vector joint;                         ///< place in `joints`, counted from 0, (R)
  Vector Y;                             ///< measured torque, (R) [N·m | N]
  Matrix W;                             ///< observation matrix, (R × b)
  Matrix V;              ///< of the instruments, see instrument_rows(), (R × b); no rows where there are none
  Vector weight;         ///< 1/σ of the joint, 1 for ordinary least squares, (R)
  Vector robust_weight;  ///< that a squared error counts with in robust estimation, 0 … 1; 1 without, (R)
  Vector prediction;     ///< W χ, (R)
  Vector residual;       ///< Y − W χ, (R)
  Vector leverage;    ///< diagonal of the hat matrix of the weighted rows; not a number where W has not full
                      ///< rank, (R)
  Vector chi;         ///< estimate, (b)
  Matrix covariance;  ///< C_χχ, (b × b)
};

/// The rows of the logs of an identification, W and Y of Eq. (13) of [RIV], and what the result makes of
/// them. All of W is held in memory.
///
/// @param logs  of the identification
/// @throws InputError  where rows() throws it, there is no log, or the result is of other sizes
[[nodiscard]] RowTable row_table(const Robot& robot, const Identification& result, std::span<const Log> logs);

/// All members as arrays of a NumPy archive, `numpy.load("rows.npz")`: members of one array a name,
/// uncompressed.
///
/// @throws InputError  for 4 GiB and more, which the format does not hold
[[nodiscard]] std::string to_npz(const RowTable& rows);

/// A line a row: t, log, joint, Y, prediction, residual, weight, robust_weight, leverage, then a column
/// "W:NAME" for each parameter, and a column "V:NAME" where there are instruments. Numbers read back bit by
/// bit.
[[nodiscard]] std::string to_csv(const RowTable& rows);

}  // namespace rivid
