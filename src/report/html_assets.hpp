#pragma once

#include <string_view>

namespace rivid::detail {

// What the HTML report brings along; the build makes these functions from files, see src/CMakeLists.txt.
[[nodiscard]] std::string_view report_css();
[[nodiscard]] std::string_view report_js();

}  // namespace rivid::detail
