#include <algorithm>
#include <array>
#include <string>
#include <variant>

#include "experiment/sections.hpp"
#include "rivid/data/table.hpp"

namespace rivid {

namespace detail {

namespace {

using Path = std::filesystem::path;

LoggedMotion read_logged(TomlReader& keys, bool file) {
  LoggedMotion out;
  keys.read(out);
  read_reference_columns(keys, out.columns);
  if (!file) {
    keys.refuse_keys({"position", "time", "rate_hz", "units"},
                     "goes with file: without it the reference is that of the first log, read as [log] says");
  }
  return out;
}

FourierSeries read_fourier(TomlReader& keys, const Path& file) {
  const Index n = keys.joints();
  FourierSeries out;
  keys.read(out);
  const std::string required =
      std::to_string(n) + " lists of numbers: one list a joint, one number a harmonic";
  const auto A = keys.matrix("A", n, -1, required);
  const auto B = keys.matrix("B", n, -1, required);
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

PointToPoint read_point_to_point(TomlReader& keys) {
  const Index n = keys.joints();
  PointToPoint out;
  keys.read(out);
  out.via = keys.matrix("via", -1, n,
                        "lists of " + std::to_string(n) + " numbers: one list a point, one number a joint")
                .value();
  const auto numbers = [&](std::string_view key) {
    const auto values =
        keys.get<std::vector<double>>(key, PointToPoint::times, "s").value_or(std::vector<double>());
    return Vector(Eigen::Map<const Vector>(values.data(), std::ssize(values)));
  };
  out.durations = numbers("durations");
  out.dwell = numbers("dwell");
  return out;
}

bool is_sampled(const std::optional<ControlLoop>& control) {
  return control && control->sampling.period > 0.0;
}

template <typename Motion>
void refuse(const TomlReader& keys, const Motion& motion) {
  if constexpr (requires { motion.complaint(); }) {
    keys.refuse(motion.complaint());
  }
}

}  // namespace

ReferenceSource read_reference_source(TomlReader keys) {
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
    out.motion = read_point_to_point(keys);
  } else {
    keys.set(out.file, {.key = "file"});
    if (word == FourierSeries::word) {
      out.motion = read_fourier(keys, out.file);
    } else {
      out.motion = read_logged(keys, !out.file.empty());
    }
  }
  // A mistyped key is reported before what is missing for it.
  keys.finish();
  std::visit([&](const auto& motion) { refuse(keys, motion); }, out.motion);
  return out;
}

SimulationPlan read_simulation(TomlReader keys, const std::optional<ControlLoop>& control) {
  refuse_floating(keys);
  SimulationPlan out;
  // The rate of the log is that of the controller where nothing else is said.
  if (is_sampled(control)) {
    out.options.f_m = 1.0 / control->sampling.period;
  }
  out.noise.feedback = is_sampled(control);
  if (const toml::node* const node = keys.find("parameters")) {
    if (node->value_exact<std::string_view>() != "a_priori") {
      out.parameters = keys.as<Path>(*node, "parameters");
    }
  }
  keys.read(out);
  if (keys.find("rate_hz") == nullptr && control && !is_sampled(control)) {
    keys.look_for_mistyped({"rate_hz"});
    keys.fail("must say rate_hz, the rate of the log: the law is continuous and has none");
  }
  if (out.noise.feedback && control && !is_sampled(control)) {
    keys.fail(*keys.find("noise_feedback"), "noise_feedback",
              "is true, but the law of [control] is continuous: errors of the measurement go through a law "
              "that is sampled, with a rate_hz");
  }
  using Recorded = SimulationPlan::Recorded;
  if (const auto recorded = keys.get<std::vector<Recorded>>("record")) {
    const auto has = [&](Recorded one) { return std::ranges::find(*recorded, one) != recorded->end(); };
    out.columns = {.torque = has(Recorded::torque),
                   .control = has(Recorded::control),
                   .reference = has(Recorded::reference),
                   .reference_velocity = has(Recorded::reference_velocity)};
  }
  keys.finish();
  keys.refuse(out.options.complaint(keys.joints()));
  keys.refuse(out.noise.complaint(keys.joints()));
  if (out.noise.torque.size() > 0 && !out.columns.torque) {
    keys.fail(
        "torque_noise is an error of the recorded torques: record = [\"torque\", …] is required with it");
  }
  return out;
}

}  // namespace detail

std::vector<SimulationPlan::Recorded> SimulationPlan::Columns::recorded() const {
  std::vector<Recorded> out;
  for (const auto& [wanted, what] :
       {std::pair(torque, Recorded::torque), std::pair(control, Recorded::control),
        std::pair(reference, Recorded::reference),
        std::pair(reference_velocity, Recorded::reference_velocity)}) {
    if (wanted) {
      out.push_back(what);
    }
  }
  return out;
}

}  // namespace rivid
