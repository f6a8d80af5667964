#include "rivid/experiment/experiment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "data/log_columns.hpp"
#include "experiment/floating_base.hpp"
#include "experiment/from_program.hpp"
#include "experiment/json_fields.hpp"
#include "experiment/law_control.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

void append_inputs(const LogSource& source, std::vector<std::filesystem::path>& out) {
  out.insert(out.end(), source.files.begin(), source.files.end());
  if (source.reference && !source.files.empty()) {
    out.push_back(source.reference->file);
  }
  for (const LogSource::Subtraction& s : source.subtract) {
    out.push_back(s.table);
  }
}

void append_simulation_inputs(const Experiment& experiment, std::vector<std::filesystem::path>& out) {
  if (experiment.reference) {
    const ReferenceSource& reference = *experiment.reference;
    if (!reference.file.empty()) {
      out.push_back(reference.file);
    } else if (std::holds_alternative<LoggedMotion>(reference.motion)) {
      LogSource first = experiment.log;
      first.files.resize(1);
      append_inputs(first, out);
    }
  }
  if (experiment.simulation) {
    const SimulationPlan& plan = *experiment.simulation;
    if (!plan.parameters.empty()) {
      out.push_back(plan.parameters);
    }
    if (plan.added_control) {
      out.push_back(plan.added_control->file);
    }
  }
}

// Column numbers that the user did not list follow from the robot: what default names find must fit it as
// well.
void require_columns(const Log& log, const Robot& robot) {
  if (log.q.cols() != robot.size()) {
    throw InputError(log.source + ": " + std::to_string(log.q.cols()) + " position columns, robot \"" +
                     robot.name + "\" has " + std::to_string(robot.size()) +
                     " joints; name one column for each joint in [log] position");
  }
}

Log adjusted(Log log, const LogSource& source, const Robot& robot) {
  if (!source.subtract.empty()) {
    log.tau = effort(robot, log);
  }
  for (const LogSource::Subtraction& s : source.subtract) {
    log = subtract_torque(std::move(log), s.joint, read_torque_table(s.table, {.columns = s.columns}),
                          s.outside);
  }
  if (source.reference) {
    Log reference = read_reference(source.reference->file, source.reference->columns);
    if (source.side == LogSource::Side::motor) {
      reference = joint_side(robot, std::move(reference));
    }
    log = with_reference(std::move(log), reference, source.reference->delay, source.reference->outside);
  }
  return log;
}

// What [log] says of a log that was read, which long gaps make several of.
void append_pieces(const detail::ColumnsRead& read, const LogSource& source, const Robot& robot,
                   std::vector<Log>& out) {
  Log log = detail::with_base(read(source.columns), source, robot, read);
  require_columns(log, robot);
  if (source.side == LogSource::Side::motor) {
    log = joint_side(robot, std::move(log));
  }
  const bool by_law = source.law && log.tau.size() == 0 && log.v_tau.size() == 0;
  if (source.torque_lag != 0.0 && !by_law) {
    log = shift_torque(log, source.torque_lag);
  }
  std::vector<Log> wrenches;
  if (!source.contact.empty()) {
    wrenches = regularised(detail::wrenches_of(source, read), source.irregular, source.resample);
  }
  for (Log& piece : regularised(std::move(log), source.irregular, source.resample)) {
    Log whole = adjusted(std::move(piece), source, robot);
    if (!wrenches.empty()) {
      whole = detail::with_wrenches(std::move(whole), wrenches.front(), source, robot);
      wrenches.erase(wrenches.begin());
    }
    out.push_back(by_law ? detail::with_control_of_law(std::move(whole), source, robot) : std::move(whole));
  }
}

}  // namespace

Estimation detail::estimation_of(const Experiment& experiment) {
  Estimation estimation = experiment.estimation;
  Auto* const open = std::get_if<Auto>(&estimation.method);
  if (Iv* const iv = open != nullptr ? &open->iv : std::get_if<Iv>(&estimation.method)) {
    if (!experiment.control && open != nullptr) {
      return estimation;
    }
    if (!experiment.control) {
      throw InputError(experiment.file.string() + ": section [control] is missing; method \"" +
                       std::string(name(estimation.method)) +
                       "\" simulates the closed loop and needs its control law, or a guess of its bandwidth");
    }
    iv->control = experiment.control->control;
    iv->sampling = experiment.control->sampling;
    iv->gain_sigma = experiment.control->gain_sigma;
    iv->delay_sigma = experiment.control->delay_sigma;
  }
  return estimation;
}

void Experiment::take_method(std::string_view name) {
  const auto comparing = [&](Iv::Compares compares) {
    Iv out = iv;
    out.compares = compares;
    return Method(std::move(out));
  };
  for (const Method& method : {Method(Ols{}), Method(Wls{}), Method(iv), Method(Auto{iv}),
                               comparing(Iv::Compares::torques), comparing(Iv::Compares::positions)}) {
    if (rivid::name(method) == name) {
      estimation.method = method;
      return;
    }
  }
  throw InputError("Experiment: there is no method \"" + std::string(name) + "\", only " +
                   listed(std::vector<std::string>(method_names.begin(), method_names.end())));
}

std::vector<std::filesystem::path> Experiment::inputs(Use use) const {
  std::vector<std::filesystem::path> out = {file, robot_file};
  out.insert(out.end(), robot_tables.begin(), robot_tables.end());
  if (use == Use::simulation) {
    append_simulation_inputs(*this, out);
  } else {
    append_inputs(log, out);
    for (const LogSource* const source : {&loaded, &validation}) {
      if (!source->files.empty()) {
        append_inputs(*source, out);
      }
    }
  }
  std::vector<std::filesystem::path> unique;
  for (std::filesystem::path& path : out) {
    if (std::ranges::find(unique, path) == unique.end()) {
      unique.push_back(std::move(path));
    }
  }
  return unique;
}

std::vector<Log> read_logs(const LogSource& source, const Robot& robot, const Progress& progress) {
  std::vector<Log> out;
  for (const std::filesystem::path& file : source.files) {
    std::function<void(double)> report;
    if (progress) {
      report = [&](double fraction) { progress("reading " + file.filename().string(), fraction); };
    }
    append_pieces(
        [&](LogOptions some) {
          some.table.progress = report;
          return read_csv(file, some);
        },
        source, robot, out);
  }
  return out;
}

const std::vector<Log>& Reading::logs(const LogSource& source, const Robot& robot) {
  // Gears turn logs of the motors; torques that a table is taken off are made with the drive gains.
  detail::Json how = {detail::json_of(source), source.columns.default_names, detail::json_of(robot.gears())};
  if (!source.subtract.empty()) {
    how.push_back(detail::json_of(robot.drive_matrix()));
  }
  const std::string key = detail::json_text(how);
  if (const auto known = logs_.find(key); known != logs_.end()) {
    return known->second;
  }
  std::vector<Log> read = read_logs(source, robot, progress_);
  files_ += source.files.size();
  return logs_.emplace(key, std::move(read)).first->second;
}

std::vector<Log> detail::logs_of(const Table& table, const LogSource& source, const Robot& robot) {
  std::vector<Log> out;
  append_pieces([&](const LogOptions& columns) { return log_of(table, columns); }, source, robot, out);
  return out;
}

Identification identify_logs(const Experiment& experiment, std::span<const Log> logs,
                             std::span<const Log> validation, const Progress& progress) {
  Estimation estimation = detail::estimation_of(experiment);
  estimation.progress = progress;
  std::array<std::vector<Log>, 2> room;
  const Iv* const iv = std::get_if<Iv>(&estimation.method);
  if (iv != nullptr && iv->compares == Iv::Compares::positions &&
      !(iv->gain_sigma.empty() && iv->delay_sigma == 0.0) &&
      std::ranges::any_of(logs, detail::has_control_of_law)) {
    // Rows of torques are judged, which are those of the loop: its estimate comes first.
    Estimation first = estimation;
    first.judge = false;
    const Identification found = identify(experiment.robot, logs, first);
    if (found.output_error) {
      room[0] =
          detail::with_control_of_loop(logs, experiment.log, experiment.robot, found.output_error->loop);
      room[1] = detail::with_control_of_loop(validation, experiment.validation, experiment.robot,
                                             found.output_error->loop);
      logs = room[0];
      validation = room[1];
    }
  }
  Identification out = identify(experiment.robot, logs, estimation, validation);
  detail::name_lines(experiment, logs.front(), out.warnings);
  out.gains = experiment.gain_report;
  return out;
}

void detail::name_lines(const Experiment& experiment, const Log& log, std::vector<Finding>& findings) {
  const LogOptions& from = experiment.log.columns;
  for (Finding& finding : findings) {
    const bool position = finding.code == "position_sign";
    if (!position && finding.code != "torque_sign") {
      continue;
    }
    const bool measured = log.tau.size() > 0;
    const std::string key = position ? "position" : measured ? "torque" : "control";
    const std::string usual = position ? "q" : measured ? "tau" : "v";
    std::vector<Column> columns = position ? from.position : measured ? from.torque : from.control;
    std::string line;
    for (std::size_t j = 0; j < experiment.robot.joints.size(); ++j) {
      if (columns.size() == j) {
        columns.push_back({usual + std::to_string(j + 1)});
      }
      const std::string& name = columns[j].name;
      const std::string cell = name.starts_with('#') ? name.substr(1) : "\"" + name + "\"";
      const bool turned =
          finding.subject == experiment.robot.joints[j].name || finding.subject == "all joints";
      const bool negative = (columns[j].scale < 0.0) != turned;
      line += (j == 0 ? "" : ", ") + (negative ? "{ column = " + cell + ", sign = -1 }" : cell);
    }
    const bool plain = std::ranges::all_of(
        columns, [](const Column& c) { return std::abs(c.scale) == 1.0 && c.offset == 0.0; });
    if (plain) {
      finding.text += "; in [log]: " + key + " = [" + line + "]";
    }
  }
}

void detail::take_friction(Experiment& experiment, std::span<const Log> logs, std::span<const Log> validation,
                           const Progress& progress) {
  Estimation estimation = experiment.estimation;
  estimation.progress = progress;
  FrictionChoices found = choose_friction(experiment.robot, logs, estimation, validation);
  experiment.robot = with_friction(std::move(experiment.robot), found.kinds);
  experiment.estimation.choice_covariance = std::move(found.C);
  experiment.friction = std::move(found.kinds);
}

void take_friction(Experiment& experiment, Reading& reading) {
  const auto open = [](const Joint& joint) { return joint.friction == Friction::automatic; };
  if (std::ranges::any_of(experiment.robot.joints, open)) {
    detail::take_friction(experiment, reading.logs(experiment.log, experiment.robot),
                          reading.logs(experiment.validation, experiment.robot), reading.progress());
  }
}

void detail::take_gains(Experiment& experiment, std::span<const Log> logs, Reading& reading) {
  if (!experiment.gains || experiment.gain_report) {
    return;
  }
  const std::vector<Log>& loaded = reading.logs(experiment.loaded, experiment.robot);
  const GainReport& found = experiment.gain_report.emplace(
      identify_gains(experiment.robot, logs, loaded, experiment.estimation, *experiment.gains));
  experiment.robot = with_gains(std::move(experiment.robot), found);
  experiment.estimation.gain_covariance = found.C;
}

void take_gains(Experiment& experiment, Reading& reading) {
  if (experiment.gains && !experiment.gain_report) {
    detail::take_gains(experiment, reading.logs(experiment.log, experiment.robot), reading);
  }
}

Identification run(const Experiment& experiment, Reading& reading) {
  const std::vector<Log>& logs = reading.logs(experiment.log, experiment.robot);
  const std::vector<Log>& others = reading.logs(experiment.validation, experiment.robot);
  return identify_logs(experiment, logs, others, reading.progress());
}

Identification run(const Experiment& experiment, const Progress& progress) {
  Reading reading(progress);
  return run(experiment, reading);
}

ShownPredictions shown_predictions(const Experiment& experiment, const Identification& result,
                                   Reading& reading, Index most) {
  ShownPredictions out;
  for (const LogSource* const source : {&experiment.log, &experiment.validation}) {
    for (const Log& log : reading.logs(*source, experiment.robot)) {
      if (log.q.size() > most) {
        out.left_out.push_back(log.source);
        continue;
      }
      most -= log.q.size();
      out.predictions.push_back(predict(experiment.robot, result, log));
      out.predictions.back().validation = source == &experiment.validation;
    }
  }
  return out;
}

}  // namespace rivid
