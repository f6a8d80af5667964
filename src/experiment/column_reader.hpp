#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/toml_reader.hpp"
#include "rivid/data/csv.hpp"

// What the sections of an experiment file that name files and columns share.
namespace rivid::detail {

/// A path relative to the experiment file's folder.
[[nodiscard]] std::filesystem::path file_at(const TomlReader& keys, const toml::node& node,
                                            std::string_view key, const std::filesystem::path& folder);
/// The same of a key that may be absent.
[[nodiscard]] std::optional<std::filesystem::path> file_named(TomlReader& keys, std::string_view key,
                                                              const std::filesystem::path& folder);

/// Factors to SI, one for each quantity: units = { position = "deg", torque = "mNm" }.
class Units {
 public:
  explicit Units(TomlReader& keys);

  [[nodiscard]] double operator()(std::string_view quantity);

  /// A unit without the columns that it is of would be passed over in silence.
  void finish(TomlReader& keys) const;

 private:
  static constexpr std::array<std::string_view, 7> quantities = {
      "position", "velocity", "torque", "control", "reference", "reference_velocity", "time"};

  std::set<std::string> idle_;  // quantities whose unit is told and was not asked for
  std::array<double, quantities.size()> scales_ = {1, 1, 1, 1, 1, 1, 1};
};

/// "q1", 3, or { column = "q1", unit = "deg", sign = -1, scale = 2.0, offset = 0.1 }; the offset is in SI units.
///
/// @param unit  factor to SI where the column does not tell its own
[[nodiscard]] Column read_column(const TomlReader& keys, const toml::node& node, std::string_view key,
                                 double unit);

/// One column a joint, or `otherwise` where the key is absent.
///
/// @param unit  as for read_column()
/// @param n     joints
[[nodiscard]] std::vector<Column> read_columns(TomlReader& keys, std::string_view key, double unit,
                                               const std::vector<Column>& otherwise, Index n);
/// The same with the unit of the quantity that the key is called after.
[[nodiscard]] std::vector<Column> read_columns(TomlReader& keys, std::string_view key, Units& units,
                                               const std::vector<Column>& otherwise, Index n);

/// Columns of a file that holds a reference motion: position, time, rate_hz, units.
///
/// @param columns   `reference` and `time` hold where the keys are absent
/// @param velocity  whether velocity is a key too
[[nodiscard]] LogOptions read_reference_columns(TomlReader& keys, LogOptions columns, Index n, bool velocity);

/// A value a joint: one number for all, or a list. Empty where the key is absent.
[[nodiscard]] Vector read_per_joint(TomlReader& keys, std::string_view key, Index n);

/// Lists of numbers, row by row, nothing where the key is absent.
///
/// @param rows, columns  −1: any number, the same in each row
/// @param required       what the key must be, for the message of any other
[[nodiscard]] std::optional<Matrix> read_matrix(TomlReader& keys, std::string_view key, Index rows,
                                                Index columns, const std::string& required);

}  // namespace rivid::detail
