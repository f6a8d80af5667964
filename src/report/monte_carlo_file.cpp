#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "experiment/text_file.hpp"
#include "rivid/error.hpp"
#include "rivid/output.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

constexpr std::size_t leading_cells = 6;

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

// FNV-1a of a line, as 16 hexadecimal digits: the last cell of each.
std::string line_checksum(std::string_view line) {
  std::uint64_t sum = 0xCBF29CE484222325U;
  for (const char c : line) {
    sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  }
  std::ostringstream out;
  out << std::hex << std::setw(16) << std::setfill('0') << sum;
  return out.str();
}

std::string lines_of(const std::vector<MonteCarloRow>& rows) {
  std::string out;
  for (const MonteCarloRow& row : rows) {
    out += to_csv(row);
  }
  return out;
}

// Rows of one run, made twice.
bool same_but_times(std::vector<MonteCarloRow> a, std::vector<MonteCarloRow> b) {
  for (std::vector<MonteCarloRow>* const rows : {&a, &b}) {
    std::ranges::for_each(*rows, [](MonteCarloRow& row) { row.seconds = 0.0; });
  }
  return lines_of(a) == lines_of(b);
}

// What the runs are made from, in the manner of sha256sum; their number may grow.
std::string fingerprint(const MonteCarlo& plan) {
  std::string out = "# rivid " + std::string(version) + "\n";
  for (const std::filesystem::path& input : plan.experiment.inputs(Use::simulation)) {
    out += input_file(input).sha256 + "  " + input.filename().string() + "\n";
  }
  for (const std::string& setting : plan.settings) {
    if (!setting.starts_with("montecarlo.runs")) {
      out += "--set " + setting + "\n";
    }
  }
  return out;
}

}  // namespace

std::string csv_header(const MonteCarlo& plan) {
  std::string out = "run,trial,status,iterations,seconds,quantile_975";
  for (const BaseParameter& p : base_parameters(plan.experiment.robot).parameters) {
    out += "," + p.name + ",sigma " + p.name;
  }
  return out + ",checksum\n";
}

std::string to_csv(const MonteCarloRow& row) {
  std::string out = std::to_string(row.run) + "," + row.label + "," + row.status + "," +
                    std::to_string(row.iterations) + "," + exact(row.seconds) + "," + exact(row.quantile);
  for (Index i = 0; i < row.value.size(); ++i) {
    out += "," + exact(row.value[i]) + "," + exact(row.sigma[i]);
  }
  return out + "," + line_checksum(out) + "\n";
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
    const auto b = (cells_of(header).size() - 1 - leading_cells) / 2;
    if (cells.size() != leading_cells + 2 * b + 1) {
      throw InputError(place + ": has " + counted(static_cast<Index>(cells.size()), "cell") + ", must have " +
                       std::to_string(leading_cells + 2 * b + 1));
    }
    if (cells.back() != line_checksum(std::string_view(line).substr(0, line.rfind(',')))) {
      throw InputError(
          place + ": is damaged, its checksum does not fit; take the line out, and its run is made again");
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

std::map<int, std::vector<MonteCarloRow>> held_runs(const std::filesystem::path& folder,
                                                    const MonteCarlo& plan) {
  const std::filesystem::path runs = folder / "runs.csv";
  const std::filesystem::path made_from = folder / "inputs.sha256";
  std::map<int, std::vector<MonteCarloRow>> out;
  if (!std::filesystem::exists(runs)) {
    return out;
  }
  if (std::filesystem::exists(made_from) &&
      detail::file_text(made_from, "the list of inputs") != fingerprint(plan)) {
    throw InputError(folder.string() +
                     ": holds runs of other input files, or of another version; --restart begins "
                     "anew, --output names another folder");
  }
  for (const MonteCarloRow& row : read_monte_carlo_rows(runs, plan)) {
    out[row.run].push_back(row);
  }
  std::erase_if(out, [&](const auto& run) { return run.second.size() != plan.trials.size(); });
  return out;
}

std::map<int, std::vector<MonteCarloRow>> merged_runs(std::span<const std::filesystem::path> folders,
                                                      const MonteCarlo& plan) {
  std::map<int, std::vector<MonteCarloRow>> out;
  for (const std::filesystem::path& folder : folders) {
    if (!std::filesystem::exists(folder / "runs.csv")) {
      throw InputError(folder.string() + ": holds no runs.csv, as rivid_montecarlo --output writes it");
    }
    for (const auto& [run, rows] : held_runs(folder, plan)) {
      const auto [there, added] = out.emplace(run, rows);
      if (!added && !same_but_times(there->second, rows)) {
        throw InputError(folder.string() + ": run " + std::to_string(run) +
                         " has other rows than in a folder before it");
      }
    }
  }
  return out;
}

MonteCarloFile::MonteCarloFile(const std::filesystem::path& folder, const MonteCarlo& plan, bool restart,
                               int first)
    : path_(folder / "runs.csv"), first_(first), end_(first + plan.runs) {
  std::string content = csv_header(plan);
  if (!restart) {
    rows_ = held_runs(folder, plan);
    for (const auto& [run, rows] : rows_) {
      content += lines_of(rows);
    }
  }
  write_file(path_, content);
  write_file(folder / "inputs.sha256", fingerprint(plan));
  out_.open(path_, std::ios::app);
}

std::vector<int> MonteCarloFile::missing() const {
  std::vector<int> out;
  for (int run = first_; run < end_; ++run) {
    if (!rows_.contains(run)) {
      out.push_back(run);
    }
  }
  return out;
}

void MonteCarloFile::add(const std::vector<MonteCarloRow>& rows) {
  out_ << lines_of(rows) << std::flush;
  if (!out_) {
    throw InputError(path_.string() + ": can not be written to");
  }
  rows_[rows.front().run] = rows;
}

std::vector<MonteCarloRow> MonteCarloFile::rows() const {
  std::vector<MonteCarloRow> out;
  for (const auto& [run, rows] : rows_) {
    if (first_ <= run && run < end_) {
      out.insert(out.end(), rows.begin(), rows.end());
    }
  }
  return out;
}

}  // namespace rivid
