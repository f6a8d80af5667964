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
                     {.type = "table", .otherwise = "those of the robot"}},
               Field{"space",
                     nullptr,
                     "what the robot must not touch, see [below](#excitationspace)",
                     {.type = "table", .otherwise = "nothing is kept clear of"}});
/// Of [excitation.space], beside those of Space.
inline constexpr auto space_keys =
    std::tuple(Field{"floor",
                     nullptr,
                     "height of the floor in the base frame",
                     {.type = "number", .otherwise = "none", .unit = "m"}},
               Field{"half_spaces",
                     nullptr,
                     "walls and ceilings, `{ normal = [x, y, z], offset = d, name = \"…\" }` each: the robot "
                     "stays where normal · x ≥ d "
                     "in the base frame",
                     {.type = "list of tables", .otherwise = "–", .unit = "m"}},
               Field{"boxes",
                     nullptr,
                     "obstacles along the axes of the base frame, `{ min = [x, y, z], max = [x, y, z], name "
                     "= \"…\" }` each",
                     {.type = "list of tables", .otherwise = "–", .unit = "m"}},
               Field{"capsules",
                     nullptr,
                     "bodies of links, `{ link = \"…\", from = [x, y, z], to = [x, y, z], radius = r }` "
                     "each: all points within r of "
                     "a line in the link's frame",
                     {.type = "list of tables", .otherwise = "between the joints", .unit = "m"}});

/// Of one of half_spaces, boxes and capsules.
inline constexpr auto half_space_keys = std::tuple(
    Field{"normal", nullptr, "direction of free space", {.type = "three numbers", .otherwise = "required"}},
    Field{"offset",
          nullptr,
          "the robot stays where normal · x is not below it",
          {.type = "number", .otherwise = "required", .unit = "m"}},
    Field{"name",
          nullptr,
          "that messages and tables call it by",
          {.type = "string", .otherwise = "its number"}});
inline constexpr auto box_keys = std::tuple(
    Field{
        "min", nullptr, "its lowest corner", {.type = "three numbers", .otherwise = "required", .unit = "m"}},
    Field{"max",
          nullptr,
          "its highest corner",
          {.type = "three numbers", .otherwise = "required", .unit = "m"}},
    Field{"name",
          nullptr,
          "that messages and tables call it by",
          {.type = "string", .otherwise = "its number"}});
inline constexpr auto capsule_keys = std::tuple(
    Field{"link", nullptr, "link that it is fixed to", {.type = "string", .otherwise = "required"}},
    Field{"from",
          nullptr,
          "one end of its line, in the link's frame",
          {.type = "three numbers", .otherwise = "required", .unit = "m"}},
    Field{"to", nullptr, "the other end", {.type = "three numbers", .otherwise = "required", .unit = "m"}},
    Field{"radius", nullptr, "about the line", {.type = "number", .otherwise = "required", .unit = "m"}});

/// [excitation]
///
/// @param known  is set to the earlier logs that it names
[[nodiscard]] ExcitationOptions read_excitation_options(TomlReader keys, const std::filesystem::path& folder,
                                                        const Robot& robot,
                                                        std::vector<std::filesystem::path>& known);

}  // namespace rivid::detail
