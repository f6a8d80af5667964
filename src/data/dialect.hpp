#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "read_number.hpp"
#include "rivid/data/table.hpp"
#include "rivid/input.hpp"

namespace rivid::detail {

/// How a file writes its table, found from its first lines.
struct Dialect {
  char separator = ',';  ///< ' ' stands for any run of spaces and tabs
  bool header = false;
  std::vector<std::string> names;  ///< one a field
  bool trailing = false;           ///< every row ends in a separator
  std::size_t begin = 0;           ///< offset of the first line of data
  std::size_t line = 1;            ///< its number, from 1
};

/// @throws InputError  where the text holds no row of data or can not be understood
[[nodiscard]] Dialect dialect(std::string_view text, const std::string& source, const TableOptions& options);

/// Cells of one line, without the blanks and quotes around them, into `cells`.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// Whether a line holds no row: blank or a comment.
[[nodiscard]] bool is_skipped(std::string_view line);

/// "#3", the name of a field without one.
[[nodiscard]] std::string field_name(std::size_t number);

/// How a cell reads.
enum class CellReading { number, not_finite, out_of_range, empty, words };

/// Reads a whole cell as a number; `value` is written where it is one.
[[nodiscard]] CellReading read_cell(std::string_view cell, char mark, double& value);

/// Bytes behind the last character of a number that parsed_number() may read.
inline constexpr std::size_t number_padding = 8;

// 2^53: doubles hold all integers up to it
inline constexpr std::uint64_t exact_integers = std::uint64_t{1} << 53U;

inline constexpr std::array<double, 23> powers_of_ten = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                         1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                         1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

inline constexpr std::array<std::uint64_t, 9> powers_of_ten_integer = {
    1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};

/// 5^0 … 5^27, the powers that fit into 64 bits.
inline constexpr auto powers_of_five = [] {
  std::array<std::uint64_t, 28> powers{};
  std::uint64_t power = 1;
  for (std::uint64_t& p : powers) {
    p = power;
    power *= 5U;
  }
  return powers;
}();

/// mantissa / 10^k, rounded to the nearest double, ties to even. mantissa > 0, 0 ≤ k ≤ 27.
///
/// With both operands shifted to 64 bits, the quotient of 128 by 64 bits has 63 or 64 of them, so 53 remain
/// after rounding and the rest of the division distinguishes a tie from a value just above it.
inline double divided(std::uint64_t mantissa, std::size_t k) {
  __extension__ using Wide = unsigned __int128;
  const std::uint64_t divisor = powers_of_five[k];
  const int up = std::countl_zero(mantissa);
  const int divisor_up = std::countl_zero(divisor);
  const Wide numerator = static_cast<Wide>(mantissa << static_cast<unsigned>(up)) << 63U;
  const std::uint64_t normal = divisor << static_cast<unsigned>(divisor_up);
  const auto quotient = static_cast<std::uint64_t>(numerator / normal);
  const bool exact = static_cast<Wide>(quotient) * normal == numerator;
  // A 1 in the lowest bit stands for whatever follows: rounding to 53 bits then never sees a false tie.
  const std::uint64_t sticky = quotient | static_cast<std::uint64_t>(!exact);
  const int drop = static_cast<int>(std::bit_width(sticky)) - 53;
  const std::uint64_t half = std::uint64_t{1} << static_cast<unsigned>(drop - 1);
  const std::uint64_t rest = sticky & ((half << 1U) - 1U);
  std::uint64_t kept = sticky >> static_cast<unsigned>(drop);
  kept += static_cast<std::uint64_t>(rest > half || (rest == half && (kept & 1U) != 0));
  const int exponent = drop + divisor_up - up - 63 - static_cast<int>(k);
  const auto scale = std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52U);
  return static_cast<double>(kept) * scale;
}

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10U; }

/// Eight characters as one integer, the first in the lowest byte.
inline std::uint64_t eight_characters(const char* p) {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t word = 0;
  std::memcpy(&word, p, sizeof word);
  return word;
}

/// The highest bit of the first of eight characters that is no digit, and perhaps bits of later ones; 0 where
/// all are digits.
inline std::uint64_t no_digits(std::uint64_t word) {
  return ((word + 0x4646464646464646U) | (word - 0x3030303030303030U)) & 0x8080808080808080U;
}

/// Value of eight digits: pairs, then fours, then eight, each in one multiplication.
inline std::uint64_t eight_digits(std::uint64_t word) {
  word -= 0x3030303030303030U;
  word = word * 10U + (word >> 8U);
  return (((word & 0x000000FF000000FFU) * 0x000F424000000064U +
           ((word >> 16U) & 0x000000FF000000FFU) * 0x0000271000000001U) >>
          32U) &
         0xFFFFFFFFU;
}

/// Appends the decimal digits at `p` to a value; returns where they end. How many there are is no matter of
/// branches, which would be foretold wrongly: numbers in a file differ in it.
inline const char* digits(const char* p, std::uint64_t& value) {
  std::uint64_t word = eight_characters(p);
  std::uint64_t others = no_digits(word);
  while (others == 0) {
    value = value * powers_of_ten_integer[8] + eight_digits(word);
    p += 8;
    word = eight_characters(p);
    others = no_digits(word);
  }
  const auto count = static_cast<unsigned>(std::countr_zero(others)) / 8U;
  // The digits at the end of eight, behind as many zeros as it takes; in two shifts, for none may be of 64
  // bits.
  const unsigned up = 8U * (7U - count);
  word = ((word << up) << 8U) | (0x3030303030303030U >> (8U * count));
  value = value * powers_of_ten_integer[count] + eight_digits(word);
  return p + count;
}

/// The number without sign in [first, last) where it has more than 19 digits or a large exponent.
template <char Mark>
[[gnu::noinline]] inline bool rare_number(const char* first, const char* last, bool negative, double& value) {
  if constexpr (Mark != '.') {
    return false;
  } else {
    double magnitude = 0.0;
    const auto [end, error] = read_number(first, last, magnitude);
    value = negative ? -magnitude : magnitude;
    return error == std::errc() && end == last;
  }
}

/// Reads the decimal number that starts at `p`, correctly rounded; `Mark` stands before its fraction.
///
/// The text must end in a character that is no part of a number, with number_padding readable bytes behind
/// it. Returns where the number ends; returns `p` for what is no finite number and for what needs more care
/// than this.
template <char Mark>
inline const char* parsed_number(const char* p, double& value) {
  const char* const begin = p;
  const bool negative = *p == '-';
  p += static_cast<int>(negative || *p == '+');
  std::uint64_t mantissa = 0;
  const char* const first = p;
  p = digits(p, mantissa);
  std::ptrdiff_t count = p - first;
  std::ptrdiff_t exponent = 0;
  if (*p == Mark) {
    const char* const fraction = ++p;
    p = digits(p, mantissa);
    exponent = fraction - p;
    count -= exponent;
  }
  if (count == 0) {
    return begin;
  }
  if (*p == 'e' || *p == 'E') {
    ++p;
    const bool down = *p == '-';
    p += static_cast<int>(down || *p == '+');
    const char* const start = p;
    std::ptrdiff_t power = 0;
    while (is_digit(*p) && p - start < 4) {
      power = power * 10 + (*p - '0');
      ++p;
    }
    if (p == start) {
      return begin;
    }
    exponent += down ? -power : power;
  }
  double magnitude = 0.0;
  if (count > 19) {
    return rare_number<Mark>(first, p, negative, value) ? p : begin;
  }
  if (mantissa <= exact_integers && exponent >= -22 && exponent <= 22) {
    // Both operands are exact, so the one operation rounds correctly.
    const auto integer = static_cast<double>(static_cast<std::int64_t>(mantissa));
    magnitude = exponent < 0 ? integer / powers_of_ten[static_cast<std::size_t>(-exponent)]
                             : integer * powers_of_ten[static_cast<std::size_t>(exponent)];
  } else if (mantissa != 0 && exponent >= -27 && exponent <= 0) {
    magnitude = divided(mantissa, static_cast<std::size_t>(-exponent));
  } else if (mantissa != 0) {
    return rare_number<Mark>(first, p, negative, value) ? p : begin;
  }
  value = negative ? -magnitude : magnitude;
  return p;
}

}  // namespace rivid::detail
