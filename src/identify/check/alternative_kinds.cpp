#include "identify/check/alternative_kinds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::string plus_minus(double value, double sigma, int digits) {
  return number(value, digits) + " ± " + number(sigma, 1);
}

std::string gravity_vector(const Eigen::Vector3d& g) {
  return "[" + number(g[0], 3) + ", " + number(g[1], 3) + ", " + number(g[2], 3) + "]";
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
              return AlternativeWords{"its load looks another one from " +
                                          number(std::round(100.0 * it.from), 2) + " % of the time on",
                                      "identify each load from a log of its own"};
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
    },
    AlternativeKind{
        .code = "direction_friction",
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest&) {
              return AlternativeWords{"its friction looks different in both directions",
                                      "friction = \"asymmetric\" in [robot]"};
            },
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
        .code = "joint_coupling",
        .words =
            [](const Robot&, const Alternative&, const AlternativeTest&) {
              return AlternativeWords{"a motor looks to turn both",
                                      "[[robot.coupling]] with motor and joints of these two"};
            },
    },
};

}  // namespace

const AlternativeKind& kind_of(const Alternative& alternative) {
  return *std::ranges::find(alternative_kinds, alternative.code, &AlternativeKind::code);
}

}  // namespace rivid::detail
