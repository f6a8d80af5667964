#include <algorithm>
#include <array>
#include <cctype>

#include "experiment/sections.hpp"
#include "rivid/model/mdh.hpp"

namespace rivid::detail {

namespace {

void read_joint(TomlReader keys, Joint& joint) {
  keys.read(joint);
  keys.read(Joint::a_priori(), joint);
  keys.finish();
}

Coupling read_coupling(TomlReader keys, const Robot& robot) {
  const auto joint = [&](const toml::node& node, std::string_view key) {
    return static_cast<int>(joint_index(keys, node, key, keys.as<std::string>(node, key), robot));
  };
  Coupling out;
  const toml::node* const motor = keys.find("motor");
  const toml::node* const joints = keys.find("joints");
  if (motor == nullptr || joints == nullptr) {
    keys.fail("must name motor and joints: { motor = \"joint_6\", joints = [\"joint_5\"] }");
  }
  out.motor = joint(*motor, "motor");
  for (const toml::node* const item : TomlReader::items(*joints)) {
    out.joints.push_back(joint(*item, "joints"));
  }
  out.ratios.assign(out.joints.size(), 1.0);
  keys.read(out);
  keys.read(Coupling::a_priori(), out);
  keys.finish();
  return out;
}

void read_couplings(TomlReader& keys, Robot& robot) {
  const toml::node* const node = keys.find("coupling");
  if (node == nullptr) {
    return;
  }
  if (!node->is_array()) {
    keys.fail(*node, "coupling", "must be a list of tables: [[robot.coupling]] before each");
  }
  for (const toml::node* const item : TomlReader::items(*node)) {
    robot.couplings.push_back(read_coupling(keys.section(*item, "coupling"), robot));
  }
}

}  // namespace

UrdfOptions read_urdf_options(TomlReader& keys) {
  UrdfOptions options;
  options.base = keys.get<std::string>("base").value_or("");
  options.tip = keys.get<std::string>("tip").value_or("");
  if (const auto gravity = keys.get<std::vector<double>>("gravity")) {
    if (gravity->size() != 3) {
      keys.fail(*keys.find("gravity"), "gravity",
                "has " + std::to_string(gravity->size()) +
                    " entries, must have three: the acceleration of free fall in the base frame, in m/s²");
    }
    options.gravity = Eigen::Vector3d(gravity->data());
  }
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

Index joint_index(const TomlReader& keys, const toml::node& node, std::string_view key,
                  const std::string& name, const Robot& robot) {
  const std::vector<std::string> names = joint_names(robot);
  const auto at = std::ranges::find(names, name);
  if (at == names.end()) {
    keys.fail(node, key,
              "is no joint of robot \"" + robot.name + "\", which has " + quoted_list(names) +
                  did_you_mean(name, names));
  }
  return at - names.begin();
}

Robot read_robot(TomlReader keys, const std::filesystem::path& folder, std::filesystem::path& robot_file) {
  const UrdfOptions options = read_urdf_options(keys);
  const auto urdf = file_named(keys, "urdf", folder);
  const auto mdh = file_named(keys, "mdh", folder);
  if (urdf.has_value() == mdh.has_value()) {
    keys.look_for_mistyped({"urdf", "mdh"});
    keys.fail(urdf ? "names both urdf and mdh, must name one" : "names no robot, must name urdf or mdh");
  }
  if (mdh) {
    refuse_links_of_table(keys);
  }
  robot_file = urdf.value_or(mdh.value_or(folder));
  return with_options(std::move(keys),
                      urdf ? read_urdf(robot_file, options) : read_mdh(robot_file, options.gravity));
}

void refuse_links_of_table(TomlReader& keys) {
  for (const char* const link : {"base", "tip"}) {
    if (keys.find(link) != nullptr) {
      keys.fail(*keys.find(link), link,
                "goes with urdf: a table describes the chain from its base to its tip");
    }
  }
}

Robot with_options(TomlReader keys, Robot robot) {
  keys.read(robot_keys, robot);
  std::apply([&](const auto&... field) { (keys.read_each(field, robot.joints), ...); }, Joint::fields());
  if (auto joints = keys.section("joints")) {
    for (const auto& [key, node] : joints->table()) {
      const std::string name(key.str());
      const Index j = joint_index(*joints, node, name, name, robot);
      if (auto joint = joints->section(name)) {
        read_joint(std::move(*joint), robot.joints[static_cast<std::size_t>(j)]);
      }
    }
  }
  read_couplings(keys, robot);
  const std::string n = std::to_string(robot.size());
  if (const auto gears =
          read_matrix(keys, "gear_matrix", robot.size(), robot.size(),
                      n + " lists of " + n + " numbers: one list a motor, one number a joint")) {
    robot.gear_matrix = *gears;
  }
  keys.finish();
  keys.refuse(robot.complaint());
  return robot;
}

}  // namespace rivid::detail
