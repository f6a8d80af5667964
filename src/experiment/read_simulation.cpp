#include <array>
#include <string>
#include <variant>

#include "experiment/sections.hpp"
#include "rivid/data/table.hpp"

namespace rivid {

namespace detail {

namespace {

using Path = std::filesystem::path;

// What a log may hold beside time and positions, in the order of the members of SimulationPlan::Columns.
constexpr auto recorded_words =
    std::to_array<std::string_view>({"torque", "control", "reference", "reference_velocity"});

LoggedMotion read_logged(TomlReader& keys, Index n, bool file) {
  LoggedMotion out;
  keys.read(out);
  out.columns = read_reference_columns(keys, {}, n, false);
  for (const char* const key : {"position", "time", "rate_hz", "units"}) {
    if (!file && keys.find(key) != nullptr) {
      keys.fail(*keys.find(key), key,
                "goes with file: without it the reference is that of the first log, read as [log] says");
    }
  }
  return out;
}

FourierSeries read_fourier(TomlReader& keys, const Path& file, Index n) {
  FourierSeries out;
  keys.read(out, n);
  if (keys.find("omega_f") == nullptr) {
    keys.look_for_mistyped({"omega_f"});
    keys.fail("must say omega_f, the fundamental frequency in rad/s");
  }
  const std::string required =
      std::to_string(n) + " lists of numbers: one list a joint, one number a harmonic";
  const auto A = read_matrix(keys, "A", n, -1, required);
  const auto B = read_matrix(keys, "B", n, -1, required);
  const bool listed = A.has_value() || B.has_value();
  if (listed == !file.empty()) {
    keys.fail(listed ? "file names coefficients beside A and B, must be one or the other"
                     : "must list A and B, or name a file of coefficients");
  }
  if (listed) {
    out.A = A.value_or(Matrix());
    out.B = B.value_or(Matrix());
  } else {
    TableOptions options;
    for (const char* const letter : {"A", "B"}) {
      for (Index j = 1; j <= n; ++j) {
        options.columns.push_back(letter + std::to_string(j));
      }
    }
    const Table table = read_table(file, options);
    out.A = table.values.leftCols(n).transpose();
    out.B = table.values.rightCols(n).transpose();
  }
  return out;
}

PointToPoint read_point_to_point(TomlReader& keys, Index n) {
  PointToPoint out;
  const auto via = read_matrix(
      keys, "via", -1, n, "lists of " + std::to_string(n) + " numbers: one list a point, one number a joint");
  if (!via) {
    keys.look_for_mistyped({"via"});
    keys.fail("must list the points, via");
  }
  out.via = *via;
  keys.read(out, n);
  const auto numbers = [&](std::string_view key) {
    const auto values =
        keys.get<std::vector<double>>(key, PointToPoint::times, "s").value_or(std::vector<double>());
    return Vector(Eigen::Map<const Vector>(values.data(), std::ssize(values)));
  };
  out.durations = numbers("durations");
  out.dwell = numbers("dwell");
  return out;
}

std::optional<SimulationPlan::AddedControl> read_added_control(TomlReader& keys, const Path& folder,
                                                               Index n) {
  auto section = keys.section("added_control");
  if (!section) {
    return std::nullopt;
  }
  const auto file = file_named(*section, "file", folder);
  const auto columns = read_columns(*section, "columns", 1.0, {}, n);
  if (!file || columns.empty()) {
    section->look_for_mistyped({"file", "columns"});
    section->fail("must name file and columns");
  }
  section->finish();
  return SimulationPlan::AddedControl{.file = *file, .columns = columns};
}

SimulationPlan::Columns read_recorded(TomlReader& keys, const SimulationPlan::Columns& otherwise) {
  const toml::node* const node = keys.find("record");
  if (node == nullptr) {
    return otherwise;
  }
  std::array<bool, recorded_words.size()> wanted = {};
  for (const toml::node* const item : TomlReader::items(*node)) {
    wanted.at(keys.word(*item, "record", recorded_words)) = true;
  }
  return {.torque = wanted[0], .control = wanted[1], .reference = wanted[2], .reference_velocity = wanted[3]};
}

bool is_sampled(const std::optional<ControlLoop>& control) {
  return control && control->sampling.period > 0.0;
}

SimulationOptions read_options(TomlReader& keys, Index n, const std::optional<ControlLoop>& control) {
  SimulationOptions out;
  // The rate of the log is that of the controller where nothing else is said.
  if (is_sampled(control)) {
    out.f_m = 1.0 / control->sampling.period;
  }
  keys.read(out, n);
  keys.read(SimulationOptions::integration(), out, n);
  if (keys.find("rate_hz") == nullptr && control && !is_sampled(control)) {
    keys.look_for_mistyped({"rate_hz"});
    keys.fail("must say rate_hz, the rate of the log: the law is continuous and has none");
  }
  return out;
}

NoiseOptions read_noise(TomlReader& keys, Index n, const std::optional<ControlLoop>& control) {
  NoiseOptions out;
  out.feedback = is_sampled(control);
  keys.read(out, n);
  if (out.feedback && control && !is_sampled(control)) {
    keys.fail(*keys.find("noise_feedback"), "noise_feedback",
              "is true, but the law of [control] is continuous: errors of the measurement go through a law "
              "that is sampled, with a rate_hz");
  }
  return out;
}

template <typename Motion>
void refuse(const TomlReader& keys, const Motion& motion) {
  if constexpr (requires { motion.complaint(); }) {
    keys.refuse(motion.complaint());
  }
}

}  // namespace

ReferenceSource read_reference_source(TomlReader keys, const Path& folder, Index n) {
  ReferenceSource out;
  constexpr auto types =
      std::to_array<std::string_view>({LoggedMotion::word, FourierSeries::word, PointToPoint::word});
  const auto type = keys.word("type", types);
  if (!type) {
    keys.look_for_mistyped({"type"});
    keys.fail("must say its type: \"logged\", \"fourier\" or \"point_to_point\"");
  }
  const std::string_view word = types[*type];
  if (word == PointToPoint::word) {
    out.motion = read_point_to_point(keys, n);
  } else {
    out.file = file_named(keys, "file", folder).value_or(Path());
    if (word == FourierSeries::word) {
      out.motion = read_fourier(keys, out.file, n);
    } else {
      out.motion = read_logged(keys, n, !out.file.empty());
    }
  }
  // A mistyped key is reported before what is missing for it.
  keys.finish();
  std::visit([&](const auto& motion) { refuse(keys, motion); }, out.motion);
  return out;
}

SimulationPlan read_simulation(TomlReader keys, const Path& folder, Index n,
                               const std::optional<ControlLoop>& control) {
  SimulationPlan out;
  if (const toml::node* const node = keys.find("parameters")) {
    if (keys.as<std::string>(*node, "parameters") != "a_priori") {
      out.parameters = file_at(keys, *node, "parameters", folder);
    }
  }
  keys.read(out);
  out.options = read_options(keys, n, control);
  out.noise = read_noise(keys, n, control);
  out.added_control = read_added_control(keys, folder, n);
  out.columns = read_recorded(keys, out.columns);
  keys.finish();
  keys.refuse(out.options.complaint(n));
  keys.refuse(out.noise.complaint(n));
  if (out.noise.torque.size() > 0 && !out.columns.torque) {
    keys.fail(
        "torque_noise is an error of the recorded torques: record = [\"torque\", …] is required with it");
  }
  return out;
}

}  // namespace detail

std::vector<std::string> SimulationPlan::Columns::words() const {
  std::vector<std::string> out;
  const std::array<bool, detail::recorded_words.size()> wanted = {torque, control, reference,
                                                                  reference_velocity};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted.at(i)) {
      out.emplace_back(detail::recorded_words.at(i));
    }
  }
  return out;
}

}  // namespace rivid
