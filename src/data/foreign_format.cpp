#include "foreign_format.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

namespace rivid::detail {

namespace {

// python/rivid/formats/__init__.py has the same table for the program that converts.
struct ForeignFormat {
  std::string_view beginning;
  std::string_view name;
  std::string_view extra;  // of the Python package; empty where it needs none
};

using namespace std::string_view_literals;

constexpr std::array foreign_formats = {
    ForeignFormat{"\x89MCAP0\r\n"sv, "an MCAP bag", "ros"},
    ForeignFormat{"SQLite format 3\0"sv, "a rosbag2 bag (SQLite)", "ros"},
    ForeignFormat{"#ROSBAG V2.0"sv, "a ROS 1 bag", "ros"},
    ForeignFormat{"PAR1"sv, "a Parquet file", "parquet"},
    ForeignFormat{"ARROW1"sv, "a Feather file", "parquet"},
    ForeignFormat{"FEA1"sv, "a Feather file", "parquet"},
    ForeignFormat{"PK\x03\x04"sv, "a zip archive, as NumPy's .npz and spreadsheets are", ""},
    ForeignFormat{"\x93NUMPY"sv, "a NumPy file", ""},
    ForeignFormat{"MATLAB 5.0 MAT-file"sv, "a MATLAB file", "matlab"},
    ForeignFormat{"MATLAB 7.3 MAT-file"sv, "a MATLAB file", "matlab"},
    ForeignFormat{"\x89HDF\r\n\x1a\n"sv, "an HDF5 file", "matlab"}};

// Files of rivid that are no logs.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> others = {
    {{".toml", "an experiment file"}, {".urdf", "a robot"}, {".json", "a result"}}};

}  // namespace

std::optional<std::string> foreign_format(std::string_view bytes, const std::string& path) {
  const auto other =
      std::ranges::find_if(others, [&](const auto& each) { return path.ends_with(each.first); });
  if (other != others.end()) {
    return "is " + std::string(other->second) + ", a log is required";
  }
  const auto found = std::ranges::find_if(
      foreign_formats, [&](const ForeignFormat& format) { return bytes.starts_with(format.beginning); });
  if (found == foreign_formats.end()) {
    return std::nullopt;
  }
  const std::string target = std::filesystem::path(path).replace_extension(".csv").string();
  const std::string package = found->extra.empty() ? "rivid" : "rivid[" + std::string(found->extra) + "]";
  return "is " + std::string(found->name) + ", a CSV file is required; the Python package " + package +
         " makes one: rivid convert " + path + " " + target;
}

}  // namespace rivid::detail
