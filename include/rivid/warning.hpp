#pragma once

#include <string>

namespace rivid {

/// Something that may make a result wrong.
struct Warning {
  std::string code;  ///< one of diagnostic_codes(), which tell cause and cure
  std::string text;  ///< what it is about, the value that was found, and what is required

  [[nodiscard]] bool operator==(const Warning& other) const = default;
};

}  // namespace rivid
