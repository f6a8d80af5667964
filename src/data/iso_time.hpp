#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace rivid::detail {

/// An instant as ISO 8601 writes it, in UTC.
struct IsoTime {
  std::int64_t day = 0;  ///< since 1970-01-01
  double seconds =
      0.0;  ///< since that day's midnight; below 0 or above 86400 where the offset leads to another day
};

/// "2024-05-06T07:08:09.123456Z": date, "T" or a blank, time with any number of decimals after a point or a
/// comma, and perhaps "Z" or an offset from UTC, "+02:00". Without one the time counts as UTC. Nothing for
/// any other text.
[[nodiscard]] std::optional<IsoTime> iso_time(std::string_view text);

}  // namespace rivid::detail
