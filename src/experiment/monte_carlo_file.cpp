#include <array>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "experiment/text_file.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

constexpr std::size_t leading_cells = 6;

// Shortest text that reads back as the same number.
std::string exact(double x) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
  return {text.data(), end};
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> out;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    out.push_back(cell);
  }
  return out;
}

template <typename Number>
Number parsed(const std::string& cell, const std::string& place) {
  Number out{};
  const auto [end, fault] = std::from_chars(cell.data(), cell.data() + cell.size(), out);
  if (fault != std::errc() || end != cell.data() + cell.size()) {
    throw InputError(place + ": \"" + cell + "\" is no number");
  }
  return out;
}

std::string padded(std::string text, std::size_t width) {
  const std::size_t shown = display_width(text);
  return shown < width ? std::string(width - shown, ' ') + text : text;
}

std::string fixed(double x, int decimals) {
  std::ostringstream out;
  out.setf(std::ios::fixed);
  out.precision(decimals);
  out << x;
  return out.str();
}

}  // namespace

std::string csv_header(const MonteCarlo& plan) {
  std::string out = "run,trial,status,iterations,seconds,quantile_975";
  for (const BaseParameter& p : base_parameters(plan.experiment.robot).parameters) {
    out += "," + p.name + ",sigma " + p.name;
  }
  return out + "\n";
}

std::string to_csv(const MonteCarloRow& row) {
  std::string out = std::to_string(row.run) + "," + row.label + "," + row.status + "," +
                    std::to_string(row.iterations) + "," + exact(row.seconds) + "," + exact(row.quantile);
  for (Index i = 0; i < row.value.size(); ++i) {
    out += "," + exact(row.value[i]) + "," + exact(row.sigma[i]);
  }
  return out + "\n";
}

std::vector<MonteCarloRow> read_monte_carlo_rows(const std::filesystem::path& path, const MonteCarlo& plan) {
  const std::string header = csv_header(plan);
  const std::string content = detail::file_text(path, "the rows of earlier runs");
  if (!content.starts_with(header)) {
    throw InputError(path.string() +
                     ":1: has other columns than this experiment asks for; --restart begins anew");
  }
  std::vector<MonteCarloRow> out;
  std::istringstream lines(content.substr(header.size(), content.rfind('\n') + 1 - header.size()));
  std::size_t number = 2;
  for (std::string line; std::getline(lines, line); ++number) {
    const std::string place = path.string() + ":" + std::to_string(number);
    const std::vector<std::string> cells = cells_of(line);
    const auto b = (cells_of(header).size() - leading_cells) / 2;
    if (cells.size() != leading_cells + 2 * b) {
      throw InputError(place + ": has " + counted(static_cast<Index>(cells.size()), "cell") + ", must have " +
                       std::to_string(leading_cells + 2 * b));
    }
    MonteCarloRow& row = out.emplace_back();
    row.run = parsed<int>(cells[0], place);
    row.label = cells[1];
    row.status = cells[2];
    row.iterations = parsed<int>(cells[3], place);
    row.seconds = parsed<double>(cells[4], place);
    row.quantile = parsed<double>(cells[5], place);
    row.value.resize(static_cast<Index>(b));
    row.sigma.resize(static_cast<Index>(b));
    for (std::size_t i = 0; i < b; ++i) {
      row.value[static_cast<Index>(i)] = parsed<double>(cells[leading_cells + 2 * i], place);
      row.sigma[static_cast<Index>(i)] = parsed<double>(cells[leading_cells + 2 * i + 1], place);
    }
  }
  return out;
}

std::ostream& operator<<(std::ostream& out, std::span<const MonteCarloSummary> summaries) {
  constexpr std::size_t name_width = 10;
  constexpr std::size_t width = 14;
  for (const MonteCarloSummary& s : summaries) {
    out << s.label << ": " << s.identified << " of " << counted(s.runs, "run") << " identified";
    if (s.mean_iterations > 0.0) {
      out << ", " << fixed(s.mean_iterations, 1) << " iterations";
    }
    out << '\n' << padded("parameter", name_width);
    for (const char* const title :
         {"truth", "bias", "bias/spread", "RMSE/bound", "sigma/spread", "coverage"}) {
      out << padded(title, width);
    }
    out << '\n';
    double coverage = 0.0;
    for (const MonteCarloParameter& p : s.parameters) {
      constexpr int digits = 4;
      out << padded(p.name, name_width) << padded(number(p.truth, digits), width)
          << padded(number(p.bias, digits), width) << padded(fixed(p.bias_in_spreads, 2), width)
          << padded(fixed(p.rmse_over_bound, 2), width) << padded(fixed(p.sigma_over_spread, 2), width)
          << padded(fixed(100.0 * p.coverage, 1) + " %", width) << '\n';
      coverage += p.coverage / static_cast<double>(s.parameters.size());
    }
    out << padded("mean", name_width) << padded(fixed(100.0 * coverage, 1) + " %", 6 * width) << "\n\n";
  }
  return out;
}

std::string to_json(std::span<const MonteCarloSummary> summaries) {
  using Json = nlohmann::ordered_json;
  Json trials = Json::array();
  for (const MonteCarloSummary& s : summaries) {
    Json parameters = Json::array();
    for (const MonteCarloParameter& p : s.parameters) {
      parameters.push_back({{"name", p.name},
                            {"unit", p.unit},
                            {"truth", p.truth},
                            {"bias", p.bias},
                            {"spread", p.spread},
                            {"rmse", p.rmse},
                            {"bias_in_spreads", p.bias_in_spreads},
                            {"rmse_over_bound", p.rmse_over_bound},
                            {"sigma_over_spread", p.sigma_over_spread},
                            {"coverage", p.coverage}});
    }
    trials.push_back({{"label", s.label},
                      {"runs", s.runs},
                      {"identified", s.identified},
                      {"mean_iterations", s.mean_iterations},
                      {"parameters", std::move(parameters)}});
  }
  const Json out = {{"format", 1}, {"trials", std::move(trials)}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rivid
