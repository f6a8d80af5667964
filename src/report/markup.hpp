#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rivid::detail {

// A text as content or attribute of XML and HTML.
[[nodiscard]] std::string escaped(std::string_view text);

// <tag attributes>content</tag>, the content being markup already.
[[nodiscard]] std::string element(std::string_view tag, std::string_view content,
                                  std::string_view attributes = {});

// What a colour of the HTML report means.
[[nodiscard]] std::string legend_item(std::string_view key, std::string_view meaning);

// A table of HTML, which scrolls sideways where it is too wide. Cells are markup.
class HtmlTable {
 public:
  enum class Align { text, number };
  struct Column {
    std::string title;
    Align align;
  };

  explicit HtmlTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

  void add(const std::vector<std::string>& cells, std::string_view row_class = {});
  [[nodiscard]] std::string markup() const;

 private:
  [[nodiscard]] std::string row(const std::vector<std::string>& cells, std::string_view tag,
                                std::string_view row_class) const;

  std::vector<Column> columns_;
  std::string rows_;
};

}  // namespace rivid::detail
