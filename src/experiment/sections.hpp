#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "experiment/text_file.hpp"
#include "experiment/toml_reader.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/model/urdf.hpp"

// The sections of an experiment file.
namespace rivid::detail {

/// A key that holds one of several words.
struct Word {};

/// Keys of [robot] beside the fields of its joints, of [control], [reference] and [method] that choose what
/// else is read.
inline constexpr auto robot_keys = std::tuple(
    Field{"urdf", Key<std::filesystem::path>(), "URDF file; either this or `mdh`", {.otherwise = "–"}},
    Field{"mdh",
          Key<std::filesystem::path>(),
          "modified Denavit-Hartenberg table, see [below](#the-mdh-table)",
          {.otherwise = "–"}},
    Field{"base",
          [](const Robot& robot) { return robot.base; },
          "URDF only: link that stands still",
          {.otherwise = "root of the tree"}},
    Field{"floating",
          [](const Robot& robot) { return robot.base_joints > 0; },
          "URDF only: the root of the tree moves freely, see [floating base](#logbase)",
          {.otherwise = "`false`"}},
    Field{"total_mass",
          &Robot::total_mass,
          "of a floating base: known mass of all links, see [floating base](#logbase)",
          {.otherwise = "unknown", .unit = "kg", .range = Range::from(1e-6, 1e6)}},
    Field{"tip",
          Key<std::string>(),
          "URDF only: last link of a chain",
          {.otherwise = "all that moves behind `base`, a chain or a tree"}},
    Field{"moving",
          Key<std::vector<std::string>>(),
          "URDF only, instead of `tip`: the joints that move, of a chain or a tree, and with them their "
          "mimic joints; all others are held at q = 0",
          {.otherwise = "all"}},
    Field{"dependent",
          Key<std::vector<DependentJoint>>(),
          "joints that follow others, beside the mimic joints of a URDF, see [below](#robotdependent)",
          {.otherwise = "–"}},
    Field{"four_bar",
          Key<std::vector<FourBar>>(),
          "URDF only: four-bar linkages, see [below](#robotfour_bar)",
          {.otherwise = "–"}},
    Field{"gravity",
          [](const Robot& robot) -> const Eigen::Vector3d& { return robot.chain.gravity; },
          "acceleration of free fall in the frame of the base: it points down",
          {.otherwise = "`[0, 0, -9.80665]`", .unit = "m/s²"}},
    Field{"base_tolerance",
          &Robot::base_tolerance,
          "relative difference of columns of the regressor below which parameters count as one, see "
          "[rounded angles](#rounded-angles)",
          {.range = Range::between(0.0, 1.0)}},
    Field{"tolerance",
          &Robot::tolerance,
          "`{ length = 0.0005, angle = 0.0009 }`: standard deviations of lengths and angles of the "
          "description, which those of the parameters then include, see "
          "[statistics](statistics.md#what-was-chosen-or-kept)",
          {.otherwise = "exactly"}},
    Field{"gear_matrix",
          [](const Robot& robot) -> const Matrix& { return robot.gear_matrix; },
          "R of q_motor = R q and τ = Rᵀ τ_motor where [gears mix the joints](coupling.md#gears), one list a "
          "motor; "
          "without `gear_ratio`",
          {.otherwise = "diagonal of `gear_ratio`"}},
    Field{"coupling",
          Key<std::vector<Coupling>>(),
          "motors that several joints turn, see [below](#robotcoupling)",
          {.otherwise = "–"}},
    Field{"joints",
          Key<std::map<std::string, Joint>>(),
          "options of single joints by their name, see the next table",
          {.otherwise = "–"}});

/// Of [method], beside the fields of its records.
inline constexpr auto method_keys = std::tuple(
    Field{"name",
          Key<Word>(),
          "`\"ols\"`: ordinary least squares (15–19); `\"wls\"`: weighted by joint (20); `\"iv\"`: "
          "instrumental variables (27–34), which need `[control]`; `\"auto\"`: `\"iv\"` with "
          "`[control]` and a reference, else, or where that gives no answer, `\"wls\"`; "
          "`\"didim\"` and `\"output_error\"`: see "
          "[statistics](statistics.md#didim-and-output-error)",
          {.otherwise = "`\"auto\"`"}},
    Field{"physical",
          Key<std::variant<bool, Physical>>(),
          "reports physically consistent parameters too; a table gives [options](#methodphysical)",
          {.otherwise = "`false`"}},
    Field{"essential",
          Key<std::variant<bool, Essential>>(),
          "reports [essential parameters](statistics.md#the-parameters-that-matter) too; a table "
          "gives [options](#methodessential)",
          {.otherwise = "`false`"}},
    Field{"gains",
          Key<std::variant<bool, GainOptions>>(),
          "`\"known\"`: those of `[robot]` are exact; `\"estimate\"`: they are estimated, see "
          "[drive gains](payload.md#drive-gains); a table gives [what is known](#methodgains)",
          {.otherwise = "`\"known\"`", .words = {"known", "estimate"}}});
inline constexpr auto gain_keys =
    std::tuple(Field{"loaded",
                     Key<std::vector<std::filesystem::path>>(),
                     "logs with a payload of known mass; columns and units as in `[log]`",
                     {.otherwise = "–"}});
inline constexpr auto iv_keys = std::tuple(
    Field{"simulation",
          Key<SimulationOptions>(),
          "integration of the simulated loop: keys of [`[simulation]`](experiment_more.md#simulation) from "
          "`dry_friction` to `max_velocity`; `max_seconds` is for all simulations of a log together",
          {.otherwise = "as there"}});

/// What is named before the rest of [control] and of [reference] can be read.
inline constexpr auto control_keys = std::tuple(
    Field{"law", Key<Word>(), "the law, by the word of one of the tables below", {.otherwise = "required"}});
inline constexpr auto reference_keys = std::tuple(Field{
    "type", Key<Word>(), "`\"logged\"`, `\"fourier\"` or `\"point_to_point\"`", {.otherwise = "required"}});

/// Of a [[montecarlo.trial]], beside those of [method].
inline constexpr auto trial_keys = std::tuple(
    Field{"label",
          Key<std::string>(),
          "what its rows are called after, without a comma",
          {.required = "must have a label, which its rows are called after"}},
    Field{"signal", Key<SignalOptions>(), "keys of `[signal]` for this trial", {.otherwise = "`[signal]`"}},
    Field{"control",
          Key<ControlLoop>(),
          "the controller that identification assumes, where it is not the actual one",
          {.otherwise = "`[control]`"}});

/// [robot].
///
/// @param robot_file  is set to the URDF or the table that the section names
[[nodiscard]] Robot read_robot(TomlReader keys, std::filesystem::path& robot_file);

/// Robot of a modified Denavit-Hartenberg table in a CSV file with the header `joint,type,alpha,a,d,theta`
/// (names may go on: alpha_prev_rad, a_prev_m, d_m, theta_offset_rad), type R or P, angles in radians,
/// lengths in metres.
///
/// @throws InputError with file and line where the table can not be read
[[nodiscard]] Robot read_mdh(const std::filesystem::path& path, const Eigen::Vector3d& gravity);

/// The same of a table that was read already.
[[nodiscard]] Robot mdh_robot(const TextTable& text, const std::string& name, const Eigen::Vector3d& gravity);

/// Keys of [robot] that choose the chain of a URDF; `gravity` is for tables too.
[[nodiscard]] UrdfOptions read_urdf_options(TomlReader& keys);

/// Refuses what a floating base has no use for: a loop, its simulation, a motion of drives alone.
void refuse_floating(TomlReader& keys);

/// Refuses those that a table has no use for.
void refuse_links_of_table(TomlReader& keys);

/// A robot with what [robot] says of it beside its description.
[[nodiscard]] Robot with_options(TomlReader keys, Robot robot);

/// Base to tip.
[[nodiscard]] std::vector<std::string> joint_names(const Robot& robot);

/// [log] or [validation], for a robot that is known, as it is for all below.
///
/// @param out  what holds where the section does not say it itself; its files are not taken over
[[nodiscard]] LogSource read_log_source(TomlReader keys, LogSource out);

/// [signal]
[[nodiscard]] SignalOptions read_signal(TomlReader keys);

/// [method]
void read_method(TomlReader keys, Experiment& out);

/// [control]
[[nodiscard]] ControlLoop read_control(TomlReader keys);

/// [reference]
[[nodiscard]] ReferenceSource read_reference_source(TomlReader keys);

/// [simulation]
///
/// @param control  of the same file, where there is one: what is not said follows it
[[nodiscard]] SimulationPlan read_simulation(TomlReader keys, const std::optional<ControlLoop>& control);

/// [excitation], into options and earlier logs of a plan.
void read_excitation_plan(TomlReader keys, ExcitationPlan& out);

/// What TomlReader::read_whole() takes beside the fields of a record.
void read_more(TomlReader& keys, Coupling& out);
void read_more(TomlReader& keys, DependentJoint& out);
void read_more(TomlReader& keys, Joint& out);
void read_more(TomlReader& keys, LogSource::BasePose& out);
void read_more(TomlReader& keys, LogSource::Contact& out);
void read_more(TomlReader& keys, LogSource::Reference& out);
void read_more(TomlReader& keys, LogSource::Subtraction& out);
void read_more(TomlReader& keys, Physical& out);
void read_more(TomlReader& keys, Space& out);

/// Columns of a file that holds a reference motion: position, time, rate_hz, units.
///
/// @param columns  `reference` and `time` hold where the keys are absent
void read_reference_columns(TomlReader& keys, LogOptions& columns);

}  // namespace rivid::detail
