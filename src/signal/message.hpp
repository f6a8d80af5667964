#pragma once

#include <sstream>
#include <string>

namespace rivid::detail {

template <typename... Parts>
[[nodiscard]] std::string message(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

}  // namespace rivid::detail
