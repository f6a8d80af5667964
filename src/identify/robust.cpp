#include "rivid/identify/robust.hpp"

#include <cmath>

#include "rivid/text.hpp"

namespace rivid {

std::optional<std::string> Robust::complaint() const {
  if (tuning && (!std::isfinite(*tuning) || *tuning <= 0.0)) {
    return "tuning is " + number(*tuning) + ", must be positive";
  }
  if (max_rounds < 1) {
    return "max_rounds is " + std::to_string(max_rounds) + ", must be at least 1";
  }
  if (!std::isfinite(tolerance) || tolerance <= 0.0) {
    return "tolerance is " + number(tolerance) + ", must be positive";
  }
  return std::nullopt;
}

}  // namespace rivid
