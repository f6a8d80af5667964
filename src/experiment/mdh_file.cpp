#include "experiment/mdh_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <vector>

#include "experiment/text_file.hpp"
#include "rivid/error.hpp"
#include "rivid/model/mdh.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr std::array<std::string_view, 6> fields = {"joint", "type", "alpha", "a", "d", "theta"};

// "alpha_prev_rad" is the column "alpha".
std::string stem(const std::string& title) { return title.substr(0, title.find('_')); }

// Place of each field among the columns.
std::array<std::size_t, fields.size()> places(const TextTable::Row& header) {
  const std::vector<std::string>& titles = header.cells;
  std::array<std::size_t, fields.size()> out{};
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const auto at = std::ranges::find_if(titles, [&](const std::string& t) { return stem(t) == fields[f]; });
    if (at == titles.end()) {
      throw InputError(header.place + ": the header has no column \"" + std::string(fields[f]) +
                       "\"; a modified Denavit-Hartenberg table has joint, type, alpha, a, d and theta");
    }
    out[f] = static_cast<std::size_t>(at - titles.begin());
  }
  return out;
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
  const TextTable text = read_text_table(path, "the file");
  std::vector<MdhRow> table;
  const auto at = text.rows.empty() ? std::array<std::size_t, fields.size()>{} : places(text.header);
  for (const TextTable::Row& row : text.rows) {
    const auto value = [&](std::size_t f) { return cell_number(row, at[f], fields[f]); };
    // A joint that is only numbered gets the name that read_mdh's robots have anyway.
    const std::string& name = row.cells[at[0]];
    const bool numbered = std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c) != 0; });
    table.push_back({.type = joint_type(row.cells[at[1]], row.place),
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
