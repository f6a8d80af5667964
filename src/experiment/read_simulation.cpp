#include <array>
#include <string>
#include <variant>

#include "experiment/column_reader.hpp"
#include "experiment/simulation_sections.hpp"
#include "rivid/data/table.hpp"

namespace rivid::detail {

namespace {

using Path = std::filesystem::path;

enum class MotionType { logged, fourier, point_to_point };
enum class Recorded { torque, control, reference, reference_velocity };

LoggedMotion read_logged(TomlReader& keys, Index n, bool file) {
  LoggedMotion out;
  out.interpolation = keys.choice("interpolation",
                                  std::array<std::pair<std::string_view, LoggedMotion::Interpolation>, 2>{
                                      {{"spline", LoggedMotion::Interpolation::spline},
                                       {"linear", LoggedMotion::Interpolation::linear}}})
                          .value_or(out.interpolation);
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
  const auto omega_f = keys.number("omega_f");
  if (!omega_f) {
    keys.look_for_mistyped({"omega_f"});
    keys.fail("must say omega_f, the fundamental frequency in rad/s");
  }
  out.omega_f = *omega_f;
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
  out.q0 = read_per_joint(keys, "q0", n);
  out.duration = keys.number("duration").value_or(out.duration);
  return out;
}

Vector as_vector(const std::optional<std::vector<double>>& values) {
  return values ? Vector(Eigen::Map<const Vector>(values->data(), std::ssize(*values))) : Vector();
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
  out.profile = keys.choice("profile",
                            std::array<std::pair<std::string_view, MoveProfile>, 2>{
                                {{"quintic", MoveProfile::quintic},
                                 {"trapezoidal_acceleration", MoveProfile::trapezoidal_acceleration}}})
                    .value_or(out.profile);
  out.durations = as_vector(keys.numbers("durations"));
  out.max_velocity = read_per_joint(keys, "max_velocity", n);
  out.max_acceleration = read_per_joint(keys, "max_acceleration", n);
  out.max_jerk = read_per_joint(keys, "max_jerk", n);
  out.dwell = as_vector(keys.numbers("dwell"));
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
  constexpr std::array<std::pair<std::string_view, Recorded>, 4> words = {
      {{"torque", Recorded::torque},
       {"control", Recorded::control},
       {"reference", Recorded::reference},
       {"reference_velocity", Recorded::reference_velocity}}};
  SimulationPlan::Columns out;
  const auto add = [&](const toml::node& item) {
    const Recorded word = keys.as_choice(item, "record", words);
    out.torque = out.torque || word == Recorded::torque;
    out.control = out.control || word == Recorded::control;
    out.reference = out.reference || word == Recorded::reference;
    out.reference_velocity = out.reference_velocity || word == Recorded::reference_velocity;
  };
  if (const toml::array* const list = node->as_array()) {
    for (const toml::node& item : *list) {
      add(item);
    }
  } else {
    add(*node);
  }
  return out;
}

double positive(TomlReader& keys, std::string_view key, double otherwise, const char* unit) {
  const double value = keys.number(key).value_or(otherwise);
  if (keys.find(key) != nullptr && value <= 0.0) {
    keys.fail(*keys.find(key), key, "is " + number(value) + " " + unit + ", must be positive");
  }
  return value;
}

// The rate of the log is that of the controller where nothing else is said.
double log_rate(TomlReader& keys, double otherwise, const std::optional<ControlLoop>& control) {
  const bool sampled = control && control->sampling.period > 0.0;
  if (keys.find("rate_hz") == nullptr && control && !sampled) {
    keys.look_for_mistyped({"rate_hz"});
    keys.fail("must say rate_hz, the rate of the log: the law is continuous and has none");
  }
  return positive(keys, "rate_hz", sampled ? 1.0 / control->sampling.period : otherwise, "Hz");
}

SimulationOptions read_options(TomlReader& keys, Index n, const std::optional<ControlLoop>& control) {
  SimulationOptions out;
  out.f_m = log_rate(keys, out.f_m, control);
  out.q_0 = read_per_joint(keys, "q_0", n);
  out.qd_0 = read_per_joint(keys, "qd_0", n);
  out.integrator = keys.choice("integrator",
                               std::array<std::pair<std::string_view, Integrator>, 6>{
                                   {{"automatic", Integrator::automatic},
                                    {"adams", Integrator::adams},
                                    {"bdf", Integrator::bdf},
                                    {"bogacki_shampine", Integrator::bogacki_shampine},
                                    {"dormand_prince", Integrator::dormand_prince},
                                    {"rk4", Integrator::rk4}}})
                       .value_or(out.integrator);
  out.friction = keys.choice("dry_friction",
                             std::array<std::pair<std::string_view, DryFrictionScheme>, 3>{
                                 {{"exact", DryFrictionScheme::exact},
                                  {"smooth", DryFrictionScheme::smooth},
                                  {"held", DryFrictionScheme::held}}})
                     .value_or(out.friction);
  out.smooth_velocity = keys.number("smooth_velocity").value_or(out.smooth_velocity);
  out.rtol = keys.number("rtol").value_or(out.rtol);
  out.atol = keys.number("atol").value_or(out.atol);
  out.max_step = keys.number("max_step").value_or(out.max_step);
  out.max_steps = keys.integer("max_steps").value_or(out.max_steps);
  out.max_seconds = keys.number("max_seconds").value_or(out.max_seconds);
  out.max_velocity = keys.number("max_velocity").value_or(out.max_velocity);
  return out;
}

NoiseOptions read_noise(TomlReader& keys, Index n, const std::optional<ControlLoop>& control) {
  const bool sampled = control && control->sampling.period > 0.0;
  NoiseOptions out;
  out.position = read_per_joint(keys, "position_noise", n);
  out.torque = read_per_joint(keys, "torque_noise", n);
  out.disturbance = read_per_joint(keys, "disturbance", n);
  out.feedback = keys.boolean("noise_feedback").value_or(sampled);
  if (out.feedback && control && !sampled) {
    keys.fail(*keys.find("noise_feedback"), "noise_feedback",
              "is true, but the law of [control] is continuous: errors of the measurement go through a law "
              "that is sampled, with a rate_hz");
  }
  if (const auto seed = keys.integer("seed")) {
    if (*seed < 0) {
      keys.fail(*keys.find("seed"), "seed", "is " + std::to_string(*seed) + ", must not be negative");
    }
    out.seed = static_cast<std::uint64_t>(*seed);
  }
  return out;
}

}  // namespace

ReferenceSource read_reference_source(TomlReader keys, const Path& folder, Index n) {
  ReferenceSource out;
  const auto type = keys.choice("type", std::array<std::pair<std::string_view, MotionType>, 3>{
                                            {{"logged", MotionType::logged},
                                             {"fourier", MotionType::fourier},
                                             {"point_to_point", MotionType::point_to_point}}});
  if (!type) {
    keys.look_for_mistyped({"type"});
    keys.fail("must say its type: \"logged\", \"fourier\" or \"point_to_point\"");
  }
  if (*type != MotionType::point_to_point) {
    out.file = file_named(keys, "file", folder).value_or(Path());
  }
  switch (*type) {
    case MotionType::logged:
      out.motion = read_logged(keys, n, !out.file.empty());
      break;
    case MotionType::fourier:
      out.motion = read_fourier(keys, out.file, n);
      break;
    case MotionType::point_to_point:
      out.motion = read_point_to_point(keys, n);
      break;
  }
  // A mistyped key is told before what is missing for it.
  keys.finish();
  const auto* const series = std::get_if<FourierSeries>(&out.motion);
  const auto* const moves = std::get_if<PointToPoint>(&out.motion);
  const auto complaint = series != nullptr  ? series->complaint()
                         : moves != nullptr ? moves->complaint()
                                            : std::nullopt;
  if (complaint) {
    keys.fail(*complaint);
  }
  return out;
}

SimulationPlan read_simulation(TomlReader keys, const Path& folder, Index n,
                               const std::optional<ControlLoop>& control) {
  SimulationPlan out;
  if (const toml::node* const node = keys.find("parameters")) {
    if (keys.as_text(*node, "parameters") != "a_priori") {
      out.parameters = file_at(keys, *node, "parameters", folder);
    }
  }
  out.duration = positive(keys, "duration", 0.0, "s");
  out.options = read_options(keys, n, control);
  out.noise = read_noise(keys, n, control);
  out.added_control = read_added_control(keys, folder, n);
  out.columns = read_recorded(keys, out.columns);
  keys.finish();
  for (const auto& complaint : {out.options.complaint(n), out.noise.complaint(n)}) {
    if (complaint) {
      keys.fail(*complaint);
    }
  }
  if (out.noise.torque.size() > 0 && !out.columns.torque) {
    keys.fail(
        "torque_noise is an error of the recorded torques: record = [\"torque\", …] is required with it");
  }
  return out;
}

}  // namespace rivid::detail
