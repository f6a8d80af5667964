#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "paper_study/svg_plot.hpp"

namespace rivid::study {

/// Where the parts of the study put what they find: text on the screen, figures into a folder, and whether the claims
/// hold that they check.
class Report {
 public:
  explicit Report(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void print(const std::string& text);

  /// @param columns  panels in a row
  /// @param width    of a panel [px]
  void figure(const std::string& file, const std::string& title, const std::vector<svg::Panel>& panels,
              int columns, double width, double height);

  /// A claim of the paper, or of docs/paper.md, that must hold in every log.
  void expect(bool holds, const std::string& claim);

  /// Names the figures, and writes what was printed beside them.
  void finish();
  [[nodiscard]] bool all_hold() const { return broken_.empty(); }

 private:
  std::filesystem::path folder_;
  std::string text_;
  std::vector<std::string> files_;
  std::vector<std::string> broken_;
};

/// Text, filled up with blanks to a width on the screen.
[[nodiscard]] std::string cell(const std::string& text, std::size_t width);

/// Rows of cells of equal widths, indented by two.
///
/// @param widths  of all columns but the last
[[nodiscard]] std::string table(const std::vector<std::size_t>& widths,
                                const std::vector<std::vector<std::string>>& rows);

/// "2.19 %" of 0.0219.
[[nodiscard]] std::string percent(double part, int digits = 3);

}  // namespace rivid::study
