#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

// Compiled once, in toml_reader.cpp.
#define TOML_HEADER_ONLY 0
#include <toml++/toml.h>

#include "rivid/error.hpp"
#include "rivid/fields.hpp"
#include "rivid/text.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// A TOML file as a table, with settings of the command line laid over it.
///
/// @param what      the file as messages name it: "the experiment file"
/// @param settings  "signal.decimation=5": a dotted key and a TOML value; a word needs no quotes
/// @throws InputError  where the file can not be read; "file:line:column: …" or "--set key=value: …" for what is no TOML
[[nodiscard]] toml::table parsed_toml(const std::filesystem::path& path, std::string_view what,
                                      std::span<const std::string> settings = {});

/// The same of text that a program made, which `source` names in messages.
[[nodiscard]] toml::table parsed_toml_text(std::string_view text, const std::string& source);

/// Where the keys of a table come from, by their dotted names: "file" or "--set".
[[nodiscard]] std::map<std::string, std::string> origins(const toml::table& table);

/// What a field asks of a value.
struct Wanted {
  std::string_view key;
  std::string_view unit = {};
  std::string_view must_be = {};
  Range range = {};
  std::array<std::string_view, 2> words = {};
  Index joints = 0;  ///< of the robot, for values that are one a joint
};

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
  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::string& path() const { return path_; }

  /// Sets the members of a record whose keys are there. Those that are no plain values are left to the section.
  ///
  /// @param joints  of the robot
  template <typename Record, typename... Accesses>
  void read(const std::tuple<Field<Accesses>...>& fields, Record& out, Index joints = 0) {
    std::apply([&](const auto&... field) { (read_field(field, out, joints), ...); }, fields);
  }
  template <Described Record>
  void read(Record& out, Index joints = 0) {
    read(Record::fields(), out, joints);
  }

  /// The value of a key, nothing if the file does not have it.
  template <typename Value>
  std::optional<Value> get(std::string_view key, const Range& range = {}, std::string_view unit = {}) {
    const toml::node* const node = find(key);
    return node == nullptr ? std::nullopt
                           : std::optional(as<Value>(*node, {.key = key, .unit = unit, .range = range}));
  }

  template <typename Value>
  [[nodiscard]] Value as(const toml::node& node, const Wanted& wanted) const {
    Value out{};
    take(node, wanted, out);
    return out;
  }
  template <typename Value>
  [[nodiscard]] Value as(const toml::node& node, std::string_view key) const {
    return as<Value>(node, Wanted{.key = key});
  }

  /// A value for each joint, one for all or a list, into a member of the records of the joints.
  template <typename Record, typename Value>
  void read_each(const Field<Value Record::*>& field, std::vector<Record>& out) {
    const toml::node* const node = find(field.key);
    if (node == nullptr) {
      return;
    }
    const toml::array* const list = node->as_array();
    if (list != nullptr) {
      require_one_each(*node, field.key, std::ssize(*list), std::ssize(out));
    }
    for (std::size_t j = 0; j < out.size(); ++j) {
      take(list != nullptr ? *list->get(j) : *node, wanted(field, 0), out[j].*field.member);
    }
  }

  /// Position of one of a few words among them.
  [[nodiscard]] std::size_t word(const toml::node& node, std::string_view key,
                                 std::span<const std::string_view> words) const;
  /// The same of a key that may be absent.
  [[nodiscard]] std::optional<std::size_t> word(std::string_view key,
                                                std::span<const std::string_view> words);

  /// What stands in a list; what is no list counts as a list of one.
  [[nodiscard]] static std::vector<const toml::node*> items(const toml::node& node);

  /// A table within this one.
  std::optional<TomlReader> section(std::string_view key);
  [[nodiscard]] TomlReader section(const toml::node& node, std::string_view key) const;

  /// A record that is wanted or not: `true`, `false`, or a table of options, which `read` takes.
  template <Described Record, typename Read>
  std::optional<Record> switched(std::string_view key, const Read& read) {
    const toml::node* const node = find(key);
    if (node != nullptr && node->is_table()) {
      TomlReader options = section(*node, key);
      Record out;
      options.read(out);
      read(options, out);
      return out;
    }
    if (node != nullptr && !node->is_boolean()) {
      fail(*node, key, "must be true or false, or a table of options");
    }
    return node != nullptr && node->as_boolean()->get() ? std::optional(Record{}) : std::nullopt;
  }

  /// Refuses keys that nobody asked for.
  void finish() const;

  /// Where one of these keys, which must be there, seems to be there under a mistyped name, reports that.
  void look_for_mistyped(const std::vector<std::string>& wanted) const;

  [[noreturn]] void fail(const toml::node& node, std::string_view key, const std::string& what) const;

  /// The same for a fault of the table as a whole, or of the key that `what` begins with.
  [[noreturn]] void fail(const std::string& what) const;
  void refuse(const std::optional<std::string>& complaint) const {
    if (complaint) {
      fail(*complaint);
    }
  }

  /// Refuses a list that has not one entry for each joint.
  void require_one_each(const toml::node& node, std::string_view key, std::ptrdiff_t entries,
                        std::ptrdiff_t joints) const;

 private:
  template <typename Access>
  static Wanted wanted(const Field<Access>& field, Index joints) {
    const FieldDetails& d = field.details;
    return {field.key, d.unit, d.must_be, d.range, d.words, joints};
  }

  template <typename Access, typename Record>
  void read_field(const Field<Access>& field, Record& out, Index joints) {
    if constexpr (std::is_member_object_pointer_v<Access>) {
      auto& value = out.*field.member;
      if constexpr (requires(const toml::node& n, const Wanted& w) { take(n, w, value); }) {
        const toml::node* const node = find(field.key);
        if (node == nullptr) {
          return;
        }
        if (!field.details.word.empty() && node->value_exact<std::string_view>() == field.details.word) {
          value = {};
        } else {
          take(*node, wanted(field, joints), value);
        }
      }
    }
  }

  void take(const toml::node& node, const Wanted& wanted, bool& out) const;
  void take(const toml::node& node, const Wanted& wanted, double& out) const;
  void take(const toml::node& node, const Wanted& wanted, int& out) const;
  void take(const toml::node& node, const Wanted& wanted, std::int64_t& out) const;
  void take(const toml::node& node, const Wanted& wanted, std::uint64_t& out) const;
  void take(const toml::node& node, const Wanted& wanted, std::string& out) const;
  void take(const toml::node& node, const Wanted& wanted, Vector& out) const;
  template <Named Enum>
  void take(const toml::node& node, const Wanted& wanted, Enum& out) const {
    out = static_cast<Enum>(word(node, wanted.key, names_of<Enum>));
  }
  template <typename Value>
    requires std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>
  void take(const toml::node& node, const Wanted& wanted, std::vector<Value>& out) const {
    out.clear();
    for (const toml::node* const item : items(node)) {
      out.push_back(as<Value>(*item, wanted));
    }
  }
  template <typename Number>
  void take(const toml::node& node, const Wanted& wanted, std::array<Number, 2>& out) const {
    const std::vector<const toml::node*> ends = items(node);
    // A whole number may stand for both ends.
    if (ends.empty() || ends.size() > 2 || (std::is_floating_point_v<Number> && ends.size() != 2)) {
      fail(node, wanted.key, "must be " + std::string(wanted.must_be));
    }
    out = {as<Number>(*ends.front(), wanted), as<Number>(*ends.back(), wanted)};
  }
  template <typename Value>
    requires(!Described<Value>)
  void take(const toml::node& node, const Wanted& wanted, std::optional<Value>& out) const {
    out = as<Value>(node, wanted);
  }

  void require_within(const toml::node& node, const Wanted& wanted, double value) const;
  [[nodiscard]] std::string place(const toml::source_region& at) const;
  [[noreturn]] void refuse_unknown(const toml::key& key, const std::string& guess) const;

  const toml::table& table_;
  std::string file_;
  std::string path_;  // of the table, as the file would write it: "robot.joints"
  std::set<std::string, std::less<>> known_;
};

}  // namespace rivid::detail
