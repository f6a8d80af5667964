#include "progress_bar.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace rivid::apps {

namespace {

using namespace std::chrono_literals;
constexpr auto patience = 1s;
constexpr auto redraw = 100ms;
constexpr int bar_width = 30;

}  // namespace

ProgressBar::ProgressBar(bool wanted)
    : wanted_(wanted && ::isatty(STDERR_FILENO) == 1), next_(Clock::now() + patience) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::show(std::string_view stage, double fraction) {
  const Clock::time_point now = Clock::now();
  if (!wanted_ || now < next_) {
    return;
  }
  next_ = now + redraw;
  drawn_ = true;
  const int filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * bar_width);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(bar_width - filled), '.');
  std::fprintf(stderr, "\r\033[K[%s] %3.0f %%  %.*s", bar.c_str(), 100.0 * fraction,
               static_cast<int>(stage.size()), stage.data());
  std::fflush(stderr);
}

void ProgressBar::clear() {
  if (drawn_) {
    std::fputs("\r\033[K", stderr);
    drawn_ = false;
  }
}

}  // namespace rivid::apps
