// runs.csv of rivid_montecarlo: rows that are read and written again are the same.

#include <iomanip>
#include <sstream>

#include "harness.hpp"
#include "rivid/report/monte_carlo.hpp"

namespace {

using namespace rivid;

std::string written(const MonteCarlo& plan, const std::vector<MonteCarloRow>& rows) {
  std::string out = csv_header(plan);
  for (const MonteCarloRow& row : rows) {
    out += to_csv(row);
  }
  return out;
}

// Each whole line with its checksum behind it.
std::string with_checksums(std::string_view lines) {
  std::ostringstream out;
  std::istringstream in{std::string(lines)};
  for (std::string line; std::getline(in, line) && !in.eof();) {
    line += ',';
    out << line << std::hex << std::setw(16) << std::setfill('0')
        << fuzz::fnv1a(std::string_view(line).substr(0, line.size() - 1)) << '\n';
  }
  return out.str();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const MonteCarlo plan = read_monte_carlo(RIVID_DATA "/scara/montecarlo_s1.toml");
  fuzz::Input input(data, size);
  const bool whole = input.choice(2) == 1;
  const std::string content =
      whole ? csv_header(plan) + with_checksums(input.rest()) : std::string(input.rest());
  const auto path = fuzz::file_with(content, "runs.csv");
  const auto rows = fuzz::accepted([&] { return read_monte_carlo_rows(path, plan); });
  if (!rows) {
    return 0;
  }
  const std::string text = written(plan, *rows);
  const auto again = fuzz::read_back("rows can be read again", [&] {
    return read_monte_carlo_rows(fuzz::file_with(text, "again.csv"), plan);
  });
  fuzz::require(written(plan, again) == text, "read(write(rows)) = rows");
  // Which costs simulations: of few inputs.
  constexpr std::uint64_t some = 1024;
  if (fuzz::fnv1a(content) % some == 0) {
    (void)fuzz::accepted([&] { return summaries(plan, *rows); });
  }
  return 0;
}
