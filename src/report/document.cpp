#include "report/document.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

struct MarkWords {
  Mark mark;
  std::string_view sign;
  std::string_view name;
};

constexpr std::array marks = {MarkWords{Mark::none, "", ""},          MarkWords{Mark::weak, "?", "weak"},
                              MarkWords{Mark::unseen, "x", "unseen"}, MarkWords{Mark::apart, "!", "apart"},
                              MarkWords{Mark::gone, "-", "gone"},     MarkWords{Mark::sum, "", "sum"},
                              MarkWords{Mark::good, "✓", "good"},     MarkWords{Mark::mixed, "✗", "mixed"},
                              MarkWords{Mark::bad, "✗", "bad"}};
static_assert(complete<marks, &MarkWords::mark>(), "one row for each Mark, in its order");

// A value shows as many decimals as its deviation has four significant digits; more would be noise.
int decimals_for(double sigma) {
  constexpr int significant = 4;  // digits of the deviation
  constexpr int most = 9;         // decimals
  return std::clamp(significant - 1 - static_cast<int>(std::floor(std::log10(sigma))), 0, most);
}

// What rounds to zero has no sign.
std::string without_minus_zero(std::string text) {
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos) {
    text.erase(0, 1);
  }
  return text;
}

std::string in_format(const Format& format, double value, double sigma) {
  if (std::isnan(value)) {
    return "–";
  }
  switch (format.kind) {
    case Format::Kind::fixed:
      return without_minus_zero(fixed(value, format.digits));
    case Format::Kind::percent:
      if (std::abs(100.0 * value) > most_said) {
        return value > 0.0 ? "> 10⁶ %" : "< −10⁶ %";
      }
      return without_minus_zero(fixed(100.0 * value, format.digits)) + " %";
    case Format::Kind::deviation:
      return with_decimals_of(value, sigma);
    default:
      return number(value, format.digits);
  }
}

}  // namespace

std::string_view sign(Mark mark) { return marks[static_cast<std::size_t>(mark)].sign; }

std::string_view name(Mark mark) { return marks[static_cast<std::size_t>(mark)].name; }

std::string shown(const Column& column, const Cell& cell) {
  if (const auto* const text = std::get_if<std::string>(&cell.value)) {
    return *text;
  }
  const auto* const value = std::get_if<double>(&cell.value);
  if (value == nullptr || column.format.drawn()) {
    return {};
  }
  if (!std::isfinite(*value)) {
    return "-";
  }
  return in_format(column.format, *value, cell.sigma) + (column.unit.empty() ? "" : " " + column.unit);
}

std::string_view advice(const Finding& finding) {
  return severity(finding) == Severity::note ? std::string_view() : cure(finding);
}

std::string percent(double fraction) { return shown({{}, format::percent}, fraction); }

std::string with_decimals_of(double value, double sigma) {
  if (!std::isfinite(value)) {
    return "-";
  }
  const bool plain = std::isfinite(sigma) && sigma > 1e-6 && std::abs(value) < 1e9;
  return plain ? without_minus_zero(fixed(value, decimals_for(sigma))) : number(value, 6);
}

std::vector<Series> curves(const Vector& t, const std::vector<std::string>& names, const Matrix& columns) {
  constexpr std::size_t colours = 8;  // series-0 … series-7 of the style sheet
  std::vector<Series> out;
  for (std::size_t j = 0; j < names.size(); ++j) {
    out.push_back({names[j], "series-" + std::to_string(j % colours), Series::Kind::line, t,
                   columns.col(static_cast<Index>(j))});
  }
  return out;
}

Chart time_chart(const std::string& id, const std::string& title, const std::string& label,
                 const std::string& y_label, std::vector<Series> series, Chart::Size size) {
  return {.id = id,
          .title = title,
          .label = label,
          .x_label = "t [s]",
          .y_label = y_label,
          .series = std::move(series),
          .size = size};
}

}  // namespace rivid::detail
