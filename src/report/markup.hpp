#pragma once

#include <string>
#include <string_view>

namespace rivid::detail {

// A text as content or attribute of XML and HTML.
[[nodiscard]] std::string escaped(std::string_view text);

// <tag attributes>content</tag>, the content being markup already.
[[nodiscard]] std::string element(std::string_view tag, std::string_view content,
                                  std::string_view attributes = {});

// What the pages bring along; the build makes these functions from files, see src/CMakeLists.txt.
[[nodiscard]] std::string_view report_css();
[[nodiscard]] std::string_view report_js();

}  // namespace rivid::detail
