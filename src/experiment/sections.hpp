#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/text_file.hpp"
#include "experiment/toml_reader.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/model/urdf.hpp"

// The sections of an experiment file.
namespace rivid::detail {

/// Keys of [robot] beside the fields of its joints, of [control], [reference] and [method] that choose what else is read.
inline constexpr auto robot_keys = std::tuple(
    Field{"urdf",
          nullptr,
          "URDF file. Either `urdf` or `mdh` must be there, not both.",
          {.type = "string", .otherwise = "–"}},
    Field{"mdh",
          nullptr,
          "modified Denavit-Hartenberg table, see [below](#the-mdh-table)",
          {.type = "string", .otherwise = "–"}},
    Field{"base",
          [](const Robot& robot) { return robot.base; },
          "URDF only: link that stands still",
          {.otherwise = "root of the tree"}},
    Field{"tip",
          nullptr,
          "URDF only: link that the chain ends at. Required where the robot branches.",
          {.type = "string", .otherwise = "the only moving link with no moving link behind it"}},
    Field{"gravity",
          [](const Robot& robot) -> const Eigen::Vector3d& { return robot.chain.gravity; },
          "acceleration of free fall in the frame of the base: it points down",
          {.type = "three numbers", .otherwise = "`[0, 0, -9.80665]`", .unit = "m/s²"}},
    Field{"base_tolerance",
          &Robot::base_tolerance,
          "parameters count as one where their columns of the regressor differ by less than this fraction of "
          "the largest column of the same unit, see [rounded angles](#rounded-angles)",
          {.range = Range::between(0.0, 1.0)}},
    Field{"gear_matrix",
          [](const Robot& robot) -> const Matrix& { return robot.gear_matrix; },
          "R of q_motor = R q and τ = Rᵀ τ_motor where gears mix the joints, one list a motor; without "
          "`gear_ratio`. See [coupled motors and gears](coupling.md#gears).",
          {.type = "n lists of n numbers", .otherwise = "diagonal of `gear_ratio`"}},
    Field{"coupling",
          nullptr,
          "motors that several joints turn, see [below](#robotcoupling)",
          {.type = "list of tables", .otherwise = "–"}},
    Field{"joints",
          nullptr,
          "options of single joints by their name, see the next table",
          {.type = "table of tables", .otherwise = "–"}});

/// Of [method], beside the fields of its records.
inline constexpr auto method_keys =
    std::tuple(Field{"name",
                     nullptr,
                     "`\"ols\"`: ordinary least squares (15–19). `\"wls\"`: each joint's rows weighted by "
                     "one over the deviation of a fit to these rows alone (20). `\"iv\"`: instrumental "
                     "variables from the simulated closed loop (27–34), which needs `[control]`. `\"auto\"`: "
                     "`\"iv\"` with "
                     "`[control]` and a reference, else, or where that gives no answer, `\"wls\"`. "
                     "`\"didim\"` and `\"output_error\"` compare the torques and the positions of that loop "
                     "with the log, see [statistics](statistics.md#didim-and-output-error).",
                     {.type = "word", .otherwise = "`\"auto\"`"}},
               Field{"physical",
                     nullptr,
                     "whether the nearest physically consistent standard parameters are reported beside "
                     "the plain estimate, by any method; a table gives options, see [below](#methodphysical)",
                     {.type = "boolean, or table", .otherwise = "`false`"}},
               Field{"essential",
                     nullptr,
                     "whether the essential parameters, those that the data need, are reported beside all "
                     "of them, by any method, see [statistics](statistics.md#the-parameters-that-matter). A "
                     "table gives options, see [below](#methodessential).",
                     {.type = "boolean, or table", .otherwise = "`false`"}},
               Field{"gains",
                     nullptr,
                     "`\"known\"`: those of `[robot]` are exact; `\"estimate\"`: they are estimated before "
                     "the parameters, whose standard deviations then contain those of the gains, see "
                     "[drive gains](payload.md#drive-gains). A table gives what is known, see "
                     "[below](#methodgains).",
                     {.type = "`\"known\"`, `\"estimate\"`, or table", .otherwise = "`\"known\"`"}});
inline constexpr auto gain_keys =
    std::tuple(Field{"loaded",
                     nullptr,
                     "logs with a payload of known mass; columns and units as in `[log]`",
                     {.type = "string or list", .otherwise = "–"}});
inline constexpr auto iv_keys = std::tuple(
    Field{"simulation",
          nullptr,
          "integration of the simulated loop: keys of [`[simulation]`](#simulation) from "
          "`dry_friction` to `max_velocity`; `max_seconds` is for all simulations of a log together",
          {.type = "table", .otherwise = "as there"}});

/// What is named before the rest of [control] and of [reference] can be read.
inline constexpr auto control_keys = std::tuple(Field{"law",
                                                      nullptr,
                                                      "the law, by the word of one of the tables below",
                                                      {.type = "word", .otherwise = "required"}});
inline constexpr auto reference_keys = std::tuple(Field{"type",
                                                        nullptr,
                                                        "`\"logged\"`, `\"fourier\"` or `\"point_to_point\"`",
                                                        {.type = "word", .otherwise = "required"}});

/// Of a [[montecarlo.trial]], beside those of [method].
inline constexpr auto trial_keys = std::tuple(
    Field{"label",
          nullptr,
          "what its rows are called after, without a comma",
          {.type = "string", .otherwise = "required"}},
    Field{
        "signal", nullptr, "keys of `[signal]` for this trial", {.type = "table", .otherwise = "`[signal]`"}},
    Field{"control",
          nullptr,
          "the controller that identification assumes, where it is not the actual one",
          {.type = "table", .otherwise = "`[control]`"}});

/// [robot].
///
/// @param folder      of the experiment file
/// @param robot_file  is set to the URDF or the table that the section names
[[nodiscard]] Robot read_robot(TomlReader keys, const std::filesystem::path& folder,
                               std::filesystem::path& robot_file);

/// Robot of a modified Denavit-Hartenberg table in a CSV file with the header
/// `joint,type,alpha,a,d,theta` (names may go on: alpha_prev_rad, a_prev_m, d_m, theta_offset_rad), type R or P,
/// angles in radians, lengths in metres.
///
/// @throws InputError with file and line where the table can not be read
[[nodiscard]] Robot read_mdh(const std::filesystem::path& path, const Eigen::Vector3d& gravity);

/// The same of a table that was read already.
[[nodiscard]] Robot mdh_robot(const TextTable& text, const std::string& name, const Eigen::Vector3d& gravity);

/// Keys of [robot] that choose the chain of a URDF; `gravity` is for tables too.
[[nodiscard]] UrdfOptions read_urdf_options(TomlReader& keys);

/// Refuses those that a table has no use for.
void refuse_links_of_table(TomlReader& keys);

/// A robot with what [robot] says of it beside its description.
[[nodiscard]] Robot with_options(TomlReader keys, Robot robot);

/// Base to tip.
[[nodiscard]] std::vector<std::string> joint_names(const Robot& robot);

/// The joint whose name a node holds.
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

/// A path relative to the experiment file's folder.
[[nodiscard]] std::filesystem::path file_at(const TomlReader& keys, const toml::node& node,
                                            std::string_view key, const std::filesystem::path& folder);
/// The same of a key that may be absent.
[[nodiscard]] std::optional<std::filesystem::path> file_named(TomlReader& keys, std::string_view key,
                                                              const std::filesystem::path& folder);

/// One column a joint, or `otherwise` where the key is absent: "q1", 3, or { column = "q1", unit = "deg", sign = -1,
/// scale = 2.0, offset = 0.1 }; the offset is in SI units.
///
/// @param unit  factor to SI where a column does not give its own
/// @param n     joints
[[nodiscard]] std::vector<Column> read_columns(TomlReader& keys, std::string_view key, double unit,
                                               const std::vector<Column>& otherwise, Index n);

/// Columns of a file that holds a reference motion: position, time, rate_hz, units.
///
/// @param columns   `reference` and `time` hold where the keys are absent
/// @param velocity  whether velocity is a key too
[[nodiscard]] LogOptions read_reference_columns(TomlReader& keys, LogOptions columns, Index n, bool velocity);

/// Lists of numbers, row by row, nothing where the key is absent.
///
/// @param rows, columns  −1: any number, the same in each row
/// @param required       what the key must be, for the message of any other
[[nodiscard]] std::optional<Matrix> read_matrix(TomlReader& keys, std::string_view key, Index rows,
                                                Index columns, const std::string& required);

}  // namespace rivid::detail
