#pragma once

#include <string>
#include <vector>

namespace rivid::detail {

/// "a, b, c".
[[nodiscard]] inline std::string comma_list(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) {
    out.append(out.empty() ? "" : ", ").append(word);
  }
  return out;
}

}  // namespace rivid::detail
