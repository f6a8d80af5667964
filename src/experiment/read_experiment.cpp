#include <algorithm>
#include <array>

#include "experiment/from_program.hpp"
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

// "; did you mean "signal.decimation"?", of a key that stands in no section.
template <Described Record>
void look_for(std::string_view key, std::string_view section, std::string& guess) {
  for_each_field<Record>([&](const auto& field) {
    using Value = KeyValue<std::decay_t<decltype(field.member)>, Record>;
    if constexpr (Described<Value>) {
      if (field.key.empty()) {
        look_for<Value>(key, section, guess);
      }
    }
    const std::string name(field.key);
    if (name == key || (guess.empty() && !did_you_mean(key, std::span(&name, 1)).empty())) {
      guess = "; did you mean \"" + std::string(section) + "." + name + "\"?";
    }
  });
}

std::string with_section(std::string_view key) {
  std::string guess;
  look_for<ControlLoop>(key, "control", guess);
  look_for<Joint>(key, "robot", guess);
  look_for<LogSource>(key, "log", guess);
  look_for<CovarianceOptions>(key, "method", guess);
  look_for<Robust>(key, "method", guess);
  look_for<Iv>(key, "method", guess);
  look_for<SignalOptions>(key, "signal", guess);
  return guess;
}

// The sections of a file, looked up before one can be missing, so that a mistyped name is reported first.
struct FileSections {
  FileSections(const toml::table& table, const std::filesystem::path& path,
               std::span<const std::string_view> required) {
    TomlReader keys(table, path.string(), "", path.parent_path());
    for (const auto& [name, section] :
         {std::pair("robot", &robot), std::pair("log", &log), std::pair("signal", &signal),
          std::pair("method", &method), std::pair("validation", &validation), std::pair("control", &control),
          std::pair("reference", &reference), std::pair("simulation", &simulation),
          std::pair("montecarlo", &montecarlo), std::pair("excitation", &excitation)}) {
      if (auto found = keys.section(name)) {
        section->emplace(std::move(*found));
      }
    }
    for (const auto& [key, node] : table) {
      const std::string guess = node.is_table() ? "" : with_section(key.str());
      if (!guess.empty()) {
        keys.refuse_unknown(key, guess);
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
void read_sections(FileSections& sections, Experiment& out) {
  const auto read = [&](std::optional<TomlReader>& section, const auto& take) {
    if (section) {
      take(section->of(out.robot));
    }
  };
  read(sections.log, [&](TomlReader& keys) { out.log = detail::read_log_source(keys, {}); });
  if (out.log.torque_without == LogSource::Without::gravity) {
    out.robot.chain.gravity.setZero();
  }
  read(sections.signal, [&](TomlReader& keys) { out.estimation.signal = detail::read_signal(keys); });
  read(sections.method, [&](TomlReader& keys) { detail::read_method(keys, out); });
  out.validation = out.log;
  out.validation.files.clear();
  out.validation.reference.reset();  // it is the motion of the first log
  read(sections.validation,
       [&](TomlReader& keys) { out.validation = detail::read_log_source(keys, out.log); });
  read(sections.control, [&](TomlReader& keys) { out.control = detail::read_control(keys); });
  if (out.control && !sections.simulation) {  // a simulation takes the motion of a log alone
    for (LogSource* const source : {&out.log, &out.validation}) {
      source->law = out.control->control;
      source->sampling = out.control->sampling;
    }
  }
  read(sections.reference, [&](TomlReader& keys) { out.reference = detail::read_reference_source(keys); });
  read(sections.simulation,
       [&](TomlReader& keys) { out.simulation = detail::read_simulation(keys, out.control); });
  read(sections.excitation, [&](TomlReader& keys) {
    ExcitationPlan plan;
    detail::read_excitation_plan(keys, plan);  // its checks
  });
}

Experiment experiment_of(const toml::table& table, FileSections& sections,
                         const std::filesystem::path& path) {
  Experiment out;
  out.file = path;
  out.robot = detail::read_robot(*sections.robot, out.robot_file);
  if (const toml::node* const dependent = sections.robot->find("dependent")) {
    for (const toml::node* const item : TomlReader::items(*dependent)) {
      if (auto file = sections.robot->section(*item, "dependent").get<std::filesystem::path>("table")) {
        out.robot_tables.push_back(*std::move(file));
      }
    }
  }
  read_sections(sections, out);
  out.origins = detail::origins(table);
  return out;
}

MonteCarlo::Trial read_trial(TomlReader keys, const MonteCarlo& plan) {
  MonteCarlo::Trial out{.label = {}, .experiment = plan.experiment};
  keys.of(out.experiment.robot).read(detail::trial_keys, out);
  const toml::node* const label = keys.find("label");
  out.label = keys.as<std::string>(*label, "label");
  if (out.label.empty() || out.label.find_first_of(",\n\r") != std::string::npos) {
    keys.fail(*label, "label", "must be a word or more without a comma");
  }
  if (std::ranges::find(plan.trials, out.label, &MonteCarlo::Trial::label) != plan.trials.end()) {
    keys.fail(*label, "label", "\"" + out.label + "\" is that of another trial");
  }
  if (const auto signal = keys.section("signal")) {
    out.experiment.estimation.signal = detail::read_signal(*signal);
  }
  if (const auto control = keys.section("control")) {
    out.experiment.control = detail::read_control(*control);
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
  FileSections sections(table, path, required);
  return experiment_of(table, sections, path);
}

Experiment detail::experiment_of_text(const std::filesystem::path& path, std::string_view text) {
  const toml::table table = parsed_toml_text(text, path.string());
  FileSections sections(table, path, of_identification);
  return experiment_of(table, sections, path);
}

Experiment detail::experiment_from(const Robot& robot, std::string_view sections, const std::string& source) {
  const toml::table table = parsed_toml_text(sections, source);
  FileSections read(table, source, {});
  if (read.robot) {
    throw InputError(source + ": [robot] is said by the robot");
  }
  Experiment out;
  out.file = source;
  out.robot = robot;
  read_sections(read, out);
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
  Robot robot =
      mdh_robot(parsed_text_table(description.text, description.source), description.name, options.gravity);
  return with_options(std::move(reader), with_dependents(std::move(robot), options.dependent));
}

LogSource detail::log_source_of(const Robot& robot, std::string_view keys, const std::string& source) {
  const toml::table table = parsed_toml_text(keys, source);
  return read_log_source(TomlReader(table, source, "log").of(robot), {});
}

MonteCarlo read_monte_carlo(const std::filesystem::path& path, std::span<const std::string> settings) {
  const toml::table table = detail::parsed_toml(path, experiment_file, settings);
  FileSections sections(table, path, of_monte_carlo);
  MonteCarlo out;
  out.experiment = experiment_of(table, sections, path);
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
  FileSections sections(table, path, of_excitation);
  ExcitationPlan out;
  out.experiment = experiment_of(table, sections, path);
  out.settings.assign(settings.begin(), settings.end());
  detail::read_excitation_plan(sections.excitation->of(out.experiment.robot), out);
  if (sections.excitation->table().contains("space") && out.experiment.robot_file.extension() != ".csv") {
    out.options.space.model = read_collision(out.experiment.robot_file, out.experiment.robot);
  }
  const auto is_log = [](const std::filesystem::path& file) { return file.extension() != result_ending; };
  if (std::ranges::any_of(out.known, is_log) && !sections.log) {
    throw InputError(path.string() + ": [excitation] known names logs, which [log] says how to read");
  }
  return out;
}

}  // namespace rivid
