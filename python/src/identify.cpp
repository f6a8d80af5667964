#include <optional>
#include <sstream>
#include <utility>

#include "binding.hpp"
#include "experiment/from_program.hpp"
#include "experiment/json_fields.hpp"
#include "logs.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/friction_curves.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/report/html.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/text.hpp"

namespace rivid::python {

namespace {

// Source and digest of what a result was made from.
using Inputs = std::vector<std::pair<std::string, std::string>>;

Provenance provenance_of(const Identification& result, const Inputs& inputs) {
  Provenance out{
      .program = "rivid (Python)", .inputs = {}, .overrides = {}, .settings = settings(result.estimation)};
  for (const auto& [source, digest] : inputs) {
    out.inputs.push_back({source, digest});
  }
  return out;
}

// With the robot of the result, where friction laws were to be chosen or drive gains to be estimated.
std::pair<Identification, std::optional<Robot>> identified(
    const Robot& robot, const std::vector<const Log*>& logs, const std::vector<const Log*>& validation,
    const std::string& sections, const std::string& source, int threads, const nb::object& progress) {
  const nb::gil_scoped_release unlocked;
  Experiment experiment = detail::experiment_from(robot, sections, source);
  experiment.estimation.threads = threads;
  const Logs own(logs);
  Reading reading{Listener(progress)};
  const Logs others(validation);
  detail::take_friction(experiment, own.all(), others.all(), reading.progress());
  detail::take_gains(experiment, own.all(), reading);
  Identification found = identify_logs(experiment, own.all(), others.all(), reading.progress());
  const bool as_it_was = experiment.friction.empty() && !experiment.gain_report;
  return {std::move(found), as_it_was ? std::nullopt : std::optional(experiment.robot)};
}

std::string findings(const Robot& robot, const std::vector<const Log*>& logs,
                     const std::vector<const Log*>& validation, const std::string& sections, int threads) {
  const Experiment experiment = detail::experiment_from(robot, sections, "check");
  return to_json(check(robot, Logs(logs).all(), Logs(validation).all(),
                       {.signal = experiment.estimation.signal,
                        .instrumental = std::holds_alternative<Iv>(experiment.estimation.method),
                        .threads = threads}));
}

std::vector<Prediction> copies(const std::vector<const Prediction*>& predictions) {
  std::vector<Prediction> out;
  for (const Prediction* const p : predictions) {
    out.push_back(*p);
  }
  return out;
}

void bind_prediction(nb::module_& m) {
  nb::class_<Prediction> prediction(m, "Prediction", "Torques of a log, measured and predicted.");
  const auto columns = [](Vector JointPrediction::* member) {
    return [member](const Prediction& self) {
      Matrix out(self.samples(), std::ssize(self.joints));
      for (std::size_t j = 0; j < self.joints.size(); ++j) {
        out.col(static_cast<Index>(j)) = self.joints[j].*member;
      }
      return out;
    };
  };
  prediction.def_ro("source", &Prediction::source)
      .def_rw("validation", &Prediction::validation)
      .def_ro("start", &Prediction::start)
      .def_ro("f_m", &Prediction::f_m)
      .def_prop_ro("samples", &Prediction::samples)
      .def_prop_ro("measured", columns(&JointPrediction::measured))
      .def_prop_ro("predicted", columns(&JointPrediction::predicted))
      .def_prop_ro(
          "kept",
          [](const Prediction& self) {
            Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic> out(self.samples(), std::ssize(self.joints));
            for (std::size_t j = 0; j < self.joints.size(); ++j) {
              for (Index k = 0; k < self.samples(); ++k) {
                out(k, static_cast<Index>(j)) = self.joints[j].kept[static_cast<std::size_t>(k)] != 0;
              }
            }
            return out;
          })
      .def(
          "residual",
          [](const Prediction& self, std::size_t joint) { return self.joints.at(joint).residual; }, "joint"_a)
      .def(
          "row_torques",
          [](const Prediction& self, std::size_t joint) { return self.joints.at(joint).fitted.measured; },
          "joint"_a)
      .def(
          "rows", [](const Prediction& self, std::size_t joint) { return self.joints.at(joint).rows; },
          "joint"_a);
}

}  // namespace

void bind_identify(nb::module_& m) {
  bind_prediction(m);
  nb::class_<Identification> result(m, "Identification", "What an identification found.");
  result.def_prop_ro("status", [](const Identification& self) { return name(self.status); })
      .def_static("of_result", &result_of, "text"_a, "source"_a, Unlocked(),
                  "Its robot and it, of a result.json.")
      .def_ro("reasons", &Identification::reasons)
      .def_ro("title", &Identification::title)
      .def(
          "document",
          [](const Identification& self, const Robot& robot, const Inputs& inputs) {
            return to_json(robot, self, provenance_of(self, inputs));
          },
          "robot"_a, "inputs"_a, Unlocked(), "result.json")
      .def(
          "text",
          [](const Identification& self) {
            std::ostringstream out;
            out << self;
            return out.str();
          },
          Unlocked(), "The table of the command line.")
      .def(
          "predict",
          [](const Identification& self, const Robot& robot, const Log& log) {
            return predict(robot, self, log);
          },
          "robot"_a, "log"_a, Unlocked())
      .def(
          "validate",
          [](Identification& self, const Robot& robot, const Log& log, int threads) {
            const Validation& found = self.validation.emplace_back(validate(robot, self, log, threads));
            detail::Json out = detail::json_of(found.fit);
            out["forecast"] = detail::json_of(found.forecast);
            return out.dump();
          },
          "robot"_a, "log"_a, "threads"_a, Unlocked())
      .def(
          "html",
          [](const Identification& self, const Robot& robot,
             const std::vector<const Prediction*>& predictions, const Inputs& inputs) {
            return html_report(robot, self, copies(predictions), provenance_of(self, inputs));
          },
          "robot"_a, "predictions"_a, "inputs"_a, Unlocked())
      .def(
          "friction",
          [](const Identification& self, const Robot& robot,
             const std::vector<const Prediction*>& predictions) {
            return to_csv(friction_curves(robot, self, copies(predictions)));
          },
          "robot"_a, "predictions"_a, Unlocked(), "The table of --write-friction.")
      .def(
          "model",
          [](const Identification& self, const Robot& robot, const std::string& parameters, bool force) {
            IdentifiedModelOptions options{.parameters = std::nullopt, .force = force};
            if (!parameters.empty()) {
              options.parameters = parameters == "physical" ? ParameterSet::physical : ParameterSet::estimate;
            }
            return identified_model(robot, self, options);
          },
          "robot"_a, "parameters"_a, "force"_a, Unlocked());
  def_array(result, "chi", &Identification::chi, "Estimate of the base parameters.");
  def_array(result, "covariance", &Identification::C_chi, "Its covariance.");
  m.def("identify", &identified, "robot"_a, "logs"_a, "validation"_a, "sections"_a, "source"_a,
        "threads"_a = 1, "progress"_a = nb::none());
  m.def("check", &findings, "robot"_a, "logs"_a, "validation"_a, "sections"_a, "threads"_a = 1, Unlocked(),
        "Findings about robot and logs, as JSON.");
}

}  // namespace rivid::python
