#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

/// One table of an experiment file. Every key that is read is remembered, and finish() refuses the others, so
/// that a mistyped key can not be passed over. Messages are "file:line:column: [table] key …".
class TomlReader {
 public:
  TomlReader(const toml::table& table, std::string file, std::string path)
      : table_(table), file_(std::move(file)), path_(std::move(path)) {}

  /// The node of a key, nothing if the file does not have it.
  const toml::node* find(std::string_view key) {
    known_.emplace(key);
    return table_.get(key);
  }

  [[nodiscard]] const toml::table& table() const { return table_; }

  std::optional<std::string> text(std::string_view key) {
    const toml::node* const node = find(key);
    return node == nullptr ? std::nullopt : std::optional(as_text(*node, key));
  }
  std::optional<double> number(std::string_view key) {
    const toml::node* const node = find(key);
    return node == nullptr ? std::nullopt : std::optional(as_number(*node, key));
  }
  std::optional<std::int64_t> integer(std::string_view key) {
    const toml::node* const node = find(key);
    return node == nullptr ? std::nullopt : std::optional(as_integer(*node, key));
  }
  std::optional<bool> boolean(std::string_view key) {
    const toml::node* const node = find(key);
    return node == nullptr ? std::nullopt : std::optional(as_boolean(*node, key));
  }

  /// A whole number that an int holds.
  std::optional<int> count(std::string_view key) {
    const toml::node* const node = find(key);
    return node == nullptr ? std::nullopt : std::optional(as_count(*node, key));
  }

  /// A list of numbers; a single number counts as a list of one.
  std::optional<std::vector<double>> numbers(std::string_view key) {
    return list<double>(key, [&](const toml::node& node) { return as_number(node, key); });
  }
  std::optional<std::vector<std::int64_t>> integers(std::string_view key) {
    return list<std::int64_t>(key, [&](const toml::node& node) { return as_integer(node, key); });
  }
  std::optional<std::vector<int>> counts(std::string_view key) {
    return list<int>(key, [&](const toml::node& node) { return as_count(node, key); });
  }
  std::optional<std::vector<std::string>> texts(std::string_view key) {
    return list<std::string>(key, [&](const toml::node& node) { return as_text(node, key); });
  }

  template <typename Value, std::size_t N>
  std::optional<Value> choice(std::string_view key,
                              const std::array<std::pair<std::string_view, Value>, N>& choices) {
    const toml::node* const node = find(key);
    return node == nullptr ? std::nullopt : std::optional(as_choice(*node, key, choices));
  }

  /// A table within this one.
  std::optional<TomlReader> section(std::string_view key) {
    const toml::node* const node = find(key);
    if (node == nullptr) {
      return std::nullopt;
    }
    return TomlReader(as_table(*node, key), file_,
                      path_.empty() ? std::string(key) : path_ + "." + std::string(key));
  }

  [[nodiscard]] const toml::table& as_table(const toml::node& node, std::string_view key) const {
    if (const toml::table* const value = node.as_table()) {
      return *value;
    }
    fail(node, key, "must be a table");
  }
  [[nodiscard]] std::string as_text(const toml::node& node, std::string_view key) const {
    if (const auto* const value = node.as_string()) {
      return value->get();
    }
    fail(node, key, "must be a string");
  }
  [[nodiscard]] double as_number(const toml::node& node, std::string_view key) const {
    if (const auto* const value = node.as_floating_point()) {
      if (std::isfinite(value->get())) {
        return value->get();
      }
      fail(node, key, "must be finite");
    }
    if (const auto* const value = node.as_integer()) {
      return static_cast<double>(value->get());
    }
    fail(node, key, "must be a number");
  }
  [[nodiscard]] std::int64_t as_integer(const toml::node& node, std::string_view key) const {
    if (const auto* const value = node.as_integer()) {
      return value->get();
    }
    fail(node, key, "must be a whole number");
  }
  [[nodiscard]] int as_count(const toml::node& node, std::string_view key) const {
    const std::int64_t value = as_integer(node, key);
    if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
      fail(node, key, "is " + std::to_string(value) + ", that is out of range");
    }
    return static_cast<int>(value);
  }
  [[nodiscard]] bool as_boolean(const toml::node& node, std::string_view key) const {
    if (const auto* const value = node.as_boolean()) {
      return value->get();
    }
    fail(node, key, "must be true or false");
  }

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::string& path() const { return path_; }

  /// One of a few words.
  template <typename Value, std::size_t N>
  [[nodiscard]] Value as_choice(const toml::node& node, std::string_view key,
                                const std::array<std::pair<std::string_view, Value>, N>& choices) const {
    const std::string word = as_text(node, key);
    std::vector<std::string> words;
    for (const auto& [name, value] : choices) {
      if (name == word) {
        return value;
      }
      words.emplace_back(name);
    }
    fail(node, key, "is \"" + word + "\", must be one of " + quoted_list(words) + did_you_mean(word, words));
  }

  /// Refuses keys that nobody asked for.
  void finish() const {
    const std::vector<std::string> names(known_.begin(), known_.end());
    for (const auto& [key, node] : table_) {
      if (!known_.contains(key.str())) {
        refuse_unknown(key, did_you_mean(key.str(), names));
      }
    }
  }

  /// Where one of these keys, which must be there, seems to be there under a mistyped name, tells that.
  void look_for_mistyped(const std::vector<std::string>& wanted) const {
    for (const auto& [key, node] : table_) {
      const std::string guess = did_you_mean(key.str(), wanted);
      if (!known_.contains(key.str()) && !guess.empty()) {
        refuse_unknown(key, guess);
      }
    }
  }

  [[noreturn]] void fail(const toml::node& node, std::string_view key, const std::string& what) const {
    throw InputError(place(node.source()) + (path_.empty() ? "" : "[" + path_ + "] ") + std::string(key) +
                     " " + what);
  }

  /// The same for a fault of the table as a whole, or of the key that `what` begins with.
  [[noreturn]] void fail(const std::string& what) const {
    const toml::node* const culprit = table_.get(what.substr(0, what.find_first_of(" :")));
    throw InputError(place(culprit != nullptr ? culprit->source() : table_.source()) + "[" + path_ + "] " +
                     what);
  }

 private:
  [[nodiscard]] std::string place(const toml::source_region& at) const {
    return file_ + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column) + ": ";
  }
  [[noreturn]] void refuse_unknown(const toml::key& key, const std::string& guess) const {
    throw InputError(place(key.source()) + "unknown key \"" + std::string(key.str()) + "\"" + where() +
                     guess);
  }
  [[nodiscard]] std::string where() const { return path_.empty() ? "" : " in [" + path_ + "]"; }

  template <typename Value, typename Convert>
  std::optional<std::vector<Value>> list(std::string_view key, const Convert& convert) {
    const toml::node* const node = find(key);
    if (node == nullptr) {
      return std::nullopt;
    }
    std::vector<Value> out;
    if (const toml::array* const array = node->as_array()) {
      for (const toml::node& item : *array) {
        out.push_back(convert(item));
      }
    } else {
      out.push_back(convert(*node));
    }
    return out;
  }

  const toml::table& table_;
  std::string file_;
  std::string path_;  // of the table, as the file would write it: "robot.joints"
  std::set<std::string, std::less<>> known_;
};

}  // namespace rivid::detail
