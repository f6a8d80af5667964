#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/toml_reader.hpp"
#include "rivid/experiment/experiment.hpp"

// The sections of an experiment file that tell what is identified, from what and how.
namespace rivid::detail {

/// [robot].
///
/// @param folder      of the experiment file
/// @param robot_file  is set to the URDF or the table that the section names
[[nodiscard]] Robot read_robot(TomlReader keys, const std::filesystem::path& folder,
                               std::filesystem::path& robot_file);

/// Base to tip.
[[nodiscard]] std::vector<std::string> joint_names(const Robot& robot);

/// The joint of that name, which `key` in `keys` gives.
[[nodiscard]] Index joint_index(const TomlReader& keys, const toml::node& node, std::string_view key,
                                const std::string& name, const Robot& robot);

/// [log] or [validation].
///
/// @param out     what holds where the section does not say it itself; its files are not taken over
/// @param folder  of the experiment file
[[nodiscard]] LogSource read_log_source(TomlReader keys, LogSource out, const std::filesystem::path& folder,
                                        const Robot& robot);

/// [signal].
///
/// @param n  joints
[[nodiscard]] SignalOptions read_signal(TomlReader keys, Index n);

/// [method], for a robot that is known.
void read_method(TomlReader keys, Experiment& out);

}  // namespace rivid::detail
