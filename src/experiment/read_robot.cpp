#include <algorithm>
#include <array>

#include "experiment/column_reader.hpp"
#include "experiment/identification_sections.hpp"
#include "experiment/mdh_file.hpp"
#include "rivid/model/urdf.hpp"

namespace rivid::detail {

namespace {

constexpr auto friction_words = [] {
  std::array<std::pair<std::string_view, Friction>, friction_rows.size()> out;
  std::ranges::transform(friction_rows, out.begin(),
                         [](const FrictionRow& row) { return std::pair(row.name, row.law); });
  return out;
}();

// A value for each joint: one number for all, or a list.
template <typename Value, typename Read>
void for_each_joint(TomlReader& keys, std::string_view key, Robot& robot, const Read& read,
                    Value Joint::* member) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return;
  }
  const toml::array* const list = node->as_array();
  if (list != nullptr && static_cast<Index>(list->size()) != robot.size()) {
    keys.fail(*node, key,
              "has " + std::to_string(list->size()) + " entries, must have one for each of the " +
                  std::to_string(robot.size()) + " joints, or be a single value for all");
  }
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    robot.joints[j].*member = read(list != nullptr ? *list->get(j) : *node);
  }
}

void read_joint_options(TomlReader& keys, Robot& robot) {
  for_each_joint(
      keys, "friction", robot,
      [&](const toml::node& n) { return keys.as_choice(n, "friction", friction_words); }, &Joint::friction);
  for_each_joint(
      keys, "rotor_inertia", robot, [&](const toml::node& n) { return keys.as_boolean(n, "rotor_inertia"); },
      &Joint::rotor_inertia);
  const auto numbers = [&](std::string_view key, double Joint::* member) {
    for_each_joint(keys, key, robot, [&](const toml::node& n) { return keys.as_number(n, key); }, member);
  };
  numbers("sign_speed", &Joint::sign_speed);
  numbers("drive_gain", &Joint::drive_gain);
  numbers("gear_ratio", &Joint::gear_ratio);
}

void read_joint(TomlReader keys, Joint& joint) {
  joint.friction = keys.choice("friction", friction_words).value_or(joint.friction);
  joint.rotor_inertia = keys.boolean("rotor_inertia").value_or(joint.rotor_inertia);
  joint.sign_speed = keys.number("sign_speed").value_or(joint.sign_speed);
  joint.drive_gain = keys.number("drive_gain").value_or(joint.drive_gain);
  joint.gear_ratio = keys.number("gear_ratio").value_or(joint.gear_ratio);
  joint.Ia = keys.number("Ia").value_or(joint.Ia);
  joint.Fv = keys.number("Fv").value_or(joint.Fv);
  joint.Fc = keys.number("Fc").value_or(joint.Fc);
  keys.finish();
}

Coupling read_coupling(TomlReader keys, const Robot& robot) {
  const auto joint = [&](const toml::node& node, std::string_view key) {
    return static_cast<int>(joint_index(keys, node, key, keys.as_text(node, key), robot));
  };
  Coupling out;
  const toml::node* const motor = keys.find("motor");
  const toml::node* const joints = keys.find("joints");
  if (motor == nullptr || joints == nullptr) {
    keys.fail("must name motor and joints: { motor = \"joint_6\", joints = [\"joint_5\"] }");
  }
  out.motor = joint(*motor, "motor");
  if (const toml::array* const list = joints->as_array()) {
    for (const toml::node& item : *list) {
      out.joints.push_back(joint(item, "joints"));
    }
  } else {
    out.joints.push_back(joint(*joints, "joints"));
  }
  out.ratios = keys.numbers("ratios").value_or(std::vector<double>(out.joints.size(), 1.0));
  out.inertia = keys.choice("inertia",
                            std::array<std::pair<std::string_view, Coupling::Inertia>, 3>{
                                {{"none", Coupling::Inertia::none},
                                 {"free", Coupling::Inertia::free},
                                 {"tied", Coupling::Inertia::tied}}})
                    .value_or(out.inertia);
  out.viscous = keys.boolean("viscous").value_or(out.viscous);
  out.coulomb = keys.choice("coulomb",
                            std::array<std::pair<std::string_view, Coupling::Coulomb>, 3>{
                                {{"none", Coupling::Coulomb::none},
                                 {"sum", Coupling::Coulomb::sum},
                                 {"single", Coupling::Coulomb::single}}})
                    .value_or(out.coulomb);
  out.terms = keys.choice("terms",
                          std::array<std::pair<std::string_view, Coupling::Terms>, 2>{
                              {{"cross", Coupling::Terms::cross}, {"all", Coupling::Terms::all}}})
                  .value_or(out.terms);
  out.Iam = keys.number("Iam").value_or(out.Iam);
  out.Fvm = keys.number("Fvm").value_or(out.Fvm);
  out.Fcm = keys.number("Fcm").value_or(out.Fcm);
  keys.finish();
  return out;
}

void read_couplings(TomlReader& keys, Robot& robot) {
  const toml::node* const node = keys.find("coupling");
  if (node == nullptr) {
    return;
  }
  const toml::array* const list = node->as_array();
  if (list == nullptr) {
    keys.fail(*node, "coupling", "must be a list of tables: [[robot.coupling]] before each");
  }
  for (const toml::node& item : *list) {
    robot.couplings.push_back(
        read_coupling(TomlReader(keys.as_table(item, "coupling"), keys.file(), "robot.coupling"), robot));
  }
}

}  // namespace

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
  UrdfOptions options;
  options.base = keys.text("base").value_or("");
  options.tip = keys.text("tip").value_or("");
  if (const auto gravity = keys.numbers("gravity")) {
    if (gravity->size() != 3) {
      keys.fail(*keys.find("gravity"), "gravity",
                "has " + std::to_string(gravity->size()) +
                    " entries, must have three: the acceleration of free fall in the base frame, in m/s²");
    }
    options.gravity = Eigen::Vector3d((*gravity)[0], (*gravity)[1], (*gravity)[2]);
  }
  const auto urdf = file_named(keys, "urdf", folder);
  const auto mdh = file_named(keys, "mdh", folder);
  if (urdf.has_value() == mdh.has_value()) {
    keys.look_for_mistyped({"urdf", "mdh"});
    keys.fail(urdf ? "names both urdf and mdh, must name one" : "names no robot, must name urdf or mdh");
  }
  for (const char* const link : {"base", "tip"}) {
    if (mdh && keys.find(link) != nullptr) {
      keys.fail(*keys.find(link), link,
                "goes with urdf: a table describes the chain from its base to its tip");
    }
  }
  robot_file = urdf.value_or(mdh.value_or(folder));
  Robot robot = urdf ? read_urdf(robot_file, options) : read_mdh(robot_file, options.gravity);
  robot.base_tolerance = keys.number("base_tolerance").value_or(robot.base_tolerance);
  read_joint_options(keys, robot);
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
  if (const auto complaint = robot.complaint()) {
    keys.fail(*complaint);
  }
  return robot;
}

}  // namespace rivid::detail
