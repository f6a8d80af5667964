#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/finding.hpp"

// Records as JSON by their fields; what is not a number or infinite becomes null when it is written.
namespace rivid::detail {

using Json = nlohmann::ordered_json;

/// The text of a file. A path may hold any bytes; JSON is UTF-8.
[[nodiscard]] inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// An array of what `of` makes of each of some records.
template <typename Records, typename Of>
[[nodiscard]] Json json_list(const Records& records, const Of& of) {
  Json out = Json::array();
  for (const auto& record : records) {
    out.push_back(of(record));
  }
  return out;
}

template <typename Value>
[[nodiscard]] Json json_of(const Value& value);

/// The value of a field that has one.
template <typename Access, typename Record>
[[nodiscard]] Json json_of(const Field<Access>& field, const Record& record) {
  if constexpr (!is_shown<Access, Record>) {
    return nullptr;
  } else {
    const auto& value = std::invoke(field.member, record);
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, bool>) {
      if (!field.details.words[0].empty()) {
        return field.details.words.at(value ? 1 : 0);
      }
    }
    return json_of(value);
  }
}

/// An object of the fields that have a value.
template <typename... Accesses, typename Record>
[[nodiscard]] Json json_of(const std::tuple<Field<Accesses>...>& fields, const Record& record) {
  Json out = Json::object();
  const auto add = [&](const auto& field) {
    if constexpr (is_shown<std::decay_t<decltype(field.member)>, Record>) {
      if (field.key.empty()) {
        out.update(json_of(field, record));
      } else {
        out[std::string(field.key)] = json_of(field, record);
      }
    }
  };
  std::apply([&](const auto&... field) { (add(field), ...); }, fields);
  return out;
}

template <typename Value>
Json json_of(const Value& value) {
  if constexpr (Described<Value>) {
    return json_of(Value::fields(), value);
  } else if constexpr (std::is_enum_v<Value>) {
    return name(value);
  } else if constexpr (std::is_same_v<Value, std::filesystem::path>) {
    return value.string();
  } else if constexpr (requires { value.valueless_by_exception(); }) {
    return std::visit([](const auto& one) { return json_of(one); }, value);
  } else if constexpr (requires { value.has_value(); }) {
    return value ? json_of(*value) : Json();
  } else if constexpr (requires { value.rowwise(); }) {
    if constexpr (Value::ColsAtCompileTime == 1) {
      return std::vector<double>(value.begin(), value.end());
    } else {
      Json out = Json::array();
      for (const auto row : value.rowwise()) {
        out.push_back(std::vector<double>(row.begin(), row.end()));
      }
      return out;
    }
  } else if constexpr (
      requires { Json(value); } && !requires { requires Named<typename Value::value_type>; }) {
    return value;
  } else {
    return json_list(value, [](const auto& item) { return json_of(item); });
  }
}

[[nodiscard]] inline Json warnings_of(std::span<const Finding> warnings) {
  return json_list(warnings, [](const Finding& warning) {
    return Json{{"code", warning.code},
                {"text", warning.text},
                {"severity", name(severity(warning))},
                {"subject", warning.subject},
                {"changes", json_of(warning.changes)}};
  });
}

}  // namespace rivid::detail
