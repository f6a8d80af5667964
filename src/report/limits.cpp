#include "rivid/report/limits.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/experiment/rehearsal.hpp"
#include "rivid/identify/log_factors.hpp"
#include "rivid/identify/posterior.hpp"

namespace rivid {

namespace {

// That of the key of an experiment file which an option stands for.
template <Described Record>
constexpr Range key_range(std::string_view key) {
  Range out;
  for_each_field<Record>([&](const auto& field) { out = field.key == key ? field.details.range : out; });
  return out;
}

constexpr Range gain_percents = Range::from(0.0, 100.0 * gain_sigma_range.most);

constexpr auto command_numbers = std::to_array<CommandLineNumber>({
    {"--threads", "all", Range::within(0, 1024)},
    {"--max-size", "all", Range::within(1, 1 << 30), "MiB"},
    {"--seconds", "`rivid excite`", Range::within(1, 1e6), "s"},
    {"--starts", "`rivid excite`", key_range<ExcitationOptions>("starts")},
    {"--spread", "`rivid excite rehearse`", Range::within(0.0, RehearsalOptions::largest_spread)},
    {"--samples", "`rivid export`", key_range<PosteriorOptions>("count")},
    {"--seed", "`rivid excite`, `rivid export`, `rivid simulate`, `rivid_odd`", seed_range},
    {"--runs", "`rivid study`", key_range<MonteCarlo>("runs")},
    {"--first-run", "`rivid study`", Range::from(0, key_range<MonteCarlo>("runs").most)},
    {"--count", "`rivid_odd`", Range::within(1, 1e6)},
    {"--first", "`rivid_odd`", Range::within(0, 1e9)},
    {"--blocks", "`rivid factors`", Range::within(1, LogFactors::most_blocks)},
    {"--gains", "`rivid payload`, `rivid online`", gain_percents, "%"},
    {"--flange", "`rivid payload`", Range::within(-1e3, 1e3), "m, rad"},
    {"--mass", "`rivid payload`", Range::above(0.0, 1e6), "kg"},
    {"--stride", "`rivid online`", Range::within(1, 1e6), "samples"},
    {"--learn", "`rivid online`", Range::from(0.0, 1e6), "s"},
});

}  // namespace

std::span<const CommandLineNumber> command_line_numbers() { return command_numbers; }

const CommandLineNumber& command_line_number(std::string_view option) {
  const auto* const at = std::ranges::find(command_numbers, option, &CommandLineNumber::option);
  if (at == command_numbers.end()) {
    throw std::logic_error("command_line_number: nothing is said of " + std::string(option));
  }
  return *at;
}

}  // namespace rivid
