#include "report/scale.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rivid/report/ticks.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

Scale::Scale(std::array<double, 2> values, bool logarithmic, Ends ends) : logarithmic_(logarithmic) {
  auto [low, high] = values;
  if (logarithmic) {
    show_decades(low, high);
    return;
  }
  if (!(high > low)) {
    const double room = std::max(std::abs(low) * 0.1, 1e-3);
    low -= room;
    high += room;
  }
  ticks_ = round_ticks(low, high);
  low_ = ends == Ends::ticks ? ticks_.front() : low;
  high_ = ends == Ends::ticks ? ticks_.back() : high;
  const double rounding = 1e-9 * (high_ - low_);
  std::erase_if(ticks_, [&](double t) { return t < low_ - rounding || t > high_ + rounding; });
  for (double& tick : ticks_) {
    tick = std::abs(tick) < rounding ? 0.0 : tick;
  }
}

void Scale::show_decades(double low, double high) {
  // Fewer than one decade has no second tick; more than these hide everything else.
  constexpr double most_decades = 8.0;
  high_ = std::ceil(std::log10(high));
  low_ = std::clamp(std::floor(std::log10(low)), high_ - most_decades, high_ - 1.0);
  for (double decade = low_; decade <= high_; decade += 1.0) {
    ticks_.push_back(std::pow(10.0, decade));
  }
}

double Scale::at(double value) const {
  const double v = logarithmic_ ? std::log10(std::max(value, std::pow(10.0, low_))) : value;
  return from_ + (std::clamp(v, low_, high_) - low_) / (high_ - low_) * (to_ - from_);
}

std::string Scale::words() const { return number(low_, 9) + " " + number(high_, 9); }

std::array<double, 2> range_of(const std::vector<const Vector*>& values, const std::vector<double>& shown,
                               bool positive) {
  std::array<double, 2> out = {std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity()};
  const auto show = [&](double value) {
    if (std::isfinite(value) && (!positive || value > 0.0)) {
      out = {std::min(out[0], value), std::max(out[1], value)};
    }
  };
  for (const Vector* const each : values) {
    std::ranges::for_each(*each, show);
  }
  std::ranges::for_each(shown, show);
  return out[0] <= out[1] ? out : std::array{positive ? 1.0 : 0.0, positive ? 10.0 : 1.0};
}

}  // namespace rivid::detail
