#include "identify/check/alternative_kinds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

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

std::vector<Change> other_law(const Alternative& it, Friction law) {
  return {{.key = "robot.friction", .joint = it.subject, .word = std::string(name(law))}};
}

// The motor of the second joint, turned by the first one as well. Which way, friction says, whose sign changes
// with that of the one velocity or the other.
std::vector<Change> coupled(const Alternative& it, const AlternativeTest& test) {
  const auto surely = [&](Index column) { return std::abs(test.estimate[column] / test.sigma[column]); };
  const std::size_t between = it.subject.find(" and ");
  return {{"robot.coupling",
           it.subject.substr(between + 5),
           {surely(2) < surely(3) ? -1.0 : 1.0},
           it.subject.substr(0, between)}};
}

constexpr std::array alternative_kinds = {
    AlternativeKind{
        .code = "torque_gain",
        .fault = true,
        .large = 0.3,
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest& test) {
              const double value = test.estimate[0];
              const double sigma = test.sigma[0];
              const double factor = 1.0 + value;
              return AlternativeWords{
                  "its torque is " + plus_minus(factor, sigma, 3) + " times what the other joints ask for",
                  "correct drive_gain, or give its column in [log] scale = " + number(1.0 / factor, 3)};
            },
        .changes =
            [](const Robot&, const Alternative& it, const AlternativeTest& test, double) {
              return changed("log.torque.scale", it.subject, 1.0 / (1.0 + test.estimate[0]));
            },
    },
    AlternativeKind{
        .code = "zero_offset",
        .fault = true,
        .large = 0.3,
        .words =
            [](const Robot&, const Alternative& it, const AlternativeTest& test) {
              const double value = test.estimate[0];
              const double sigma = test.sigma[0];
              return AlternativeWords{
                  "its position looks off by " + plus_minus(-value, sigma, 3) + (it.turns ? " rad" : " m"),
                  "give its column in [log] position offset = " + number(value, 3)};
            },
        .changes = [](const Robot&, const Alternative& it, const AlternativeTest& test,
                      double) { return changed("log.position.offset", it.subject, test.estimate[0]); },
    },
    AlternativeKind{
        .code = "gravity_tilt",
        .fault = true,
        .large = 0.2,
        .words =
            [](const Robot& robot, const Alternative&, const AlternativeTest& test) {
              const double degrees = 180.0 / std::numbers::pi;
              return AlternativeWords{
                  "gravity looks tilted by " +
                      plus_minus(degrees * test.estimate.norm(), degrees * test.sigma.norm(), 2) + "°",
                  "[robot] gravity = " + gravity_vector(tilted_gravity(robot, test.estimate))};
            },
        .changes =
            [](const Robot& robot, const Alternative&, const AlternativeTest& test, double) {
              const Eigen::Vector3d g = tilted_gravity(robot, test.estimate);
              return std::vector<Change>{{.key = "robot.gravity", .numbers = {g[0], g[1], g[2]}}};
            },
    },
    AlternativeKind{
        .code = "clock_rate",
        .fault = true,
        .large = 0.05,
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest& test) {
              const double value = test.estimate[0];
              const double sigma = test.sigma[0];
              return AlternativeWords{
                  "the sampling rate of the log looks wrong by " +
                      plus_minus(100.0 * value, 100.0 * sigma, 2) + " %",
                  "multiply [log] rate_hz by " + number(1.0 + value, 4) + ", or correct the time stamps"};
            },
        .changes = [](const Robot&, const Alternative&, const AlternativeTest& test,
                      double f_m) { return changed("log.rate_hz", {}, f_m * (1.0 + test.estimate[0])); },
    },
    AlternativeKind{
        .code = "position_scale",
        .fault = true,
        .large = 0.3,
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest& test) {
              const double factor = 1.0 + test.estimate[0];
              return AlternativeWords{"positions look too small or too large: they should be " +
                                          plus_minus(factor, test.sigma[0], 3) + " times as large",
                                      "give their columns in [log] position scale = " + number(factor, 3)};
            },
        .changes =
            [](const Robot& robot, const Alternative& it, const AlternativeTest& test, double) {
              std::vector<Change> out;
              for (const Joint& joint : robot.joints) {
                if (it.subject == joint.name || it.subject == "all joints") {
                  out.push_back(Change{"log.position.scale", joint.name, {1.0 + test.estimate[0]}});
                }
              }
              return out;
            },
    },
    AlternativeKind{
        .code = "torque_delay",
        .fault = true,
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest& test) {
              const double value = test.estimate[0];
              const double sigma = test.sigma[0];
              return AlternativeWords{"torques look " + plus_minus(1e3 * std::abs(value), 1e3 * sigma, 2) +
                                          " ms " + (value > 0.0 ? "late" : "early") + " beside the motion",
                                      "change [log] torque_lag by as much, in samples"};
            },
        .changes = [](const Robot&, const Alternative&, const AlternativeTest& test,
                      double f_m) { return changed("log.torque_lag", {}, f_m * test.estimate[0]); },
    },
    AlternativeKind{
        .code = "joint_origin",
        .fault = true,
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest&) {
              return AlternativeWords{"its frame looks moved or turned against the URDF",
                                      "compare its <origin> with the arm"};
            },
    },
    AlternativeKind{
        .code = "load_changed",
        .fault = true,
        .words =
            [](const Robot&, const Alternative& it, const AlternativeTest&) {
              return AlternativeWords{it.from > 0.0
                                          ? "its load looks another one from " +
                                                number(std::round(100.0 * it.from), 2) + " % of the time on"
                                          : "its load looks to come and go",
                                      ""};
            },
    },
    AlternativeKind{
        .code = "logs_differ",
        .fault = true,
        .words =
            [](const Robot&, const Alternative& it, const AlternativeTest&) {
              return AlternativeWords{std::string(it.load ? "its load looks" : "its bodies look") +
                                          " other than those of the other logs, beside friction that changed",
                                      "identify each arm, and each tool, from logs of its own"};
            },
    },
    AlternativeKind{
        .code = "load_friction",
        .positive = true,
        .words =
            [](const Robot&, const Alternative& it, const AlternativeTest& test) {
              const double value = test.estimate[0];
              const double sigma = test.sigma[0];
              return AlternativeWords{"its friction looks to grow with the load, by " +
                                          plus_minus(value, sigma, 2) +
                                          (it.turns ? " N·m for one N·m" : " N for one N"),
                                      ""};
            },
        .changes = [](const Robot&, const Alternative& it, const AlternativeTest&,
                      double) { return other_law(it, Friction::load); },
    },
    AlternativeKind{
        .code = "stribeck_friction",
        .positive = true,
        .words =
            [](const Robot&, const Alternative& it, const AlternativeTest& test) {
              const double value = test.estimate[0];
              const double sigma = test.sigma[0];
              return AlternativeWords{"its friction looks larger at low speed, by " +
                                          plus_minus(value, sigma, 2) + (it.turns ? " N·m" : " N"),
                                      ""};
            },
        .changes = [](const Robot&, const Alternative& it, const AlternativeTest&,
                      double) { return other_law(it, Friction::root); },
    },
    AlternativeKind{
        .code = "direction_friction",
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest&) {
              return AlternativeWords{"its friction looks different in both directions",
                                      "friction = \"asymmetric\" in [robot]"};
            },
        .changes = [](const Robot&, const Alternative& it, const AlternativeTest&,
                      double) { return other_law(it, Friction::asymmetric); },
    },
    AlternativeKind{
        .code = "joint_elasticity",
        .positive = true,
        .words =
            [](const Robot&, const Alternative& it, const AlternativeTest& test) {
              const double value = test.estimate[0];
              const double sigma = test.sigma[0];
              // The link swings on the spring while the motor stands.
              const double swings =
                  value * it.inertia > 0.0 ? 0.5 / (std::numbers::pi * std::sqrt(value * it.inertia)) : 0.0;
              return AlternativeWords{
                  "it looks elastic, " + plus_minus(value, sigma, 2) +
                      (it.turns ? " rad for one N·m" : " m for one N") +
                      (swings > 0.0 ? ", on which its link would swing at " + number(swings, 2) + " Hz" : ""),
                  ""};
            },
    },
    AlternativeKind{
        .code = "joint_spring",
        .words =
            [](const Robot&, const Alternative& it, const AlternativeTest& test) {
              return AlternativeWords{"a spring or counterbalance looks to pull it, by " +
                                          plus_minus(test.estimate[0], test.sigma[0], 2) +
                                          (it.turns ? " N·m for one rad" : " N for one m"),
                                      "give its torque over the position in [log] subtract"};
            },
    },
    AlternativeKind{
        .code = "joint_coupling",
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest&) {
              return AlternativeWords{"a motor looks to turn both",
                                      "[[robot.coupling]] with motor and joints of these two"};
            },
        .changes = [](const Robot&, const Alternative& it, const AlternativeTest& test,
                      double) { return coupled(it, test); },
    },
};

}  // namespace

const AlternativeKind& kind_of(const Alternative& alternative) {
  return *std::ranges::find(alternative_kinds, alternative.code, &AlternativeKind::code);
}

}  // namespace rivid::detail
