#include "experiment/changed_text.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <utility>

#include "data/log_columns.hpp"
#include "experiment/toml_reader.hpp"
#include "joined.hpp"

namespace rivid::detail {

namespace {

using Path = std::vector<std::string>;

std::string bare_or_quoted(const std::string& key) {
  const bool bare =
      std::ranges::all_of(key, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
  return bare && !key.empty() ? key : "\"" + key + "\"";
}

std::string dotted(const Path& path) { return joined(path, ".", bare_or_quoted); }

class TomlText {
 public:
  TomlText(std::string text, std::string source) : text_(std::move(text)), source_(std::move(source)) {
    read();
  }

  [[nodiscard]] const toml::node* find(const Path& path) const {
    const toml::node* at = &table_;
    for (const std::string& key : path) {
      const toml::table* const within = at == nullptr ? nullptr : at->as_table();
      at = within == nullptr ? nullptr : within->get(key);
    }
    return at;
  }

  [[nodiscard]] std::string text_of(const toml::node& node) const {
    const auto [begin, end] = place_of(node);
    return text_.substr(begin, end - begin);
  }

  // In the place of what the key has, within its table, behind the header of its table, or in a table at the
  // end.
  void set(const Path& section, const std::string& key, const std::string& value) {
    Path whole = section;
    whole.push_back(key);
    const std::string line = key + " = " + value;
    const toml::node* const table = find(section);
    if (const toml::node* const there = find(whole)) {
      const auto [begin, end] = place_of(*there);
      text_.replace(begin, end - begin, value);
    } else if (table != nullptr && text_[place_of(*table).first] == '{') {
      text_.insert(place_of(*table).first + 1, " " + line + (table->as_table()->empty() ? " " : ","));
    } else if (table != nullptr && is_headed(*table, section)) {
      const std::size_t end = std::min(text_.find('\n', place_of(*table).first), text_.size());
      text_.insert(end, "\n" + line);
    } else {
      text_ += "\n[" + dotted(section) + "]\n" + line + "\n";
    }
    say("[" + dotted(section) + "]", line);
  }

  // One more of a list of tables.
  void add_table(const std::string& name, const std::vector<std::string>& lines) {
    text_ += "\n[[" + name + "]]\n";
    for (const std::string& line : lines) {
      text_ += line + "\n";
    }
    for (const std::string& line : lines) {
      say("[[" + name + "]]", line);
    }
  }

  [[nodiscard]] ChangedText result() && {
    ChangedText out{std::move(text_), {}};
    for (const auto& [header, lines] : said_) {
      out.lines.push_back(header);
      out.lines.insert(out.lines.end(), lines.begin(), lines.end());
    }
    return out;
  }

 private:
  void read() {
    table_ = parsed_toml_text(text_, source_);
    starts_ = {0};
    for (std::size_t at = text_.find('\n'); at != std::string::npos; at = text_.find('\n', at + 1)) {
      starts_.push_back(at + 1);
    }
  }

  // toml++ counts lines and, in a line, characters.
  [[nodiscard]] std::size_t place_of(const toml::source_position& position) const {
    std::size_t at = starts_.at(position.line - 1);
    const auto goes_on = [&] {
      return at < text_.size() && (static_cast<unsigned char>(text_[at]) & 0xC0U) == 0x80U;
    };
    for (toml::source_index column = 1; column < position.column && at < text_.size(); ++column) {
      for (++at; goes_on(); ++at) {
      }
    }
    return at;
  }
  [[nodiscard]] std::pair<std::size_t, std::size_t> place_of(const toml::node& node) const {
    return {place_of(node.source().begin), place_of(node.source().end)};
  }

  // A table that only others name has the place of the first of these.
  [[nodiscard]] bool is_headed(const toml::node& table, const Path& section) const {
    std::string header = text_of(table);
    std::erase_if(header, [](char c) { return c == ' ' || c == '\t'; });
    return header == "[" + dotted(section) + "]";
  }

  void say(const std::string& header, const std::string& line) {
    auto at = std::ranges::find(said_, header, &std::pair<std::string, Path>::first);
    if (at == said_.end()) {
      said_.emplace_back(header, Path());
      at = std::prev(said_.end());
    }
    at->second.push_back(line);
    try {
      read();
    } catch (const InputError&) {
      throw InputError(source_ + ": leaves no place for " + line + " in " + header + "; write it there");
    }
  }

  std::string text_;
  std::string source_;
  toml::table table_;
  std::vector<std::size_t> starts_;  // of the lines
  std::vector<std::pair<std::string, Path>> said_;
};

std::string value_text(const Change& change) {
  if (change.numbers.empty()) {
    return change.word == "true" || change.word == "false" ? change.word : "\"" + change.word + "\"";
  }
  const std::string out = joined(change.numbers, ", ", [](double value) { return number(value); });
  return change.numbers.size() == 1 ? out : "[" + out + "]";
}

// What becomes of the column of a joint.
struct ColumnChange {
  std::size_t from = 0;  // joint whose column it takes
  double scale = 1.0;
  double offset = 0.0;
};

// A column of a list, or the one of that usual name, with another scale and zero.
std::string column_text(const TomlText& text, const toml::node* node, const std::string& usual,
                        const Column& column, const ColumnChange& change) {
  const auto plain = [&] { return node == nullptr ? "\"" + usual + "\"" : text.text_of(*node); };
  if (change.scale == 1.0 && change.offset == 0.0) {
    return plain();
  }
  const toml::table* const options = node == nullptr ? nullptr : node->as_table();
  const auto factor = [&](const char* key) {
    return options == nullptr ? 1.0 : (*options)[key].value_or(1.0);
  };
  const double scale = change.scale * factor("scale") * factor("sign");
  const double offset = change.scale * column.offset + change.offset;
  const toml::node* const unit = options == nullptr ? nullptr : options->get("unit");
  return "{ column = " + (options == nullptr ? plain() : text.text_of(*options->get("column"))) +
         (unit == nullptr ? "" : ", unit = " + text.text_of(*unit)) + (scale < 0.0 ? ", sign = -1" : "") +
         (std::abs(scale) == 1.0 ? "" : ", scale = " + number(std::abs(scale))) +
         (offset == 0.0 ? "" : ", offset = " + number(offset)) + " }";
}

void set_columns(TomlText& text, const Experiment& experiment, const LogColumns& quantity,
                 const std::vector<ColumnChange>& changes) {
  const Path key = {"log", std::string(quantity.key)};
  const toml::node* const node = text.find(key);
  const toml::array* const list = node == nullptr ? nullptr : node->as_array();
  const std::vector<Column>& listed = experiment.log.columns.*quantity.listed;
  const auto changed = [&](const ColumnChange& change) {
    const std::string usual = std::string(quantity.prefix) + std::to_string(change.from + 1);
    const toml::node* const item = list == nullptr ? node : list->get(change.from);
    return column_text(text, item, usual, listed.empty() ? Column{usual} : listed.at(change.from), change);
  };
  text.set({"log"}, key.back(), "[" + joined(changes, ", ", changed) + "]");
}

// Columns by joint. What was measured of positions goes with them; whoever lists torques lists all.
void change_columns(TomlText& text, const Experiment& experiment, const Log& log, bool torques,
                    std::span<const Change> changes) {
  const std::string key = torques ? "log.torque." : "log.position.";
  std::vector<ColumnChange> columns(experiment.robot.joints.size());
  const auto joint = [&](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(experiment.robot.joints, name, &Joint::name) -
                                    experiment.robot.joints.begin());
  };
  for (std::size_t j = 0; j < columns.size(); ++j) {
    columns[j].from = j;
  }
  bool any = false;
  for (const Change& change : changes) {
    if (!change.key.starts_with(key)) {
      continue;
    }
    any = true;
    ColumnChange& of_joint = columns.at(joint(change.joint));
    if (change.key.ends_with(".column")) {
      of_joint.from = joint(change.word);
    } else {
      (change.key.ends_with(".scale") ? of_joint.scale : of_joint.offset) = change.numbers.front();
    }
  }
  if (!any) {
    return;
  }
  std::vector<ColumnChange> unchanged(columns.size());
  std::vector<ColumnChange> rates = columns;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    unchanged[j].from = j;
    rates[j].offset = 0.0;
  }
  for (const LogColumns& quantity : log_columns) {
    const bool of_torques = quantity.member == &Log::tau || quantity.member == &Log::v_tau;
    const bool used =
        (log.*quantity.member).size() > 0 && (quantity.member != &Log::v_tau || log.tau.size() == 0);
    const bool listed = !(experiment.log.columns.*quantity.listed).empty();
    if (used && of_torques == torques) {
      set_columns(text, experiment, quantity, quantity.smooth || torques ? columns : rates);
    } else if (used && torques && !listed && experiment.log.columns.default_names) {
      set_columns(text, experiment, quantity, unchanged);
    }
  }
}

}  // namespace

ChangedText changed_text(std::string text, const Experiment& experiment, const Log& log,
                         std::span<const Change> changes) {
  TomlText out(std::move(text), experiment.file.string());
  change_columns(out, experiment, log, false, changes);
  change_columns(out, experiment, log, true, changes);
  for (const Change& change : changes) {
    const std::size_t dot = change.key.find('.');
    const std::string section = change.key.substr(0, dot);
    const std::string key = change.key.substr(dot + 1);
    if (change.key == "robot.coupling") {
      out.add_table("robot.coupling",
                    {"motor = \"" + change.joint + "\"", "joints = [\"" + change.word + "\"]",
                     "ratios = [" + number(change.numbers.front()) + "]"});
    } else if (change.key == "log.torque_lag") {
      out.set({section}, key, number(experiment.log.torque_lag + change.numbers.front()));
    } else if (!change.joint.empty() && key.find('.') == std::string::npos) {
      out.set({section, "joints", change.joint}, key, value_text(change));
    } else if (change.joint.empty()) {
      out.set({section}, key, value_text(change));
    }
  }
  return std::move(out).result();
}

}  // namespace rivid::detail
