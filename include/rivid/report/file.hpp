#pragma once

#include <filesystem>
#include <string_view>

namespace rivid {

/// Writes a file as a whole or not at all: a temporary file beside it is filled, flushed to disk and renamed.
/// Missing folders are made.
///
/// @throws InputError where the place can not be written to; what stood there before is untouched
void write_file(const std::filesystem::path& path, std::string_view content);

}  // namespace rivid
