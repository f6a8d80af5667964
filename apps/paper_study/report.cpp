#include "paper_study/report.hpp"

#include <algorithm>
#include <iostream>

#include "rivid/report/file.hpp"
#include "rivid/text.hpp"

namespace rivid::study {

void Report::print(const std::string& text) {
  std::cout << text << std::flush;
  text_ += text;
}

void Report::figure(const std::string& file, const std::string& title, const std::vector<svg::Panel>& panels,
                    int columns, double width, double height) {
  write_file(folder_ / file, svg::figure(title, panels, columns, width, height));
  files_.push_back(file);
}

void Report::expect(bool holds, const std::string& claim) {
  if (!holds) {
    broken_.push_back(claim);
  }
}

void Report::finish() {
  for (const std::string& claim : broken_) {
    print("\ndoes not hold: " + claim + '\n');
  }
  write_file(folder_ / "tables.txt", text_);
  std::cout << "\nwrote to " << folder_.string() << ": tables.txt";
  for (const std::string& file : files_) {
    std::cout << ", " << file;
  }
  std::cout << '\n';
}

std::string cell(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, display_width(text)), ' ');
}

std::string table(const std::vector<std::size_t>& widths, const std::vector<std::vector<std::string>>& rows) {
  std::string out;
  for (const std::vector<std::string>& row : rows) {
    std::string line = "  ";
    for (std::size_t c = 0; c < row.size(); ++c) {
      line += c < widths.size() ? cell(row[c], widths[c]) : row[c];
    }
    out += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return out;
}

std::string percent(double part, int digits) { return number(100.0 * part, digits) + " %"; }

}  // namespace rivid::study
