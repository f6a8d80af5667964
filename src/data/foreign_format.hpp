#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace rivid::detail {

/// What is wrong with a file that holds a log in a format that is no text, by its first bytes, and the
/// command that makes CSV of it; nothing for any other file.
///
/// @param bytes  of the file, 20 or more unless it is shorter
/// @param path   of the file, for the message
[[nodiscard]] std::optional<std::string> foreign_format(std::string_view bytes, const std::string& path);

}  // namespace rivid::detail
