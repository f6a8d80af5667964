#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "identify/check/alternatives.hpp"
#include "identify/check/reading_changes.hpp"
#include "rivid/data/adjust.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/hint.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// What a hint changes: the robot, how the columns of the logs are read, and their clock.
struct Change {
  std::string what;
  Robot robot;
  detail::Reading reading;
  double rate = 1.0;  // factor of the sampling rate
  double lag = 0.0;   // of the torques, beside that of the file [samples]
  std::optional<Friction> friction = {};
  std::optional<double> stated_rate_hz = {};  // in place of the stamps
};

detail::Reading as_told(const Robot& robot) {
  const Index n = robot.size();
  detail::Reading out{.position = {},
                      .position_scale = Vector::Ones(n),
                      .position_offset = Vector::Zero(n),
                      .torque = {},
                      .torque_sign = Vector::Ones(n),
                      .gravity = robot.chain.gravity};
  for (Index j = 0; j < n; ++j) {
    out.position.push_back(j);
    out.torque.push_back(j);
  }
  return out;
}

Log changed(const Log& log, const Change& change) {
  const detail::Reading& r = change.reading;
  Log out = log;
  for (Matrix Log::* const part : {&Log::q, &Log::qd, &Log::q_r, &Log::qd_r}) {
    if ((log.*part).size() > 0) {
      out.*part = (log.*part)(Eigen::all, r.position) * r.position_scale.asDiagonal();
    }
  }
  for (Matrix Log::* const part : {&Log::q, &Log::q_r}) {
    if ((out.*part).size() > 0) {
      (out.*part).rowwise() += r.position_offset.transpose();
    }
  }
  for (Matrix Log::* const part : {&Log::tau, &Log::v_tau}) {
    if ((log.*part).size() > 0) {
      out.*part = (log.*part)(Eigen::all, r.torque) * r.torque_sign.asDiagonal();
    }
  }
  out.f_m *= change.rate;
  out.t = (log.t.array() - log.t[0]) / change.rate + log.t[0];
  return change.lag == 0.0 ? out : shift_torque(out, change.lag);
}

// An experiment with its logs.
struct Case {
  Experiment experiment;
  std::vector<Log> logs;
  std::vector<Log> validation;
};

Case with(const Case& told, const Change& change) {
  Case out = told;
  out.experiment.robot = change.robot;
  out.experiment.robot.chain.gravity = change.reading.gravity;
  if (change.stated_rate_hz) {
    for (LogSource* const source : {&out.experiment.log, &out.experiment.validation}) {
      source->columns.rate_hz = change.stated_rate_hz;
      source->irregular = Irregular::ignore;
    }
    out.logs = read_logs(out.experiment.log, out.experiment.robot);
    out.validation = read_logs(out.experiment.validation, out.experiment.robot);
  }
  for (std::vector<Log>* const some : {&out.logs, &out.validation}) {
    for (Log& log : *some) {
      log = changed(log, change);
    }
  }
  return out;
}

Identification run_case(const Case& it, std::span<const Log> logs, std::span<const Log> validation,
                        bool judge) {
  Experiment experiment = it.experiment;
  experiment.estimation.judge = judge;
  return identify_logs(experiment, logs, validation);
}

std::optional<double> error_on(const Identification& result) {
  double squares = 0.0;
  for (const Validation& one : result.validation) {
    squares += one.fit.relative_error * one.fit.relative_error;
  }
  const double error =
      std::sqrt(squares / static_cast<double>(std::max<std::size_t>(result.validation.size(), 1)));
  const bool answer = result.status == Status::identified || result.status == Status::doubtful;
  return answer && !result.validation.empty() && std::isfinite(error) ? std::optional(error) : std::nullopt;
}

// Each half of the logs with the parameters of the other.
std::optional<double> error_of_halves(const Case& it) {
  std::array<std::vector<Log>, 2> halves;
  for (const Log& log : it.logs) {
    const Index half = log.samples() / 2;
    halves[0].push_back(excerpt(log, 0, half));
    halves[1].push_back(excerpt(log, half, log.samples() - half));
  }
  double squares = 0.0;
  for (std::size_t h = 0; h < 2; ++h) {
    std::optional<double> error;
    try {
      error = error_on(run_case(it, halves[h], halves[1 - h], false));
    } catch (const InputError&) {
      return std::nullopt;
    }
    if (!error) {
      return std::nullopt;
    }
    squares += 0.5 * *error * *error;
  }
  return std::sqrt(squares);
}

HintOutcome outcome_of(const Case& it, const Identification& result) {
  return {.status = result.status,
          .fit = result.fit.relative_error,
          .held_out = it.validation.empty() ? error_of_halves(it) : error_on(result)};
}

// Relative error of the fit; a large number where there is none.
double fit_error(const Case& it) {
  constexpr double none = 1e9;
  try {
    const double error = run_case(it, it.logs, {}, false).fit.relative_error;
    return std::isfinite(error) ? error : none;
  } catch (const InputError&) {
    return none;
  }
}

std::vector<Index> joints_in(const Robot& robot, std::string_view subject) {
  std::vector<Index> out;
  for (Index j = 0; j < robot.size(); ++j) {
    const std::string name = detail::joint_name(robot, j);
    if (subject == "all joints" || subject == name || subject.starts_with(name + " and ") ||
        subject.ends_with(" and " + name)) {
      out.push_back(j);
    }
  }
  return out;
}

// A size that a test has estimated, taken back.
void take_size(const ModelTest& test, double f_m, Change& to) {
  const double size = test.estimate[0];
  const std::string by = test.subject + ": ";
  for (const Index j : joints_in(to.robot, test.subject)) {
    if (test.code == "torque_gain") {
      to.reading.torque_sign[j] /= 1.0 + size;
      to.what = by + "torque times " + number(to.reading.torque_sign[j], 4);
    } else if (test.code == "zero_offset") {
      to.reading.position_offset[j] += size;
      to.what = by + "position offset " + number(to.reading.position_offset[j], 4);
    } else if (test.code == "position_scale") {
      to.reading.position_scale[j] *= 1.0 + size;
      to.what = by + "position times " + number(to.reading.position_scale[j], 4);
    }
  }
  if (test.code == "gravity_tilt") {
    to.reading.gravity = detail::tilted_gravity(to.robot, test.estimate);
    to.robot.chain.gravity = to.reading.gravity;
    to.what = "gravity turned by " + number(test.estimate.norm(), 3) + " rad";
  } else if (test.code == "clock_rate") {
    to.rate *= 1.0 + size;
    to.what = "sampling rate times " + number(to.rate, 5);
  } else if (test.code == "torque_delay") {
    to.lag += size * f_m;
    to.what = "torques earlier by " + number(to.lag, 3) + " samples";
  }
}

bool has_size(std::string_view code) {
  return code == "torque_gain" || code == "zero_offset" || code == "position_scale" ||
         code == "gravity_tilt" || code == "clock_rate" || code == "torque_delay";
}

// The readings of a hint without a size.
std::vector<Change> choices(const Change& told, std::string_view code, std::string_view subject,
                            const std::vector<Log>& logs) {
  std::vector<Change> out;
  for (detail::Change& one : detail::changes(told.robot, told.reading)) {
    if (one.code == code && (subject.empty() || one.subject == subject)) {
      Change change = told;
      change.reading = std::move(one.reading);
      change.what = one.subject + ": " + one.text;
      out.push_back(std::move(change));
    }
  }
  const auto with_friction = [&](Friction law) {
    Change change = told;
    change.friction = law;
    for (Joint& joint : change.robot.joints) {
      joint.friction = law;
    }
    change.what = "friction \"" + std::string(name(law)) + "\"";
    out.push_back(std::move(change));
  };
  if (code == "direction_friction") {
    with_friction(Friction::asymmetric);
  } else if (code == "load_friction") {
    with_friction(Friction::load);
  } else if (code == "stribeck_friction") {
    with_friction(Friction::root);
  } else if (code == "joint_coupling") {
    const std::vector<Index> pair = joints_in(told.robot, subject);
    for (std::size_t k = 0; pair.size() == 2 && k < 2; ++k) {
      for (const double ratio : {1.0, -1.0}) {
        Change change = told;
        Coupling& coupling = change.robot.couplings.emplace_back();
        coupling.motor = static_cast<int>(pair[k]);
        coupling.joints = {static_cast<int>(pair[1 - k])};
        coupling.ratios = {ratio};
        change.what = "motor of " + detail::joint_name(told.robot, pair[k]) + " turned by " +
                      detail::joint_name(told.robot, pair[1 - k]) + " as well, ratio " + number(ratio);
        if (!change.robot.complaint()) {
          out.push_back(std::move(change));
        }
      }
    }
  } else if (code == "torque_delay" || code == "torque_lag") {
    constexpr double longest = 0.3;  // [s]
    const auto most = static_cast<Index>(longest * logs.front().f_m);
    for (Index s = 1; s <= most; s += std::max<Index>(1, s / 4)) {
      for (const double sign : {1.0, -1.0}) {
        Change change = told;
        change.lag = sign * static_cast<double>(s);
        change.what = "torques earlier by " + number(change.lag) + " samples";
        out.push_back(std::move(change));
      }
    }
  } else if (code == "clock_jitter" || code == "late_stamps") {
    const Log& log = logs.front();
    Change change = told;
    change.stated_rate_hz = static_cast<double>(log.samples() - 1) / (log.t[log.samples() - 1] - log.t[0]);
    change.what = "samples as of a clock, in place of their stamps";
    out.push_back(std::move(change));
  }
  return out;
}

// The one that fits best, as it is in the experiment.
std::optional<Change> best_of(const Case& told, std::vector<Change> some) {
  std::optional<Change> out;
  double least = 0.0;
  for (Change& change : some) {
    const double error = fit_error(with(told, change));
    if (!out || error < least) {
      least = error;
      out = std::move(change);
    }
  }
  return out;
}

// Steps that grow smaller, as long as they fit better.
void refine_lag(const Case& told, Change& change) {
  double least = fit_error(with(told, change));
  for (double step = std::max(1.0, std::abs(change.lag) / 8.0); step >= 0.5; step *= 0.5) {
    for (const double by : {step, -step}) {
      Change other = change;
      other.lag += by;
      other.what = "torques earlier by " + number(other.lag, 4) + " samples";
      if (const double error = fit_error(with(told, other)); error < least) {
        least = error;
        change = std::move(other);
      }
    }
  }
}

const ModelTest* test_of(const Identification& result, std::string_view code, std::string_view subject) {
  const auto at = std::ranges::find_if(result.alternatives, [&](const ModelTest& test) {
    return (test.code == code || code == "model_mismatch") && (subject.empty() || test.subject == subject);
  });
  return at == result.alternatives.end() ? nullptr : &*at;
}

// What a finding with a size asks for, and what is then left of it, as long as the fit grows better.
Change sized(const Case& told, Change change, ModelTest test) {
  constexpr int rounds = 3;
  double least = fit_error(told);
  for (int k = 0; k < rounds; ++k) {
    Change next = change;
    take_size(test, told.logs.front().f_m, next);
    const Case then = with(told, next);
    const double error = fit_error(then);
    if (k > 0 && !(error < least)) {
      break;
    }
    least = error;
    change = std::move(next);
    const Identification result = run_case(then, then.logs, {}, true);
    const ModelTest* const rest = test_of(result, test.code, test.subject);
    if (rest == nullptr) {
      break;
    }
    test = *rest;
  }
  return change;
}

std::string in_quotes_all(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) {
    out += (out.empty() ? "\"" : ", \"") + name + '"';
  }
  return '[' + out + ']';
}

// A list of columns, each in SI units.
std::string columns_line(std::string_view key, const std::vector<Column>& named, std::string_view otherwise,
                         std::string_view unit, const std::vector<Index>& order, const Vector& scale,
                         const Vector& offset) {
  std::string out;
  for (std::size_t j = 0; j < order.size(); ++j) {
    const auto from = static_cast<std::size_t>(order[j]);
    const Column column =
        named.empty() ? Column{std::string(otherwise) + std::to_string(from + 1)} : named.at(from);
    const auto at = static_cast<Index>(j);
    const double total = scale[at] * column.scale;
    const double added = scale[at] * column.offset + offset[at];
    out += std::string(out.empty() ? "" : ", ") + "{ column = \"" + column.name + "\", unit = \"" +
           std::string(unit) + "\"" + (total == 1.0 ? "" : ", scale = " + number(total, 8)) +
           (added == 0.0 ? "" : ", offset = " + number(added, 6)) + " }";
  }
  return std::string(key) + " = [" + out + "]";
}

std::vector<std::string> lines_of(const Experiment& told, const Change& change) {
  const LogOptions& columns = told.log.columns;
  const detail::Reading& now = change.reading;
  const detail::Reading before = as_told(told.robot);
  std::vector<std::string> robot;
  std::vector<std::string> log;
  if (now.gravity.norm() == 0.0 && told.robot.chain.gravity.norm() > 0.0) {
    log.emplace_back("torque_without = \"gravity\"");
  } else if (now.gravity != told.robot.chain.gravity) {
    robot.push_back("gravity = [" + number(now.gravity[0], 6) + ", " + number(now.gravity[1], 6) + ", " +
                    number(now.gravity[2], 6) + "]");
  }
  if (change.friction) {
    robot.push_back("friction = \"" + std::string(name(*change.friction)) + "\"");
  }
  if (now.position != before.position || now.position_scale != before.position_scale ||
      now.position_offset != before.position_offset) {
    log.push_back(columns_line("position", columns.position, "q", "rad", now.position, now.position_scale,
                               now.position_offset));
  }
  if (now.torque != before.torque || now.torque_sign != before.torque_sign) {
    const bool control = columns.torque.empty() && !columns.control.empty();
    log.push_back(columns_line(control ? "control" : "torque", control ? columns.control : columns.torque,
                               "tau", control ? "A" : "Nm", now.torque, now.torque_sign,
                               Vector::Zero(now.torque_sign.size())));
  }
  if (change.lag != 0.0) {
    log.push_back("torque_lag = " + number(told.log.torque_lag + change.lag, 4));
  }
  if (change.stated_rate_hz) {
    log.push_back("rate_hz = " + number(*change.stated_rate_hz, 7));
    log.emplace_back("irregular = \"ignore\"");
  } else if (change.rate != 1.0 && columns.rate_hz) {
    log.push_back("rate_hz = " + number(*columns.rate_hz * change.rate, 7));
  } else if (change.rate != 1.0) {
    const Column time = columns.time.value_or(Column{"t"});
    log.push_back("time = { column = \"" + time.name +
                  "\", unit = \"s\", scale = " + number(time.scale / change.rate, 7) + " }");
  }
  std::vector<std::string> out;
  const auto add = [&](const char* section, const std::vector<std::string>& some) {
    if (!some.empty()) {
      out.emplace_back(section);
      out.insert(out.end(), some.begin(), some.end());
    }
  };
  add("[robot]", robot);
  add("[log]", log);
  for (std::size_t k = told.robot.couplings.size(); k < change.robot.couplings.size(); ++k) {
    const Coupling& coupling = change.robot.couplings[k];
    std::vector<std::string> joints;
    std::string ratios;
    for (std::size_t i = 0; i < coupling.joints.size(); ++i) {
      joints.push_back(detail::joint_name(told.robot, coupling.joints[i]));
      ratios += (ratios.empty() ? "" : ", ") + number(coupling.ratios[i]);
    }
    add("[[robot.coupling]]", {"motor = \"" + detail::joint_name(told.robot, coupling.motor) + "\"",
                               "joints = " + in_quotes_all(joints), "ratios = [" + ratios + "]"});
  }
  return out;
}

}  // namespace

bool HintTrial::helps() const {
  return before.held_out && after.held_out ? *after.held_out < *before.held_out : after.fit < before.fit;
}

HintTrial try_hint(const Experiment& experiment, std::string_view code, std::string_view subject,
                   Reading& reading) {
  const Case told{experiment, reading.logs(experiment.log, experiment.robot),
                  reading.logs(experiment.validation, experiment.robot)};
  const Identification result = run_case(told, told.logs, told.validation, true);
  const Change nothing{.what = {}, .robot = experiment.robot, .reading = as_told(experiment.robot)};
  const auto finding = std::ranges::find_if(result.warnings, [&](const Finding& f) {
    return f.code == code && (subject.empty() || f.subject == subject);
  });
  const bool found = finding != result.warnings.end();
  const std::string of = !subject.empty() || !found ? std::string(subject) : finding->subject;
  const ModelTest* const test = test_of(result, code, of);
  if (!found && test == nullptr) {
    std::vector<std::string> codes;
    for (const Finding& f : result.warnings) {
      codes.push_back(f.code + (f.subject.empty() ? "" : " of " + f.subject));
    }
    throw InputError("try: " + experiment.file.string() + " has no finding " + in_quotes(std::string(code)) +
                     (subject.empty() ? "" : " of " + in_quotes(std::string(subject))) +
                     (codes.empty() ? "; it has none at all" : "; it has " + listed(codes)));
  }
  const std::string taken = test != nullptr ? test->code : std::string(code);
  const std::string about = test != nullptr ? test->subject : of;
  std::optional<Change> change;
  if (test != nullptr && has_size(taken)) {
    change = sized(told, nothing, *test);
  } else {
    change = best_of(told, choices(nothing, taken, about, told.logs));
    if (change && change->lag != 0.0) {
      refine_lag(told, *change);
    }
  }
  if (!change) {
    throw InputError(
        "try: the hint of " + in_quotes(std::string(code)) + (about.empty() ? "" : " of " + about) +
        " is none that can be applied; rivid_identify explain " + std::string(code) + " says what to do");
  }
  const Case then = with(told, *change);
  const Identification changed_result = run_case(then, then.logs, then.validation, true);
  return {.finding = found ? *finding : Finding{taken, about, ""},
          .change = change->what,
          .lines = lines_of(experiment, *change),
          .before = outcome_of(told, result),
          .after = outcome_of(then, changed_result)};
}

std::string in_words(const HintTrial& trial) {
  const auto percent = [](double part) { return number(100.0 * part, 4) + " %"; };
  const auto row = [&](const char* what, const HintOutcome& of) {
    return std::string(what) + "  fit " + percent(of.fit) + ", held out " +
           (of.held_out ? percent(*of.held_out) : std::string("unknown")) + ", " +
           std::string(name(of.status)) + '\n';
  };
  std::string out = in_words(trial.finding) + "\ntried   " + trial.change + '\n' +
                    row("before", trial.before) + row("after ", trial.after);
  if (!trial.helps()) {
    return out + "It does not help: leave the experiment as it is.\n";
  }
  out += "It helps. In the experiment file:\n\n";
  for (const std::string& line : trial.lines) {
    out += (line.starts_with("[") && &line != &trial.lines.front() ? "\n" : "") + line + '\n';
  }
  return out;
}

}  // namespace rivid
