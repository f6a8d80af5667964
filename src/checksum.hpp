#pragma once

#include <cstdint>
#include <string_view>

namespace rivid::detail {

/// FNV-1a, 64 bits: finds damage, not malice.
[[nodiscard]] constexpr std::uint64_t checksum(std::string_view content) {
  std::uint64_t out = 0xcbf29ce484222325U;
  for (const char c : content) {
    out = (out ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  }
  return out;
}

}  // namespace rivid::detail
