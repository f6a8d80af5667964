#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "paper_study/scara.hpp"
#include "report/document.hpp"

namespace rivid::study {

/// Where the parts of the study put their findings: text on the screen, charts on a page, and whether the claims
/// that they check hold.
class Report {
 public:
  explicit Report(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void print(const std::string& text);
  /// Charts beside each other, or below each other where they are wide.
  void figure(const std::string& heading, std::vector<detail::Chart> charts);

  /// A claim of the paper, or of rivid, that must hold in every log.
  void expect(bool holds, const std::string& claim);

  /// Writes the page of the charts, and beside it what was printed.
  void finish();
  [[nodiscard]] bool all_hold() const { return broken_.empty(); }

 private:
  std::filesystem::path folder_;
  std::string text_;
  std::vector<detail::Section> figures_;
  std::size_t charts_ = 0;
  std::vector<std::string> broken_;
};

/// A line of a chart.
///
/// @param color  number of the colour, 0 to 7
[[nodiscard]] inline detail::Series curve(std::string label, std::size_t color, Vector x = {},
                                          Vector y = {}) {
  return {.name = std::move(label),
          .style = "series-" + std::to_string(color),
          .x = std::move(x),
          .y = std::move(y)};
}

/// Rows of cells, indented by two; each column as wide as its widest cell.
using Table = std::vector<std::vector<std::string>>;
[[nodiscard]] std::string aligned(const Table& rows);
/// "2.19 %" of 0.0219.
[[nodiscard]] std::string percent(double part);

/// Identifications of logs that differ in their noise.
using Runs = std::vector<Identification>;
/// Of the seeds 1 … `seeds`.
[[nodiscard]] Runs over(std::uint64_t seeds, const std::function<Identification(std::uint64_t)>& identified);
[[nodiscard]] Runs only_identified(const Runs& runs);
/// "19 of 20 identified".
[[nodiscard]] std::string how_many(const Runs& all);

[[nodiscard]] bool identified(const Identification& found);
/// Estimate in the units of the paper, and its standard deviation.
[[nodiscard]] double value(const Identification& found, std::size_t i);
[[nodiscard]] double sigma(const Identification& found, std::size_t i);
/// |χ̂_i / χ_i − 1|.
[[nodiscard]] double off(const Identification& found, std::size_t i);
/// Of the last iteration, ‖Y − Vχ‖ / ‖Y‖.
[[nodiscard]] double error_of_instruments(const Identification& found);

[[nodiscard]] double mean(const Runs& runs, const std::function<double(const Identification&)>& of);
/// Mean of the estimates over the truth; not a number where there are no runs.
[[nodiscard]] double mean_ratio(const Runs& runs, std::size_t i);
/// Standard deviation of the estimates from run to run.
[[nodiscard]] double scatter(const Runs& runs, std::size_t i);
/// That something holds in every run.
[[nodiscard]] bool all(const Runs& runs, const std::function<bool(const Identification&)>& holds);

/// Runs that one procedure made of the logs.
struct Procedure {
  std::string name;
  const Runs& runs;
};
/// Estimates beside a table of the paper, as means over the runs that were identified.
[[nodiscard]] std::string beside(const std::string& title, const PaperTable& paper,
                                 const std::vector<Procedure>& procedures);

// The parts of the study, each over logs of the seeds 1 … `seeds`.

/// Where the tables of the paper disagree with themselves or with each other.
void misprints(Report& report);
/// Sections 4.2 to 4.5: tables 1 to 7, figures 7 to 13, essential parameters, and the limit of the bandwidth.
void identification(const Scara& scara, std::uint64_t seeds, Report& report);
/// Section 4.3: W from the reference trajectory in place of the measured one.
void reference_regressor(const Scara& scara, std::uint64_t seeds, Report& report);
/// Section 4.4: LMX2 by least squares on raw data, over noise and trajectories.
void raw_least_squares(const Scara& scara, std::uint64_t seeds, Report& report);
/// (47): a controller that was designed with wrong inertias, and a wrong drive gain.
void wrong_design(const Scara& scara, std::uint64_t seeds, Report& report);
/// Section 5: estimates over the cut-off of the filter, by least squares and by instrumental variables.
void cutoff(const Scara& scara, std::uint64_t seeds, Report& report);
/// (24–33): the error over the length of the log.
void length_of_the_log(const Scara& scara, std::uint64_t seeds, Report& report);
/// (21): the direct dynamic model, driven by the torques of a trajectory that was not used.
void replay(const Scara& scara, std::uint64_t seeds, Report& report);

}  // namespace rivid::study
