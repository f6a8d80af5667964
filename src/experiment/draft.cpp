#include "rivid/experiment/draft.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "data/log_columns.hpp"
#include "experiment/recognised_columns.hpp"
#include "experiment/sections.hpp"
#include "experiment/text_file.hpp"
#include "joined.hpp"
#include "rivid/data/log.hpp"
#include "rivid/data/table.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::from_folder;
using detail::joined;
using detail::RecognisedColumns;
using Path = std::filesystem::path;

// No log of a moving arm is slower than that; what seems to be has its time in a smaller unit [Hz]. Below
// what the check of a log accepts: a slow log is reported, and not taken for one in another unit.
constexpr double slowest_rate = 5.0;

// A basic string of TOML.
std::string toml_string(std::string_view text) {
  const toml::value<std::string> value{std::string(text)};
  constexpr toml::format_flags flags =
      toml::toml_formatter::default_flags &
      ~(toml::format_flags::allow_literal_strings | toml::format_flags::allow_multi_line_strings);
  std::ostringstream out;
  out << toml::toml_formatter(value, flags);
  return out.str();
}

std::string toml_strings(std::span<const std::string> items) {
  return "[" + joined(items, ", ", toml_string) + "]";
}

// Sampling of a log.
struct Clock {
  std::string unit = "s";
  bool guessed = false;  // by its steps
  double rate_hz = 0.0;
  bool regular = true;
  bool forward = true;
  Index late = 0;  // stamps, on a clock that the others keep
  std::string summary;
};

Clock clock_of(const Path& log, const RecognisedColumns& time) {
  std::vector<std::string> columns = time.columns;
  if (const auto nanoseconds = detail::nanoseconds_of(columns.front(), column_names(log))) {
    columns.push_back(*nanoseconds);
  }
  const Table table = read_table(log, {.columns = columns});
  Clock out;
  const Vector stamps = columns.size() == 1 ? Vector(table.values.col(0))
                                            : detail::stamps_of(table.values.col(0), table.values.col(1));
  if (stamps.size() < 2) {
    throw InputError(log.string() + ": the log has one sample, at least 2 are required");
  }
  if (time.unit) {
    out.unit = *time.unit;
  } else {
    const double period = inspect_time(stamps).period;
    constexpr std::array<std::string_view, 4> units = {"s", "ms", "us", "ns"};
    const auto plausible = std::ranges::find_if(
        units, [&](std::string_view unit) { return unit_scale(unit) * period * slowest_rate <= 1.0; });
    out.unit = plausible == units.end() ? "s" : std::string(*plausible);
    out.guessed = out.unit != "s";
  }
  const TimeReport report = inspect_time(unit_scale(out.unit) * stamps);
  out.rate_hz = report.rate_hz;
  out.regular = report.regular;
  out.late = report.late;
  out.forward = (report.reversed.count == 0 || report.late > 0) && report.rate_hz > 0.0;
  out.summary = report.summary();
  return out;
}

Irregular irregular_of(const Clock& clock) {
  return clock.regular ? Irregular::refuse : clock.late > 0 ? Irregular::ignore : Irregular::resample;
}

// Whether a robot is a modified Denavit-Hartenberg table.
bool is_table(const Path& robot) { return robot.extension() == ".csv"; }

// Lines of the sections.
class Writer {
 public:
  void line(std::string_view text = {}) { text_ += std::string(text) + '\n'; }
  void key(std::string_view name, const std::string& value, const std::string& comment = {}) {
    const std::string assignment = std::string(name) + " = " + value;
    const std::size_t width = display_width(assignment);
    line(comment.empty()
             ? assignment
             : assignment + std::string(width < comment_at ? comment_at - width : 1, ' ') + "# " + comment);
  }
  void comment(std::string_view text) { line("# " + std::string(text)); }

  [[nodiscard]] std::string text() && { return std::move(text_); }

 private:
  static constexpr std::size_t comment_at = 34;  // column where comments begin; a choice of layout

  std::string text_;
};

// A pose of the base, and forces on links, which are known by their names.
void write_base(Writer& out, const detail::RecognisedBase& base, const Robot& robot) {
  if (base.position.empty()) {
    return;
  }
  out.line("[log.base]");
  out.key("position", toml_strings(base.position));
  out.key("orientation", toml_strings(base.orientation),
          base.orientation.size() == 4 ? "w, x, y, z of the rotation from link to world" : "");
  out.line();
  if (base.forces.empty()) {
    out.comment(
        "[[log.contact]] names measured forces of feet or a hoist; without it nothing touches the robot");
    out.line();
  }
  for (const auto& [stem, columns] : base.forces) {
    const auto touched = std::ranges::find_if(robot.joints, [&, &begin = stem](const Joint& joint) {
      return begin.find(joint.link) != std::string::npos;
    });
    const bool known = touched != robot.joints.end();
    const std::string mark = known ? "" : "# ";
    out.line(mark + "[[log.contact]]");
    out.line(mark +
             "link = " + (known ? toml_string(touched->link) : "\"…\"        # moving link that is touched"));
    out.line(mark + "wrench = " + toml_strings(columns));
    out.comment("at = [0, 0, 0]    # where, in the frame of the link");
    out.comment("frame = \"world\"  # where the sensor does not turn with the link");
    out.line();
  }
}

void write_robot(Writer& out, const Robot& robot, const std::string& file, const UrdfOptions& options,
                 bool floating, bool control, const std::optional<detail::TargetGains>& gains) {
  out.line("[robot]");
  out.key(is_table(file) ? "mdh" : "urdf", toml_string(file));
  if (!options.base.empty()) {
    out.key("base", toml_string(options.base));
  }
  if (!options.tip.empty()) {
    out.key("tip", toml_string(options.tip));
  }
  if (!options.moving.empty()) {
    out.key("moving", toml_strings(options.moving), "all other joints are held at 0");
  }
  if (floating) {
    out.key("floating", "true", "the log has a pose of the root link");
  }
  out.key("friction", toml_string("auto"), "one law for all joints, by cross-validation (docs/friction.md)");
  out.key("rotor_inertia", "true", "false behind joint torque sensors and for direct drives");
  if (control) {
    std::vector<std::string> values;
    bool all = gains.has_value();
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      const bool found = gains && gains->motors[j].missing.empty();
      values.push_back(found ? number(gains->motors[j].value, 4) : "1.0");
      all = all && found;
    }
    out.key("drive_gain", "[" + joined(values) + "]",
            all ? "N·m/A, by the target currents and torques of the logs"
                : "N·m (or N) for one unit of the control columns: fill in" +
                      std::string(gains && gains->any() ? " 1.0, the others are of the controller" : ""));
  }
  out.key("tolerance", "{ length = 0.0005, angle = 0.0009 }",
          "m, rad: standard deviations of lengths and joint zeros; these of calibrated arms");
  const Eigen::Vector3d& gravity = robot.chain.gravity;
  out.comment("gravity = [" + number(gravity.x()) + ", " + number(gravity.y()) + ", " + number(gravity.z()) +
              "]   # of the base frame; another one if the robot hangs or stands on a wall");
  out.line();
}

void write_log(Writer& out, const detail::RecognisedLog& columns, const std::vector<std::string>& joints,
               std::span<const std::string> files, const std::optional<Clock>& clock) {
  out.line("[log]");
  out.key("files", toml_strings(files));
  if (clock) {
    out.key("time", toml_string(columns.time.columns.front()), clock->summary);
    if (!clock->regular) {
      out.key("irregular", toml_string(name(irregular_of(*clock))),
              clock->late > 0 ? counted(clock->late, "stamp") + " late, none early: stamped on arrival"
                              : "at a uniform sampling rate");
    }
  } else {
    out.comment("time = \"…\"   # or rate_hz = 1000, where there is no column of time stamps");
  }
  out.comment("one column for each of " + joined(joints, ", ", on_one_line));
  const auto missing = [&](std::string_view key, const std::string& what) {
    out.comment(std::string(key) + " = [\"…\"]   # " + what);
  };
  std::string units;
  const auto add_unit = [&](std::string_view quantity, const std::string& unit) {
    if (unit_scale(unit) != 1.0) {
      units += (units.empty() ? "" : ", ") + std::string(quantity) + " = " + toml_string(unit);
    }
  };
  add_unit("time", clock ? clock->unit : "s");
  for (const detail::LogKey& key : detail::log_keys) {
    const RecognisedColumns& found = columns.*key.columns;
    if (!found.columns.empty()) {
      out.key(key.key, toml_strings(found.columns));
      add_unit(key.key, found.unit.value_or("1"));
    } else if (key.kind == detail::ColumnKind::position) {
      missing(key.key,
              "measured positions: names or numbers (from 1) of " + counted(std::ssize(joints), "column"));
    } else if (key.kind == detail::ColumnKind::torque && columns.control.columns.empty()) {
      missing(key.key, "joint torques; or control = [\"…\"], motor currents or control signals");
    }
  }
  if (!units.empty()) {
    out.key("units", "{ " + units + " }");
  }
  out.line();
}

void write_signal(Writer& out) {
  out.line("[signal]");
  out.key("decimation", toml_string("auto"), "the window of the rows is chosen by the noise of the log");
  out.comment(
      "torque_held = true   # where the torques are what the controller asked for, held until its next "
      "sample");
  out.line();
}

void write_control(Writer& out, const std::optional<Clock>& clock) {
  out.comment(
      "The log has a reference: with the control law, instrumental variables are not biased by noise and");
  out.comment("feedback (docs/control.md, docs/instrumental.md).");
  out.comment("[control]");
  out.comment("law = \"pd\"        # or \"pid\", \"cascade\", \"computed_torque\"");
  out.comment("omega_n = 10      # rad/s: a guess of the bandwidth, one for all joints or a list");
  out.comment("zeta = 1");
  out.comment("rate_hz = " + (clock ? number(clock->rate_hz, 4) : std::string("1000")) +
              "    # of the controller");
}

// What a draft is made of.
struct Parts {
  Path robot_file;
  UrdfOptions options;
  Robot robot;
  std::vector<std::string> joints;
  std::vector<Path> logs;
  std::vector<std::string> names;  // of their columns
  detail::RecognisedLog columns;
  detail::RecognisedBase base;
  std::optional<Clock> clock;
  std::optional<detail::TargetGains> gains;
  std::ptrdiff_t held = 0;  // joints that the logs have no positions of

  [[nodiscard]] bool by_control() const {
    return columns.torque.columns.empty() && !columns.control.columns.empty();
  }
  [[nodiscard]] bool torques() const { return !columns.torque.columns.empty() || by_control(); }
  [[nodiscard]] bool complete() const {
    return !columns.position.columns.empty() && torques() && clock.has_value();
  }
};

// The logs as the draft says that they are to be read.
LogSource source_of(const Parts& found) {
  const auto columns = [](const RecognisedColumns& from) {
    std::vector<Column> out;
    for (const std::string& name : from.columns) {
      out.push_back({name, unit_scale(from.unit.value_or("1"))});
    }
    return out;
  };
  LogSource out;
  out.files = found.logs;
  out.columns.position = columns(found.columns.position);
  out.columns.control = columns(found.columns.control);
  out.columns.time = Column{found.columns.time.columns.front(), unit_scale(found.clock->unit)};
  out.irregular = irregular_of(*found.clock);
  return out;
}

std::vector<std::string> doubts_about(const Parts& found) {
  std::vector<std::string> out = found.columns.doubts;
  const std::string there_are = "; the columns are " + listed(found.names);
  if (found.held > 0) {
    out.push_back(
        "the logs have no positions of " + counted(found.held, "joint") +
        " of the robot; they are taken to stand at 0 (moving, in [robot]); passive ones of a linkage follow "
        "others: see [[robot.four_bar]] and [[robot.dependent]]");
  }
  if (found.columns.position.columns.empty()) {
    out.push_back("no columns of positions were recognised, one for each joint" + there_are);
  }
  if (!found.torques()) {
    out.push_back("no columns of torques or control signals were recognised, one for each joint" + there_are);
  }
  if (!found.clock) {
    out.push_back("no column of time stamps was recognised" + there_are);
  } else if (found.clock->guessed) {
    out.push_back("time is taken for " + found.clock->unit + ": its stamps are then " + found.clock->summary);
  }
  if (found.clock && !found.clock->forward) {
    out.push_back("time goes back: " + found.clock->summary);
  }
  if (found.gains) {
    out.insert(out.end(), found.gains->doubts.begin(), found.gains->doubts.end());
  }
  if (found.gains && found.gains->any()) {
    out.push_back(found.gains->text(found.robot) +
                  "; rivid payload --gains estimate finds them from a known payload");
  } else if (found.by_control()) {
    out.emplace_back(
        "control signals are taken for torques in their own unit until [robot] drive_gain says what they "
        "make");
  }
  return out;
}

std::string text_of(const Parts& found, const Path& file) {
  const Path folder = file.parent_path();
  const std::string name = file.filename().string();
  const std::size_t fitted = found.logs.size() > 1 ? found.logs.size() - 1 : 1;
  std::vector<std::string> files;
  files.reserve(found.logs.size());
  for (const Path& log : found.logs) {
    files.push_back(from_folder(log, folder));
  }
  Writer out;
  out.comment("Look it over, then");
  out.comment("  rivid check " + name + "               faults, and identifiability of the parameters");
  out.comment("  rivid identify " + name + " --report   the parameters");
  out.comment("docs/experiment.md lists every key.");
  out.line();
  write_robot(out, found.robot, from_folder(found.robot_file, folder), found.options,
              !found.base.position.empty(), found.by_control(), found.gains);
  write_log(out, found.columns, found.joints, std::span(files).first(fitted), found.clock);
  write_base(out, found.base, found.robot);
  write_signal(out);
  out.line("[method]");
  out.key("name", toml_string("auto"),
          "instrumental variables with [control] and a reference, else weighted least squares");
  out.line();
  if (fitted < files.size()) {
    out.line("[validation]");
    out.key("files", toml_strings(std::span(files).subspan(fitted)), "takes no part in the fit");
  } else {
    out.comment("[validation]");
    out.comment("files = [\"another_run.csv\"]   # takes no part in the fit and judges it");
  }
  if (!found.columns.reference.columns.empty() && found.base.position.empty()) {
    out.line();
    write_control(out, found.clock);
  }
  return std::move(out).text();
}

// A limit of all joints, where the description has none of some.
void write_limit(Writer& out, const Robot& robot, std::string_view key, double Joint::* limit, double guess,
                 std::vector<std::string>& doubts) {
  std::vector<std::string> values;
  std::vector<std::string> guessed;
  for (const Joint& joint : robot.joints) {
    const bool known = std::isfinite(joint.*limit);
    values.push_back(number(known ? joint.*limit : guess, 6));
    if (!known) {
      guessed.push_back(joint.name);
    }
  }
  if (!guessed.empty()) {
    const std::string names = joined(guessed, ", ", on_one_line);
    out.key(key, "[" + joined(values) + "]", "a guess of " + names);
    doubts.push_back("the description has no " + std::string(key) + " limit of " + names + "; " +
                     number(guess) + " in [excitation.limits] is a guess");
  }
}

// Before there is a log: what a motion to record is designed with.
ExperimentDraft design_draft(const Parts& found, const Path& file) {
  const Robot& robot = found.robot;
  const std::string name = file.filename().string();
  ExperimentDraft draft;
  draft.complete = true;
  Writer out;
  out.comment("Look it over, then");
  out.comment("  rivid excite " + name +
              " --output plan --report   designs a motion, forecasts what it shows");
  out.comment("  rivid play plan --on ARM   plays and records it; or play plan/motion.csv by your own means");
  out.comment("docs/excite.md and docs/experiment_more.md list every key.");
  out.line();
  write_robot(out, robot, from_folder(found.robot_file, file.parent_path()), found.options, false, false, {});
  out.line("[excitation]");
  out.key("duration", "20", "s");
  out.key("rate_hz", "500", "of the controller that plays it");
  const bool rated = std::ranges::all_of(robot.joints, [](const Joint& joint) {
    return std::isfinite(joint.max_effort) && joint.max_effort > 0.0;
  });
  if (rated) {
    out.comment("noise = […]   # N·m, of each joint's torque; else 1 % of its limit");
  } else {
    out.key("noise", "1", "N·m, of each joint's torque: fill in");
    draft.doubts.emplace_back(
        "torque errors are not known: noise = 1 in [excitation] is a guess, and forecast "
        "standard deviations are in proportion to it");
  }
  out.line();
  out.line("[excitation.limits]");
  out.key("acceleration", "5", "rad/s², m/s²; one for all joints or a list");
  write_limit(out, robot, "lower", &Joint::lower, -3.1, draft.doubts);
  write_limit(out, robot, "upper", &Joint::upper, 3.1, draft.doubts);
  write_limit(out, robot, "velocity", &Joint::max_velocity, 1.0, draft.doubts);
  out.line();
  const std::string last = on_one_line(robot.joints.back().link);
  out.line("[excitation.space]");
  out.key("clearance", "0.01", "m, that links keep from all of it and from each other");
  out.line(std::string(robot.chain.branches() ? "# " : "") +
           "floor = 0                         # m, in the base frame");
  out.comment("boxes = [{ name = \"table\", min = [0.6, -0.5, 0], max = [1.2, 0.5, 0.2] }]");
  out.comment("capsules = [{ link = " + toml_string(last) +
              ", from = [0, 0, 0], to = [0, 0, 0.2], radius = 0.08 }]   # instead of its shape: tool too");
  draft.doubts.push_back("is there a tool or gripper on " + last +
                         " that the description lacks? Its room goes into [excitation.space], capsules");
  draft.text = std::move(out).text();
  return draft;
}

// The joints that a log has positions of, where those of some are missing: of a gripper, or of another arm.
// They are those that its columns are named after, or of a tree all on the way to some link. Empty where the
// log has those of all, or nothing fits, or more than one way.
std::vector<std::string> logged_joints(const Robot& robot, std::span<const std::string> columns) {
  const auto fits = [&](const std::vector<std::string>& joints) {
    return !joints.empty() && !detail::recognised_log(columns, joints).position.columns.empty();
  };
  const std::vector<std::string> all = detail::joint_names(robot);
  if (fits(all)) {
    return {};
  }
  if (std::vector<std::string> named = detail::joints_in(columns, all); fits(named)) {
    return named;
  }
  // Passive joints of a linkage have no effort.
  std::vector<std::string> driven;
  for (const Joint& joint : robot.joints) {
    if (joint.max_effort > 0.0 && std::isfinite(joint.max_effort)) {
      driven.push_back(joint.name);
    }
  }
  if (fits(driven)) {
    return driven;
  }
  std::vector<std::vector<std::string>> ways;
  for (std::size_t j = 0; robot.chain.branches() && j < all.size(); ++j) {
    std::vector<std::string> way;
    for (const std::size_t k : robot.chain.path(j)) {
      if (k < all.size()) {
        way.push_back(all[k]);
      }
    }
    if (way.size() > 1 && fits(way)) {
      ways.push_back(std::move(way));
    }
  }
  return ways.size() == 1 ? ways.front() : std::vector<std::string>{};
}

}  // namespace

ExperimentDraft draft_experiment(const Path& file, const Path& robot_file, const UrdfOptions& options,
                                 std::span<const Path> logs) {
  for (const Path& log : logs) {
    if (log.extension() == ".urdf") {
      throw InputError(log.string() + ": is a robot, which comes before the logs");
    }
    (void)read_input(log);  // no pipe: the experiment file will name it
  }
  if (is_table(robot_file) && (!options.base.empty() || !options.tip.empty())) {
    throw InputError(robot_file.string() +
                     ": base and tip go with a URDF; a table describes the whole chain");
  }
  Parts found;
  found.robot_file = robot_file;
  found.options = options;
  found.robot =
      is_table(robot_file) ? detail::read_mdh(robot_file, options.gravity) : read_urdf(robot_file, options);
  if (logs.empty()) {
    return design_draft(found, file);
  }
  found.logs.assign(logs.begin(), logs.end());
  found.names = column_names(logs.front());
  for (const Path& log : logs.subspan(1)) {
    if (column_names(log) != found.names) {
      throw InputError(log.string() + ": has other columns than " + logs.front().string() +
                       "; all logs of an experiment file have the same");
    }
  }
  if (!is_table(robot_file) && options.tip.empty() && options.moving.empty()) {
    found.options.moving = logged_joints(found.robot, found.names);
    if (!found.options.moving.empty()) {
      found.held = found.robot.size() - std::ssize(found.options.moving);
      found.robot = read_urdf(robot_file, found.options);
    }
  }
  found.joints = detail::joint_names(found.robot);
  found.columns = detail::recognised_log(found.names, found.joints);
  if (!is_table(robot_file) && options.base.empty()) {
    found.base = detail::recognised_base(found.names);
  }
  if (!found.columns.time.columns.empty()) {
    found.clock = clock_of(logs.front(), found.columns.time);
  }
  if (found.by_control() && found.complete()) {
    found.gains = detail::target_gains(std::array{source_of(found)}, found.robot);
  }
  return {.text = text_of(found, file), .complete = found.complete(), .doubts = doubts_about(found)};
}

}  // namespace rivid
