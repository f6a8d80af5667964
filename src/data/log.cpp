#include "rivid/data/log.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "log_columns.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// A clock that drifts by less than this from the rate over the whole log is the same clock.
constexpr double clock_tolerance = 0.01;

// One pass that the compiler can put into vectors: zero times anything else is no zero.
bool all_finite(const Eigen::Ref<const Vector>& x) { return (x.array() * 0.0).sum() == 0.0; }

// Period of stamps that lie on a uniform grid so well that inspect_time() need not look at them.
std::optional<double> exact_period(const Vector& t) {
  constexpr double exact = 1e-3;  // of a period
  const double period = (t[t.size() - 1] - t[0]) / static_cast<double>(t.size() - 1);
  double worst = 0.0;
  for (Index k = 0; k < t.size(); ++k) {
    worst = std::max(worst, std::abs(t[k] - t[0] - static_cast<double>(k) * period));
  }
  return period > 0.0 && worst <= exact * period ? std::optional(period) : std::nullopt;
}

}  // namespace

namespace detail {

std::optional<std::string> shape_complaint(const Log& log) {
  const Index n_m = log.t.size();
  if (n_m < 2) {
    return log.source + ": the log has " + std::to_string(n_m) + (n_m == 1 ? " sample" : " samples") +
           ", at least 2 are required";
  }
  if (!std::isfinite(log.f_m) || log.f_m <= 0.0) {
    return log.source + ": f_m is " + number(log.f_m) + " Hz, must be positive";
  }
  if (!all_finite(log.t)) {
    return log.source + ": t must be finite";
  }
  for (const LogColumns& part : log_columns) {
    const Matrix& values = log.*part.member;
    if (values.size() == 0) {
      continue;
    }
    if (values.rows() != n_m || values.cols() != log.joints()) {
      return log.source + ": " + std::string(part.symbol) + " is " + std::to_string(values.rows()) + " × " +
             std::to_string(values.cols()) + ", must be " + std::to_string(n_m) + " × " +
             std::to_string(log.joints()) + " (samples × joints)";
    }
    for (Index j = 0; j < values.cols(); ++j) {
      if (all_finite(values.col(j))) {
        continue;
      }
      for (Index k = 0; k < values.rows(); ++k) {
        if (!std::isfinite(values(k, j))) {
          return log.place(k) + ": " + std::string(part.symbol) + " of joint " + std::to_string(j + 1) +
                 " is " + number(values(k, j)) + "; values must be finite";
        }
      }
    }
  }
  return std::nullopt;
}

void require_even(std::string_view who, const Log& log) {
  for (const LogColumns& part : log_columns) {
    const Matrix& values = log.*part.member;
    if (values.size() > 0 && values.rows() != log.samples()) {
      throw InputError(std::string(who) + ": " + log.source + ": " + std::string(part.symbol) + " has " +
                       counted(values.rows(), "row") + ", must have one for each of the " +
                       counted(log.samples(), "sample"));
    }
  }
}

}  // namespace detail

std::optional<std::string> Log::complaint() const {
  if (t.size() > 0 && q.size() == 0) {
    return source + ": the log has no positions";
  }
  if (const auto fault = detail::shape_complaint(*this)) {
    return fault;
  }
  double rate_hz = 0.0;
  if (const auto period = exact_period(t)) {
    rate_hz = 1.0 / *period;
  } else if (const TimeReport report = inspect_time(t); report.regular) {
    rate_hz = report.rate_hz;
  } else {
    return source + ": the time stamps are irregular: " + report.summary() +
           "; resample them or ignore them by regularised(), or state the rate when reading";
  }
  if (std::abs(rate_hz - f_m) > clock_tolerance * f_m) {
    return source + ": f_m is " + number(f_m) + " Hz, but the time stamps give " + number(rate_hz) + " Hz";
  }
  return std::nullopt;
}

std::string Log::place(Index row) const {
  return lines.empty() ? source + ": row " + std::to_string(row + 1)
                       : source + ":" + std::to_string(lines[row]);
}

Log excerpt(const Log& log, Index first, Index count) {
  detail::require_even("excerpt", log);
  if (first < 0 || count < 0 || count > log.samples() - first) {
    throw InputError("excerpt: " + log.source + " has " + std::to_string(log.samples()) + " samples; " +
                     std::to_string(count) + " from index " + std::to_string(first) + " can not be taken");
  }
  Log out;
  out.source = log.source;
  out.f_m = log.f_m;
  out.notes = log.notes;
  out.t = log.t.segment(first, count);
  for (const detail::LogColumns& part : detail::log_columns) {
    const Matrix& values = log.*part.member;
    if (values.size() > 0) {
      out.*part.member = values.middleRows(first, count);
    }
  }
  if (!log.lines.empty() && count > 0) {
    out.lines.runs.push_back({0, log.lines[first]});
    for (const LineNumbers::Run& run : log.lines.runs) {
      if (run.row > first && run.row < first + count) {
        out.lines.runs.push_back({run.row - first, run.line});
      }
    }
  }
  return out;
}

namespace {

struct Unit {
  std::string_view name;
  double scale;
};

constexpr double degree = std::numbers::pi / 180.0;  // [rad]
constexpr std::array units = {Unit{"1", 1.0},
                              Unit{"rad", 1.0},
                              Unit{"deg", degree},
                              Unit{"m", 1.0},
                              Unit{"mm", 1e-3},
                              Unit{"um", 1e-6},
                              Unit{"s", 1.0},
                              Unit{"ms", 1e-3},
                              Unit{"us", 1e-6},
                              Unit{"ns", 1e-9},
                              Unit{"Nm", 1.0},
                              Unit{"mNm", 1e-3},
                              Unit{"kNm", 1e3},
                              Unit{"N·m", 1.0},
                              Unit{"N", 1.0},
                              Unit{"kN", 1e3},
                              Unit{"V", 1.0},
                              Unit{"mV", 1e-3},
                              Unit{"A", 1.0},
                              Unit{"mA", 1e-3},
                              Unit{"rad/s", 1.0},
                              Unit{"deg/s", degree},
                              Unit{"rpm", std::numbers::pi / 30.0},
                              Unit{"m/s", 1.0},
                              Unit{"mm/s", 1e-3}};

}  // namespace

double unit_scale(std::string_view unit) {
  for (const Unit& known : units) {
    if (known.name == unit) {
      return known.scale;
    }
  }
  throw InputError("unit_scale: " + unit_complaint(unit).value_or(""));
}

std::optional<std::string> unit_complaint(std::string_view unit) {
  std::vector<std::string> names;
  for (const Unit& known : units) {
    if (known.name == unit) {
      return std::nullopt;
    }
    names.emplace_back(known.name);
  }
  return in_quotes(unit) + " is no known unit; the units are " + listed(names) + did_you_mean(unit, names);
}

}  // namespace rivid
