#include "experiment/identification_sections.hpp"
#include "experiment/simulation_sections.hpp"
#include "experiment/text_file.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid {

using detail::TomlReader;

Experiment read_experiment(const std::filesystem::path& path, Use use) {
  const toml::table table = detail::parsed_toml(path, "the experiment file");
  const std::filesystem::path folder = path.parent_path();
  TomlReader keys(table, path.string(), "");
  // All sections are looked up before one can be missing, so that a mistyped name is told first.
  const auto robot = keys.section("robot");
  const auto log = keys.section("log");
  const auto signal = keys.section("signal");
  auto method = keys.section("method");
  const auto validation = keys.section("validation");
  const auto control = keys.section("control");
  const auto reference = keys.section("reference");
  const auto simulation = keys.section("simulation");
  static_cast<void>(keys.find("montecarlo"));  // read_monte_carlo() reads it
  keys.finish();
  const auto require = [&](const std::optional<TomlReader>& section, const char* name) -> const TomlReader& {
    if (!section) {
      throw InputError(path.string() + ": section [" + name + "] is missing");
    }
    return *section;
  };
  const TomlReader& robot_keys = require(robot, "robot");
  if (use == Use::identification) {
    require(log, "log");
    require(signal, "signal");
  } else {
    require(control, "control");
    require(reference, "reference");
    require(simulation, "simulation");
  }

  Experiment out;
  out.file = path;
  out.robot = detail::read_robot(robot_keys, folder, out.robot_file);
  if (log) {
    out.log = detail::read_log_source(*log, {}, folder, out.robot);
  }
  if (signal) {
    out.estimation.signal = detail::read_signal(*signal, out.robot.size());
  }
  if (method) {
    detail::read_method(*method, out);
  }
  out.validation = out.log;
  out.validation.files.clear();
  out.validation.reference.reset();  // it is the motion of the first log
  if (validation) {
    out.validation = detail::read_log_source(*validation, out.log, folder, out.robot);
  }
  if (control) {
    out.control = detail::read_control(*control, out.robot);
  }
  if (reference) {
    out.reference = detail::read_reference_source(*reference, folder, out.robot.size());
  }
  if (simulation) {
    out.simulation = detail::read_simulation(*simulation, folder, out.robot.size(), out.control);
  }
  return out;
}

}  // namespace rivid
