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
constexpr double convincing_part = 0.3;
// An alternative with fewer parameters is preferred where it explains this part of what another one does; and one that does not win
// is told.
constexpr double simpler_part = 0.9;
constexpr double rival_part = 0.7;
constexpr std::size_t most_told = 5;

// Faults of robot and log, which make parameters wrong; else what the model lacks.
constexpr std::array faults = {"torque_gain", "zero_offset",  "gravity_tilt",
                               "clock_rate",  "joint_origin", "load_changed"};
// Alternatives that exist with positive coefficients alone.
constexpr std::array positive = {"load_friction", "stribeck_friction", "joint_elasticity"};

// Words of an alternative and what would mend it.
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
    return {"the clock of the log looks wrong by " + plus_minus(100.0 * value, 100.0 * sigma, 2) + " %",
            "multiply [log] rate_hz by " + number(1.0 + value, 4) + ", or mend the time stamps"};
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

// What of the tests is more than chance and can be.
std::vector<AlternativeTest> believed(const std::vector<Alternative>& all,
                                      std::vector<AlternativeTest> found) {
  std::erase_if(found, [&](const AlternativeTest& test) {
    return !(test.p < by_chance) || test.held_out < notable_part ||
           (contains(positive, all[test.of].code) && test.estimate[0] < 0.0);
  });
  std::ranges::sort(found, std::ranges::greater(), &AlternativeTest::held_out);
  return found;
}

void add_finding(const Robot& robot, const Identification& result, const Alternative& named,
                 const AlternativeTest& test, std::span<const ModelTest> believed, Findings& out) {
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
  const bool refused = harm.is_grave && test.held_out > convincing_part;
  out.add(fault && !refused ? "model_mismatch" : named.code, named.subject, std::move(text));
}

}  // namespace

Alternatives check_model(const TorqueProbe& probe, const Robot& robot, const Identification& result,
                         Findings& out) {
  const std::optional<ProbedRows> rows = ProbedRows::of(probe, robot, result.base);
  if (!rows) {
    return {};
  }
  const std::vector<Alternative> all = alternatives(robot, result.base, *rows);
  std::vector<AlternativeTest> found = believed(all, tests(*rows, all));
  std::erase_if(
      found, [&](const AlternativeTest& test) { return harm_of(result, test.shift).sigmas < harmful_shift; });
  if (found.empty()) {
    return {};
  }
  // Of those that explain as much, the one with the fewest parameters.
  const double most = found.front().held_out;
  std::ranges::stable_sort(found, {}, [&](const AlternativeTest& test) {
    return test.held_out >= simpler_part * most ? test.freedom : std::numeric_limits<double>::infinity();
  });
  Alternatives report{.believed = {}, .shift = found.front().shift};
  for (const AlternativeTest& test : found) {
    const Alternative& it = all[test.of];
    const auto same = [&](const ModelTest& told) {
      return told.code == it.code && told.subject == it.subject;
    };
    if (report.believed.size() < most_told && std::ranges::none_of(report.believed, same)) {
      const Harm harm = harm_of(result, test.shift);
      report.believed.push_back({.code = std::string(it.code),
                                 .subject = it.subject,
                                 .test = {test.statistic, test.freedom, test.p},
                                 .estimate = test.estimate,
                                 .sigma = test.sigma,
                                 .explained = test.held_out,
                                 .largest_shift = harm.sigmas,
                                 .parameter = harm.parameter});
    }
  }
  add_finding(robot, result, all[found.front().of], found.front(), report.believed, out);
  return report;
}

}  // namespace rivid::detail
