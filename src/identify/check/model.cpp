// The model of robot and log against its nearest alternatives: another gain, zero, clock, geometry, load or friction that
// explains the torques better, on blocks of time that took no part as well, is named.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "identify/check/alternative_tests.hpp"
#include "identify/check/findings.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Chance of an alternative that is none, of some hundred that are looked at.
constexpr double by_chance = 1e-5;
// Part of the sum of squares that it has to explain on blocks that took no part.
constexpr double notable_part = 0.05;
// Shift of a parameter that matters, in σ; and that makes a result useless: in σ, of its value, and of the largest value of its unit.
constexpr double harmful_shift = 3.0;
constexpr double grave = 5.0;
constexpr double grave_part = 0.1;
constexpr double grave_of_largest = 0.02;
// Part of the sum of squares by which a fault is believed enough to refuse a result.
constexpr double convincing_part = 0.4;
// An alternative with fewer parameters is preferred where it explains this part of what another one does; and one that does not win
// is reported.
constexpr double simpler_part = 0.9;
constexpr double rival_part = 0.7;
constexpr std::size_t most_told = 5;
// Torques that are late by fewer samples were sampled or filtered otherwise than the experiment says, but belong to the motion.
constexpr double least_delay = 2.0;
// Alternatives that are taken, one after the other.
constexpr int most_rounds = 3;

// Faults of robot and log, which make parameters wrong; else what the model lacks.
constexpr std::array faults = {"torque_gain",  "zero_offset",  "gravity_tilt", "clock_rate",
                               "torque_delay", "joint_origin", "load_changed"};
// Alternatives that exist with positive coefficients alone.
constexpr std::array positive = {"load_friction", "stribeck_friction", "joint_elasticity"};

// Words of an alternative and its cure.
struct Words {
  std::string what;
  std::string cure;
};

std::string plus_minus(double value, double sigma, int digits) {
  return number(value, digits) + " ± " + number(sigma, 1);
}

std::string gravity_vector(const Eigen::Vector3d& g) {
  return "[" + number(g[0], 3) + ", " + number(g[1], 3) + ", " + number(g[2], 3) + "]";
}

Words words_of(const Robot& robot, const Alternative& alternative, const AlternativeTest& test) {
  const double value = test.estimate[0];
  const double sigma = test.sigma[0];
  if (alternative.code == "torque_gain") {
    const double factor = 1.0 + value;
    return {"its torque is " + plus_minus(factor, sigma, 3) + " times what the other joints ask for",
            "correct drive_gain, or give its column in [log] scale = " + number(1.0 / factor, 3)};
  }
  if (alternative.code == "zero_offset") {
    return {"its position looks off by " + plus_minus(-value, sigma, 3) + (alternative.turns ? " rad" : " m"),
            "give its column in [log] position offset = " + number(value, 3)};
  }
  if (alternative.code == "gravity_tilt") {
    const double degrees = 180.0 / std::numbers::pi;
    return {"gravity looks tilted by " +
                plus_minus(degrees * test.estimate.norm(), degrees * test.sigma.norm(), 2) + "°",
            "[robot] gravity = " + gravity_vector(tilted_gravity(robot, test.estimate))};
  }
  if (alternative.code == "clock_rate") {
    return {
        "the sampling rate of the log looks wrong by " + plus_minus(100.0 * value, 100.0 * sigma, 2) + " %",
        "multiply [log] rate_hz by " + number(1.0 + value, 4) + ", or correct the time stamps"};
  }
  if (alternative.code == "torque_delay") {
    return {"torques look " + plus_minus(1e3 * std::abs(value), 1e3 * sigma, 2) + " ms " +
                (value > 0.0 ? "late" : "early") + " beside the motion",
            "change [log] torque_lag by as much, in samples"};
  }
  if (alternative.code == "joint_origin") {
    return {"its frame looks moved or turned against the URDF", "compare its <origin> with the arm"};
  }
  if (alternative.code == "load_changed") {
    return {"its load looks another one from " + number(std::round(100.0 * alternative.from), 2) +
                " % of the time on",
            "identify each load from a log of its own"};
  }
  if (alternative.code == "load_friction") {
    return {"its friction looks to grow with the load, by " + plus_minus(value, sigma, 2) +
                (alternative.turns ? " N·m for one N·m" : " N for one N"),
            ""};
  }
  if (alternative.code == "stribeck_friction") {
    return {"its friction looks larger at low speed, by " + plus_minus(value, sigma, 2) +
                (alternative.turns ? " N·m" : " N"),
            ""};
  }
  if (alternative.code == "direction_friction") {
    return {"its friction looks different in both directions", "friction = \"asymmetric\" in [robot]"};
  }
  if (alternative.code == "joint_elasticity") {
    return {"it looks elastic, " + plus_minus(value, sigma, 2) +
                (alternative.turns ? " rad for one N·m" : " m for one N"),
            ""};
  }
  return {"a motor looks to turn both", "[[robot.coupling]] with motor and joints of these two"};
}

// The largest shift of a parameter in σ, and whether it is grave.
struct Harm {
  double sigmas = 0.0;
  std::string parameter;
  bool is_grave = false;
};

Harm harm_of(const Identification& result, const Vector& shift) {
  std::map<std::string_view, double> largest;
  for (const ParameterEstimate& p : result.parameters) {
    double& of_unit = largest[p.unit];
    of_unit = std::isfinite(p.value) ? std::max(of_unit, std::abs(p.value)) : of_unit;
  }
  Harm out;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const double by = std::abs(shift[static_cast<Index>(i)]);
    const double sigmas = by / p.sigma;
    if (!std::isfinite(sigmas)) {
      continue;
    }
    if (sigmas > out.sigmas) {
      out.sigmas = sigmas;
      out.parameter = p.name;
    }
    out.is_grave = out.is_grave || (sigmas > grave && by > grave_part * std::abs(p.value) &&
                                    by > grave_of_largest * largest[p.unit]);
  }
  return out;
}

bool contains(const auto& codes, std::string_view code) {
  return std::ranges::find(codes, code) != codes.end();
}

// What of the tests is more than chance, can be and does harm: first those that explain most, and of those that explain as much the one
// with the fewest parameters.
std::vector<AlternativeTest> believed(const std::vector<Alternative>& all, const Identification& result,
                                      std::vector<AlternativeTest> found) {
  std::erase_if(found, [&](const AlternativeTest& test) {
    return !(test.p < by_chance) || test.held_out < notable_part ||
           (contains(positive, all[test.of].code) && test.estimate[0] < 0.0) ||
           harm_of(result, test.shift).sigmas < harmful_shift;
  });
  std::ranges::sort(found, std::ranges::greater(), &AlternativeTest::held_out);
  const double most = found.empty() ? 0.0 : found.front().held_out;
  std::ranges::stable_sort(found, {}, [&](const AlternativeTest& test) {
    return test.held_out >= simpler_part * most ? test.freedom : std::numeric_limits<double>::infinity();
  });
  return found;
}

bool same_test(const ModelTest& a, const ModelTest& b) { return a.code == b.code && a.subject == b.subject; }

std::vector<ModelTest> in_report(const std::vector<Alternative>& all, const Identification& result,
                                 const std::vector<AlternativeTest>& found) {
  std::vector<ModelTest> out;
  for (const AlternativeTest& test : found) {
    const Alternative& it = all[test.of];
    const Harm harm = harm_of(result, test.shift);
    ModelTest told = {.code = std::string(it.code),
                      .subject = it.subject,
                      .test = {test.statistic, test.freedom, test.p},
                      .estimate = test.estimate,
                      .sigma = test.sigma,
                      .explained = test.held_out,
                      .largest_shift = harm.sigmas,
                      .parameter = harm.parameter};
    if (out.size() < most_told &&
        std::ranges::none_of(out, [&](const ModelTest& t) { return same_test(t, told); })) {
      out.push_back(std::move(told));
    }
  }
  return out;
}

// Errors of such a size are no small ones that something else looks like.
bool is_large(const Alternative& alternative, const AlternativeTest& test) {
  constexpr std::array<std::pair<std::string_view, double>, 4> sizes = {
      {{"torque_gain", 0.3}, {"zero_offset", 0.3}, {"gravity_tilt", 0.2}, {"clock_rate", 0.05}}};
  return std::ranges::any_of(sizes, [&](const auto& size) {
    return alternative.code == size.first && test.estimate.norm() > size.second;
  });
}

void add_finding(const Robot& robot, const Identification& result, const Alternative& named,
                 const AlternativeTest& test, std::span<const ModelTest> believed, double f_m,
                 Findings& out) {
  const Harm harm = harm_of(result, test.shift);
  const Words words = words_of(robot, named, test);
  std::string text =
      words.what + ": " + number(std::round(100.0 * test.held_out), 3) +
      " % of the squared residual goes with it, on blocks of time that took no part; it moves " +
      harm.parameter + " by " + number(harm.sigmas, 2) + " σ" + (words.cure.empty() ? "" : "; " + words.cure);
  std::vector<std::string> rivals;
  for (const ModelTest& other : believed) {
    if (&other != &believed.front() && other.explained > rival_part * test.held_out) {
      rivals.push_back(other.code + " of " + other.subject);
    }
  }
  if (!rivals.empty()) {
    text += "; nearly as much goes with " + listed(rivals);
  }
  const bool fault = contains(faults, named.code);
  bool refused = (harm.is_grave && test.held_out > convincing_part) || is_large(named, test);
  if (named.code == "torque_delay") {
    refused = refused && std::abs(test.estimate[0]) * f_m > least_delay;
  }
  if (fault && !refused && named.code == "torque_delay") {
    if (!out.has("torque_lag")) {
      out.add("torque_lag", named.subject, std::move(text));
    }
    return;
  }
  out.add(fault && !refused ? "model_mismatch" : named.code, named.subject, std::move(text));
}

}  // namespace

Alternatives check_model(const TorqueProbe& probe, const Robot& robot, const Identification& result,
                         Findings& out) {
  std::optional<ProbedRows> rows = ProbedRows::of(probe, robot, result);
  if (!rows) {
    return {};
  }
  const std::vector<Alternative> all = alternatives(robot, result.base, *rows);
  Alternatives report;
  std::vector<ModelTest> rivals;
  for (int round = 0; round < most_rounds; ++round) {
    const std::vector<AlternativeTest> found = believed(all, result, tests(*rows, all));
    if (found.empty()) {
      break;
    }
    const AlternativeTest& best = found.front();
    const Alternative& named = all[best.of];
    const std::vector<ModelTest> told = in_report(all, result, found);
    report.believed.push_back(told.front());
    if (round == 0) {
      rivals.assign(told.begin() + 1, told.end());
      report.shift = best.shift;
    } else {
      report.shift += best.shift;
    }
    add_finding(robot, result, named, best, told, probe.logs().front().log->f_m, out);
    if (!rows->take(best.columns)) {
      break;
    }
  }
  for (const ModelTest& rival : rivals) {
    if (std::ranges::none_of(report.believed, [&](const ModelTest& it) { return same_test(it, rival); })) {
      report.believed.push_back(rival);
    }
  }
  return report;
}

}  // namespace rivid::detail
