#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "identify/check/alternatives.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::string plus_minus(double value, double sigma, int digits) {
  return number(value, digits) + " ± " + number(sigma, 1);
}

std::string gravity_vector(const Eigen::Vector3d& g) {
  return "[" + number(g[0], 3) + ", " + number(g[1], 3) + ", " + number(g[2], 3) + "]";
}

std::vector<Change> changed(const char* key, std::string joint, double value) {
  return {{key, std::move(joint), {value}}};
}

std::vector<Change> other_law(const Told& t, Friction law) {
  return {{.key = "robot.friction", .joint = t.it.subject, .word = std::string(name(law))}};
}

// The motor of the second joint, turned by the first one as well. Which way, friction says, whose sign
// changes with that of the one velocity or the other.
std::vector<Change> coupled(const Told& t) {
  const auto surely = [&](Index column) { return std::abs(t.test.estimate[column] / t.test.sigma[column]); };
  const std::size_t between = t.it.subject.find(" and ");
  return {{"robot.coupling",
           t.it.subject.substr(between + 5),
           {surely(2) < surely(3) ? -1.0 : 1.0},
           t.it.subject.substr(0, between)}};
}

std::vector<Change> scaled_positions(const Told& t) {
  std::vector<Change> out;
  for (const Joint& joint : t.robot.joints) {
    if (t.it.subject == joint.name || t.it.subject == "all joints") {
      out.push_back(Change{"log.position.scale", joint.name, {1.0 + t.value}});
    }
  }
  return out;
}

constexpr std::array alternative_kinds = {
    AlternativeKind{
        .code = "torque_gain",
        .fault = true,
        .large = 0.3,
        .words = [](const Told& t) -> AlternativeWords {
          const double factor = 1.0 + t.value;
          return {"its torque is " + plus_minus(factor, t.sigma, 3) + " times what the other joints ask for",
                  "correct drive_gain, or give its column in [log] scale = " + number(1.0 / factor, 3)};
        },
        .changes =
            [](const Told& t) { return changed("log.torque.scale", t.it.subject, 1.0 / (1.0 + t.value)); },
    },
    AlternativeKind{
        .code = "zero_offset",
        .fault = true,
        .large = 0.3,
        .words = [](const Told& t) -> AlternativeWords {
          return {
              "its position looks off by " + plus_minus(-t.value, t.sigma, 3) + (t.it.turns ? " rad" : " m"),
              "give its column in [log] position offset = " + number(t.value, 3)};
        },
        .changes = [](const Told& t) { return changed("log.position.offset", t.it.subject, t.value); },
    },
    AlternativeKind{
        .code = "gravity_tilt",
        .fault = true,
        .large = 0.2,
        .words = [](const Told& t) -> AlternativeWords {
          const double degrees = 180.0 / std::numbers::pi;
          return {"gravity looks tilted by " +
                      plus_minus(degrees * t.test.estimate.norm(), degrees * t.test.sigma.norm(), 2) + "°",
                  "[robot] gravity = " + gravity_vector(tilted_gravity(t.robot, t.test.estimate))};
        },
        .changes =
            [](const Told& t) {
              const Eigen::Vector3d g = tilted_gravity(t.robot, t.test.estimate);
              return std::vector<Change>{{.key = "robot.gravity", .numbers = {g[0], g[1], g[2]}}};
            },
    },
    AlternativeKind{
        .code = "clock_rate",
        .fault = true,
        .large = 0.05,
        .words = [](const Told& t) -> AlternativeWords {
          return {"the sampling rate of the log looks wrong by " +
                      plus_minus(100.0 * t.value, 100.0 * t.sigma, 2) + " %",
                  "multiply [log] rate_hz by " + number(1.0 + t.value, 4) + ", or correct the time stamps"};
        },
        .changes = [](const Told& t) { return changed("log.rate_hz", {}, t.f_m * (1.0 + t.value)); },
    },
    AlternativeKind{
        .code = "position_scale",
        .fault = true,
        .large = 0.3,
        .words = [](const Told& t) -> AlternativeWords {
          const double factor = 1.0 + t.value;
          return {"positions look too small or too large: they should be " + plus_minus(factor, t.sigma, 3) +
                      " times as large",
                  "give their columns in [log] position scale = " + number(factor, 3)};
        },
        .changes = scaled_positions,
    },
    AlternativeKind{
        .code = "torque_delay",
        .fault = true,
        .words = [](const Told& t) -> AlternativeWords {
          return {"torques look " + plus_minus(1e3 * std::abs(t.value), 1e3 * t.sigma, 2) + " ms " +
                      (t.value > 0.0 ? "late" : "early") + " beside the motion",
                  "change [log] torque_lag by as much, in samples"};
        },
        .changes = [](const Told& t) { return changed("log.torque_lag", {}, t.f_m * t.value); },
    },
    AlternativeKind{
        .code = "joint_origin",
        .fault = true,
        .words = [](const Told&) -> AlternativeWords {
          return {"its frame looks moved or turned against the URDF", "compare its <origin> with the arm"};
        },
    },
    AlternativeKind{
        .code = "load_changed",
        .fault = true,
        .words = [](const Told& t) -> AlternativeWords {
          return {t.it.from > 0.0 ? "its load looks another one from " +
                                        number(std::round(100.0 * t.it.from), 2) + " % of the time on"
                                  : "its load looks to come and go",
                  ""};
        },
    },
    AlternativeKind{
        .code = "logs_differ",
        .fault = true,
        .words = [](const Told& t) -> AlternativeWords {
          return {std::string(t.it.load ? "its load looks" : "its bodies look") +
                      " other than those of the other logs, beside friction that changed",
                  "identify each arm, and each tool, from logs of its own"};
        },
    },
    AlternativeKind{
        .code = "load_friction",
        .positive = true,
        .words = [](const Told& t) -> AlternativeWords {
          return {"its friction looks to grow with the load, by " + plus_minus(t.value, t.sigma, 2) +
                      (t.it.turns ? " N·m for one N·m" : " N for one N"),
                  ""};
        },
        .changes = [](const Told& t) { return other_law(t, Friction::load); },
    },
    AlternativeKind{
        .code = "stribeck_friction",
        .positive = true,
        .words = [](const Told& t) -> AlternativeWords {
          return {"its friction looks larger at low speed, by " + plus_minus(t.value, t.sigma, 2) +
                      (t.it.turns ? " N·m" : " N"),
                  ""};
        },
        .changes = [](const Told& t) { return other_law(t, Friction::root); },
    },
    AlternativeKind{
        .code = "direction_friction",
        .words = [](const Told&) -> AlternativeWords {
          return {"its friction looks different in both directions", "friction = \"asymmetric\" in [robot]"};
        },
        .changes = [](const Told& t) { return other_law(t, Friction::asymmetric); },
    },
    AlternativeKind{
        .code = "joint_elasticity",
        .positive = true,
        .words = [](const Told& t) -> AlternativeWords {
          // The link swings on the spring while the motor stands.
          const double swings = t.value * t.it.inertia > 0.0
                                    ? 0.5 / (std::numbers::pi * std::sqrt(t.value * t.it.inertia))
                                    : 0.0;
          return {"it looks elastic, " + plus_minus(t.value, t.sigma, 2) +
                      (t.it.turns ? " rad for one N·m" : " m for one N") +
                      (swings > 0.0 ? ", on which its link would swing at " + number(swings, 2) + " Hz" : ""),
                  ""};
        },
    },
    AlternativeKind{
        .code = "joint_spring",
        .words = [](const Told& t) -> AlternativeWords {
          return {"a spring or counterbalance looks to pull it, by " + plus_minus(t.value, t.sigma, 2) +
                      (t.it.turns ? " N·m for one rad" : " N for one m"),
                  "give its torque over the position in [log] subtract"};
        },
    },
    AlternativeKind{
        .code = "joint_coupling",
        .words = [](const Told&) -> AlternativeWords {
          return {"a motor looks to turn both", "[[robot.coupling]] with motor and joints of these two"};
        },
        .changes = coupled,
    },
};

}  // namespace

const AlternativeKind& kind_of(const Alternative& alternative) {
  return *std::ranges::find(alternative_kinds, alternative.code, &AlternativeKind::code);
}

}  // namespace rivid::detail
