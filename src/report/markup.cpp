#include "report/markup.hpp"

namespace rivid::detail {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
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
