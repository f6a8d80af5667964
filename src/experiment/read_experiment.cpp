#include <algorithm>
#include <array>

#include "experiment/from_program.hpp"
#include "experiment/read_excitation.hpp"
#include "experiment/sections.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/monte_carlo.hpp"

namespace rivid {

using detail::TomlReader;

namespace {

constexpr auto of_identification = std::to_array<std::string_view>({"robot", "log"});
constexpr auto of_simulation =
    std::to_array<std::string_view>({"robot", "control", "reference", "simulation"});
constexpr auto of_monte_carlo =
    std::to_array<std::string_view>({"robot", "control", "reference", "simulation", "montecarlo"});
constexpr auto of_excitation = std::to_array<std::string_view>({"robot", "excitation"});

// The sections of a file, looked up before one can be missing, so that a mistyped name is reported first.
struct FileSections {
  FileSections(const toml::table& table, const std::filesystem::path& path,
               std::span<const std::string_view> required) {
    TomlReader keys(table, path.string(), "");
    for (const auto& [name, section] :
         {std::pair("robot", &robot), std::pair("log", &log), std::pair("signal", &signal),
          std::pair("method", &method), std::pair("validation", &validation), std::pair("control", &control),
          std::pair("reference", &reference), std::pair("simulation", &simulation),
          std::pair("montecarlo", &montecarlo), std::pair("excitation", &excitation)}) {
      if (auto found = keys.section(name)) {
        section->emplace(std::move(*found));
      }
    }
    keys.finish();
    for (const std::string_view name : required) {
      if (!table.contains(name)) {
        throw InputError(path.string() + ": section [" + std::string(name) + "] is missing");
      }
    }
  }

  std::optional<TomlReader> robot, log, signal, method, validation, control, reference, simulation,
      montecarlo, excitation;
};

// What the sections beside [robot] say of an experiment whose robot is known.
void read_sections(const FileSections& sections, const std::filesystem::path& folder, Experiment& out) {
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
  if (sections.excitation) {
    std::vector<std::filesystem::path> known;
    (void)detail::read_excitation_options(*sections.excitation, folder, out.robot, known);  // its checks
  }
}

Experiment experiment_of(const FileSections& sections, const std::filesystem::path& path) {
  Experiment out;
  out.file = path;
  out.robot = detail::read_robot(*sections.robot, path.parent_path(), out.robot_file);
  read_sections(sections, path.parent_path(), out);
  return out;
}

MonteCarlo::Trial read_trial(TomlReader keys, const MonteCarlo& plan) {
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
  const std::span<const std::string_view> required =
      use == Use::identification ? std::span<const std::string_view>(of_identification) : of_simulation;
  Experiment out = experiment_of(FileSections(table, path, required), path);
  out.origins = detail::origins(table);
  return out;
}

Experiment detail::experiment_from(const Robot& robot, std::string_view sections, const std::string& source) {
  const toml::table table = parsed_toml_text(sections, source);
  const FileSections read(table, source, {});
  if (read.robot) {
    throw InputError(source + ": [robot] is said by the robot");
  }
  Experiment out;
  out.file = source;
  out.robot = robot;
  read_sections(read, {}, out);
  return out;
}

Robot detail::robot_of(const RobotDescription& description, std::string_view keys) {
  const toml::table table = parsed_toml_text(keys, description.source);
  TomlReader reader(table, description.source, "robot");
  const UrdfOptions options = read_urdf_options(reader);
  if (!description.mdh) {
    return with_options(std::move(reader), parse_urdf(description.text, description.source, options));
  }
  refuse_links_of_table(reader);
  return with_options(std::move(reader), mdh_robot(parsed_text_table(description.text, description.source),
                                                   description.name, options.gravity));
}

LogSource detail::log_source_of(const Robot& robot, std::string_view keys, const std::string& source) {
  const toml::table table = parsed_toml_text(keys, source);
  return read_log_source(TomlReader(table, source, "log"), {}, {}, robot);
}

MonteCarlo read_monte_carlo(const std::filesystem::path& path, std::span<const std::string> settings) {
  const toml::table table = detail::parsed_toml(path, experiment_file, settings);
  const FileSections sections(table, path, of_monte_carlo);
  MonteCarlo out;
  out.experiment = experiment_of(sections, path);
  out.experiment.origins = detail::origins(table);
  out.settings.assign(settings.begin(), settings.end());
  TomlReader keys = *sections.montecarlo;
  keys.read(out);
  const toml::node* const trials = keys.find("trial");
  keys.finish();
  if (trials == nullptr || !trials->is_array() || trials->as_array()->empty()) {
    keys.fail("must have at least one table [[montecarlo.trial]]");
  }
  for (const toml::node* const trial : TomlReader::items(*trials)) {
    out.trials.push_back(read_trial(keys.section(*trial, "trial"), out));
  }
  return out;
}

ExcitationPlan read_excitation(const std::filesystem::path& path, std::span<const std::string> settings) {
  const toml::table table = detail::parsed_toml(path, experiment_file, settings);
  const FileSections sections(table, path, of_excitation);
  ExcitationPlan out;
  out.experiment = experiment_of(sections, path);
  out.experiment.origins = detail::origins(table);
  out.settings.assign(settings.begin(), settings.end());
  out.options = detail::read_excitation_options(*sections.excitation, path.parent_path(),
                                                out.experiment.robot, out.known);
  if (!out.known.empty() && !sections.log) {
    throw InputError(path.string() + ": [excitation] known names logs, which [log] says how to read");
  }
  return out;
}

}  // namespace rivid
