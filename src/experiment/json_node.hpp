#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "experiment/text_file.hpp"
#include "rivid/error.hpp"
#include "rivid/fields.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// The JSON of a text.
///
/// @param file  that it is the content of
/// @param other what it is not, where it is no JSON: "is no result.json of rivid identify: "
/// @throws InputError  where it is no JSON, or more than deepest_nesting lists within each other
[[nodiscard]] inline nlohmann::json parsed_json(std::string_view text, const std::string& file,
                                                const std::string& other) {
  try {
    return nlohmann::json::parse(text, [&](int depth, auto /*event*/, const auto& /*parsed*/) {
      if (depth > deepest_nesting) {
        throw InputError(file + ": lists and objects within each other go deeper than " +
                         std::to_string(deepest_nesting));
      }
      return true;
    });
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file + ": " + other + e.what());
  }
}

/// The same of a file.
///
/// @param what  the file as messages name it: "the result"
/// @throws InputError  where it can not be read or is larger than result_limit as well
[[nodiscard]] inline nlohmann::json parsed_json(const std::filesystem::path& path, std::string_view what,
                                                const std::string& other) {
  return parsed_json(description_text(path, what, result_limit), path.string(), other);
}

/// A member of a JSON file that knows where it stands: messages are "file: robot.joints[2].friction …".
class JsonNode {
 public:
  JsonNode(const nlohmann::json& json, std::string file, std::string path = {})
      : json_(json), file_(std::move(file)), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file_ + ": " + (path_.empty() ? "the file" : path_) + " " + what);
  }

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const nlohmann::json& json() const { return json_; }
  [[nodiscard]] bool has(const char* key) const { return json_.is_object() && json_.contains(key); }

  /// A member that must be there.
  [[nodiscard]] JsonNode at(const char* key) const {
    if (!has(key)) {
      fail(std::string("has no ") + in_quotes(key));
    }
    return {json_.at(key), file_, path_.empty() ? key : path_ + "." + key};
  }

  /// The entries of a list.
  [[nodiscard]] std::vector<JsonNode> list() const {
    if (!json_.is_array()) {
      fail("must be a list");
    }
    std::vector<JsonNode> out;
    out.reserve(json_.size());
    for (std::size_t i = 0; i < json_.size(); ++i) {
      out.emplace_back(json_.at(i), file_, path_ + "[" + std::to_string(i) + "]");
    }
    return out;
  }

  [[nodiscard]] std::string text() const {
    if (!json_.is_string()) {
      fail("must be a string");
    }
    return json_.get<std::string>();
  }
  [[nodiscard]] bool boolean() const {
    if (!json_.is_boolean()) {
      fail("must be true or false");
    }
    return json_.get<bool>();
  }
  [[nodiscard]] double number() const {
    if (!json_.is_number() || !std::isfinite(json_.get<double>())) {
      fail("must be a finite number");
    }
    return json_.get<double>();
  }

  [[nodiscard]] std::vector<double> numbers() const {
    std::vector<double> out;
    for (const JsonNode& node : list()) {
      out.push_back(node.number());
    }
    return out;
  }
  [[nodiscard]] std::vector<double> numbers(std::size_t count) const {
    std::vector<double> out = numbers();
    if (out.size() != count) {
      fail("has " + std::to_string(out.size()) + " numbers, must have " + std::to_string(count));
    }
    return out;
  }

  /// Sets the members of a record as json_of() writes them, all of which must be there; null is not a number.
  template <Described Record>
  void read(Record& out) const {
    for_each_field<Record>([&](const auto& field) {
      if constexpr (std::is_member_object_pointer_v<std::decay_t<decltype(field.member)>>) {
        at(std::string(field.key).c_str()).read(out.*field.member);
      }
    });
  }
  void read(bool& out) const { out = boolean(); }
  void read(double& out) const {
    out = json_.is_null() ? std::numeric_limits<double>::quiet_NaN() : number();
  }
  void read(std::integral auto& out) const {
    using Integer = std::remove_reference_t<decltype(out)>;
    constexpr double exact = 1e15;  // doubles hold all integers up to it
    constexpr double least = std::max(-exact, static_cast<double>(std::numeric_limits<Integer>::min()));
    constexpr double most = std::min(exact, static_cast<double>(std::numeric_limits<Integer>::max()));
    const double value = number();
    if (value != std::floor(value)) {
      fail("must be a whole number");
    }
    if (value < least || value > most) {
      fail("is " + in_digits(value) + ", must be between " + in_digits(least) + " and " + in_digits(most));
    }
    out = static_cast<Integer>(value);
  }
  void read(std::string& out) const { out = text(); }
  template <typename Value>
  void read(std::optional<Value>& out) const {
    json_.is_null() ? out.reset() : read(out.emplace());
  }
  template <typename Value>
  void read(std::vector<Value>& out) const {
    out.clear();
    for (const JsonNode& node : list()) {
      node.read(out.emplace_back());
    }
  }
  template <typename Value, std::size_t size>
  void read(std::array<Value, size>& out) const {
    std::vector<Value> values;
    read(values);
    if (values.size() != size) {
      fail("has " + std::to_string(values.size()) + " entries, must have " + std::to_string(size));
    }
    std::ranges::copy(values, out.begin());
  }
  void read(Vector& out) const {
    std::vector<double> values;
    read(values);
    out = Eigen::Map<const Vector>(values.data(), std::ssize(values));
  }
  void read(Matrix& out) const {
    std::vector<Vector> rows;
    read(rows);
    out.resize(std::ssize(rows), rows.empty() ? 0 : rows.front().size());
    for (Index i = 0; i < out.rows(); ++i) {
      const Vector& row = rows[static_cast<std::size_t>(i)];
      if (row.size() != out.cols()) {
        fail("has rows of different lengths");
      }
      out.row(i) = row.transpose();
    }
  }
  template <Named Enum>
  void read(Enum& out) const {
    const std::string word = text();
    const std::optional<Enum> value = named<Enum>(word);
    if (!value) {
      fail("is " + in_quotes(word) + ", must be one of " +
           quoted_list(std::vector<std::string>(names_of<Enum>.begin(), names_of<Enum>.end())));
    }
    out = *value;
  }

 private:
  const nlohmann::json& json_;
  std::string file_;
  std::string path_;
};

}  // namespace rivid::detail
