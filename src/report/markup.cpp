#include "report/markup.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace rivid::detail {

std::string escaped(std::string_view text) {
  constexpr std::array<std::pair<char, std::string_view>, 5> entities = {
      {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}}};
  std::string out;
  for (const char c : text) {
    const auto* const entity = std::ranges::find(entities, c, &std::pair<char, std::string_view>::first);
    out += entity == entities.end() ? std::string_view(&c, 1) : entity->second;
  }
  return out;
}

std::string element(std::string_view tag, std::string_view content, std::string_view attributes) {
  std::string out = "<" + std::string(tag);
  if (!attributes.empty()) {
    out.append(" ").append(attributes);
  }
  return out.append(">").append(content).append("</").append(tag).append(">");
}

}  // namespace rivid::detail
