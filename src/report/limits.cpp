#include "rivid/report/limits.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/identify/log_factors.hpp"

namespace rivid {

namespace {

// That of the key of an experiment file which an option stands for.
template <Described Record>
constexpr Range range_of(std::string_view key) {
  Range out;
  for_each_field<Record>([&](const auto& field) { out = field.key == key ? field.details.range : out; });
  return out;
}

constexpr Range percents = Range::from(0.0, 100.0 * gain_sigma_range.most);

constexpr auto numbers = std::to_array<CommandLineNumber>({
    {"--threads", "all", Range::within(0, 1024)},
    {"--max-size", "all", Range::within(1, 1 << 30), "MiB"},
    {"--seconds", "`rivid_excite`", Range::within(1, 1e6), "s"},
    {"--starts", "`rivid_excite`", range_of<ExcitationOptions>("starts")},
    {"--seed", "`rivid_excite`, `rivid_simulate`", seed_range},
    {"--runs", "`rivid_montecarlo`", range_of<MonteCarlo>("runs")},
    {"--first-run", "`rivid_montecarlo`", Range::from(0, range_of<MonteCarlo>("runs").most)},
    {"--seeds", "`rivid_paper_study`", Range::within(1, 1000)},
    {"--blocks", "`rivid_identify factors`", Range::within(1, LogFactors::most_blocks)},
    {"--gains", "`rivid_identify payload`, `rivid_online`", percents, "%"},
    {"--flange", "`rivid_identify payload`", Range::within(-1e3, 1e3), "m, rad"},
    {"--mass", "`rivid_identify payload`", Range::above(0.0, 1e6), "kg"},
    {"--stride", "`rivid_online`", Range::within(1, 1e6), "samples"},
    {"--learn", "`rivid_online`", Range::from(0.0, 1e6), "s"},
});

}  // namespace

std::span<const CommandLineNumber> command_line_numbers() { return numbers; }

const CommandLineNumber& command_line_number(std::string_view option) {
  const auto* const at = std::ranges::find(numbers, option, &CommandLineNumber::option);
  if (at == numbers.end()) {
    throw std::logic_error("command_line_number: nothing is said of " + std::string(option));
  }
  return *at;
}

}  // namespace rivid
