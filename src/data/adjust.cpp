#include "rivid/data/adjust.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Rounding of time stamps may put a sample behind the end of a reference by this part of the reference's
// period.
constexpr double span_tolerance = 1e-6;

void require_torques(const char* who, const Log& log) {
  if (log.tau.size() == 0) {
    throw InputError(std::string(who) + ": " + log.source + " has no torques");
  }
}

std::string range(double lower, double upper, const char* unit) {
  return number(lower) + " to " + number(upper) + unit;
}

}  // namespace

Log shift_torque(const Log& log, double lag) {
  if (log.tau.size() == 0 && log.v_tau.size() == 0) {
    throw InputError("shift_torque: " + log.source + " has neither torques nor control signals");
  }
  if (!std::isfinite(lag) || std::abs(lag) >= static_cast<double>(log.samples() - 1)) {
    throw InputError("shift_torque: lag is " + number(lag) + " samples, but " + log.source + " has only " +
                     std::to_string(log.samples()));
  }
  if (lag == 0.0) {
    return log;
  }
  // Sample k takes its torque from row k + lag, between the rows k + whole and k + whole + 1.
  const auto whole = static_cast<Index>(std::floor(lag));
  const double fraction = lag - std::floor(lag);
  const Index reach = fraction > 0.0 ? whole + 1 : whole;
  const Index first = std::max<Index>(0, -whole);
  const Index kept = log.samples() - first - std::max<Index>(0, reach);
  Log out = excerpt(log, first, kept);
  const auto shifted = [&](const Matrix& x) -> Matrix {
    if (x.size() == 0) {
      return x;
    }
    return (1.0 - fraction) * x.middleRows(first + whole, kept) +
           fraction * x.middleRows(first + reach, kept);
  };
  out.tau = shifted(log.tau);
  out.v_tau = shifted(log.v_tau);
  const Index lost = log.samples() - kept;
  out.notes.push_back("torques moved by " + number(-lag) + " samples, " + counted(lost, "row") +
                      " dropped at the " + (lag > 0.0 ? "end" : "start"));
  return out;
}

std::optional<std::string> TorqueTable::complaint() const {
  if (q.size() != tau.size() || q.size() < 2) {
    return source + ": the table has " + std::to_string(q.size()) + " positions and " +
           std::to_string(tau.size()) +
           " torques; at least 2 of both are required, as many of one as of the other";
  }
  if (!q.allFinite() || !tau.allFinite()) {
    return source + ": the table must be finite";
  }
  for (Index i = 1; i < q.size(); ++i) {
    if (q[i] <= q[i - 1]) {
      return source + ": the positions of the table must increase, but row " + std::to_string(i + 1) +
             " has " + number(q[i]) + " after " + number(q[i - 1]);
    }
  }
  return std::nullopt;
}

TorqueTable read_torque_table(const std::filesystem::path& path, const TableOptions& options) {
  const Table table = read_table(path, options);
  if (table.columns() != 2) {
    throw InputError(table.source + ": two columns are required, position and torque; got " +
                     std::to_string(table.columns()) + " (" + listed(table.names) + ")");
  }
  TorqueTable out{table.source, table.values.col(0), table.values.col(1)};
  if (const auto fault = out.complaint()) {
    throw InputError(*fault);
  }
  return out;
}

Log subtract_torque(Log log, Index joint, const TorqueTable& table, Outside outside) {
  require_torques("subtract_torque", log);
  if (const auto fault = table.complaint()) {
    throw InputError("subtract_torque: " + *fault);
  }
  if (joint < 0 || joint >= log.q.cols() || joint >= log.tau.cols()) {
    throw InputError("subtract_torque: there is no joint " + std::to_string(joint + 1) + "; " + log.source +
                     " has " + std::to_string(log.joints()));
  }
  const double lower = table.q[0];
  const double upper = table.q[table.q.size() - 1];
  Index held = 0;
  for (Index k = 0; k < log.q.rows(); ++k) {
    const double q = log.q(k, joint);
    if (q >= lower && q <= upper) {
      continue;
    }
    if (outside == Outside::refuse) {
      throw InputError("subtract_torque: " + log.place(k) + ": joint " + std::to_string(joint + 1) +
                       " is at " + number(q) + ", outside of " + table.source + ", which goes from " +
                       range(lower, upper, "") + "; extend the table, cut the log, or hold the end values");
    }
    ++held;
  }
  log.tau.col(joint) -= linear_interpolation(table.q, table.tau, log.q.col(joint));
  log.notes.push_back("torque of " + table.source + " subtracted from joint " + std::to_string(joint + 1) +
                      (held > 0 ? "; its end values held for " + counted(held, "sample") : ""));
  return log;
}

Log with_reference(Log log, const Log& reference, double delay_s, Outside outside) {
  if (reference.q_r.size() == 0 || reference.t.size() < 2) {
    throw InputError("with_reference: " + reference.source + " has no reference positions");
  }
  if (!std::isfinite(delay_s)) {
    throw InputError("with_reference: delay_s is " + number(delay_s) + " s, must be finite");
  }
  if (reference.q_r.cols() != log.joints()) {
    throw InputError("with_reference: " + reference.source + " has " + std::to_string(reference.q_r.cols()) +
                     " joints, " + log.source + " has " + std::to_string(log.joints()));
  }
  const double first = reference.t[0];
  const double last = reference.t[reference.t.size() - 1];
  const double tolerance = span_tolerance * (last - first) / static_cast<double>(reference.t.size() - 1);
  Vector at = log.t.array() - delay_s;
  const auto is_outside = [&](Index k) { return at[k] < first - tolerance || at[k] > last + tolerance; };
  std::vector<Index> held;
  for (Index k = 0; k < at.size(); ++k) {
    if (is_outside(k)) {
      held.push_back(k);
    }
  }
  if (!held.empty() && outside == Outside::refuse) {
    throw InputError("with_reference: " + log.place(held.front()) + ": t − delay is " +
                     number(at[held.front()]) + " s, but " + reference.source + " covers " +
                     range(first, last, " s") + " only; cut the log to t = " +
                     range(first + delay_s, last + delay_s, " s") + ", or hold the end values");
  }
  at = at.cwiseMax(first).cwiseMin(last);
  log.q_r = CubicSpline(reference.t, reference.q_r)(at);
  log.qd_r.resize(0, 0);
  if (reference.qd_r.size() > 0) {
    log.qd_r = linear_interpolation(reference.t, reference.qd_r, at);
    for (const Index k : held) {
      log.qd_r.row(k).setZero();
    }
  }
  log.notes.push_back("reference from " + reference.source + ", " + number(delay_s) + " s later" +
                      (held.empty() ? "" : "; held for " + counted(std::ssize(held), "sample")));
  return log;
}

}  // namespace rivid
