#pragma once

#include <filesystem>
#include <string_view>

namespace rivid::detail {

/// Has read_input() give this content for an absolute path, whether there is a file or not, until the last
/// InputScope ends. One must live.
void provide_input(const std::filesystem::path& path, std::string_view content);

}  // namespace rivid::detail
