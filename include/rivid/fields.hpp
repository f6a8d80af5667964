#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "rivid/text.hpp"

// What the members of a record are called and mean outside of the program. One list, `Record::fields()`,
// drives the reader of experiment files with its checks, the JSON of results, --dry-run, --set and the tables
// of docs/experiment.md and docs/result.md.

namespace rivid {

/// Names of the values of an enum in their order, as files write them: specialised beside each such enum.
template <typename Enum>
inline constexpr std::array<std::string_view, 0> names_of = {};

namespace detail {

// Whether an enumeration has a name for a value: how a table knows that it has a row for the last one.
// Compilers write "value = rivid::Verdict::weak", and "value = (rivid::Verdict)3" where there is none.
template <auto value>
consteval bool is_enumerator() {
  std::string_view shown = __PRETTY_FUNCTION__;
  shown = shown.substr(0, shown.find_first_of(";]", shown.rfind("value = ")));
  return shown[shown.find_last_not_of("0123456789")] != ')';
}

// Whether rows are in the order of their enumeration, and there is one for each of its values.
template <const auto& rows, auto member>
constexpr bool complete() {
  using Enum = std::remove_cvref_t<decltype(rows[0].*member)>;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].*member != static_cast<Enum>(i)) {
      return false;
    }
  }
  return !is_enumerator<static_cast<Enum>(rows.size())>();
}

template <typename Enum>
consteval bool has_names() {
  if constexpr (std::is_enum_v<Enum> && names_of<Enum>.size() > 0) {
    static_assert(!is_enumerator<static_cast<Enum>(names_of<Enum>.size())>(), "each value has a name");
    static_assert(is_enumerator<static_cast<Enum>(names_of<Enum>.size() - 1)>(), "each name has a value");
    return true;
  }
  return false;
}

}  // namespace detail

/// An enum with names; one that has a value without a name does not compile.
template <typename Enum>
concept Named = detail::has_names<Enum>();

/// The name of a value.
template <Named Enum>
[[nodiscard]] constexpr std::string_view name(Enum value) {
  return names_of<Enum>[static_cast<std::size_t>(value)];
}

/// Whether it is one of the values that have a name, and no number that was cast to the enum.
template <Named Enum>
[[nodiscard]] constexpr bool is_value(Enum value) {
  const auto index = static_cast<std::ptrdiff_t>(value);
  return index >= 0 && index < std::ssize(names_of<Enum>);
}

/// The value of a name, nothing where there is none.
template <Named Enum>
[[nodiscard]] constexpr std::optional<Enum> named(std::string_view name) {
  for (std::size_t i = 0; i < names_of<Enum>.size(); ++i) {
    if (names_of<Enum>[i] == name) {
      return static_cast<Enum>(i);
    }
  }
  return std::nullopt;
}

/// Numbers that an option may be. A count, size, tolerance or time has both ends, see docs/reliability.md:
/// one that is far beyond what anybody means costs hours or the memory of the machine.
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool open = false;    ///< whether the ends themselves are excluded
  bool budget = false;  ///< whether `most` is one: allowed itself, and told only where it is exceeded

  /// least < x ≤ most.
  [[nodiscard]] static constexpr Range above(double least,
                                             double most = std::numeric_limits<double>::infinity()) {
    return {.least = least, .most = most, .open = true, .budget = true};
  }
  /// least ≤ x ≤ most.
  [[nodiscard]] static constexpr Range from(double least,
                                            double most = std::numeric_limits<double>::infinity()) {
    return {.least = least, .most = most, .budget = true};
  }
  /// least ≤ x ≤ most.
  [[nodiscard]] static constexpr Range within(double least, double most) {
    return {.least = least, .most = most};
  }
  /// least < x < most.
  [[nodiscard]] static constexpr Range between(double least, double most) {
    return {.least = least, .most = most, .open = true};
  }

  /// Whether it holds; of a range without ends any number, be it finite or not.
  [[nodiscard]] bool holds(double x) const {
    if (std::isinf(least) && std::isinf(most)) {
      return true;
    }
    return std::isfinite(x) && (open ? least < x : least <= x) && (open && !budget ? x < most : x <= most);
  }
};

/// Magnitude that no other number of an experiment file may exceed: squares and products of such numbers are
/// finite.
inline constexpr double largest_number = 1e15;
/// Relative standard deviations of drive gains: beyond 1 a gain is not known at all.
inline constexpr Range gain_sigma_range = Range::from(0.0, 1.0);
/// Seeds are whole numbers of 63 bits.
inline constexpr Range seed_range = Range::from(0.0, 9223372036854775807.0);
/// Rates and cut-off frequencies [Hz].
inline constexpr Range rate_range = Range::above(0.0, 1e9);

namespace detail {

[[nodiscard]] inline std::string required(const Range& range, double value) {
  if (range.budget && value > range.most) {
    return "be at most " + rivid::number(range.most);
  }
  if (!range.budget && std::isfinite(range.least) && std::isfinite(range.most)) {
    return std::string(range.open ? "be" : "lie") + " between " + rivid::number(range.least) + " and " +
           rivid::number(range.most);
  }
  if (range.least == 0.0) {
    return range.open ? "be positive" : "not be negative";
  }
  return (range.open ? "be above " : "be at least ") + rivid::number(range.least);
}

// Whole numbers with all their digits.
[[nodiscard]] inline std::string in_digits(double value) {
  constexpr double exactly = 1e15;  // doubles hold all integers below it
  return std::abs(value) < exactly && value == std::floor(value)
             ? std::to_string(static_cast<long long>(value))
             : rivid::number(value);
}

}  // namespace detail

/// "rtol is 2, must be between 0 and 1", with the unit behind the value.
[[nodiscard]] inline std::string out_of_range(std::string_view key, double value, std::string_view unit,
                                              const Range& range) {
  return std::string(key) + " is " + detail::in_digits(value) + (unit.empty() ? "" : " ") +
         std::string(unit) + ", must " + detail::required(range, value);
}

/// What a field has beside its name, place and meaning.
struct FieldDetails {
  std::string_view otherwise = {};  ///< the default in words, where the value of a new record does not say it
  std::string_view unit = {};
  Range range = {};                            ///< of a number, or of each of several
  std::string_view word = {};                  ///< that stands for the value of nothing: "off" for 0 Hz
  std::array<std::string_view, 2> words = {};  ///< of a boolean, for false and for true
  std::string_view must_be = {};               ///< what a message requires, where the range does not say it
  std::string_view required = {};  ///< of a key that must be there: what a message says without it
};

/// In place of a member: a key whose value in files is not that of a member.
///
/// @tparam Value     what stands in files; a variant where there are several kinds
/// @tparam Function  of the record, to what it has for the key; nullptr_t for a key that nothing is shown of
template <typename Value, typename Function = std::nullptr_t>
struct Key {
  Function value = nullptr;

  template <typename Record>
    requires std::is_invocable_v<const Function&, const Record&>
  constexpr decltype(auto) operator()(const Record& record) const {
    return value(record);
  }
};
template <typename Value, typename Function>
[[nodiscard]] constexpr Key<Value, Function> shown_key(Function value) {
  return {value};
}

/// One member of a record, as files and pages name it.
///
/// @tparam Access  a pointer to the member; or a function of the record, for what is only written; or a Key
template <typename Access>
struct Field {
  std::string_view key;  ///< empty of a record whose keys stand among those of this one
  Access member;
  std::string_view meaning;  ///< one sentence for the page
  FieldDetails details = {};
};

/// Whether a field has a value to show of a record.
template <typename Access, typename Record>
inline constexpr bool is_shown = std::is_invocable_v<const Access&, const Record&>;

/// A record whose keys stand among those of the record that has it as a member.
template <typename Member>
[[nodiscard]] constexpr Field<Member> embedded(Member member) {
  return {"", member, ""};
}

namespace detail {

template <typename Access, typename Record>
struct ValueOfKey {
  using type = std::decay_t<std::invoke_result_t<const Access&, const Record&>>;
};
template <typename Value, typename Function, typename Record>
struct ValueOfKey<Key<Value, Function>, Record> {
  using type = Value;
};

}  // namespace detail

/// What files hold for a field of a record.
template <typename Access, typename Record>
using KeyValue = typename detail::ValueOfKey<Access, Record>::type;

/// A record that lists its fields: its static `fields()` returns a tuple of them. A template on the record
/// itself, so that only who asks for the list compiles it, and not each file that includes the record.
template <typename Record>
concept Described = requires { Record::fields(); };

/// Calls visit(field) for each field.
template <Described Record, typename Visit>
constexpr void for_each_field(const Visit& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, Record::fields());
}

namespace detail {

template <typename Value>
[[nodiscard]] std::optional<double> number_out_of(const Range& range, const Value& value) {
  if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
    const auto x = static_cast<double>(value);
    return range.holds(x) ? std::nullopt : std::optional(x);
  } else if constexpr (requires { value.has_value(); }) {
    return value ? number_out_of(range, *value) : std::nullopt;
  } else if constexpr (requires { value.begin(); }) {
    for (const auto& item : value) {
      if (const auto fault = number_out_of(range, item)) {
        return fault;
      }
    }
  }
  return std::nullopt;
}

}  // namespace detail

/// The first number of a record that lies outside of its range, in words; nothing where all are within, or
/// what a new record has.
template <Described Record>
[[nodiscard]] std::optional<std::string> range_fault(const Record& record) {
  std::optional<std::string> out;
  Record other;  // not "{}", for whose members g++ 12 warns without reason
  for_each_field<Record>([&](const auto& field) {
    if constexpr (std::is_member_object_pointer_v<std::decay_t<decltype(field.member)>>) {
      const auto& value = record.*field.member;
      const FieldDetails& details = field.details;
      const std::optional<double> fault = detail::number_out_of(details.range, value);
      if (fault && !out && detail::number_out_of(details.range, other.*field.member) != fault) {
        out = out_of_range(field.key, *fault, details.unit, details.range);
      }
    }
  });
  return out;
}

}  // namespace rivid
