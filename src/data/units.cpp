#include <array>
#include <numbers>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

struct Unit {
  std::string_view name;
  double scale;
};

constexpr double degree = std::numbers::pi / 180.0;
constexpr std::array units = {Unit{"1", 1.0},
                              Unit{"rad", 1.0},
                              Unit{"deg", degree},
                              Unit{"m", 1.0},
                              Unit{"mm", 1e-3},
                              Unit{"um", 1e-6},
                              Unit{"s", 1.0},
                              Unit{"ms", 1e-3},
                              Unit{"us", 1e-6},
                              Unit{"ns", 1e-9},
                              Unit{"Nm", 1.0},
                              Unit{"mNm", 1e-3},
                              Unit{"kNm", 1e3},
                              Unit{"N·m", 1.0},
                              Unit{"N", 1.0},
                              Unit{"kN", 1e3},
                              Unit{"V", 1.0},
                              Unit{"mV", 1e-3},
                              Unit{"A", 1.0},
                              Unit{"mA", 1e-3},
                              Unit{"rad/s", 1.0},
                              Unit{"deg/s", degree},
                              Unit{"rpm", std::numbers::pi / 30.0},
                              Unit{"m/s", 1.0},
                              Unit{"mm/s", 1e-3}};

}  // namespace

double unit_scale(std::string_view unit) {
  for (const Unit& known : units) {
    if (known.name == unit) {
      return known.scale;
    }
  }
  throw InputError("unit_scale: " + unit_complaint(unit).value_or(""));
}

std::optional<std::string> unit_complaint(std::string_view unit) {
  std::vector<std::string> names;
  for (const Unit& known : units) {
    if (known.name == unit) {
      return std::nullopt;
    }
    names.emplace_back(known.name);
  }
  return in_quotes(unit) + " is no known unit; the units are " + listed(names) + did_you_mean(unit, names);
}

}  // namespace rivid
