#include <algorithm>

#include "experiment/sections.hpp"
#include "rivid/experiment/monte_carlo.hpp"

namespace rivid {

using detail::TomlReader;

namespace {

const TomlReader& require(const std::optional<TomlReader>& section, const std::filesystem::path& path,
                          const char* name) {
  if (!section) {
    throw InputError(path.string() + ": section [" + name + "] is missing");
  }
  return *section;
}

// The sections of a file, looked up before one can be missing, so that a mistyped name is reported first.
struct FileSections {
  FileSections(const toml::table& table, const std::filesystem::path& path, Use use) {
    TomlReader keys(table, path.string(), "");
    for (const auto& [name, section] :
         {std::pair("robot", &robot), std::pair("log", &log), std::pair("signal", &signal),
          std::pair("method", &method), std::pair("validation", &validation), std::pair("control", &control),
          std::pair("reference", &reference), std::pair("simulation", &simulation),
          std::pair("montecarlo", &montecarlo)}) {
      if (auto found = keys.section(name)) {
        section->emplace(std::move(*found));
      }
    }
    keys.finish();
    require(robot, path, "robot");
    if (use == Use::identification) {
      require(log, path, "log");
      require(signal, path, "signal");
    } else {
      require(control, path, "control");
      require(reference, path, "reference");
      require(simulation, path, "simulation");
    }
  }

  std::optional<TomlReader> robot, log, signal, method, validation, control, reference, simulation,
      montecarlo;
};

Experiment experiment_of(const FileSections& sections, const std::filesystem::path& path) {
  const std::filesystem::path folder = path.parent_path();
  Experiment out;
  out.file = path;
  out.robot = detail::read_robot(*sections.robot, folder, out.robot_file);
  const Index n = out.robot.size();
  if (sections.log) {
    out.log = detail::read_log_source(*sections.log, {}, folder, out.robot);
  }
  if (sections.signal) {
    out.estimation.signal = detail::read_signal(*sections.signal, n);
  }
  if (sections.method) {
    detail::read_method(*sections.method, out);
  }
  out.validation = out.log;
  out.validation.files.clear();
  out.validation.reference.reset();  // it is the motion of the first log
  if (sections.validation) {
    out.validation = detail::read_log_source(*sections.validation, out.log, folder, out.robot);
  }
  if (sections.control) {
    out.control = detail::read_control(*sections.control, out.robot);
  }
  if (sections.reference) {
    out.reference = detail::read_reference_source(*sections.reference, folder, n);
  }
  if (sections.simulation) {
    out.simulation = detail::read_simulation(*sections.simulation, folder, n, out.control);
  }
  return out;
}

MonteCarlo::Trial read_trial(TomlReader keys, const MonteCarlo& plan, bool has_signal) {
  MonteCarlo::Trial out{.label = {}, .experiment = plan.experiment};
  const toml::node* const label = keys.find("label");
  if (label == nullptr) {
    keys.fail("must have a label, which its rows are called after");
  }
  out.label = keys.as<std::string>(*label, "label");
  if (out.label.empty() || out.label.find_first_of(",\n\r") != std::string::npos) {
    keys.fail(*label, "label", "must be a word or more without a comma");
  }
  if (std::ranges::find(plan.trials, out.label, &MonteCarlo::Trial::label) != plan.trials.end()) {
    keys.fail(*label, "label", "\"" + out.label + "\" is that of another trial");
  }
  if (const auto signal = keys.section("signal")) {
    out.experiment.estimation.signal = detail::read_signal(*signal, out.experiment.robot.size());
  } else if (!has_signal) {
    keys.fail("must have a table signal, since there is no section [signal] for all trials");
  }
  if (const auto control = keys.section("control")) {
    out.experiment.control = detail::read_control(*control, out.experiment.robot);
  }
  for (const auto& [key, origin] : detail::origins(keys.table())) {
    const bool of_section = key.starts_with("signal") || key.starts_with("control");
    out.experiment.origins[of_section ? key : "method." + key] = origin;
  }
  detail::read_method(std::move(keys), out.experiment);
  return out;
}

constexpr std::string_view experiment_file = "the experiment file";

}  // namespace

Experiment read_experiment(const std::filesystem::path& path, Use use,
                           std::span<const std::string> settings) {
  const toml::table table = detail::parsed_toml(path, experiment_file, settings);
  Experiment out = experiment_of(FileSections(table, path, use), path);
  out.origins = detail::origins(table);
  return out;
}

MonteCarlo read_monte_carlo(const std::filesystem::path& path, std::span<const std::string> settings) {
  const toml::table table = detail::parsed_toml(path, experiment_file, settings);
  const FileSections sections(table, path, Use::simulation);
  MonteCarlo out;
  out.experiment = experiment_of(sections, path);
  out.experiment.origins = detail::origins(table);
  out.settings.assign(settings.begin(), settings.end());
  TomlReader keys = require(sections.montecarlo, path, "montecarlo");
  keys.read(out);
  const toml::node* const trials = keys.find("trial");
  keys.finish();
  if (trials == nullptr || !trials->is_array() || trials->as_array()->empty()) {
    keys.fail("must have at least one table [[montecarlo.trial]]");
  }
  for (const toml::node* const trial : TomlReader::items(*trials)) {
    out.trials.push_back(read_trial(keys.section(*trial, "trial"), out, sections.signal.has_value()));
  }
  return out;
}

}  // namespace rivid
