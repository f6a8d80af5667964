#pragma once

#include <string>
#include <string_view>

namespace rivid::detail {

/// SHA-256 of a text, 64 hexadecimal digits.
///
/// @param instructions  whether the processor's own instructions are used where it has them
[[nodiscard]] std::string sha256_digits(std::string_view text, bool instructions = true);

}  // namespace rivid::detail
