#define TOML_IMPLEMENTATION
#include "experiment/toml_reader.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "experiment/text_file.hpp"

namespace rivid::detail {

namespace {

constexpr std::string_view flag = "--set ";

bool is_word(std::string_view text) {
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text.front())) != 0 &&
         std::ranges::all_of(text, [](unsigned char c) {
           return std::isalnum(c) != 0 ||
                  std::string_view("_-./").find(static_cast<char>(c)) != std::string_view::npos;
         });
}

// What to do about a line like `cutoff_hz = off`, whose word wants quotes; nothing for other lines.
std::string quotes_wanted(std::string_view text, std::size_t line) {
  for (; line > 1 && !text.empty(); --line) {
    text.remove_prefix(std::min(text.find('\n') + 1, text.size()));
  }
  text = text.substr(0, std::min(text.find('\n'), text.find('#')));
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return {};
  }
  const auto trimmed = [](std::string_view part) {
    constexpr std::string_view blanks = " \t\r";
    const std::size_t first = part.find_first_not_of(blanks);
    return first == std::string_view::npos ? std::string_view()
                                           : part.substr(first, part.find_last_not_of(blanks) - first + 1);
  };
  const std::string_view value = trimmed(text.substr(equals + 1));
  return is_word(value) ? "; a word needs quotes: " + std::string(trimmed(text.substr(0, equals))) + " = \"" +
                              std::string(value) + "\""
                        : "";
}

// A setting of the command line as a table, whose places are the setting itself.
toml::table parsed_setting(const std::string& setting) {
  const std::string place = std::string(flag) + setting;
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || setting.find('\n') != std::string::npos) {
    throw InputError(place + ": is no setting; a key and its value are required: signal.decimation=5");
  }
  const std::string key = setting.substr(0, equals);
  const std::string value = setting.substr(equals + 1);
  try {
    const bool quoted =
        is_word(value) && value != "true" && value != "false" && value != "inf" && value != "nan";
    return toml::parse(key + " = " + (quoted ? "\"" + value + "\"" : value), place);
  } catch (const toml::parse_error& e) {
    throw InputError(place + ": " + std::string(e.description()));
  }
}

void lay_over(toml::table& table, toml::table&& patch) {
  for (auto&& [key, node] : patch) {
    toml::node* const there = table.get(key);
    if (there != nullptr && there->is_table() && node.is_table()) {
      lay_over(*there->as_table(), std::move(*node.as_table()));
    } else {
      // An assigned key would keep the place of the old one.
      table.erase(key);
      node.visit([&](auto& value) { table.insert(key, std::move(value)); });
    }
  }
}

bool is_set(const toml::source_region& at) { return at.path && at.path->starts_with(flag); }

void collect_origins(const toml::table& table, const std::string& path,
                     std::map<std::string, std::string>& out) {
  for (const auto& [key, node] : table) {
    const std::string name = (path.empty() ? "" : path + ".") + std::string(key.str());
    if (const toml::table* const inner = node.as_table()) {
      collect_origins(*inner, name, out);
    }
    out[name] = is_set(key.source()) ? "--set" : "file";
  }
}

}  // namespace

toml::table parsed_toml(const std::filesystem::path& path, std::string_view what,
                        std::span<const std::string> settings) {
  const std::string text = file_text(path, what);
  const auto parsed = [&] {
    try {
      return toml::parse(text, path.string());
    } catch (const toml::parse_error& e) {
      const auto& at = e.source().begin;
      throw InputError(path.string() + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) +
                       ": " + std::string(e.description()) + quotes_wanted(text, at.line));
    }
  };
  toml::table out = parsed();
  for (const std::string& setting : settings) {
    lay_over(out, parsed_setting(setting));
  }
  return out;
}

toml::table parsed_toml_text(std::string_view text, const std::string& source) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& e) {
    throw InputError(source + ": " + std::string(e.description()));
  }
}

std::map<std::string, std::string> origins(const toml::table& table) {
  std::map<std::string, std::string> out;
  collect_origins(table, "", out);
  return out;
}

std::size_t TomlReader::word(const toml::node& node, std::string_view key,
                             std::span<const std::string_view> words) const {
  const auto text = as<std::string>(node, key);
  const auto at = std::ranges::find(words, text);
  if (at == words.end()) {
    const std::vector<std::string> names(words.begin(), words.end());
    fail(node, key, "is \"" + text + "\", must be one of " + quoted_list(names) + did_you_mean(text, names));
  }
  return static_cast<std::size_t>(at - words.begin());
}

std::optional<std::size_t> TomlReader::word(std::string_view key, std::span<const std::string_view> words) {
  const toml::node* const node = find(key);
  return node == nullptr ? std::nullopt : std::optional(word(*node, key, words));
}

std::vector<const toml::node*> TomlReader::items(const toml::node& node) {
  const toml::array* const list = node.as_array();
  if (list == nullptr) {
    return {&node};
  }
  std::vector<const toml::node*> out;
  for (const toml::node& item : *list) {
    out.push_back(&item);
  }
  return out;
}

std::optional<TomlReader> TomlReader::section(std::string_view key) {
  const toml::node* const node = find(key);
  return node == nullptr ? std::nullopt : std::optional(section(*node, key));
}

TomlReader TomlReader::section(const toml::node& node, std::string_view key) const {
  const toml::table* const table = node.as_table();
  if (table == nullptr) {
    fail(node, key, "must be a table");
  }
  return {*table, file_, path_.empty() ? std::string(key) : path_ + "." + std::string(key)};
}

void TomlReader::finish() const {
  const std::vector<std::string> names(known_.begin(), known_.end());
  for (const auto& [key, node] : table_) {
    if (!known_.contains(key.str())) {
      refuse_unknown(key, did_you_mean(key.str(), names));
    }
  }
}

void TomlReader::look_for_mistyped(const std::vector<std::string>& wanted) const {
  for (const auto& [key, node] : table_) {
    const std::string guess = did_you_mean(key.str(), wanted);
    if (!known_.contains(key.str()) && !guess.empty()) {
      refuse_unknown(key, guess);
    }
  }
}

void TomlReader::fail(const toml::node& node, std::string_view key, const std::string& what) const {
  throw InputError(place(node.source()) + (path_.empty() ? "" : "[" + path_ + "] ") + std::string(key) + " " +
                   what);
}

void TomlReader::fail(const std::string& what) const {
  const toml::node* const culprit = table_.get(what.substr(0, what.find_first_of(" :")));
  throw InputError(place(culprit != nullptr ? culprit->source() : table_.source()) + "[" + path_ + "] " +
                   what);
}

void TomlReader::require_one_each(const toml::node& node, std::string_view key, std::ptrdiff_t entries,
                                  std::ptrdiff_t joints) const {
  if (entries != joints) {
    fail(node, key,
         "has " + counted(entries, "entry") + ", must have one for each of the " + counted(joints, "joint") +
             ", or be a single value for all");
  }
}

void TomlReader::take(const toml::node& node, const Wanted& wanted, bool& out) const {
  if (!wanted.words[0].empty()) {
    out = word(node, wanted.key, wanted.words) == 1;
    return;
  }
  const auto* const value = node.as_boolean();
  if (value == nullptr) {
    fail(node, wanted.key, "must be true or false");
  }
  out = value->get();
}

void TomlReader::take(const toml::node& node, const Wanted& wanted, double& out) const {
  const std::optional<double> value = node.value<double>();
  if (!node.is_number() || !value) {
    fail(node, wanted.key, "must be " + std::string(wanted.must_be.empty() ? "a number" : wanted.must_be));
  }
  if (!std::isfinite(*value)) {
    fail(node, wanted.key, "must be finite");
  }
  require_within(node, wanted, *value);
  out = *value;
}

void TomlReader::take(const toml::node& node, const Wanted& wanted, std::int64_t& out) const {
  const auto* const value = node.as_integer();
  if (value == nullptr) {
    fail(node, wanted.key,
         wanted.must_be.empty() ? "must be a whole number" : "must be " + std::string(wanted.must_be));
  }
  require_within(node, wanted, static_cast<double>(value->get()));
  out = value->get();
}

void TomlReader::take(const toml::node& node, const Wanted& wanted, int& out) const {
  const auto value = as<std::int64_t>(node, {.key = wanted.key, .must_be = wanted.must_be});
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
    fail(node, wanted.key, "is " + std::to_string(value) + ", that is out of range");
  }
  require_within(node, wanted, static_cast<double>(value));
  out = static_cast<int>(value);
}

void TomlReader::take(const toml::node& node, const Wanted& wanted, std::uint64_t& out) const {
  out = static_cast<std::uint64_t>(as<std::int64_t>(node, wanted));
}

void TomlReader::take(const toml::node& node, const Wanted& wanted, std::string& out) const {
  const auto* const value = node.as_string();
  if (value == nullptr) {
    fail(node, wanted.key, "must be a string");
  }
  out = value->get();
}

void TomlReader::take(const toml::node& node, const Wanted& wanted, Vector& out) const {
  const auto values = as<std::vector<double>>(node, wanted);
  if (!node.is_array()) {
    out = Vector::Constant(wanted.joints, values.front());
    return;
  }
  require_one_each(node, wanted.key, std::ssize(values), wanted.joints);
  out = Eigen::Map<const Vector>(values.data(), wanted.joints);
}

void TomlReader::require_within(const toml::node& node, const Wanted& wanted, double value) const {
  if (wanted.range.holds(value)) {
    return;
  }
  if (!wanted.must_be.empty()) {
    fail(node, wanted.key, "must be " + std::string(wanted.must_be));
  }
  const std::string fault = out_of_range(wanted.key, value, wanted.unit, wanted.range);
  fail(node, wanted.key, fault.substr(wanted.key.size() + 1));
}

std::string TomlReader::place(const toml::source_region& at) const {
  if (!at.path) {  // text of a program, whose lines nobody sees
    return file_ + ": ";
  }
  return is_set(at)
             ? *at.path + ": "
             : file_ + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column) + ": ";
}

void TomlReader::refuse_unknown(const toml::key& key, const std::string& guess) const {
  throw InputError(place(key.source()) + "unknown key \"" + std::string(key.str()) + "\"" +
                   (path_.empty() ? "" : " in [" + path_ + "]") + guess);
}

}  // namespace rivid::detail
