#include "rivid/report/text.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "report/document.hpp"
#include "report/documents.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

constexpr std::size_t gap = 2;         // blanks between columns
constexpr std::size_t narrowest = 30;  // shorter lines are none

using Cells = std::vector<std::string>;

// Lines of cells, each column as wide as its widest cell.
class TextTable {
 public:
  // numbers  whether a column is one
  TextTable(std::vector<Cells> lines, std::vector<bool> numbers)
      : lines_(std::move(lines)), numbers_(std::move(numbers)), widths_(numbers_.size()) {
    for (std::size_t c = 0; c < widths_.size(); ++c) {
      for (const Cells& cells : lines_) {
        widths_[c] = std::max(widths_[c], display_width(cells[c]));
      }
    }
  }

  // The last column is folded where it holds text. What is wider than the screen goes on below, behind the
  // first column again.
  [[nodiscard]] std::string text(std::size_t screen) const {
    std::string out;
    std::size_t next = 0;
    while (next < widths_.size()) {
      std::vector<std::size_t> columns;
      if (next > 0) {
        columns.push_back(0);
        out += '\n';
      }
      std::size_t used = next > 0 ? gap + widths_[0] : 0;
      const std::size_t first = next;
      while (next < widths_.size() &&
             (next == first || screen == 0 || used + gap + least_width(next) <= screen)) {
        used += gap + widths_[next];
        columns.push_back(next++);
      }
      out += part(columns, screen == 0 ? longest_line : screen);
    }
    return out;
  }

 private:
  [[nodiscard]] bool folds(std::size_t column) const {
    return column + 1 == widths_.size() && !numbers_[column];
  }
  [[nodiscard]] std::size_t least_width(std::size_t column) const {
    return folds(column) ? std::min(widths_[column], narrowest) : widths_[column];
  }

  [[nodiscard]] std::string part(const std::vector<std::size_t>& columns, std::size_t line_width) const {
    std::string out;
    for (const Cells& cells : lines_) {
      std::string line;
      std::size_t used = 0;
      for (const std::size_t c : columns) {
        const std::string padding(widths_[c] - display_width(cells[c]), ' ');
        line += std::string(gap, ' ') + (numbers_[c] ? padding + cells[c]
                                         : folds(c)  ? folded(cells[c], used + gap, line_width)
                                                     : cells[c] + padding);
        used += gap + widths_[c];
      }
      out += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
    }
    return out;
  }

  std::vector<Cells> lines_;
  std::vector<bool> numbers_;
  std::vector<std::size_t> widths_;
};

class TextRenderer {
 public:
  explicit TextRenderer(std::size_t screen)
      : screen_(screen), line_width_(screen == 0 ? longest_line : std::min(screen, longest_line)) {}

  std::string operator()(const Sentence& sentence) const {
    return std::string(gap, ' ') + folded(sentence.text, gap, line_width_) + '\n';
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
    return TextTable(std::move(lines), std::move(numbers)).text(screen_);
  }

  std::string operator()(const List& list) const {
    std::string out;
    for (const Item& item : list.items) {
      const std::string before = sign(item.mark).empty() ? "" : std::string(sign(item.mark)) + " ";
      out += (*this)(Sentence{before + item.name + item.text});
    }
    return out;
  }

  // The gravest ones with their cures, the codes of all others.
  std::string operator()(const FindingList& list) const {
    std::string out;
    std::vector<std::string> others;
    for (std::size_t k = 0; k < list.findings.size(); ++k) {
      if (k < FindingList::shown) {
        out += (*this)(Sentence{with_cure(list.findings[k])});
      } else {
        others.push_back(list.findings[k].code);
      }
    }
    if (!others.empty()) {
      out += (*this)(Sentence{counted(std::ssize(others), "more finding") + ": " + listed(others)});
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

 private:
  std::size_t screen_;
  std::size_t line_width_;
};

// What became of a simulation, for a screen.
Document simulation_document(const Robot& robot, const SimulationRecord& record) {
  const Simulation& simulation = record.simulation;
  const SimulationEffort& effort = simulation.effort;
  Document out;
  out.line = "Simulation: " + std::string(name(simulation.outcome)) + ", " +
             counted(record.log.samples(), "sample") + " at " + number(record.log.f_m) + " Hz";
  const auto say = [&](std::string sentence) { out.opening.push_back({Sentence{std::move(sentence)}}); };
  if (!simulation.reason.empty()) {
    say(simulation.reason);
  }
  for (Index j = 0; j < simulation.max_tracking_error.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    say(joint.name + ": largest tracking error " + number(simulation.max_tracking_error[j], 4) + " " +
        position_unit(joint));
  }
  for (std::size_t e = 0; e < simulation.element_names.size(); ++e) {
    say("friction of " + simulation.element_names[e] + ": " +
        counted(simulation.element_changes[e], "mode change"));
  }
  say(counted(effort.steps, "step") + ", " + counted(effort.right_hand_sides, "right-hand side") + ", " +
      number(effort.seconds, 3) + " s");
  return out;
}

}  // namespace

std::string text_of(const Document& document, std::size_t screen) {
  const TextRenderer text(screen);
  std::string out = document.line + '\n' + text.of(document.opening);
  bool first = true;
  for (const Section& section : document.sections) {
    if (is_on(Shown::screen, section.shown)) {
      // What comes first needs no title under the verdict.
      out += '\n' + (first || section.heading.empty() ? std::string() : section.heading + '\n') +
             text.of(section.blocks);
      first = false;
    }
  }
  return out;
}

}  // namespace detail

namespace {

std::ptrdiff_t count(std::span<const Finding> findings, Severity wanted) {
  return std::ranges::count(findings, wanted, severity);
}

std::string counts(std::span<const Finding> findings) {
  return counted(count(findings, Severity::error), "error") + ", " +
         counted(count(findings, Severity::warning), "warning") + ", " +
         counted(count(findings, Severity::note), "note");
}

}  // namespace

std::string with_cure(const Finding& finding) {
  const std::string_view known = detail::advice(finding);
  return in_words(finding) + (known.empty() ? "." : ". " + std::string(known));
}

std::string in_words(std::span<const Finding> findings, std::size_t screen) {
  std::string out;
  const std::vector<Finding> told = told_once(findings);
  for (const Finding& f : told) {
    out += folded(with_cure(f), 2, screen == 0 ? longest_line : screen) + '\n';
  }
  return out + counts(told) + '\n';
}

std::string in_words(const HintTrial& trial) {
  const auto percent = [](double part) {
    return std::isnan(part) ? std::string("unknown") : number(100.0 * part, 4) + " %";
  };
  const auto row = [&](const char* when, const HintOutcome& outcome) {
    return std::string(when) + "fit " + percent(outcome.fit) + ", held out " + percent(outcome.held_out) +
           ", " + std::string(name(outcome.status)) + '\n';
  };
  std::string out = in_words(trial.finding) + "\n\n" + row("before  ", trial.before) +
                    row("after   ", trial.after) +
                    (trial.helps() ? "\nIt helps. In the experiment file:\n"
                                   : "\nIt does not help: leave the experiment as it is. Tried was:\n");
  for (const std::string& line : trial.lines) {
    out += (line.starts_with('[') ? "\n" : "") + line + '\n';
  }
  return out;
}

std::string folded(const std::string& text, std::size_t indent, std::size_t line_width) {
  const std::size_t room = std::max(detail::narrowest, line_width - std::min(line_width, indent));
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

std::string in_one_line(const DiagnosticCode& code) {
  constexpr std::size_t width = 20;  // of the column of codes; a choice of layout
  std::string out(code.code);
  out.resize(std::max(out.size() + 2, width), ' ');
  return out + std::string(code.meaning) + '\n';
}

std::string explained(const DiagnosticCode& code) {
  return std::string(code.code) + " (" + std::string(name(code.severity)) + ")\n  " +
         std::string(code.meaning) + "\n  Cause: " + std::string(code.cause) +
         "\n  Cure:  " + std::string(code.cure) + '\n';
}

std::string in_words(const Identification& result, std::size_t screen) {
  return detail::text_of(detail::document_of(result), screen);
}

std::string first_screen(const Robot& robot, const Identification& result, std::size_t screen) {
  return detail::text_of(detail::first_screen_of(robot, result), screen == 0 ? longest_line : screen);
}

std::ostream& operator<<(std::ostream& out, const Identification& result) { return out << in_words(result); }

std::string summary(const Robot& robot, const SimulationRecord& record, std::size_t screen) {
  return detail::text_of(detail::simulation_document(robot, record), screen);
}

std::string in_words(std::span<const MonteCarloSummary> summaries, std::size_t screen) {
  std::string out;
  for (const MonteCarloSummary& summary : summaries) {
    out += detail::text_of(detail::document_of(summary), screen) + '\n';
  }
  return out;
}

}  // namespace rivid
