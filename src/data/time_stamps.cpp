#include "rivid/data/time_stamps.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "log_columns.hpp"
#include "rivid/data/adjust.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// [periods] shorter steps are repeated stamps; a choice far below any jitter
constexpr double repeated_step = 1e-3;
// [periods] of jitter; a choice: below it a constant rate stands for the stamps
constexpr double regular_rms = 0.01;
constexpr double regular_max = 0.1;  // [periods] of jitter; a choice
// Sampling this much more slowly than the log was recorded folds what lies above half the new rate.
constexpr double aliasing_ratio = 0.75;
// Nobody gains by more samples than that many for each recorded one.
constexpr double highest_ratio = 100.0;

// Rows that are missing are counted in integers.
constexpr double largest_gap = 1e9;

std::optional<std::string> gap_complaint(double max_gap) {
  if (!(max_gap >= 2.0)) {
    return "max_gap is " + number(max_gap) + " periods, must be at least 2";
  }
  if (max_gap > largest_gap) {
    return "max_gap is " + number(max_gap) + " periods, must be at most " + number(largest_gap);
  }
  return std::nullopt;
}

double median(std::vector<double> values) {
  if (values.empty()) {
    return 0.0;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) {
    return *middle;
  }
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

void add(TimeFault& fault, Index row, double time) {
  if (fault.count++ == 0) {
    fault.row = row;
    fault.time = time;
  }
}

// Deviation of stamps from the line through them over their grid points, added up.
class GridFit {
 public:
  void add_piece(const std::vector<double>& grid, const std::vector<double>& t, double period) {
    const auto count = static_cast<Index>(t.size());
    if (count < 2) {
      return;
    }
    const Eigen::Map<const Vector> k(grid.data(), count);
    const Eigen::Map<const Vector> stamps(t.data(), count);
    const Vector x = k.array() - k.mean();
    // Taken from the first stamp on: time since the epoch would cost all digits of the jitter.
    const Vector y = stamps.array() - stamps[0];
    const double spread = x.squaredNorm();
    const double step = spread > 0.0 ? x.dot(y) / spread : period;
    const Vector deviation = (y.array() - y.mean() - step * x.array()) / period;
    squares_ += deviation.squaredNorm();
    largest_ = std::max(largest_, deviation.cwiseAbs().maxCoeff());
    count_ += count;
  }
  [[nodiscard]] double rms() const {
    return count_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(count_));
  }
  [[nodiscard]] double largest() const { return largest_; }

 private:
  double squares_ = 0.0;
  double largest_ = 0.0;
  Index count_ = 0;
};

// Of the lines below all points (k, t_k) the highest one in the middle: its slope, by the lower convex hull
// [Andrew 1979]. Where stamps are late, never early, those in time lie on it.
double slope_below(const Eigen::Ref<const Vector>& t) {
  std::vector<Index> hull;
  const auto slope = [&](Index a, Index b) { return (t[b] - t[a]) / static_cast<double>(b - a); };
  for (Index k = 0; k < t.size(); ++k) {
    while (hull.size() >= 2 && slope(hull[hull.size() - 2], hull.back()) >= slope(hull.back(), k)) {
      hull.pop_back();
    }
    hull.push_back(k);
  }
  const auto right = std::ranges::lower_bound(hull, t.size() / 2);
  return slope(*std::prev(right), *right);
}

// Period of the clock of which stamps are late, and how many are. See TimeReport::late.
struct LateStamps {
  Index count = 0;
  double period = 0.0;
};

LateStamps late_stamps(const Eigen::Ref<const Vector>& t) {
  constexpr Index least_samples = 100;  // a choice: shares of fewer say nothing of a clock
  // [periods] by which a stamp in time may be late; a choice: jitter stays below
  constexpr double in_time = 0.1;
  constexpr double off = 0.3;            // [periods] from which on a stamp is late; a choice
  constexpr double kept_at_least = 0.2;  // share of the samples that are in time; a choice
  // of those in time, that may lie between them and those that are off; a choice
  constexpr double few = 0.25;
  constexpr Index stretches = 10;  // of the log, that all keep some stamps in time; a choice
  // share of a stretch's samples; a choice: a clock that drifts has none in some
  constexpr double kept_of_each = 0.05;
  if (t.size() < least_samples) {
    return {};
  }
  const double period = slope_below(t);
  if (!(period > 0.0)) {
    return {};
  }
  Vector late = t / period - Vector::LinSpaced(t.size(), 0.0, static_cast<double>(t.size() - 1));
  late.array() -= late.minCoeff();
  const auto in_time_from = [&](Index begin, Index count) {
    return static_cast<double>((late.segment(begin, count).array() < in_time).count());
  };
  const double kept = in_time_from(0, t.size());
  const double between = static_cast<double>((late.array() < off).count()) - kept;
  bool of_a_clock = kept >= kept_at_least * static_cast<double>(t.size()) && between <= few * kept;
  for (Index k = 0; k < stretches; ++k) {
    const Index begin = k * t.size() / stretches;
    const Index samples = (k + 1) * t.size() / stretches - begin;
    of_a_clock = of_a_clock && in_time_from(begin, samples) >= kept_of_each * static_cast<double>(samples);
  }
  // Behind rows that are missing all stamps are late.
  Index longest_run = 0;
  Index run = 0;
  for (Index k = 0; k < t.size(); ++k) {
    longest_run = late[k] > off ? longest_run : std::max(longest_run, run);
    run = late[k] > off ? run + 1 : 0;
  }
  of_a_clock = of_a_clock && run <= longest_run;
  return {.count = of_a_clock ? (late.array() > off).count() : 0, .period = period};
}

// What to do about them.
std::string cure_of_late_stamps(const TimeReport& report) {
  return counted(report.late, "stamp") +
         " late, none early: samples that were taken in time and stamped when "
         "they arrived; irregular = \"ignore\" with rate_hz = " +
         number(report.rate_hz, 6) + " takes them for samples of a clock";
}

Log on_grid(const Log& log, double rate_hz) {
  Log out;
  out.source = log.source;
  out.notes = log.notes;
  out.f_m = rate_hz;
  const double span = log.t[log.t.size() - 1] - log.t[0];
  // A last grid point that only rounding puts behind the last stamp still counts.
  const auto steps = static_cast<Index>(std::floor(span * rate_hz * (1.0 + 1e-12) + 1e-6));
  out.t = log.t[0] + Vector::LinSpaced(steps + 1, 0.0, static_cast<double>(steps)).array() / rate_hz;
  for (const detail::LogColumns& part : detail::log_columns) {
    const Matrix& values = log.*part.member;
    if (values.size() == 0) {
      continue;
    }
    out.*part.member =
        part.smooth ? CubicSpline(log.t, values)(out.t) : linear_interpolation(log.t, values, out.t);
  }
  return out;
}

// First row of each piece between jumps, and the end of the last one.
std::vector<Index> piece_bounds(const Vector& t, double longest_gap) {
  std::vector<Index> bounds = {0};
  for (Index i = 1; i < t.size(); ++i) {
    if (t[i] - t[i - 1] > longest_gap) {
      bounds.push_back(i);
    }
  }
  bounds.push_back(t.size());
  return bounds;
}

Log without_repeated(const Log& log, double shortest_step) {
  std::vector<Index> kept = {0};
  for (Index i = 1; i < log.t.size(); ++i) {
    if (log.t[i] - log.t[kept.back()] >= shortest_step) {
      kept.push_back(i);
    }
  }
  Log out = log;
  out.t = log.t(kept);
  for (const detail::LogColumns& part : detail::log_columns) {
    const Matrix& values = log.*part.member;
    if (values.size() > 0) {
      out.*part.member = values(kept, Eigen::all);
    }
  }
  return out;
}

// Where the first fault is, for a message: file and line, or the file alone for jitter.
std::string first_place(const Log& log, const TimeReport& report) {
  Index row = -1;
  for (const TimeFault* fault : {&report.reversed, &report.repeated, &report.jumps, &report.missing}) {
    if (fault->count > 0 && (row < 0 || fault->row < row)) {
      row = fault->row;
    }
  }
  return row < 0 ? log.source : log.place(row) + " (t = " + number(log.t[row]) + " s)";
}

std::vector<Log> resampled(const Log& log, const TimeReport& report, const ResampleOptions& options) {
  if (report.reversed.count > 0) {
    throw InputError(log.place(report.reversed.row) + ": the time stamps go back, " +
                     counted(report.reversed.count, "time") +
                     ", first to t = " + number(report.reversed.time) +
                     " s; such a log can not be resampled: repair or cut it, or state the rate" +
                     (report.late > 0 ? "; " + cure_of_late_stamps(report) : ""));
  }
  if (report.period <= 0.0) {
    throw InputError(log.source + ": the time stamps do not go forward, or not by seconds; state the rate");
  }
  const double rate_hz = options.rate_hz.value_or(1.0 / report.period);
  if (rate_hz * report.period > highest_ratio) {
    throw InputError(log.source + ": resampling to " + number(rate_hz) + " Hz, recorded at " +
                     number(1.0 / report.period) + " Hz; at most " + number(highest_ratio) +
                     " times the recorded rate is possible");
  }
  const Log distinct = report.repeated.count > 0 ? without_repeated(log, repeated_step * report.period) : log;
  std::vector<Log> pieces;
  const std::vector<Index> bounds = piece_bounds(distinct.t, options.max_gap * report.period);
  std::vector<std::string> dropped;
  for (std::size_t p = 0; p + 1 < bounds.size(); ++p) {
    const Index count = bounds[p + 1] - bounds[p];
    Log piece = excerpt(distinct, bounds[p], count);
    if (count >= 2) {
      Log regular = on_grid(piece, rate_hz);
      if (regular.samples() >= options.min_samples) {
        pieces.push_back(std::move(regular));
        continue;
      }
    }
    dropped.push_back("t = " + number(piece.t[0]) + " to " + number(piece.t[count - 1]) + " s");
  }
  if (pieces.empty()) {
    throw InputError(log.source + ": no stretch of the log without a gap of more than " +
                     number(options.max_gap) + " periods has " + std::to_string(options.min_samples) +
                     " samples at " + number(rate_hz) + " Hz; " + report.summary() +
                     (report.late > 0 ? "; " + cure_of_late_stamps(report) : ""));
  }
  std::vector<std::string> notes = {
      "time stamps: " + report.summary(),
      "resampled to " + number(rate_hz) + " Hz, positions by cubic spline, all else linearly"};
  if (report.repeated.count > 0) {
    notes.push_back("dropped " + counted(log.samples() - distinct.samples(), "row") +
                    " with repeated time stamps");
  }
  if (report.missing.count > 0) {
    notes.push_back("interpolated over " + counted(report.missing.count, "gap") + ", " +
                    counted(report.missing_rows, "missing row"));
  }
  if (report.jumps.count > 0) {
    notes.push_back("split at " + counted(report.jumps.count, "jump") + " of the time stamps into " +
                    counted(std::ssize(pieces), "log"));
  }
  if (!dropped.empty()) {
    notes.push_back("dropped stretches of fewer than " + std::to_string(options.min_samples) +
                    " samples: " + listed(dropped));
  }
  if (rate_hz * report.period < aliasing_ratio) {
    notes.push_back("the log was recorded at " + number(1.0 / report.period) +
                    " Hz and resampled without a filter: what lies above " + number(0.5 * rate_hz) +
                    " Hz is folded");
  }
  for (Log& piece : pieces) {
    if (report.late > 0) {
      piece.warnings.push_back(Finding{"late_stamps", log.source, cure_of_late_stamps(report)});
    }
    piece.notes.insert(piece.notes.end(), notes.begin(), notes.end());
  }
  return pieces;
}

}  // namespace

std::string TimeReport::summary() const {
  const bool timed = period > 0.0;
  std::string out = std::to_string(samples) + " samples" + (timed ? " at " + number(rate_hz) + " Hz" : "");
  const auto add = [&](const TimeFault& fault, const std::string& what) {
    if (fault.count > 0) {
      out += "; " + what + " (first at row " + std::to_string(fault.row + 1) + ", t = " + number(fault.time) +
             " s)";
    }
  };
  add(repeated, std::to_string(repeated.count) + " repeated");
  add(reversed, std::to_string(reversed.count) + " reversed");
  add(missing, counted(missing.count, "gap") + " of " + counted(missing_rows, "missing row"));
  add(jumps, counted(jumps.count, "jump"));
  const auto percent = [](double fraction) {
    const double value = 100.0 * fraction;
    return number(value < 0.01 ? 0.0 : std::round(value * 100.0) / 100.0);
  };
  if (!timed) {
    return out + (longest_step > 0.0
                      ? "; steps of " + number(shortest_step) + " to " + number(longest_step) + " s"
                      : "");
  }
  out += "; jitter " + percent(jitter_rms) + " % rms, " + percent(jitter_max) + " % at most";
  if (jitter_rms >= regular_rms || jitter_max >= regular_max) {
    out += ", steps of " + number(1e3 * shortest_step) + " to " + number(1e3 * longest_step) + " ms";
  }
  return out;
}

TimeReport inspect_time(const Eigen::Ref<const Vector>& t, double max_gap) {
  if (const auto fault = gap_complaint(max_gap)) {
    throw InputError("inspect_time: " + *fault);
  }
  for (Index i = 0; i < t.size(); ++i) {
    if (!std::isfinite(t[i])) {
      throw InputError("inspect_time: t is " + number(t[i]) + " at row " + std::to_string(i + 1) +
                       ", must be finite");
    }
  }
  TimeReport report;
  report.samples = t.size();
  if (t.size() < 2) {
    return report;
  }
  std::vector<double> forward;
  forward.reserve(static_cast<std::size_t>(t.size()));
  for (Index i = 1; i < t.size(); ++i) {
    if (t[i] > t[i - 1]) {
      forward.push_back(t[i] - t[i - 1]);
    }
  }
  if (!forward.empty()) {
    const auto [shortest, longest] = std::minmax_element(forward.begin(), forward.end());
    report.shortest_step = *shortest;
    report.longest_step = *longest;
  }
  report.period = median(std::move(forward));
  const double span = t[t.size() - 1] - t[0];
  report.rate_hz = span > 0.0 ? static_cast<double>(t.size() - 1) / span : 0.0;
  // Of other steps neither rate nor jitter is a number.
  constexpr double shortest = 1e-12;  // [s]
  constexpr double longest = 1e12;    // [s]
  if (report.period > 0.0 && (report.period < shortest || report.longest_step > longest)) {
    report.period = report.rate_hz = 0.0;
    return report;
  }

  GridFit fit;
  std::vector<double> grid = {0.0};
  std::vector<double> stamps = {t[0]};
  const auto begin_piece = [&](double first) {
    fit.add_piece(grid, stamps, report.period);
    grid.assign(1, 0.0);
    stamps.assign(1, first);
  };
  for (Index i = 1; i < t.size(); ++i) {
    const double step = t[i] - t[i - 1];
    const double periods = report.period > 0.0 ? step / report.period : 0.0;
    if (step < 0.0 && periods <= -repeated_step) {
      add(report.reversed, i, t[i]);
      begin_piece(t[i]);
      continue;
    }
    if (periods < repeated_step) {
      add(report.repeated, i, t[i]);
      continue;
    }
    if (periods > max_gap) {
      add(report.jumps, i, t[i]);
      begin_piece(t[i]);
      continue;
    }
    const double k = std::max(1.0, std::round(periods));
    if (k >= 2.0) {
      add(report.missing, i, t[i]);
      report.missing_rows += static_cast<Index>(k) - 1;
    }
    grid.push_back(grid.back() + k);
    stamps.push_back(t[i]);
  }
  fit.add_piece(grid, stamps, report.period);
  if (const LateStamps late = late_stamps(t); late.count > 0) {
    report.late = late.count;
    report.rate_hz = 1.0 / late.period;
  }
  report.jitter_rms = fit.rms();
  report.jitter_max = fit.largest();
  report.regular = report.period > 0.0 && report.repeated.count == 0 && report.reversed.count == 0 &&
                   report.missing.count == 0 && report.jumps.count == 0 && report.jitter_rms < regular_rms &&
                   report.jitter_max < regular_max;
  return report;
}

std::optional<std::string> ResampleOptions::complaint() const {
  if (rate_hz && (!std::isfinite(*rate_hz) || *rate_hz <= 0.0)) {
    return "rate_hz is " + number(*rate_hz) + " Hz, must be positive";
  }
  if (auto fault = gap_complaint(max_gap)) {
    return fault;
  }
  if (min_samples < 2) {
    return "min_samples is " + std::to_string(min_samples) + ", must be at least 2";
  }
  return std::nullopt;
}

std::vector<Log> regularised(Log log, Irregular irregular, const ResampleOptions& options) {
  if (const auto fault = options.complaint()) {
    throw InputError("regularised: " + *fault);
  }
  if (const auto fault = detail::shape_complaint(log)) {
    throw InputError("regularised: " + *fault);
  }
  const TimeReport report = inspect_time(log.t, options.max_gap);
  if (irregular == Irregular::resample && (!report.regular || options.rate_hz)) {
    return resampled(log, report, options);
  }
  if (!report.regular && irregular == Irregular::refuse) {
    throw InputError(first_place(log, report) + ": the time stamps are irregular: " + report.summary() +
                     "; resample the log, state its rate, or ignore the time stamps if only they are wrong" +
                     (report.late > 0 ? "; " + cure_of_late_stamps(report) : ""));
  }
  if (irregular == Irregular::ignore && (!report.regular || options.rate_hz)) {
    const double rate_hz = options.rate_hz.value_or(report.rate_hz);
    if (rate_hz <= 0.0) {
      throw InputError(log.source + ": the time stamps do not go forward, so they give no rate; state it");
    }
    log.notes.push_back("time stamps ignored, rows taken as samples at " +
                        std::string(options.rate_hz ? "the stated " : "the mean rate of ") + number(rate_hz) +
                        " Hz; found: " + report.summary());
    log.f_m = rate_hz;
    log.t = log.t[0] +
            Vector::LinSpaced(log.samples(), 0.0, static_cast<double>(log.samples() - 1)).array() / rate_hz;
  }
  std::vector<Log> out;
  out.push_back(std::move(log));
  return out;
}

}  // namespace rivid
