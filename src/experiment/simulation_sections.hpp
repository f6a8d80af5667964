#pragma once

#include <filesystem>
#include <optional>

#include "experiment/toml_reader.hpp"
#include "rivid/experiment/experiment.hpp"

// The sections of an experiment file that a simulated loop is made of.
namespace rivid::detail {

/// [control]
[[nodiscard]] ControlLoop read_control(TomlReader keys, const Robot& robot);

/// [reference]
///
/// @param folder  of the experiment file
/// @param n       joints
[[nodiscard]] ReferenceSource read_reference_source(TomlReader keys, const std::filesystem::path& folder,
                                                    Index n);

/// [simulation]
///
/// @param control  of the same file, where there is one: what is not said follows it
[[nodiscard]] SimulationPlan read_simulation(TomlReader keys, const std::filesystem::path& folder, Index n,
                                             const std::optional<ControlLoop>& control);

}  // namespace rivid::detail
