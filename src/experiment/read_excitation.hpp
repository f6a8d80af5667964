#pragma once

#include <filesystem>
#include <vector>

#include "experiment/toml_reader.hpp"
#include "rivid/excite/excitation.hpp"

namespace rivid::detail {

/// Of [excitation], beside the fields of its records.
inline constexpr auto excitation_keys =
    std::tuple(Field{"known",
                     nullptr,
                     "earlier logs, whose information the design adds to; `[log]` and `[signal]` say how "
                     "they are read",
                     {.type = "string or list", .otherwise = "–"}},
               Field{"limits",
                     nullptr,
                     "what the motion must keep to, see [below](#excitationlimits)",
                     {.type = "table", .otherwise = "those of the robot"}});

/// [excitation]
///
/// @param known  is set to the earlier logs that it names
[[nodiscard]] ExcitationOptions read_excitation_options(TomlReader keys, const std::filesystem::path& folder,
                                                        const Robot& robot,
                                                        std::vector<std::filesystem::path>& known);

}  // namespace rivid::detail
