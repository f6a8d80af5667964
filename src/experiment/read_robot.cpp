#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>

#include "experiment/sections.hpp"
#include "rivid/model/mdh.hpp"

namespace rivid::detail {

// A motor and the joints that turn it, by their names.
void read_more(TomlReader& keys, Coupling& out) {
  out.motor = static_cast<int>(keys.joint(*keys.find("motor"), "motor"));
  for (const toml::node* const item : TomlReader::items(*keys.find("joints"))) {
    out.joints.push_back(static_cast<int>(keys.joint(*item, "joints")));
  }
  if (keys.find("ratios") == nullptr) {
    out.ratios.assign(out.joints.size(), 1.0);
  }
  keys.read(Coupling::a_priori(), out);
}

// What follows a table: its columns, those of the joint and of others.
void read_more(TomlReader& keys, DependentJoint& out) {
  const auto table = keys.get<std::filesystem::path>("table");
  auto columns = keys.get<std::vector<std::string>>("columns");
  if (!table) {
    keys.refuse_keys({"columns"}, "goes with table");
    if (out.of.empty()) {
      keys.fail("must name of or table: { joint = \"joint_3\", of = { joint_2 = -1 } }");
    }
    return;
  }
  if (out.of.empty()) {
    for (const std::string& name : column_names(*table)) {
      if (name != out.joint) {
        out.of[name] = 1.0;
      }
    }
  }
  if (out.offset != 0.0 || std::ranges::any_of(out.of, [](const auto& of) { return of.second != 1.0; })) {
    keys.fail("offset and factors are of a sum: with table must be 0 and 1");
  }
  if (!columns) {
    columns = {out.joint};
    std::ranges::transform(out.of, std::back_inserter(*columns), [](const auto& of) { return of.first; });
  }
  if (columns->size() != out.of.size() + 1) {
    keys.fail("columns lists " + counted(std::ssize(*columns), "column") +
              ", must list that of the joint and " + counted(std::ssize(out.of), "column") +
              " of those that it follows");
  }
  const Table points = read_table(*table, {.columns = *columns});
  try {
    out.curve = spline_through(points.values.rightCols(points.columns() - 1), points.values.col(0));
  } catch (const InputError& e) {
    throw InputError(points.source + ": dependent joint \"" + out.joint + "\": " + e.what());
  }
}

void read_more(TomlReader& keys, Joint& out) {
  keys.read(Joint::a_priori(), out);
  keys.read(Joint::twin(), out);
}

UrdfOptions read_urdf_options(TomlReader& keys) {
  UrdfOptions options;
  keys.set(options.base, {.key = "base"});
  keys.set(options.floating, {.key = "floating"});
  keys.set(options.tip, {.key = "tip"});
  keys.set(options.moving, {.key = "moving"});
  keys.set(options.dependent,
           {.key = "dependent", .details = {.must_be = "a list of tables: [[robot.dependent]] before each"}});
  keys.set(options.four_bars,
           {.key = "four_bar", .details = {.must_be = "a list of tables: [[robot.four_bar]] before each"}});
  keys.set(options.gravity,
           {.key = "gravity",
            .details = {.must_be = "three: the acceleration of free fall in the base frame, in m/s²"}});
  return options;
}

namespace {

constexpr std::array<std::string_view, 6> mdh_columns = {"joint", "type", "alpha", "a", "d", "theta"};

// "alpha_prev_rad" is the column "alpha".
std::string stem(const std::string& title) { return title.substr(0, title.find('_')); }

// Place of each field among the columns.
std::array<std::size_t, mdh_columns.size()> places(const TextTable::Row& header) {
  const std::vector<std::string>& titles = header.cells;
  std::array<std::size_t, mdh_columns.size()> out{};
  for (std::size_t f = 0; f < mdh_columns.size(); ++f) {
    const auto at =
        std::ranges::find_if(titles, [&](const std::string& t) { return stem(t) == mdh_columns[f]; });
    if (at == titles.end()) {
      throw InputError(header.place + ": the header has no column \"" + std::string(mdh_columns[f]) +
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
  return mdh_robot(read_text_table(path, "the file"), path.stem().string(), gravity);
}

Robot mdh_robot(const TextTable& text, const std::string& name, const Eigen::Vector3d& gravity) {
  std::vector<MdhRow> table;
  const auto at = text.rows.empty() ? std::array<std::size_t, mdh_columns.size()>{} : places(text.header);
  for (const TextTable::Row& row : text.rows) {
    const auto value = [&](std::size_t f) { return cell_number(row, at[f], mdh_columns[f]); };
    // A joint that is only numbered gets the name that read_mdh's robots have anyway.
    const std::string& joint = row.cells[at[0]];
    const bool numbered = std::ranges::all_of(joint, [](unsigned char c) { return std::isdigit(c) != 0; });
    table.push_back({.type = joint_type(row.cells[at[1]], row.place),
                     .alpha = value(2),
                     .a = value(3),
                     .d = value(4),
                     .theta = value(5),
                     .name = numbered ? "" : joint});
  }
  if (table.empty()) {
    throw InputError(text.file + ": the table has no joint");
  }
  Robot robot = [&] {
    try {
      return robot_from(table, gravity);
    } catch (const InputError& e) {
      throw InputError(text.file + ": " + e.what());
    }
  }();
  robot.name = name;
  return robot;
}

std::vector<std::string> joint_names(const Robot& robot) {
  std::vector<std::string> out;
  out.reserve(robot.joints.size());
  for (const Joint& joint : robot.joints) {
    out.push_back(joint.name);
  }
  return out;
}

Robot read_robot(TomlReader keys, std::filesystem::path& robot_file) {
  const UrdfOptions options = read_urdf_options(keys);
  const auto urdf = keys.get<std::filesystem::path>("urdf");
  const auto mdh = keys.get<std::filesystem::path>("mdh");
  if (urdf.has_value() == mdh.has_value()) {
    keys.look_for_mistyped({"urdf", "mdh"});
    keys.fail(urdf ? "names both urdf and mdh, must name one" : "names no robot, must name urdf or mdh");
  }
  if (mdh) {
    refuse_links_of_table(keys);
  }
  robot_file = urdf ? *urdf : *mdh;
  return with_options(std::move(keys),
                      urdf ? read_urdf(robot_file, options)
                           : with_dependents(read_mdh(robot_file, options.gravity), options.dependent));
}

void refuse_links_of_table(TomlReader& keys) {
  keys.refuse_keys({"base", "floating", "tip", "moving", "four_bar"},
                   "goes with urdf: a table describes the chain from its base to its tip");
}

void refuse_floating(TomlReader& keys) {
  if (keys.robot().base_joints > 0) {
    keys.fail("is for a base that stands still: take floating out of [robot]");
  }
}

Robot with_options(TomlReader keys, Robot robot) {
  keys.of(robot);
  keys.read(robot_keys, robot);
  const auto first = robot.joints.begin() + robot.base_joints;
  std::vector<Joint> driven(first, robot.joints.end());
  std::apply([&](const auto&... field) { (keys.read_each(field, driven), ...); }, Joint::fields());
  std::ranges::move(driven, first);
  if (auto joints = keys.section("joints")) {
    for (const auto& [key, node] : joints->table()) {
      const std::string name(key.str());
      const Index j = joints->joint(node, name, name);
      joints->set(robot.joints[static_cast<std::size_t>(j)], {.key = name});
    }
  }
  keys.set(robot.couplings,
           {.key = "coupling", .details = {.must_be = "a list of tables: [[robot.coupling]] before each"}});
  const Index count = keys.joints();
  const std::string n = std::to_string(count);
  if (const auto gears =
          keys.matrix("gear_matrix", count, count,
                      n + " lists of " + n + " numbers: one list a motor, one number a joint")) {
    robot.gear_matrix = Matrix::Identity(robot.size(), robot.size());
    robot.gear_matrix.bottomRightCorner(count, count) = *gears;
  }
  keys.finish();
  keys.refuse(robot.complaint());
  return robot;
}

}  // namespace rivid::detail
