#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/data/table.hpp"
#include "rivid/finding.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// What was recorded while a robot moved: n_m samples of n joints, one row a sample, one column a joint, in
/// SI units on the joint side. Matrices of what was not recorded are empty.
struct Log {
  std::string source;              ///< the file, as messages name it
  Vector t;                        ///< instants, (n_m) [s]
  double f_m = 0.0;                ///< measuring rate [Hz]
  Matrix q;                        ///< measured positions, (n_m × n) [rad | m]
  Matrix qd;                       ///< measured velocities, (n_m × n) or empty [rad/s | m/s]
  Matrix tau;                      ///< joint-side torques, (n_m × n) or empty [N·m | N]
  Matrix v_tau;                    ///< control signals, (n_m × n) or empty [as recorded]
  Matrix q_r;                      ///< reference positions, (n_m × n) or empty [rad | m]
  Matrix qd_r;                     ///< reference velocities, (n_m × n) or empty [rad/s | m/s]
  LineNumbers lines;               ///< of the file, while the rows are those of the file; else empty
  std::vector<std::string> notes;  ///< what was found or done and the user should know
  std::vector<Finding> warnings;   ///< what may make a result wrong

  [[nodiscard]] Index samples() const { return t.size(); }
  [[nodiscard]] Index joints() const { return q.cols() > 0 ? q.cols() : q_r.cols(); }

  /// The first fault found, nothing if the log can be used: sizes agree, all values are finite, the rate is
  /// positive and the time stamps are those of a uniform clock, see inspect_time(); regularised() makes them
  /// so.
  [[nodiscard]] std::optional<std::string> complaint() const;

  /// "run1.csv:1842" for a row, or "run1.csv: row 1841" where its line is not known.
  [[nodiscard]] std::string place(Index row) const;
};

/// The rows first … first + count − 1 of a log.
///
/// @throws InputError  where the log has no such rows, or columns of other lengths
[[nodiscard]] Log excerpt(const Log& log, Index first, Index count);

/// Factor from a unit to SI: x [unit] · unit_scale(unit) is x in rad, m, s, N·m, N, V, A, rad/s or m/s.
///
/// Known: 1; rad deg; m mm um; s ms us ns; Nm mNm kNm (also N·m); N kN; V mV; A mA; rad/s deg/s rpm; m/s
/// mm/s.
///
/// @throws InputError  for any other word, with the list
[[nodiscard]] double unit_scale(std::string_view unit);

/// What is wrong with the name of a unit, with the list; nothing where unit_scale() knows it.
[[nodiscard]] std::optional<std::string> unit_complaint(std::string_view unit);

}  // namespace rivid
