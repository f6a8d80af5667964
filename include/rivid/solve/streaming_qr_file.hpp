#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "rivid/solve/streaming_qr.hpp"

namespace rivid {

/// An accumulator as the content of a file, so that rows reduced in one place can be merged in another. Every
/// number comes back bit for bit. All values are little-endian, whatever the machine:
///
/// | bytes | what |
/// |---|---|
/// | 8 | `rivid-QR` |
/// | 4, 4 | version of the format, 1; the number 0x01020304, which shows the order of the bytes |
/// | 8, 8, 8 | columns, carried columns, rows |
/// | 8 each | R and Qᵀ times the carried columns: column by column, each down to the diagonal or the last row |
/// | 8 each | norms of the unreachable parts of the carried columns; sums of all columns |
/// | 8 | FNV-1a checksum of all bytes before it |
[[nodiscard]] std::string encoded(const StreamingQr& qr);

/// The accumulator that encoded() wrote.
///
/// @param source  a name for messages, such as the path of the file
/// @throws InputError where the content is none of that: another kind of file, another version, truncated, damaged
[[nodiscard]] StreamingQr decoded_streaming_qr(std::string_view content, std::string_view source);

/// The accumulator in a file.
///
/// @throws InputError where the file can not be read, and as decoded_streaming_qr() does
[[nodiscard]] StreamingQr read_streaming_qr(const std::filesystem::path& path);

}  // namespace rivid
