#include "binding.hpp"
#include "data/log_columns.hpp"
#include "experiment/from_program.hpp"
#include "experiment/recognised_columns.hpp"
#include "experiment/sections.hpp"
#include "rivid/data/adjust.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/report/text.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/signal/filter.hpp"

namespace rivid::python {

namespace {

using LogState =
    std::tuple<std::string, double, Vector, Matrix, Matrix, Matrix, Matrix, Matrix, Matrix,
               std::vector<std::string>, std::vector<std::tuple<std::string, std::string, std::string>>>;

LogState state(const Log& log) {
  std::vector<std::tuple<std::string, std::string, std::string>> warnings;
  for (const Finding& w : log.warnings) {
    warnings.emplace_back(w.code, w.subject, w.text);
  }
  return {log.source, log.f_m, log.t,    log.q,     log.qd,  log.tau,
          log.v_tau,  log.q_r, log.qd_r, log.notes, warnings};
}

Log log_in(const LogState& state) {
  Log log;
  std::vector<std::tuple<std::string, std::string, std::string>> warnings;
  std::tie(log.source, log.f_m, log.t, log.q, log.qd, log.tau, log.v_tau, log.q_r, log.qd_r, log.notes,
           warnings) = state;
  for (const auto& [code, subject, text] : warnings) {
    log.warnings.push_back(Finding{code, subject, text});
  }
  return log;
}

// Keys of [log] by the names of columns: key → columns, unit; and what was doubtful.
std::pair<std::map<std::string, std::pair<std::vector<std::string>, std::optional<std::string>>>,
          std::vector<std::string>>
recognised(const std::vector<std::string>& names, const Robot& robot) {
  const detail::RecognisedLog found = detail::recognised_log(names, detail::joint_names(robot));
  std::map<std::string, std::pair<std::vector<std::string>, std::optional<std::string>>> out;
  const auto add = [&](std::string_view key, const detail::RecognisedColumns& columns) {
    if (!columns.columns.empty()) {
      out[std::string(key)] = {columns.columns, columns.unit};
    }
  };
  add("time", found.time);
  for (const detail::LogKey& key : detail::log_keys) {
    add(key.key, found.*key.columns);
  }
  return {out, found.doubts};
}

void bind_log(nb::module_& m) {
  nb::class_<Log> log(
      m, "Log", "What was recorded while a robot moved: one row a sample, one column a joint, in SI units.");
  log.def(
         "__init__",
         [](Log* self, const std::string& source, const std::vector<std::string>& names, const Matrix& values,
            std::optional<double> rate_hz) {
           Table table;
           table.source = source;
           table.names = names;
           table.values = values;
           Log made = detail::log_of(table, {.rate_hz = rate_hz});
           if (const auto fault = made.complaint()) {
             throw InputError(*fault);
           }
           new (self) Log(std::move(made));
         },
         "source"_a, "names"_a, "values"_a, "rate_hz"_a = nb::none(),
         "A log of columns with default names: t, q1 …, tau1 …, v1 …, qref1 …")
      .def_ro("source", &Log::source, "What messages name it by.")
      .def_ro("f_m", &Log::f_m, "Measuring rate [Hz].")
      .def_ro("notes", &Log::notes, "What was found or done.")
      .def_prop_ro(
          "findings", [](const Log& self) { return to_json(std::span<const Finding>(self.warnings)); },
          "What may make a result wrong, as JSON.")
      .def(
          "note", [](Log& self, const std::string& text) { self.notes.push_back(text); }, "text"_a)
      .def_prop_ro("samples", &Log::samples)
      .def_prop_ro("joints", &Log::joints)
      .def(
          "to_csv", [](const Log& self) { return to_csv(self); }, Unlocked())
      .def("__getstate__", &state)
      .def("__setstate__", [](Log& self, const LogState& from) { new (&self) Log(log_in(from)); });
  def_array(log, "t", &Log::t, "Instants [s].");
  def_array(log, "q", &Log::q, "Measured positions [rad | m].");
  def_array(log, "qd", &Log::qd, "Measured velocities, or empty [rad/s | m/s].");
  def_array(log, "tau", &Log::tau, "Joint-side torques, or empty [N·m | N].");
  def_array(log, "v_tau", &Log::v_tau, "Control signals, or empty.");
  def_array(log, "q_r", &Log::q_r, "Reference positions, or empty [rad | m].");
  def_array(log, "qd_r", &Log::qd_r, "Reference velocities, or empty [rad/s | m/s].");
  m.def(
      "read_logs",
      [](const Robot& robot, const std::string& keys, const std::string& source, const nb::object& progress) {
        const LogSource files = detail::log_source_of(robot, keys, source);
        const nb::gil_scoped_release unlocked;
        return read_logs(files, robot, Listener(progress));
      },
      "robot"_a, "keys"_a, "source"_a, "progress"_a = nb::none(), "The logs of files, as [log] says.");
  m.def(
      "logs_of",
      [](const Robot& robot, const std::string& keys, const std::string& source,
         const std::vector<std::string>& names, const Matrix& values) {
        Table table;
        table.source = source;
        table.names = names;
        table.values = values;
        return detail::logs_of(table, detail::log_source_of(robot, keys, source), robot);
      },
      "robot"_a, "keys"_a, "source"_a, "names"_a, "values"_a, Unlocked(),
      "The logs in a table, as [log] says.");
  m.def(
      "column_names", [](const std::filesystem::path& path) { return column_names(path); }, "path"_a,
      Unlocked());
  m.def("recognised", &recognised, "names"_a, "robot"_a,
        "Keys of [log] by the names of columns, and what was doubtful.");
  m.def(
      "default_columns", [](const std::vector<std::string>& names) { return detail::default_columns(names); },
      "names"_a, "Columns that are read where none are listed, by the keys of [log].");
  m.def(
      "nanoseconds_of",
      [](const std::string& seconds, const std::vector<std::string>& names) {
        return detail::nanoseconds_of(seconds, names);
      },
      "seconds"_a, "names"_a, "The column of nanoseconds that belongs to one of seconds.");
  m.def(
      "shift_torque", [](const Log& log, double lag) { return shift_torque(log, lag); }, "log"_a, "lag"_a,
      Unlocked(), "The log with torques and control signals `lag` samples earlier.");
}

void bind_signal(nb::module_& m) {
  const auto convention_of = [](const std::string& word) {
    const auto found = named<Convention>(word);
    if (!found) {
      throw InputError("convention is " + in_quotes(word) + ", must be \"standard\" or \"matlab\"");
    }
    return *found;
  };
  m.def(
      "zero_phase",
      [=](const Matrix& x, double f_m, double cutoff_hz, int order, const std::string& convention) {
        return zero_phase(x, f_m, cutoff_hz, order, convention_of(convention));
      },
      "x"_a, "f_m"_a, "cutoff_hz"_a, "order"_a = 4, "convention"_a = "standard", Unlocked(),
      "Each column through a Butterworth low-pass forwards, then backwards.");
  m.def(
      "differentiate",
      [](const Matrix& q, double f_m) {
        const Motion out = differentiate(q, f_m);
        return std::tuple(out.q, out.qd, out.qdd);
      },
      "q"_a, "f_m"_a, Unlocked(), "q, q̇ and q̈ by central differences.");
  m.def(
      "decimate",
      [=](const Matrix& x, const std::vector<int>& stages, const std::string& convention) {
        return decimate(x, stages, convention_of(convention));
      },
      "x"_a, "stages"_a, "convention"_a = "standard", Unlocked(),
      "Parallel decimation (13, 14) of each column.");
  m.def(
      "deviation_factor", [](const std::vector<int>& stages) { return deviation_factor(stages); }, "stages"_a,
      "What decimation makes of classical standard deviations.");
}

}  // namespace

void bind_data(nb::module_& m) {
  nb::class_<Robot> robot(m, "Robot", "A serial robot.");
  robot
      .def_static(
          "of_description",
          [](const std::string& text, const std::string& source, const std::string& name, bool mdh,
             const std::string& keys) {
            return detail::robot_of({.text = text, .source = source, .name = name, .mdh = mdh}, keys);
          },
          "text"_a, "source"_a, "name"_a, "mdh"_a, "keys"_a, Unlocked(),
          "The robot of a URDF or of a modified Denavit-Hartenberg table, with the keys of [robot].")
      .def_ro("name", &Robot::name)
      .def_ro("base", &Robot::base)
      .def_prop_ro("size", &Robot::size)
      .def_prop_ro("joint_names", [](const Robot& self) { return detail::joint_names(self); })
      .def_prop_ro("parameter_names",
                   [](const Robot& self) {
                     std::vector<std::string> out;
                     for (const StandardParameter& p : self.standard_parameters()) {
                       out.push_back(p.name());
                     }
                     return out;
                   })
      .def_prop_ro("findings",
                   [](const Robot& self) { return to_json(std::span<const Finding>(self.warnings)); })
      .def("chi_st", &Robot::chi_st)
      .def(
          "effort", [](const Robot& self, const Log& log) { return effort(self, log); }, "log"_a, Unlocked());
  const auto limits = [](double Joint::* member) {
    return [member](const Robot& self) {
      Vector out(self.size());
      for (Index j = 0; j < out.size(); ++j) {
        out[j] = self.joints[static_cast<std::size_t>(j)].*member;
      }
      return out;
    };
  };
  robot.def_prop_ro("lower", limits(&Joint::lower))
      .def_prop_ro("upper", limits(&Joint::upper))
      .def_prop_ro("max_velocity", limits(&Joint::max_velocity))
      .def_prop_ro("max_effort", limits(&Joint::max_effort));
  bind_log(m);
  bind_signal(m);
}

}  // namespace rivid::python
