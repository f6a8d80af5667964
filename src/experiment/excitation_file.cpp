#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string_view>

#include "experiment/sections.hpp"
#include "experiment/text_file.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using Path = std::filesystem::path;

// Keys whose values are files.
constexpr auto file_keys =
    std::to_array<std::string_view>({"urdf", "mdh", "file", "files", "loaded", "table", "parameters"});

// Paths of a file in one folder as those of a file in another.
void move_paths(toml::node& node, bool is_file, const Path& from, const Path& to) {
  if (toml::table* const table = node.as_table()) {
    for (auto&& [key, value] : *table) {
      move_paths(value, std::ranges::find(file_keys, key.str()) != file_keys.end(), from, to);
    }
  } else if (toml::array* const list = node.as_array()) {
    for (toml::node& item : *list) {
      move_paths(item, is_file, from, to);
    }
  } else if (toml::value<std::string>* const text = node.as_string(); text != nullptr && is_file) {
    const Path path = text->get();
    if (path.is_relative() && path != "a_priori") {
      *text = detail::from_folder(from / path, to);
    }
  }
}

toml::array list_of(const Vector& values) {
  toml::array out;
  for (const double value : values) {
    out.push_back(value);
  }
  return out;
}

toml::array rows_of(const Matrix& values) {
  toml::array out;
  for (Index i = 0; i < values.rows(); ++i) {
    out.push_back(list_of(values.row(i)));
  }
  return out;
}

// The series, or with leads the positions of motion.csv, which lies beside the file.
toml::table reference_section(const Excitation& excitation) {
  if (excitation.series && !excitation.lead_in) {
    const FourierSeries& series = *excitation.series;
    return toml::table{{"type", FourierSeries::word}, {"omega_f", series.omega_f},
                       {"A", rows_of(series.A)},      {"B", rows_of(series.B)},
                       {"q0", list_of(series.q0)},    {"duration", series.duration}};
  }
  toml::array columns;
  for (Index j = 1; j <= excitation.motion.joints(); ++j) {
    columns.push_back("q" + std::to_string(j));
  }
  return toml::table{
      {"type", "logged"}, {"file", "motion.csv"}, {"time", "t"}, {"position", std::move(columns)}};
}

// Noise of a sample at the rate of the log.
Vector noise_of_a_sample(const ExcitationOptions& options) {
  const double rate = options.noise.rate_hz > 0.0 ? options.noise.rate_hz : options.rate_hz;
  return options.noise.sigma * std::sqrt(options.rate_hz / rate);
}

toml::table simulation_of(const ExcitationOptions& options) {
  toml::table out{{"parameters", "a_priori"},
                  {"rate_hz", options.rate_hz},
                  {"record", toml::array{"torque", "control", "reference"}}};
  if (options.noise.sigma.size() > 0) {
    out.insert("torque_noise", list_of(noise_of_a_sample(options)));
  }
  return out;
}

toml::table& section(toml::table& file, std::string_view name) {
  if (!file.contains(name)) {
    file.insert(name, toml::table());
  }
  return *file[name].as_table();
}

std::string comment(const Excitation& excitation) {
  const Vector start = excitation.motion.q.row(0);
  std::ostringstream out;
  out << "# Written by rivid excite: the motion is [reference]; put the log that it gives beside this file "
         "as\n"
         "# log.csv, or make one with rivid simulate. Its time must count from the beginning of the motion. "
         "The robot must rest\n"
         "# before the motion at";
  for (const double q : start) {
    out << ' ' << number(q, 6);
  }
  out << "\n\n";
  return out.str();
}

}  // namespace

std::string experiment_text(const ExcitationPlan& plan, const Excitation& excitation, const Path& folder) {
  toml::table file = detail::parsed_toml(plan.experiment.file, "the experiment file", plan.settings);
  for (const char* const name : {"excitation", "montecarlo", "reference", "validation"}) {
    file.erase(name);
  }
  move_paths(file, false, plan.experiment.file.parent_path(), folder);
  file.insert("reference", reference_section(excitation));
  section(file, "log").insert_or_assign("files", "log.csv");
  const bool controlled = plan.experiment.control.has_value();
  toml::table& signal = section(file, "signal");
  if (signal.empty()) {
    signal.insert("decimation", "auto");
    if (controlled && plan.experiment.control->sampling.period > 0.0) {
      signal.insert("torque_held", true);
    }
  }
  if (!file.contains("method")) {
    file.insert("method", toml::table{{"name", "auto"}});
  }
  if (controlled && !file.contains("simulation")) {
    file.insert("simulation", simulation_of(plan.options));
  }
  if (toml::table* const simulation = file["simulation"].as_table()) {
    simulation->erase("duration");
  }
  std::ostringstream out;
  out << comment(excitation) << file << '\n';
  return out.str();
}

}  // namespace rivid
