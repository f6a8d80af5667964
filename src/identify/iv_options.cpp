#include <array>
#include <cmath>
#include <utility>

#include "rivid/identify/iv.hpp"
#include "rivid/text.hpp"

namespace rivid {

std::optional<std::string> Iv::complaint(const Robot& robot) const {
  if (!control) {
    return "control is not set; the loop that makes the instruments needs a control law, PdControl say";
  }
  if (auto fault = signal.complaint(robot.size())) {
    return fault;
  }
  if (follows == Follows::measured && reference_cutoff_hz == 0.0 && signal.cutoff_hz == 0.0) {
    return "reference_cutoff_hz is 0: a loop that followed the raw positions would carry their noise into "
           "the "
           "instruments; it must be positive where follows is measured";
  }
  if (auto fault = sampling.complaint(robot.size())) {
    return fault;
  }
  if (auto fault = covariance.complaint()) {
    return fault;
  }
  if (auto fault = physical ? physical->complaint(robot) : std::nullopt) {
    return "physical: " + *fault;
  }
  if (auto fault = essential ? essential->complaint() : std::nullopt) {
    return "essential: " + *fault;
  }
  if (auto fault = robust ? robust->complaint() : std::nullopt) {
    return "robust: " + *fault;
  }
  if (prefilter && robust) {
    return "prefilter and robust do not go together: a filter smears each outlier over the rows that follow";
  }
  if (prefilter && !signal.exact_rows()) {
    return "prefilter works on exact rows: rows must be \"exact\"";
  }
  if (prefilter_order < 0 || prefilter_order > most_prefilter_order) {
    return "prefilter_order is " + std::to_string(prefilter_order) + ", must lie between 0 and " +
           std::to_string(most_prefilter_order);
  }
  const auto positive = [](double x) { return std::isfinite(x) && x > 0.0; };
  for (const auto& [key, value] :
       {std::pair("tolerance", tolerance), std::pair("parameter_tolerance", parameter_tolerance)}) {
    if (!positive(value)) {
      return std::string(key) + " is " + number(value) + ", must be positive";
    }
  }
  for (const auto& [key, value] :
       {std::pair("transient", transient), std::pair("reference_cutoff_hz", reference_cutoff_hz)}) {
    if (!std::isfinite(value) || value < 0.0) {
      return std::string(key) + " is " + number(value) + ", must not be negative";
    }
  }
  for (const auto& [key, value] :
       {std::pair("max_iterations", max_iterations), std::pair("threads", threads)}) {
    if (value < 1) {
      return std::string(key) + " is " + std::to_string(value) + ", must be at least 1";
    }
  }
  return std::nullopt;
}

std::string_view name(Iv::Start start) {
  constexpr std::array<std::string_view, 3> names = {"regular", "a_priori", "least_squares"};
  return names[static_cast<std::size_t>(start)];
}

}  // namespace rivid
