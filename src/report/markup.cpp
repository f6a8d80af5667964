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

std::string legend_item(std::string_view key, std::string_view meaning) {
  return element("span", element("span", "", "class=\"key " + std::string(key) + "\"") + std::string(meaning),
                 "class=\"item\"") +
         "\n";
}

void HtmlTable::add(const std::vector<std::string>& cells, std::string_view row_class) {
  rows_ += row(cells, "td", row_class);
}

std::string HtmlTable::row(const std::vector<std::string>& cells, std::string_view tag,
                           std::string_view row_class) const {
  std::string out;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    out += element(tag, cells[c], columns_[c].align == Align::number ? "class=\"number\"" : "");
  }
  return element("tr", out, row_class.empty() ? "" : "class=\"" + std::string(row_class) + "\"") + "\n";
}

std::string HtmlTable::markup() const {
  std::vector<std::string> titles;
  titles.reserve(columns_.size());
  for (const Column& column : columns_) {
    titles.push_back(column.title);
  }
  const std::string table =
      element("table", element("thead", row(titles, "th", "")) + "\n" + element("tbody", rows_));
  return element("div", table, "class=\"scroll\"") + "\n";
}

}  // namespace rivid::detail
