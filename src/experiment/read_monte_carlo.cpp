#include <algorithm>

#include "experiment/identification_sections.hpp"
#include "experiment/simulation_sections.hpp"
#include "experiment/text_file.hpp"
#include "rivid/experiment/monte_carlo.hpp"

namespace rivid {

namespace {

using detail::TomlReader;

MonteCarlo::Trial read_trial(TomlReader keys, const MonteCarlo& plan, bool has_signal) {
  MonteCarlo::Trial out{.label = {}, .experiment = plan.experiment};
  const toml::node* const label = keys.find("label");
  if (label == nullptr) {
    keys.fail("must have a label, which its rows are called after");
  }
  out.label = keys.as_text(*label, "label");
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
  detail::read_method(std::move(keys), out.experiment);
  return out;
}

}  // namespace

MonteCarlo read_monte_carlo(const std::filesystem::path& path) {
  MonteCarlo out;
  out.experiment = read_experiment(path, Use::simulation);
  const toml::table table = detail::parsed_toml(path, "the experiment file");
  TomlReader file(table, path.string(), "");
  auto keys = file.section("montecarlo");
  if (!keys) {
    throw InputError(path.string() + ": section [montecarlo] is missing");
  }
  out.runs = keys->count("runs").value_or(out.runs);
  if (out.runs < 1) {
    keys->fail("runs is " + std::to_string(out.runs) + ", must be at least 1");
  }
  if (const auto seed = keys->integer("seed")) {
    if (*seed < 0) {
      keys->fail("seed is " + std::to_string(*seed) + ", must not be negative");
    }
    out.seed = static_cast<std::uint64_t>(*seed);
  }
  const toml::node* const trials = keys->find("trial");
  keys->finish();
  const toml::array* const list = trials == nullptr ? nullptr : trials->as_array();
  if (list == nullptr || list->empty()) {
    keys->fail("must have at least one table [[montecarlo.trial]]");
  }
  for (const toml::node& trial : *list) {
    out.trials.push_back(
        read_trial(TomlReader(keys->as_table(trial, "trial"), path.string(), "montecarlo.trial"), out,
                   table.contains("signal")));
  }
  return out;
}

}  // namespace rivid
