#include "report/page_lists.hpp"

#include <cmath>
#include <sstream>
#include <utility>

#include "experiment/json_fields.hpp"
#include "experiment/text_file.hpp"
#include "report/page_tables.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/plan_file.hpp"
#include "rivid/input.hpp"
#include "rivid/report/limits.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::string in_code(std::string_view text) { return "`" + std::string(text) + "`"; }

// Of what has a unit.
std::string shown_unit(std::string_view unit) { return unit == "1" ? "" : std::string(unit); }

// "number, Hz; from the stamps", or a default that shows its type: "`600` s".
std::string value_of(const KeyRow& row) {
  const std::string unit = shown_unit(row.unit);
  const bool shows_type = row.type == rivid::name(row.kinds.front()) && row.kinds.front() < ValueKind::file &&
                          row.otherwise.starts_with('`') &&
                          row.otherwise.find('`', 1) + 1 == row.otherwise.size();
  if (shows_type) {
    return row.otherwise + (unit.empty() ? "" : " " + unit);
  }
  const std::string or_default = " or " + row.otherwise;
  const bool twice = row.type.ends_with(or_default);
  return row.type.substr(0, row.type.size() - (twice ? or_default.size() : 0)) +
         (unit.empty() ? "" : ", " + unit) + (row.otherwise == "–" ? "" : "; " + row.otherwise);
}

// An item in lines of 110 characters at most, if code and links, which stay whole, let it.
std::string in_lines(std::string_view item) {
  constexpr Index most = 110;
  std::string out;
  Index column = 0;
  std::string part;  // that stays whole
  Index width = 0;   // of it, in characters
  bool in_code = false;
  Index links = 0;  // whose text goes on, and brackets
  const auto put = [&] {
    const bool first = out.empty();
    if (!first && column + 1 + width > most) {
      out += "\n  ";
      column = 2;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += std::exchange(part, {});
    column += std::exchange(width, 0);
  };
  for (const char c : item) {
    if (!in_code && links == 0 && c == ' ' && !part.empty()) {
      put();
      continue;
    }
    in_code = in_code != (c == '`');
    links += in_code ? 0 : (c == '[' ? 1 : 0) - (c == ']' ? 1 : 0);
    part += c;
    width += (static_cast<unsigned char>(c) & 0xC0U) == 0x80U ? 0 : 1;  // 10xxxxxx goes on with a character
  }
  put();
  return out + "\n";
}

// An item of a list: "- `max_gap` (`10` periods): a longer gap splits a log that is resampled".
std::string item_of(std::string_view name, const std::string& in_brackets, std::string_view meaning) {
  return in_lines("- " + in_code(name) + (in_brackets.empty() ? "" : " (" + in_brackets + ")") + ": " +
                  std::string(meaning));
}

std::string in_digits_or_power(double value) {
  const bool short_enough = std::abs(value) < 1e6;
  return short_enough ? number(value, 6) : number(value, 3);
}

// What the numbers of command lines and the files may be. The interval of a key is in the message that
// refuses its value.
std::string limits_list() {
  std::string out;
  for (const CommandLineNumber& number : command_line_numbers()) {
    const Range& range = number.range;
    out += "- " + in_code(number.option) + " (" + std::string(number.tools) +
           "): " + (range.open ? "(" : "[") + in_digits_or_power(range.least) + ", " +
           in_digits_or_power(range.most) + (range.open && !range.budget ? ")" : "]") +
           (number.unit.empty() ? "" : " ") + std::string(number.unit) + "\n";
  }
  out += "- `.toml`: numbers without another limit: up to " + number(largest_number) + "\n";
  const auto size = [&](const std::string& what, std::uintmax_t bytes) {
    out += "- " + what + ": files of up to " + std::to_string(bytes >> 20U) + " MiB\n";
  };
  size("`.urdf`, `.toml`", robot_limit);
  size("`.json`, tables of results, plans and parameters", result_limit);
  return out + "- `.toml`, `.json`: nesting, parts of a key: up to " + std::to_string(deepest_nesting) + "\n";
}

template <Described Record>
std::string member_table() {
  std::string out;
  for_each_field<Record>(
      [&](const auto& field) { out += item_of(field.key, shown_unit(field.details.unit), field.meaning); });
  return out;
}

}  // namespace

std::map<std::string, std::string> page_tables() {
  std::map<std::string, std::string> out = {{"result.parameters", member_table<ParameterEstimate>()},
                                            {"result.covariance", member_table<CovarianceReport>()},
                                            {"result.tests", member_table<Diagnostics>()},
                                            {"result.alternatives", member_table<ModelTest>()},
                                            {"result.fit", member_table<Fit>()},
                                            {"result.fit.joints", member_table<JointFit>()},
                                            {"result.forecast", member_table<TorqueForecast>()},
                                            {"result.gains", member_table<GainReport>()},
                                            {"result.gains.joints", member_table<GainEstimate>()},
                                            {"result.prefilter", member_table<PrefilterReport>()},
                                            {"result.output_error", member_table<OutputErrorReport>()},
                                            {"result.robust", member_table<RobustReport>()},
                                            {"result.essential", member_table<EssentialParameters>()},
                                            {"result.physical", member_table<PhysicalParameters>()},
                                            {"result.iterations", member_table<IvIteration>()},
                                            {"result.loop", member_table<LoopDiagnosis>()},
                                            {"limits", limits_list()},
                                            {"plan.parameters", member_table<ForecastParameter>()},
                                            {"plan.limits", member_table<LimitUse>()},
                                            {"plan.clearances", member_table<ClearanceUse>()},
                                            {"plan.joints", member_table<JointInformation>()},
                                            {"plan.comparison", member_table<PlanComparison::Parameter>()},
                                            {"plan.check", member_table<PlanCheck::ParameterRatio>()},
                                            {"plan.check_joints", member_table<PlanCheck::JointRatio>()},
                                            {"plan.starts", member_table<StartReport>()}};
  for (const auto& [name, rows] : key_rows()) {
    for (const KeyRow& row : rows) {
      out[name] += item_of(row.key, value_of(row), row.meaning);
    }
  }
  return out;
}

std::string with_tables(const std::string& page) {
  constexpr std::string_view begin = "<!-- table: ";
  constexpr std::string_view end = " -->";
  const std::map<std::string, std::string> tables = page_tables();
  std::string out;
  bool skips = false;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    skips = skips && (line.starts_with("- `") || line.starts_with("  "));
    if (!skips) {
      out += line + "\n";
    }
    if (line.starts_with(begin) && line.ends_with(end)) {
      const std::string name = line.substr(begin.size(), line.size() - begin.size() - end.size());
      const auto table = tables.find(name);
      if (table == tables.end()) {
        throw InputError("there is no table " + in_quotes(name));
      }
      out += table->second;
      skips = true;
    }
  }
  return out;
}

}  // namespace rivid::detail
