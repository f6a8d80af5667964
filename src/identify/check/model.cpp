// The model of robot and log against its nearest alternatives: another gain, zero, clock, geometry, load or
// friction that explains the torques better, on blocks of time that took no part as well, is named.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "identify/check/alternative_kinds.hpp"
#include "identify/check/alternative_tests.hpp"
#include "identify/check/checks.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Chance of an alternative that is none, of some hundred that are looked at.
constexpr double by_chance = 1e-5;
// Part of the sum of squares that it has to explain on blocks that took no part.
constexpr double notable_part = 0.05;
// Shift of a parameter that matters, in σ; and that makes a result useless: in σ, of its value, and of the
// largest value of its unit.
constexpr double harmful_shift = 3.0;
constexpr double grave = 5.0;
constexpr double grave_part = 0.1;
constexpr double grave_of_largest = 0.02;
// Part of the sum of squares by which a fault is believed enough to refuse a result.
constexpr double convincing_part = 0.4;
// An alternative with fewer parameters is preferred where it explains this part of what another one does; and
// one that does not win is reported.
constexpr double simpler_part = 0.9;
constexpr double rival_part = 0.7;
constexpr std::size_t most_told = 5;
// Torques that are late by fewer samples were sampled or filtered otherwise than the experiment says, but
// belong to the motion.
constexpr double least_delay = 2.0;
// Alternatives that are taken, one after the other.
constexpr int most_rounds = 3;

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

// What of the tests is more than chance, can be and does harm: first those that explain most, and of those
// that explain as much the one with the fewest parameters.
std::vector<AlternativeTest> believed(const std::vector<Alternative>& all, const Identification& result,
                                      std::vector<AlternativeTest> found) {
  std::erase_if(found, [&](const AlternativeTest& test) {
    return !(test.p < by_chance) || test.held_out < notable_part ||
           (kind_of(all[test.of]).positive && test.estimate[0] < 0.0) ||
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

void add_finding(const Robot& robot, const Identification& result, const Alternative& named,
                 const AlternativeTest& test, std::span<const ModelTest> believed, double f_m,
                 Findings& out) {
  const Harm harm = harm_of(result, test.shift);
  const AlternativeKind& kind = kind_of(named);
  const AlternativeWords words = kind.words(robot, named, test);
  std::string text =
      words.what + ": " + number(std::round(100.0 * test.held_out), 3) +
      " % of the squared residual goes with it, on blocks of time that took no part; it moves " +
      harm.parameter + " by " + number_that_says(harm.sigmas, 2) + " σ" +
      (words.cure.empty() ? "" : "; " + words.cure);
  std::vector<std::string> rivals;
  for (const ModelTest& other : believed) {
    if (&other != &believed.front() && other.explained > rival_part * test.held_out) {
      rivals.push_back(other.code + " of " + other.subject);
    }
  }
  if (!rivals.empty()) {
    text += "; nearly as much goes with " + listed(rivals);
  }
  bool refused = (harm.is_grave && test.held_out > convincing_part) ||
                 (kind.large > 0.0 && test.estimate.norm() > kind.large);
  if (named.code == "torque_delay") {
    refused = refused && std::abs(test.estimate[0]) * f_m > least_delay;
  }
  if (!refused && named.code == "torque_delay") {
    if (!out.has("torque_lag")) {
      out.add("torque_lag", named.subject, std::move(text));
    }
    return;
  }
  out.add(kind.fault && !refused ? "model_mismatch" : named.code, named.subject, std::move(text));
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
