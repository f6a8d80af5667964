#include "rivid/identify/payload.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "binding.hpp"
#include "experiment/from_program.hpp"
#include "logs.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/report/payload.hpp"

namespace rivid::python {

namespace {

// Logs with one payload: its name, they, its mass.
using Load = std::tuple<std::string, std::vector<const Log*>, std::optional<double>>;

// From logs without payload, or on an arm that was identified before. Returns payload.json and the text of
// the command line.
std::pair<std::string, std::string> payloads(const Robot& robot, const std::vector<Load>& loads,
                                             const std::vector<const Log*>& without, const IdentifiedArm* arm,
                                             const std::string& sections, const PayloadOptions& options,
                                             int threads) {
  Experiment experiment = detail::experiment_from(robot, sections, "rivid.identify_payloads");
  experiment.estimation.threads = threads;
  std::vector<Logs> kept;
  kept.reserve(loads.size());
  std::vector<LoadedLogs> with;
  for (const auto& [name, logs, mass] : loads) {
    kept.emplace_back(logs);
    with.push_back({.name = name, .logs = kept.back().all(), .mass = mass});
  }
  const Logs alone(without);
  PayloadReport found = arm != nullptr
                            ? identify_payloads(*arm, with, experiment.estimation, options)
                            : identify_payloads(robot, alone.all(), with, experiment.estimation, options);
  examine(robot, alone.all(), with, experiment.estimation, found);
  return {to_json(found, options), in_words(found)};
}

}  // namespace

void bind_payload(nb::module_& m) {
  nb::class_<IdentifiedArm>(m, "IdentifiedArm", "An arm as it was identified before.")
      .def_static("of_result", &read_identified_arm, "path"_a, "robot"_a)
      .def_static("of_fit", &identified_arm, "robot"_a, "found"_a)
      .def_prop_ro("robot", [](const IdentifiedArm& self) { return self.robot; });
  nb::class_<PayloadOptions>(m, "PayloadOptions", "What is known beside the logs.")
      .def(
          "__init__",
          [](PayloadOptions* self, const std::string& model, const std::string& link,
             const Eigen::Matrix3d& R, const Eigen::Vector3d& p, const Vector& gain_sigma,
             bool load_friction) {
            const auto known = named<PayloadModel>(model);
            if (!known) {
              throw InputError("model is \"" + model + "\", must be automatic, point or body");
            }
            new (self) PayloadOptions{*known, link, R, p, gain_sigma, load_friction};
          },
          "model"_a, "link"_a, "R"_a, "p"_a, "gain_sigma"_a, "load_friction"_a);
  m.def("identify_payloads", &payloads, "robot"_a, "loads"_a, "without"_a, "arm"_a.none(), "sections"_a,
        "options"_a, "threads"_a, Unlocked());
}

}  // namespace rivid::python
