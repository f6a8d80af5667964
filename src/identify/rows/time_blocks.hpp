#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "ranges.hpp"
#include "rivid/data/log.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Of all logs, that a covariance is told by.
inline constexpr Index blocks_of_time = 10;

// A log as far as time is concerned.
struct Duration {
  Index samples = 0;
  double f_m = 0.0;  // [Hz]
  Index first = 0;   // sample of it that counts, of a window

  [[nodiscard]] double seconds() const { return static_cast<double>(samples) / f_m; }
};

[[nodiscard]] inline std::vector<Duration> durations(std::span<const Log> logs) {
  std::vector<Duration> out;
  std::ranges::transform(logs, std::back_inserter(out),
                         [](const Log& log) { return Duration{log.samples(), log.f_m}; });
  return out;
}

// Of the window that rows are taken from, where there is one.
[[nodiscard]] inline std::vector<Duration> durations(std::span<const Log> logs,
                                                     const std::optional<std::array<double, 2>>& window) {
  std::vector<Duration> out = durations(logs);
  for (std::size_t l = 0; window && l < logs.size(); ++l) {
    const Vector& t = logs[l].t;
    const Index first = std::ranges::lower_bound(t, (*window)[0]) - t.begin();
    const Index last = std::ranges::upper_bound(t, (*window)[1]) - t.begin();
    if (last > first) {
      out[l] = {last - first, logs[l].f_m, first};
    }
  }
  return out;
}

// The time of all logs divided into blocks of about the same length, between which errors count as
// independent: each log has as many as its duration asks for, and one at least.
class TimeBlocks {
 public:
  TimeBlocks(std::vector<Duration> logs, Index wanted) : logs_(std::move(logs)) {
    const double seconds = sum_of(logs_, &Duration::seconds);
    for (const Duration& log : logs_) {
      first_.push_back(count_);
      count_ += std::max<Index>(std::lround(static_cast<double>(wanted) * (log.seconds() / seconds)), 1);
    }
    first_.push_back(count_);
  }

  // Blocks of all logs, of one log, and the first one of a log.
  [[nodiscard]] Index count() const { return count_; }
  [[nodiscard]] Index count(std::size_t log) const { return first_[log + 1] - first_[log]; }
  [[nodiscard]] Index first(std::size_t log) const { return first_[log]; }
  // Where a sample of a log belongs, among the blocks of all.
  [[nodiscard]] Index of(std::size_t log, Index sample) const {
    const Index since = sample - logs_[log].first;
    return first_[log] + std::clamp<Index>(since * count(log) / logs_[log].samples, 0, count(log) - 1);
  }

  // Divides rows by their blocks: take(block, first row, count).
  //
  // samples  of the log that the rows stand for, ascending
  template <typename Take>
  void divide(std::size_t log, std::span<const Index> samples, const Take& take) const {
    const Index rows = std::ssize(samples);
    for (Index begin = 0, end = 0; begin < rows; begin = end) {
      const Index block = of(log, samples[static_cast<std::size_t>(begin)]);
      while (end < rows && of(log, samples[static_cast<std::size_t>(end)]) == block) {
        ++end;
      }
      take(block, begin, end - begin);
    }
  }

 private:
  std::vector<Duration> logs_;
  std::vector<Index> first_;
  Index count_ = 0;
};

// Intervals of time that scores are summed over: finer than any correlation from which a covariance could
// still be estimated, and little memory.
class TimeIntervals {
 public:
  // shortest  [s]
  TimeIntervals(std::vector<Duration> logs, double shortest) : logs_(std::move(logs)), seconds_(shortest) {
    constexpr double most = 2048.0;  // that a log is divided into
    for (const Duration& log : logs_) {
      seconds_ = std::max(seconds_, log.seconds() / most);
    }
  }

  [[nodiscard]] double seconds() const { return seconds_; }
  [[nodiscard]] double samples(std::size_t log) const { return seconds_ * logs_[log].f_m; }
  [[nodiscard]] Index count(std::size_t log) const { return of(logs_[log].samples, samples(log)) + 1; }
  // Where a sample belongs in a log.
  [[nodiscard]] Index of(std::size_t log, Index sample) const { return of(sample, samples(log)); }
  // The same of intervals of so many samples.
  [[nodiscard]] static Index of(Index sample, double samples) {
    constexpr double rounding = 1e-9;  // samples; above the rounding of the quotient, below a sample
    return static_cast<Index>(static_cast<double>(sample) / samples + rounding);
  }

 private:
  std::vector<Duration> logs_;
  double seconds_;
};

}  // namespace rivid::detail
