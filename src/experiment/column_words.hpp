#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "data/dialect.hpp"

// The words that names of columns are made of.
namespace rivid::detail {

/// ASCII capitals as small letters.
[[nodiscard]] std::string lower(std::string_view text);

/// Bytes of characters beyond ASCII are letters too.
[[nodiscard]] inline bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) >= 0x80;
}

/// A name without its unit: "Axis1 Torque [Nm]".
struct ColumnName {
  std::vector<std::string> words;   ///< in small letters, without numbers
  std::optional<std::string> unit;  ///< as unit_scale() knows it
};

[[nodiscard]] ColumnName parted(std::string_view name);

/// What a column holds; `other` is something that no key of a [log] section takes.
enum class ColumnKind { position, velocity, torque, control, reference, reference_velocity, time, other };

/// What the words of a name say together.
struct ColumnMeaning {
  std::optional<ColumnKind> kind;  ///< none: no quantity, or more than one
  int strangeness = 0;             ///< words that say something else besides
};

[[nodiscard]] ColumnMeaning meaning_of(const std::vector<std::string>& words);

}  // namespace rivid::detail
