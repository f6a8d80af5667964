#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// Rows as lines of a CSV file; numbers are written so that they read back bit by bit.
[[nodiscard]] std::string csv_header(const MonteCarlo& plan);
[[nodiscard]] std::string to_csv(const MonteCarloRow& row);

/// Rows of such a file. A last line without an end, where a program was stopped, is passed over.
///
/// @throws InputError  for any other fault: the message names file and line
[[nodiscard]] std::vector<MonteCarloRow> read_monte_carlo_rows(const std::filesystem::path& path,
                                                               const MonteCarlo& plan);

/// Rows of the runs that a folder holds whole, by the runs' numbers; none where there is no such folder.
/// Nothing is written.
///
/// @throws InputError  where it holds runs of other input files or of another version, or does not say of
///                     which
[[nodiscard]] std::map<int, std::vector<MonteCarloRow>> held_runs(const std::filesystem::path& folder,
                                                                  const MonteCarlo& plan);

/// A folder with the rows of all runs that were ever made of a plan, runs.csv, and what they were made from,
/// inputs.sha256: work that was stopped goes on from there. No two can have a folder at the same time.
class MonteCarloFile {
 public:
  /// Opens or makes the folder. Of a run that was cut short nothing is kept.
  ///
  /// @param restart  forget what is in the folder
  /// @param first    number of the first run that is wanted; the others follow it
  /// @throws InputError  where it holds runs of other input files or of another version, or of unknown ones,
  ///                     another study is at work in it, or it can not be used
  MonteCarloFile(const std::filesystem::path& folder, const MonteCarlo& plan, bool restart, int first = 0);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Numbers of the runs that are wanted and not there yet.
  [[nodiscard]] std::vector<int> missing() const;

  /// Adds the rows of one run. They are on their way to the disk when this returns.
  ///
  /// @throws InputError  where the file can not be written to
  void add(const std::vector<MonteCarloRow>& rows);

  /// Rows of the runs that are wanted, in the order of the runs; the folder may hold more.
  [[nodiscard]] std::vector<MonteCarloRow> rows() const;

 private:
  void write_all();

  std::shared_ptr<const int> lock_;
  std::filesystem::path path_;
  std::string header_;
  std::string made_from_;
  int first_;
  int end_;
  std::map<int, std::vector<MonteCarloRow>> rows_;
  std::ofstream out_;
  std::pair<std::uintmax_t, std::uintmax_t> identity_;  // of the file that out_ writes to
};

/// The runs of several folders, of one plan, in one: what MonteCarloFile would hold had it made them all.
///
/// @throws InputError  where a folder holds no runs or those of other input files, and where two have
///                     different rows of one run
[[nodiscard]] std::map<int, std::vector<MonteCarloRow>> merged_runs(
    std::span<const std::filesystem::path> folders, const MonteCarlo& plan);

/// Summaries as tables for people.
///
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string in_words(std::span<const MonteCarloSummary> summaries, std::size_t screen = 0);

/// Summaries as JSON, the content of summary.json. It holds no times, so that the same runs give the same
/// file.
///
/// @param run  see run_id(); empty: none is written
[[nodiscard]] std::string to_json(std::span<const MonteCarloSummary> summaries, const std::string& run = {});

/// Summaries as one HTML page to look at, the content of report.html of rivid study; docs/statistics.md
/// says what it shows. Like html_report() of an identification it loads nothing and follows the browser's
/// choice of light or dark. Tables are there without scripts too. The same runs give the same page.
///
/// @param rows  in any order
[[nodiscard]] std::string html_report(const MonteCarlo& plan, std::span<const MonteCarloSummary> summaries,
                                      std::span<const MonteCarloRow> rows, const Provenance& provenance);

}  // namespace rivid
