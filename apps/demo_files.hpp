#pragma once

#include <string_view>

// Files of data/six_axis, which the build embeds.
namespace rivid::detail {

std::string_view six_axis_urdf();
std::string_view six_axis_toml();
std::string_view simulate_toml();
std::string_view reference_csv();

}  // namespace rivid::detail
