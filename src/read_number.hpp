#pragma once

#include <charconv>
#include <version>

#ifndef __cpp_lib_to_chars
#include <algorithm>
#include <cerrno>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <string>
#endif

namespace rivid::detail {

/// std::from_chars of a double, which the libc++ of clang 19 does not have yet.
[[nodiscard]] inline std::from_chars_result read_number(const char* first, const char* last, double& value) {
#ifdef __cpp_lib_to_chars
  return std::from_chars(first, last, value);
#else
  // What strtod() takes besides: spaces, a plus, hexadecimal digits.
  std::string text(first, last);
  text.resize(std::min(text.find_first_of("xX"), text.size()));
  if (text.find_first_of(" \t\n\v\f\r+") == 0) {
    return {first, std::errc::invalid_argument};
  }
  static const locale_t no_language = newlocale(LC_ALL_MASK, "C", nullptr);
  char* end = nullptr;
  errno = 0;
  const double read = strtod_l(text.c_str(), &end, no_language);
  const char* const stop = first + (end - text.c_str());
  if (stop == first) {
    return {first, std::errc::invalid_argument};
  }
  if (errno == ERANGE && (read == 0.0 || std::isinf(read))) {
    return {stop, std::errc::result_out_of_range};
  }
  value = read;
  return {stop, std::errc()};
#endif
}

}  // namespace rivid::detail
