
#include "binding.hpp"
#include "experiment/from_program.hpp"
#include "experiment/json_fields.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/report/excitation.hpp"
#include "rivid/report/html.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/monte_carlo.hpp"

namespace rivid::python {

namespace {

using Settings = std::vector<std::string>;

// Of a plan that has the settings of its file.
template <typename Inputs>
Provenance provenance_from(const Inputs& inputs, std::vector<Setting> settings, const Settings& overrides) {
  Provenance out{.program = "rivid (Python)", .inputs = {}, .overrides = {}, .settings = std::move(settings)};
  for (const std::string& setting : overrides) {
    const std::size_t equals = setting.find('=');
    out.overrides.emplace_back("set " + setting.substr(0, equals), setting.substr(equals + 1));
  }
  for (const std::filesystem::path& input : inputs) {
    out.inputs.push_back(input_file(input));
  }
  return out;
}

void bind_simulation(nb::module_& m) {
  nb::class_<SimulationRecord> record(m, "SimulationRecord", "A simulated experiment.");
  record.def_prop_ro("outcome", [](const SimulationRecord& self) { return name(self.simulation.outcome); })
      .def_prop_ro("reason", [](const SimulationRecord& self) { return self.simulation.reason; })
      .def_ro("log", &SimulationRecord::log)
      .def(
          "document",
          [](const SimulationRecord& self, const Robot& robot) {
            return to_json(robot, self, {.program = "rivid (Python)", .inputs = {}, .overrides = {}});
          },
          "robot"_a, Unlocked(), "simulation.json")
      .def(
          "text", [](const SimulationRecord& self, const Robot& robot) { return summary(robot, self); },
          "robot"_a);
  const auto array = [&](const char* name, const auto& member) {
    record.def_prop_ro(
        name, [member](const SimulationRecord& self) { return view(member(self.simulation)); },
        nb::rv_policy::reference_internal);
  };
  array("t", [](const Simulation& s) -> const Vector& { return s.t; });
  array("q", [](const Simulation& s) -> const Matrix& { return s.motion.q; });
  array("qd", [](const Simulation& s) -> const Matrix& { return s.motion.qd; });
  array("qdd", [](const Simulation& s) -> const Matrix& { return s.motion.qdd; });
  array("tau", [](const Simulation& s) -> const Matrix& { return s.tau; });
  array("v_tau", [](const Simulation& s) -> const Matrix& { return s.v_tau; });
  array("q_r", [](const Simulation& s) -> const Matrix& { return s.q_r; });
  m.def(
      "simulate",
      [](const Robot& robot, const std::string& sections, const nb::object& progress) {
        const nb::gil_scoped_release unlocked;
        return run_simulation(detail::experiment_from(robot, sections, "simulate"), Listener(progress));
      },
      "robot"_a, "sections"_a, "progress"_a = nb::none());
}

void bind_monte_carlo(nb::module_& m) {
  nb::class_<MonteCarloRow>(m, "MonteCarloRow", "What one trial made of one run.")
      .def_ro("run", &MonteCarloRow::run)
      .def_ro("label", &MonteCarloRow::label)
      .def_ro("status", &MonteCarloRow::status)
      .def_ro("iterations", &MonteCarloRow::iterations)
      .def_ro("seconds", &MonteCarloRow::seconds)
      .def_ro("quantile", &MonteCarloRow::quantile)
      .def_ro("value", &MonteCarloRow::value)
      .def_ro("sigma", &MonteCarloRow::sigma)
      .def("__getstate__",
           [](const MonteCarloRow& r) {
             return std::tuple(r.run, r.label, r.status, r.iterations, r.seconds, r.quantile, r.value,
                               r.sigma);
           })
      .def("__setstate__",
           [](MonteCarloRow& self,
              const std::tuple<int, std::string, std::string, int, double, double, Vector, Vector>& s) {
             new (&self) MonteCarloRow{std::get<0>(s), std::get<1>(s), std::get<2>(s), std::get<3>(s),
                                       std::get<4>(s), std::get<5>(s), std::get<6>(s), std::get<7>(s)};
           });
  nb::class_<MonteCarlo>(m, "MonteCarlo", "A study of [montecarlo].")
      .def(
          "__init__",
          [](MonteCarlo* self, const std::filesystem::path& path, const Settings& settings) {
            new (self) MonteCarlo(read_monte_carlo(path, settings));
          },
          "path"_a, "settings"_a, Unlocked())
      .def_rw("runs", &MonteCarlo::runs)
      .def_ro("seed", &MonteCarlo::seed)
      .def_prop_ro("robot", [](const MonteCarlo& self) { return self.experiment.robot; })
      .def_prop_ro("inputs", [](const MonteCarlo& self) { return self.experiment.inputs(Use::simulation); })
      .def(
          "run",
          [](const MonteCarlo& self, const std::vector<int>& runs, int threads, const nb::object& progress) {
            const nb::gil_scoped_release unlocked;
            const Listener listener(progress);
            std::vector<MonteCarloRow> out;
            double done = 0.0;
            monte_carlo_runs(self, runs, threads, [&](const std::vector<MonteCarloRow>& rows) {
              out.insert(out.end(), rows.begin(), rows.end());
              done += 1.0;
              listener("runs", done / static_cast<double>(runs.size()));
            });
            return out;
          },
          "runs"_a, "threads"_a, "progress"_a = nb::none())
      .def(
          "summary",
          [](const MonteCarlo& self, const std::vector<MonteCarloRow>& rows) {
            return to_json(summaries(self, rows));
          },
          "rows"_a, Unlocked(), "summary.json")
      .def(
          "text",
          [](const MonteCarlo& self, const std::vector<MonteCarloRow>& rows) {
            return in_words(summaries(self, rows));
          },
          "rows"_a, Unlocked())
      .def(
          "html",
          [](const MonteCarlo& self, const std::vector<MonteCarloRow>& rows) {
            return html_report(self, summaries(self, rows), rows,
                               provenance_from(self.experiment.inputs(Use::simulation),
                                               settings(self.experiment, Use::simulation), self.settings));
          },
          "rows"_a, Unlocked());
}

void bind_excitation(nb::module_& m) {
  m.def(
      "design",
      [](const std::filesystem::path& path, const Settings& overrides, int threads,
         const nb::object& progress) {
        const nb::gil_scoped_release unlocked;
        ExcitationPlan plan = read_excitation(path, overrides);
        plan.options.known = known_information(plan);
        plan.options.threads = threads;
        plan.options.progress = Listener(progress);
        const Excitation found = design(plan.experiment.robot, plan.options);
        return std::tuple(to_json(plan, found, provenance_from(plan.inputs(), settings(plan), overrides)),
                          summary(found), found.t, found.motion.q, found.motion.qd, found.motion.qdd);
      },
      "path"_a, "settings"_a, "threads"_a, "progress"_a = nb::none(),
      "plan.json, its summary, and t, q, q̇, q̈ of a designed motion.");
}

}  // namespace

void bind_experiment(nb::module_& m) {
  nb::class_<Experiment>(m, "Experiment", "What an experiment file says.")
      .def(
          "__init__",
          [](Experiment* self, const std::filesystem::path& path, const Settings& settings, bool simulation) {
            new (self) Experiment(
                read_experiment(path, simulation ? Use::simulation : Use::identification, settings));
          },
          "path"_a, "settings"_a, "simulation"_a, Unlocked())
      .def_prop_ro("robot", [](const Experiment& self) { return self.robot; })
      .def(
          "inputs",
          [](const Experiment& self, bool simulation) {
            return self.inputs(simulation ? Use::simulation : Use::identification);
          },
          "simulation"_a, "All files that it reads, itself first.")
      .def(
          "logs",
          [](const Experiment& self, bool validation, const nb::object& progress) {
            const nb::gil_scoped_release unlocked;
            return read_logs(validation ? self.validation : self.log, self.robot, Listener(progress));
          },
          "validation"_a, "progress"_a = nb::none())
      .def(
          "run",
          [](Experiment& self, int threads, const nb::object& progress) {
            const nb::gil_scoped_release unlocked;
            self.estimation.threads = threads;
            Reading reading{Listener(progress)};
            take_friction(self, reading);
            take_gains(self, reading);
            return run(self, reading);
          },
          "threads"_a, "progress"_a = nb::none())
      .def(
          "simulate",
          [](const Experiment& self, const nb::object& progress) {
            const nb::gil_scoped_release unlocked;
            return run_simulation(self, Listener(progress));
          },
          "progress"_a = nb::none())
      .def(
          "settings",
          [](const Experiment& self, bool simulation) {
            std::vector<std::tuple<std::string, std::string, std::string, std::string>> out;
            for (const Setting& s : settings(self, simulation ? Use::simulation : Use::identification)) {
              out.emplace_back(s.key, s.value, s.unit, s.origin);
            }
            return out;
          },
          "simulation"_a)
      .def(
          "document",
          [](const Experiment& self, const Identification& result, const Settings& overrides) {
            return to_json(self.robot, result, provenance_from(self.inputs(), settings(self), overrides));
          },
          "result"_a, "settings"_a, Unlocked(), "result.json")
      .def(
          "html",
          [](const Experiment& self, const Identification& result, const Settings& overrides) {
            Reading reading;
            return html_report(self.robot, result, shown_predictions(self, result, reading).predictions,
                               provenance_from(self.inputs(), settings(self), overrides));
          },
          "result"_a, "settings"_a, Unlocked(), "report.html");
  m.def(
      "draft",
      [](const std::filesystem::path& file, const std::filesystem::path& robot, const std::string& tip,
         const std::vector<std::filesystem::path>& logs) {
        const ExperimentDraft out = draft_experiment(file, robot, {.tip = tip}, logs);
        return std::tuple(out.text, out.complete, out.doubts);
      },
      "file"_a, "robot"_a, "tip"_a, "logs"_a, Unlocked(),
      "Text of an experiment file, whether it is complete, doubts.");
  bind_simulation(m);
  bind_monte_carlo(m);
  bind_excitation(m);
}

}  // namespace rivid::python
