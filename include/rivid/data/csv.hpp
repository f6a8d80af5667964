#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/data/table.hpp"
#include "rivid/fields.hpp"

namespace rivid {

/// A column of a file and what turns its values into SI units on the joint side: scale · x + offset.
struct Column {
  std::string name;    ///< or "#3": the third field of each line
  double scale = 1.0;  ///< see unit_scale(); a gear ratio, a drive gain, a sign
  double offset = 0.0;

  template <typename R = Column>
  static constexpr auto fields() {
    return std::tuple(
        Field{"column",
              shown_key<std::variant<std::string, int>>([](const R& r) { return r.name; }),
              "name or number of the column",
              {.required = "must say which column: { column = \"q1\", unit = \"deg\", sign = -1 }"}},
        Field{"unit", Key<std::string>(), "unit of the column", {.otherwise = "that of `units`"}},
        Field{"scale", &R::scale, "factor beside the unit"},
        Field{"sign", Key<int>(), "1 or −1, a factor too", {.otherwise = "1", .range = Range::within(-1, 1)}},
        Field{
            "offset", &R::offset, "added last: value = unit × scale × sign × cell + offset", {.unit = "SI"}});
  }
};

/// Units by the quantities whose columns have them: "position", "deg".
using UnitNames = std::map<std::string, std::string>;

/// Which columns of a file are what. A list that is empty stands for its default names, counted from 1
/// without a gap; only positions must be there.
struct LogOptions {
  std::vector<Column> position = {};            ///< q; default q1, q2, …
  std::vector<Column> velocity = {};            ///< q̇; default qd1, …
  std::vector<Column> torque = {};              ///< τ; default tau1, …
  std::vector<Column> control = {};             ///< v_τ; default v1, …
  std::vector<Column> reference = {};           ///< q_r; default qref1, …
  std::vector<Column> reference_velocity = {};  ///< q̇_r; default qdref1, …
  std::optional<Column> time = {};              ///< default t, else time; its scale is that of its unit
  /// Sampling rate [Hz]. Where it is stated it is used exactly, and a time column is only inspected.
  std::optional<double> rate_hz = {};
  /// If false, only the listed columns are read (and the time column if `rate_hz` is absent).
  /// Default names are those of docs/experiment.md.
  bool default_names = true;
  TableOptions table = {};  ///< how the file is written; its `columns` must be empty

  /// The first fault found, nothing if the options can be used.
  [[nodiscard]] std::optional<std::string> complaint() const;

  template <typename L = LogOptions>
  static constexpr auto fields() {
    const auto columns = [](std::string_view key, std::vector<Column> L::* member, std::string_view otherwise,
                            std::string_view unit, std::string_view meaning) {
      return Field{key, member, meaning, {.otherwise = otherwise, .unit = unit}};
    };
    return std::tuple(
        columns("position", &L::position, "`q1`, `q2`, …", "rad, m", "measured joint positions"),
        columns("velocity", &L::velocity, "`qd1`, …", "rad/s, m/s",
                "measured velocities; not used: q̇ and q̈ come from the positions"),
        columns("torque", &L::torque, "`tau1`, …", "N·m, N", "joint-side torques"),
        columns("control", &L::control, "`v1`, …", "V, A, …",
                "control signal or motor current; τ = g_τ v_τ (8). Used where there are no torques."),
        columns("reference", &L::reference, "`qref1`, …", "rad, m",
                "reference positions. Not used by least squares."),
        columns("reference_velocity", &L::reference_velocity, "`qdref1`, …", "rad/s, m/s",
                "reference velocities. Not used by least squares."),
        Field{"time", &L::time, "time stamps", {.otherwise = "`t`, else `time`", .unit = "s"}},
        Field{"rate_hz",
              &L::rate_hz,
              "sampling rate, which replaces the time stamps. Required without a time column.",
              {.otherwise = "from the stamps", .unit = "Hz", .range = rate_range}},
        embedded(&L::table));
  }
};

/// Reads the log of an experiment from a text file, see read_table() for what such a file may look like.
///
/// Irregular time stamps are reported in the notes and do not stop the reading; Log::complaint() finds them,
/// and regularised() repairs them. Without a time column `rate_hz` is required and t starts at 0.
///
/// @throws InputError  for what read_table() refuses; where positions, or both time and rate, are missing;
///                     where a quantity has not one column for each joint
[[nodiscard]] Log read_csv(const std::filesystem::path& path, const LogOptions& options = {});

/// Reads a reference motion from a file of its own: as read_csv(), but what must be there is the reference,
/// not the positions. See with_reference().
[[nodiscard]] Log read_reference(const std::filesystem::path& path, const LogOptions& options = {});

/// A log as text that read_csv() reads without options: default names, SI units, one column each for what is
/// not empty. Numbers are the shortest ones that read back bit by bit.
///
/// @throws InputError  where columns have other lengths
[[nodiscard]] std::string to_csv(const Log& log);

}  // namespace rivid
