#pragma once

#include <span>
#include <string_view>

#include "rivid/fields.hpp"

namespace rivid {

/// A number that command lines take.
struct CommandLineNumber {
  std::string_view option;
  std::string_view tools;  ///< that have it, for the page
  Range range;
  std::string_view unit = {};
};

/// All of them, in the order of docs/reliability.md, which prints them. An option means the same in each
/// tool.
[[nodiscard]] std::span<const CommandLineNumber> command_line_numbers();

/// What the number of an option may be.
///
/// @throws std::logic_error  where it is not among command_line_numbers()
[[nodiscard]] const CommandLineNumber& command_line_number(std::string_view option);

}  // namespace rivid
