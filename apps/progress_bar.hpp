#pragma once

#include <chrono>
#include <string_view>

namespace rivid::apps {

/// A progress bar on standard error: on a terminal only, and only for work that takes longer than a second.
class ProgressBar {
 public:
  /// @param wanted  false never draws
  explicit ProgressBar(bool wanted);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();

  void show(std::string_view stage, double fraction);
  /// Takes the bar off the terminal, so that other output can follow.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool wanted_;
  bool drawn_ = false;
  Clock::time_point next_;
};

}  // namespace rivid::apps
