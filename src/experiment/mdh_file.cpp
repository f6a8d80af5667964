#include "experiment/mdh_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/mdh.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
constexpr std::array<std::string_view, 6> fields = {"joint", "type", "alpha", "a", "d", "theta"};

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out(1);
  for (const char c : line) {
    if (c == ',' || c == ';') {
      out.emplace_back();
    } else if (c != ' ' && c != '\t' && c != '\r' && c != '"') {
      out.back() += c;
    }
  }
  return out;
}

// "alpha_prev_rad" is the column "alpha".
std::string stem(const std::string& title) { return title.substr(0, title.find('_')); }

// Place of each field among the columns.
std::array<std::size_t, fields.size()> places(const std::vector<std::string>& titles,
                                              const std::string& where) {
  std::array<std::size_t, fields.size()> out{};
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const auto at = std::ranges::find_if(titles, [&](const std::string& t) { return stem(t) == fields[f]; });
    if (at == titles.end()) {
      throw InputError(where + ": the header has no column \"" + std::string(fields[f]) +
                       "\"; a modified Denavit-Hartenberg table has joint, type, alpha, a, d and theta");
    }
    out[f] = static_cast<std::size_t>(at - titles.begin());
  }
  return out;
}

double parsed(const std::string& cell, std::string_view field, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    throw InputError(where + ": column \"" + std::string(field) + "\" holds \"" + cell +
                     "\"; must be a finite number");
  }
  return value;
}

JointType joint_type(const std::string& cell, const std::string& where) {
  if (cell == "R" || cell == "revolute") {
    return JointType::revolute;
  }
  if (cell == "P" || cell == "prismatic") {
    return JointType::prismatic;
  }
  throw InputError(where + ": column \"type\" holds \"" + cell + "\"; must be R or P");
}

}  // namespace

Robot read_mdh(const std::filesystem::path& path, const Eigen::Vector3d& gravity) {
  std::ifstream in(path);
  if (!in) {
    throw InputError(path.string() + ": the file can not be read");
  }
  std::vector<MdhRow> table;
  std::array<std::size_t, fields.size()> at{};
  std::size_t width = 0;
  std::string line;
  for (int count = 1; std::getline(in, line); ++count) {
    const std::string where = path.string() + ":" + std::to_string(count);
    if (count == 1 && line.starts_with(byte_order_mark)) {
      line.erase(0, byte_order_mark.size());
    }
    const std::vector<std::string> row = cells(line);
    if ((row.size() == 1 && row[0].empty()) || row[0].starts_with('#')) {
      continue;
    }
    if (width == 0) {
      at = places(row, where);
      width = row.size();
      continue;
    }
    if (row.size() != width) {
      throw InputError(where + ": " + std::to_string(row.size()) + " fields, the header has " +
                       std::to_string(width));
    }
    const auto value = [&](std::size_t f) { return parsed(row[at[f]], fields[f], where); };
    // A joint that is only numbered gets the name that read_mdh's robots have anyway.
    const std::string& name = row[at[0]];
    const bool numbered = std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c) != 0; });
    table.push_back({.type = joint_type(row[at[1]], where),
                     .alpha = value(2),
                     .a = value(3),
                     .d = value(4),
                     .theta = value(5),
                     .name = numbered ? "" : name});
  }
  if (table.empty()) {
    throw InputError(path.string() + ": the table has no joint");
  }
  Robot robot = [&] {
    try {
      return robot_from(table, gravity);
    } catch (const InputError& e) {
      throw InputError(path.string() + ": " + e.what());
    }
  }();
  robot.name = path.stem().string();
  return robot;
}

}  // namespace rivid::detail
