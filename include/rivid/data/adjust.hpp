#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "rivid/data/log.hpp"
#include "rivid/data/table.hpp"
#include "rivid/fields.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Cubic spline through samples, twice continuously differentiable, with not-a-knot ends: the two intervals
/// at each end share one cubic. The same curve as the default of SciPy's CubicSpline; two samples give a
/// line, three a parabola.
class CubicSpline {
 public:
  /// @param t       instants, (m), strictly increasing, m ≥ 2 [s]
  /// @param values  (m × n), one column a signal
  /// @throws InputError  where the sizes differ, m < 2, or t does not increase
  CubicSpline(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& values);

  /// Values at other instants, (k × n). Outside of the samples the cubic of the end is continued.
  ///
  /// @param at  instants, (k), in any order, fastest when ascending [s]
  [[nodiscard]] Matrix operator()(const Eigen::Ref<const Vector>& at) const;

  /// Value and derivatives at one instant, (n) each. No allocation, and no search where the clock is nearly
  /// uniform.
  ///
  /// @param t  instant [s]
  void at(double t, Eigen::Ref<Vector> value, Eigen::Ref<Vector> slope, Eigen::Ref<Vector> curvature) const;

  [[nodiscard]] Index size() const { return values_.cols(); }
  /// First and last instant of the samples [s].
  [[nodiscard]] double begin() const { return t_[0]; }
  [[nodiscard]] double end() const { return t_[t_.size() - 1]; }

 private:
  Vector t_;
  Matrix values_;
  Matrix slopes_;
};

namespace detail {

/// Interval i of the instants t that `at` lies in, t_i ≤ at < t_{i+1} and 0 ≤ i ≤ m − 2; the first or the
/// last one outside. It needs no search where the clock is nearly uniform.
[[nodiscard]] Index interval(const Vector& t, double at);

}  // namespace detail

/// Values of the polygon through samples at other instants, (k × n); outside of the samples the end value is
/// held.
///
/// @param t       instants, (m), strictly increasing, m ≥ 1 [s]
/// @param values  (m × n), one column a signal
/// @param at      instants, (k), in any order, fastest when ascending [s]
/// @throws InputError  where the sizes differ, m < 1, or t does not increase
[[nodiscard]] Matrix linear_interpolation(const Eigen::Ref<const Vector>& t,
                                          const Eigen::Ref<const Matrix>& values,
                                          const Eigen::Ref<const Vector>& at);

/// What to do with a sample outside of what a table or a second log covers.
enum class Outside {
  refuse,  ///< InputError
  hold     ///< the value at the end holds on; the result's notes say for how many samples
};
template <>
inline constexpr std::array names_of<Outside> = std::to_array<std::string_view>({"refuse", "hold"});

/// Takes back a delay of the recorded torques and control signals: row k of them belongs to sample k − lag.
///
/// The other columns stay where they are. Rows that lose their partner are dropped: at the end where lag > 0,
/// at the start where the torques came early, lag < 0. Fractions of a sample are interpolated linearly: a
/// control signal that is computed at t_k and held until t_{k+1} acts half a sample later than its row says,
/// lag = −0.5.
///
/// @param lag  [samples]
/// @throws InputError  where the log has neither torques nor control signals, not more than |lag| samples, or
///                     columns of other lengths
[[nodiscard]] Log shift_torque(const Log& log, double lag);

/// A torque known as a table over one joint's position: a counterbalance, a spring.
struct TorqueTable {
  std::string source;  ///< as messages name it
  Vector q;            ///< positions, strictly increasing [rad | m]
  Vector tau;          ///< torques at them [N·m | N]

  /// The first fault found, nothing if the table can be used.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Reads a table of torques.
///
/// @param options  its `columns` name position and torque; empty: the file has just these two, in this order
/// @throws InputError  for what read_table() refuses, and where the positions do not increase
[[nodiscard]] TorqueTable read_torque_table(const std::filesystem::path& path,
                                            const TableOptions& options = {});

/// The log without a known torque: tau of the joint becomes tau − table(q), linear between the points of the
/// table.
///
/// @param joint  counted from 0
/// @throws InputError  where the log has no torques or no such joint; where a position lies outside of the
///                     table and `outside` refuses, with joint and value
[[nodiscard]] Log subtract_torque(Log log, Index joint, const TorqueTable& table,
                                  Outside outside = Outside::refuse);

/// The log with a reference motion that was recorded elsewhere: q_r(t) = reference.q_r(t − delay), by cubic
/// spline, and qd_r alike, linearly, where the other log has it. What the log had there is replaced.
///
/// @param reference  with q_r; its own time stamps need not be uniform, but must increase
/// @param delay_s    by how much the log is behind the reference [s]
/// @throws InputError  where the joints differ, or an instant is not finite; where a sample lies outside of
///                     the reference's time and `outside` refuses, with the span; held, the reference stands
///                     still
[[nodiscard]] Log with_reference(Log log, const Log& reference, double delay_s = 0.0,
                                 Outside outside = Outside::refuse);

}  // namespace rivid
