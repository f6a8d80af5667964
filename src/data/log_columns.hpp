#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/data/csv.hpp"
#include "rivid/data/log.hpp"

namespace rivid::detail {

/// One of the matrices of a log, for what is done to each alike.
struct LogColumns {
  Matrix Log::* member;
  std::string_view symbol;
  bool smooth;              ///< a position, that a spline may follow
  std::string_view key;     ///< of [log]
  std::string_view prefix;  ///< of the default names of its columns
  std::vector<Column> LogOptions::* listed;
};

inline constexpr std::array<LogColumns, 6> log_columns = {
    {{&Log::q, "q", true, "position", "q", &LogOptions::position},
     {&Log::qd, "qd", false, "velocity", "qd", &LogOptions::velocity},
     {&Log::tau, "tau", false, "torque", "tau", &LogOptions::torque},
     {&Log::v_tau, "v_tau", false, "control", "v", &LogOptions::control},
     {&Log::q_r, "q_r", true, "reference", "qref", &LogOptions::reference},
     {&Log::qd_r, "qd_r", false, "reference_velocity", "qdref", &LogOptions::reference_velocity}}};

/// The column of nanoseconds that belongs to one of whole seconds: "header.stamp.nanosec" beside
/// "header.stamp.sec". Nothing where there is none.
[[nodiscard]] std::optional<std::string> nanoseconds_of(std::string_view seconds,
                                                        std::span<const std::string> names);

/// Columns that are read where a log lists none, by the keys of [log]: "position" → "q1", "q2". Quantities
/// that are counted from 0 are not among them.
[[nodiscard]] std::map<std::string, std::vector<std::string>> default_columns(
    std::span<const std::string> names);

/// Stamps of both, in seconds since the midnight (UTC) before the first one: since 1970 a double would round
/// them to a quarter of a microsecond.
[[nodiscard]] Vector stamps_of(const Eigen::Ref<const Vector>& seconds,
                               const Eigen::Ref<const Vector>& nanoseconds);

/// The part of Log::complaint() that says nothing about the regularity of the time stamps or about missing
/// positions.
[[nodiscard]] std::optional<std::string> shape_complaint(const Log& log);

/// @throws InputError  in the name of `who`, where a matrix of the log has not one row for each sample
void require_even(std::string_view who, const Log& log);

/// The log in a table that a program holds: as read_csv() makes it of a file.
///
/// @throws InputError  as read_csv() does
[[nodiscard]] Log log_of(const Table& table, const LogOptions& options);

}  // namespace rivid::detail
