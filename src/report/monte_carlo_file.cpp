#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include "checksum.hpp"
#include "experiment/text_file.hpp"
#include "read_number.hpp"
#include "rivid/error.hpp"
#include "rivid/output.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

constexpr std::size_t leading_cells = 6;  // of a row, before values and deviations

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
  const char* const last = cell.data() + cell.size();
  const auto [end, fault] = [&] {
    if constexpr (std::is_same_v<Number, double>) {
      return detail::read_number(cell.data(), last, out);
    } else {
      return std::from_chars(cell.data(), last, out);
    }
  }();
  if (fault != std::errc() || end != last) {
    throw InputError(place + ": \"" + cell + "\" is no number");
  }
  return out;
}

// That of a line, as 16 hexadecimal digits: the last cell of each.
std::string line_checksum(std::string_view line) {
  std::ostringstream out;
  out << std::hex << std::setw(16) << std::setfill('0') << detail::checksum(line);
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

constexpr std::string_view of_rivid = "# rivid ";

// What the runs are made from, in the manner of sha256sum; their number may grow.
std::string fingerprint(const MonteCarlo& plan) {
  std::string out = std::string(of_rivid) + version + "\n";
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

// What a folder says its runs are made from; nothing where it does not.
std::optional<std::string> told_fingerprint(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "inputs.sha256";
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    return std::nullopt;
  }
  std::string out = detail::file_text(file, "the list of inputs");
  if (!out.starts_with(of_rivid)) {
    throw InputError(file.string() +
                     ": is not of rivid study, and not overwritten; --output names another folder");
  }
  return out;
}

// Held as long as a study writes to its folder; nothing where the file system has no locks.
std::shared_ptr<const int> locked(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) {
    return nullptr;
  }
  std::shared_ptr<const int> out(new int(descriptor), [](const int* held) {
    ::close(*held);
    delete held;
  });
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw InputError(
        folder.string() +
        ": another rivid study writes there; --output names another folder, and merge sums up several");
  }
  return out;
}

// Device and number of a file; zeros where there is none.
std::pair<std::uintmax_t, std::uintmax_t> identity_of(const std::filesystem::path& path) {
  struct stat status{};
  return ::stat(path.c_str(), &status) == 0
             ? std::pair<std::uintmax_t, std::uintmax_t>(status.st_dev, status.st_ino)
             : std::pair<std::uintmax_t, std::uintmax_t>();
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
  const std::optional<std::string> made_from = told_fingerprint(folder);
  std::map<int, std::vector<MonteCarloRow>> out;
  std::error_code error;
  if (!std::filesystem::exists(runs, error)) {
    return out;
  }
  const std::string content = detail::file_text(runs, "the rows of earlier runs");
  if (std::ranges::count(content, '\n') <= 1) {
    return out;  // the heading alone
  }
  if (!made_from) {
    throw InputError(
        folder.string() +
        ": has runs.csv without the inputs.sha256 that says what its runs are made from; --restart begins "
        "anew, --output names another folder");
  }
  if (*made_from != fingerprint(plan)) {
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
    std::error_code error;
    if (!std::filesystem::exists(folder / "runs.csv", error)) {
      throw InputError(folder.string() + ": holds no runs.csv, as rivid study --output writes it");
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
    : lock_(locked(folder)),
      path_(folder / "runs.csv"),
      header_(csv_header(plan)),
      made_from_(fingerprint(plan)),
      first_(first),
      end_(first + plan.runs) {
  if (restart) {
    static_cast<void>(told_fingerprint(folder));
  } else {
    rows_ = held_runs(folder, plan);
  }
  write_all();
}

void MonteCarloFile::write_all() {
  std::string content = header_;
  for (const auto& [run, rows] : rows_) {
    content += lines_of(rows);
  }
  // Rows first: those of other inputs must be gone before these are named.
  write_file(path_, content);
  write_file(path_.parent_path() / "inputs.sha256", made_from_);
  out_.close();
  identity_ = identity_of(path_);
  // Not one without a heading, where the file is gone again.
  out_.open(path_, std::ios::in | std::ios::ate);
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
  rows_[rows.front().run] = rows;
  if (!out_.is_open() || identity_of(path_) != identity_) {
    write_all();  // someone moved or removed the file
    return;
  }
  out_ << lines_of(rows) << std::flush;
  if (!out_) {
    throw InputError(path_.string() + ": can not be written to");
  }
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
