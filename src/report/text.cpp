#include "rivid/report/text.hpp"

#include <algorithm>
#include <sstream>

#include "report/document.hpp"
#include "report/documents.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

constexpr std::size_t gap = 2;
constexpr std::size_t line_width = 110;

// Words from the column `indent` on, in lines that end before the screen does, but never too narrow.
std::string folded(const std::string& text, std::size_t indent) {
  constexpr std::size_t narrowest = 30;
  const std::size_t room = std::max(narrowest, line_width - std::min(line_width, indent));
  std::string out;
  std::size_t used = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::size_t width = display_width(word);
    if (used > 0 && used + 1 + width > room) {
      out += '\n' + std::string(indent, ' ');
      used = 0;
    }
    out += (used > 0 ? " " : "") + word;
    used += width + (used > 0 ? 1 : 0);
  }
  return out;
}

using Cells = std::vector<std::string>;

// Lines of cells, each column as wide as its widest cell; the last column is folded where it holds text.
std::string aligned(const std::vector<Cells>& lines, const std::vector<bool>& numbers) {
  std::vector<std::size_t> widths(numbers.size());
  std::size_t before_last = gap;
  for (std::size_t c = 0; c < widths.size(); ++c) {
    for (const Cells& cells : lines) {
      widths[c] = std::max(widths[c], display_width(cells[c]));
    }
    before_last += c + 1 < widths.size() ? widths[c] + gap : 0;
  }
  std::string out;
  for (const Cells& cells : lines) {
    std::string line;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::string padding(widths[c] - display_width(cells[c]), ' ');
      const bool last = c + 1 == cells.size();
      line += std::string(gap, ' ') + (numbers[c] ? padding + cells[c]
                                       : last     ? folded(cells[c], before_last)
                                                  : cells[c] + padding);
    }
    out += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return out;
}

class TextRenderer {
 public:
  std::string operator()(const Sentence& sentence) const {
    return std::string(gap, ' ') + folded(sentence.text, gap) + '\n';
  }

  std::string operator()(const Heading& heading) const { return '\n' + heading.text + '\n'; }

  std::string operator()(const Table& table) const {
    std::vector<std::size_t> columns;
    std::vector<bool> numbers;
    std::vector<Cells> lines(1);
    bool titles = false;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const Column& column = table.columns[c];
      if (is_on(Shown::screen, column.shown) && !column.format.drawn()) {
        columns.push_back(c);
        numbers.push_back(column.format.number());
        lines.front().push_back(column.heading);
        titles = titles || !column.heading.empty();
      }
    }
    for (const Row& row : table.rows) {
      Cells& cells = lines.emplace_back();
      for (const std::size_t c : columns) {
        cells.push_back(shown(table.columns[c], row.cells[c]));
      }
      if (!sign(row.mark).empty()) {
        cells.front().append(" ").append(sign(row.mark));
      }
    }
    if (!titles) {
      lines.erase(lines.begin());
    }
    return aligned(lines, numbers);
  }

  std::string operator()(const List& list) const {
    std::string out;
    for (const Item& item : list.items) {
      const std::string before = sign(item.mark).empty() ? "" : std::string(sign(item.mark)) + " ";
      out += (*this)(Sentence{before + item.name + item.text});
    }
    return out;
  }

  std::string operator()(const FindingList& list) const {
    std::string out;
    for (const Finding& finding : list.findings) {
      out += (*this)(Sentence{with_cure(finding)});
    }
    return out;
  }

  std::string operator()(const KeyFigures& list) const {
    Table table{{{"", format::name}, {"", format::text}}};
    for (const auto& [value, what] : list.figures) {
      table.rows.push_back({{what, value}});
    }
    return (*this)(table);
  }

  std::string operator()(const Legend& /*unused*/) const { return {}; }
  std::string operator()(const Plots& /*unused*/) const { return {}; }

  [[nodiscard]] std::string of(const std::vector<Block>& blocks) const {
    std::string out;
    for (const Block& block : blocks) {
      out += is_on(Shown::screen, block.shown) ? std::visit(*this, block.content) : std::string();
    }
    return out;
  }
};

}  // namespace

std::string text_of(const Document& document) {
  const TextRenderer text;
  std::string out = document.line + '\n' + text.of(document.opening);
  bool first = true;
  for (const Section& section : document.sections) {
    if (is_on(Shown::screen, section.shown)) {
      // What comes first needs no title under the verdict.
      out += '\n' + (first ? std::string() : section.heading + '\n') + text.of(section.blocks);
      first = false;
    }
  }
  return out;
}

}  // namespace detail

std::ostream& operator<<(std::ostream& out, const Identification& result) {
  return out << detail::text_of(detail::document_of(result));
}

std::string summary(const Robot& robot, const SimulationRecord& record) {
  return detail::text_of(detail::document_of(robot, record));
}

std::ostream& operator<<(std::ostream& out, std::span<const MonteCarloSummary> summaries) {
  for (const MonteCarloSummary& summary : summaries) {
    out << detail::text_of(detail::document_of(summary)) << '\n';
  }
  return out;
}

}  // namespace rivid
