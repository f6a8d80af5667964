#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

// Compiled once, in toml_reader.cpp.
#define TOML_HEADER_ONLY 0
#include <toml++/toml.h>

#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/text.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// A TOML file as a table, with settings of the command line laid over it.
///
/// @param what      the file as messages name it: "the experiment file"
/// @param settings  "signal.decimation=5": a dotted key and a TOML value; a word needs no quotes
/// @throws InputError  where the file can not be read; "file:line:column: …" or "--set key=value: …" for what
///                     is no TOML
[[nodiscard]] toml::table parsed_toml(const std::filesystem::path& path, std::string_view what,
                                      std::span<const std::string> settings = {});

/// The same of text that a program made, which `source` names in messages.
[[nodiscard]] toml::table parsed_toml_text(std::string_view text, const std::string& source);

/// Where the keys of a table come from, by their dotted names: "file" or "--set".
[[nodiscard]] std::map<std::string, std::string> origins(const toml::table& table);

/// What a field asks of a value.
struct Wanted {
  std::string_view key;
  FieldDetails details = {};
};

/// Whether a record can do without any key.
template <typename Value>
[[nodiscard]] constexpr bool is_switch() {
  if constexpr (Described<Value>) {
    bool out = true;
    for_each_field<Value>([&](const auto& field) { out = out && field.details.required.empty(); });
    return out;
  } else {
    return false;
  }
}

/// One table of an experiment file. Every key that is read is remembered, and finish() refuses the others, so
/// that a mistyped key can not be passed over. Messages are "file:line:column: [table] key …".
class TomlReader {
 public:
  /// @param folder  that paths are relative to
  TomlReader(const toml::table& table, std::string file, std::string path, std::filesystem::path folder = {})
      : table_(table), file_(std::move(file)), path_(std::move(path)), folder_(std::move(folder)) {}

  /// Says which robot values are of, as those that are one a joint.
  TomlReader& of(const Robot& robot) {
    robot_ = &robot;
    return *this;
  }
  [[nodiscard]] const Robot& robot() const { return *robot_; }
  /// Those that lists have a value of.
  [[nodiscard]] Index joints() const { return robot_ != nullptr ? robot_->size() - robot_->base_joints : 0; }

  /// The node of a key, nothing if the file does not have it.
  const toml::node* find(std::string_view key) {
    known_.emplace(key);
    return table_.get(key);
  }

  [[nodiscard]] const toml::table& table() const { return table_; }

  /// Sets the members of a record whose keys are there, and refuses one without a required key. What is under
  /// a Key, or in no member, is left to the section.
  template <typename Record, typename... Accesses>
  void read(const std::tuple<Field<Accesses>...>& fields, Record& out) {
    std::apply(
        [&](const auto&... field) {
          (read_field(field, out), ...);
          require({{field.key, field.details.required}...});
        },
        fields);
  }
  template <Described Record>
  void read(Record& out) {
    read(Record::fields(), out);
  }

  /// All of a table: the fields of a record, what read_more() of its section takes besides, nothing else;
  /// checked by its complaint().
  template <Described Record>
  void read_whole(Record& out) {
    read(out);
    if constexpr (requires { read_more(*this, out); }) {
      read_more(*this, out);
    }
    finish();
    refuse(complaint_of(out));
  }

  /// Sets a value whose key is there.
  template <typename Value>
  void set(Value& out, const Wanted& wanted) {
    if (const toml::node* const node = find(wanted.key)) {
      take(*node, wanted, out);
    }
  }

  /// The value of a key, nothing if the file does not have it.
  template <typename Value>
  std::optional<Value> get(std::string_view key, const Range& range = {}, std::string_view unit = {}) {
    const toml::node* const node = find(key);
    return node == nullptr
               ? std::nullopt
               : std::optional(as<Value>(*node, {.key = key, .details = {.unit = unit, .range = range}}));
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
      take(list != nullptr ? *list->get(j) : *node, {field.key, field.details}, out[j].*field.member);
    }
  }

  /// Columns that are not one a joint, of which there must be one of a few numbers; none where the key is
  /// absent.
  [[nodiscard]] std::vector<Column> columns(std::string_view key, std::vector<Index> numbers);

  /// Position of one of a few words among them.
  [[nodiscard]] std::size_t word(const toml::node& node, std::string_view key,
                                 std::span<const std::string_view> words) const;
  /// The same of a key that may be absent.
  [[nodiscard]] std::optional<std::size_t> word(std::string_view key,
                                                std::span<const std::string_view> words);

  /// The joint whose name a node holds, from 0.
  [[nodiscard]] Index joint(const toml::node& node, std::string_view key) const;
  /// The same of a name that is there.
  [[nodiscard]] Index joint(const toml::node& node, std::string_view key, const std::string& name) const;

  /// Lists of numbers, row by row, nothing where the key is absent.
  ///
  /// @param rows, columns  −1: any number, the same in each row
  /// @param required       what the key must be, for the message of any other
  [[nodiscard]] std::optional<Matrix> matrix(std::string_view key, Index rows, Index columns,
                                             const std::string& required);

  /// What stands in a list; what is no list counts as a list of one.
  [[nodiscard]] static std::vector<const toml::node*> items(const toml::node& node);

  /// A table within this one.
  std::optional<TomlReader> section(std::string_view key);
  [[nodiscard]] TomlReader section(const toml::node& node, std::string_view key) const;

  /// Refuses keys that nobody asked for.
  void finish() const;
  /// @param guess  "; did you mean …?"
  [[noreturn]] void refuse_unknown(const toml::key& key, const std::string& guess) const;

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
  /// Refuses keys that are there without another one.
  void refuse_keys(std::initializer_list<std::string_view> keys, const std::string& why);

  /// Refuses a list that has not one entry for each joint.
  void require_one_each(const toml::node& node, std::string_view key, std::ptrdiff_t entries,
                        std::ptrdiff_t joints) const;

 private:
  template <typename Access, typename Record>
  void read_field(const Field<Access>& field, Record& out) {
    if constexpr (std::is_same_v<Access, Key<UnitNames>>) {
      check_units(field.key);
    } else if constexpr (std::is_member_object_pointer_v<Access>) {
      auto& value = out.*field.member;
      if constexpr (Described<std::decay_t<decltype(value)>>) {
        if (field.key.empty()) {
          read(value);
          return;
        }
      }
      if constexpr (requires(const toml::node& n, const Wanted& w) { take(n, w, value); }) {
        const toml::node* const node = find(field.key);
        if (node == nullptr) {
          return;
        }
        if (!field.details.word.empty() && node->value_exact<std::string_view>() == field.details.word) {
          value = Record().*field.member;
        } else {
          take(*node, {field.key, field.details}, value);
        }
      }
    }
  }

  // Keys and what is said where they are absent; empty where they may be.
  void require(std::initializer_list<std::pair<std::string_view, std::string_view>> keys);

  template <typename Record>
  [[nodiscard]] std::optional<std::string> complaint_of(const Record& record) const {
    if constexpr (requires { record.complaint(*robot_); }) {
      return record.complaint(*robot_);
    } else if constexpr (requires { record.complaint(joints()); }) {
      return record.complaint(joints());
    } else if constexpr (requires { record.complaint(); }) {
      return record.complaint();
    } else {
      return std::nullopt;
    }
  }

  // The value of a node of the right type, which `what` names where the field does not.
  template <typename Value>
  const Value& expected(const toml::value<Value>* value, const toml::node& node, const Wanted& wanted,
                        std::string_view what) const;

  void take(const toml::node& node, const Wanted& wanted, bool& out) const;
  void take(const toml::node& node, const Wanted& wanted, double& out) const;
  void take(const toml::node& node, const Wanted& wanted, int& out) const;
  void take(const toml::node& node, const Wanted& wanted, std::int64_t& out) const;
  void take(const toml::node& node, const Wanted& wanted, std::uint64_t& out) const;
  void take(const toml::node& node, const Wanted& wanted, std::string& out) const;
  void take(const toml::node& node, const Wanted& wanted, std::filesystem::path& out) const;
  void take(const toml::node& node, const Wanted& wanted, Vector& out) const;
  void take(const toml::node& node, const Wanted& wanted, Eigen::Vector3d& out) const;
  // "q1", 3, or { column = "q1", unit = "deg", sign = -1, scale = 2.0, offset = 0.1 }; the offset is in SI
  // units. `units` beside the key says the unit of a column that does not say its own.
  void take(const toml::node& node, const Wanted& wanted, Column& out) const;
  // One a joint.
  void take(const toml::node& node, const Wanted& wanted, std::vector<Column>& out) const;
  template <Named Enum>
  void take(const toml::node& node, const Wanted& wanted, Enum& out) const {
    std::vector<std::string_view> words(names_of<Enum>.begin(), names_of<Enum>.end());
    if (!wanted.details.word.empty()) {
      words.push_back(wanted.details.word);  // which stands for no value and was looked for
    }
    out = static_cast<Enum>(word(node, wanted.key, words));
  }
  template <typename Value>
  void take(const toml::node& node, const Wanted& wanted, std::vector<Value>& out) const {
    out.clear();
    if (Described<Value> && !wanted.details.must_be.empty() && !node.is_array()) {
      fail(node, wanted.key, "must be " + std::string(wanted.details.must_be));
    }
    for (const toml::node* const item : items(node)) {
      take(*item, wanted, out.emplace_back());
    }
  }
  template <typename Number>
  void take(const toml::node& node, const Wanted& wanted, std::array<Number, 2>& out) const {
    const std::vector<const toml::node*> ends = items(node);
    // A whole number may stand for both ends.
    if (ends.empty() || ends.size() > 2 || (std::is_floating_point_v<Number> && ends.size() != 2)) {
      fail(node, wanted.key, "must be " + std::string(wanted.details.must_be));
    }
    out = {as<Number>(*ends.front(), wanted), as<Number>(*ends.back(), wanted)};
  }
  template <typename Value>
  void take(const toml::node& node, const Wanted& wanted, std::map<std::string, Value>& out) const {
    const TomlReader inner = section(node, wanted.key);
    for (const auto& [key, value] : inner.table()) {
      out[std::string(key.str())] = inner.as<Value>(value, {key.str(), wanted.details});
    }
  }
  template <Described Record>
  void take(const toml::node& node, const Wanted& wanted, Record& out) const {
    section(node, wanted.key).read_whole(out);
  }
  // A record that can do without any key may be a switch: `true`, `false`, or a table of options.
  template <typename Value>
  void take(const toml::node& node, const Wanted& wanted, std::optional<Value>& out) const {
    if constexpr (is_switch<Value>()) {
      if (const auto* const on = node.as_boolean()) {
        out = on->get() ? std::optional(Value{}) : std::nullopt;
        return;
      }
      if (!node.is_table()) {
        fail(node, wanted.key, "must be true or false, or a table of options");
      }
    }
    take(node, wanted, out.emplace(Value{}));
  }

  void require_within(const toml::node& node, const Wanted& wanted, double value) const;
  // Refuses units that are none, and units of columns that are not listed: they would be passed over in
  // silence.
  void check_units(std::string_view key);
  [[nodiscard]] std::string column_name(const toml::node& node, std::string_view key) const;
  // A factor to SI.
  [[nodiscard]] std::optional<double> unit(std::string_view key);
  [[nodiscard]] std::string place(const toml::source_region& at) const;

  const toml::table& table_;
  std::string file_;
  std::string path_;  // of the table, as the file would write it: "robot.joints"
  std::filesystem::path folder_;
  const Robot* robot_ = nullptr;
  std::set<std::string, std::less<>> known_;
};

}  // namespace rivid::detail
