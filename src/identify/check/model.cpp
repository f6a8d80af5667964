// The model of robot and log against its nearest alternatives: another gain, zero, clock, geometry, load or
// friction that explains the torques better, on blocks of time that took no part as well, is named.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "identify/check/alternative_kinds.hpp"
#include "identify/check/alternative_tests.hpp"
#include "identify/check/checks.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Chance of an alternative that is none, of some hundred that are looked at.
constexpr double by_chance = 1e-5;
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
    return !(test.p < by_chance) || test.held_out < kind_of(all[test.of]).least ||
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

ModelTest in_report(const Alternative& it, const Identification& result, const AlternativeTest& test) {
  const Harm harm = harm_of(result, test.shift);
  return {.code = std::string(it.code),
          .subject = it.subject,
          .test = {test.statistic, test.freedom, test.p},
          .estimate = test.estimate,
          .sigma = test.sigma,
          .explained = test.held_out,
          .largest_shift = harm.sigmas,
          .parameter = harm.parameter};
}

// What the first search found beside the likeliest one.
std::vector<ModelTest> rivals_of(const std::vector<Alternative>& all, const Identification& result,
                                 const std::vector<AlternativeTest>& found) {
  std::vector<ModelTest> out;
  for (const AlternativeTest& test : found) {
    ModelTest told = in_report(all[test.of], result, test);
    if (out.size() < most_told &&
        std::ranges::none_of(out, [&](const ModelTest& t) { return same_test(t, told); })) {
      out.push_back(std::move(told));
    }
  }
  return out;
}

// An alternative that was taken, as it is beside the others.
struct Taken {
  std::size_t of = 0;  // place among all
  AlternativeTest beside;
};

// The model with alternatives, one after the other: friction that follows the load first, which looks like
// gains and loads; then whatever explains most of the rest.
std::vector<Taken> taken_from(const ProbedRows& rows, const std::vector<Alternative>& all,
                              const Identification& result, std::vector<AlternativeTest> found) {
  std::vector<Taken> out;
  ProbedRows more = rows;
  const auto take = [&](const AlternativeTest& test) {
    more.take(test.columns);
    out.push_back({test.of, test});
  };
  for (const AlternativeTest& test : found) {
    if (all[test.of].code == "load_friction") {
      take(test);
    }
  }
  for (int round = 0; round < most_rounds; ++round) {
    if (!out.empty()) {
      found = believed(all, result, tests(more, all));
    }
    if (found.empty()) {
      break;
    }
    take(found.front());
  }
  return out;
}

// The rows with all that was taken but one, or with all.
ProbedRows beside_others(const ProbedRows& rows, const std::vector<Taken>& taken, std::size_t but) {
  ProbedRows out = rows;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    if (k != but) {
      out.take(taken[k].beside.columns);
    }
  }
  return out;
}

// Each beside all others, without those that are no longer believed then.
void fit_jointly(const ProbedRows& rows, const std::vector<Alternative>& all, const Identification& result,
                 std::vector<Taken>& taken) {
  for (std::size_t i = 0; taken.size() > 1 && i < taken.size();) {
    const std::span one(&all[taken[i].of], 1);
    std::vector<AlternativeTest> now = tests(beside_others(rows, taken, i), one);
    if (now.empty() || believed({one.begin(), one.end()}, result, now).empty()) {
      taken.erase(taken.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;
    } else {
      taken[i].beside = std::move(now.front());
      ++i;
    }
  }
}

// What alternatives move the parameters by. Of an error of the model some is seen and some hides in the
// parameters: no more than so many times what is seen is believed of it.
Vector shift_by(const ProbedRows& rows, const ProbedRows& beside) {
  constexpr double most_hidden = 20.0;
  const Vector shift = beside.beside - rows.chi;
  const double seen = std::sqrt(std::max(rows.residual.squaredNorm() - beside.residual.squaredNorm(), 0.0));
  const double hidden = (rows.W * shift).norm();
  return hidden > most_hidden * seen ? Vector(shift * (most_hidden * seen / hidden)) : shift;
}

// What the validation logs say of an alternative: parts of their torques that are left without and with it.
struct Trial {
  double without = 0.0;
  double with = 0.0;
};

// Rows of the validation logs under the alternatives.
struct TrialRows {
  ProbedRows rows;
  std::vector<Alternative> all;
};

std::optional<TrialRows> trial_rows(const Robot& robot, std::span<const Log> validation,
                                    const Identification& result, const std::vector<Alternative>& believed,
                                    const std::vector<Taken>& taken) {
  std::set<std::string_view> codes;
  for (const Taken& one : taken) {
    codes.insert(believed[one.of].code);
  }
  if (validation.empty() || codes.empty()) {
    return std::nullopt;
  }
  const TorqueProbe probe(robot, result.base, validation, result.estimation.signal);
  std::optional<ProbedRows> rows = ProbedRows::of(probe, robot, result);
  if (!rows) {
    return std::nullopt;
  }
  rows->chi = result.chi;
  std::vector<Alternative> all = alternatives(robot, result.base, *rows, codes);
  return TrialRows{std::move(*rows), std::move(all)};
}

// Whether an alternative is a matter of single logs, or of instants in them.
bool of_these_logs(const Alternative& it) { return it.code == "load_changed" || it.code == "logs_differ"; }

// The alternative by itself, as the logs of the fit have it, on the torques of the validation; nothing where
// its effect is a matter of these logs alone.
std::optional<Trial> tried(const TrialRows& on, const Alternative& it, const ProbedRows& rows) {
  const auto same = std::ranges::find_if(
      on.all, [&](const Alternative& other) { return other.code == it.code && other.subject == it.subject; });
  const std::vector<AlternativeTest> alone = tests(rows, std::span(&it, 1));
  if (same == on.all.end() || alone.empty() || of_these_logs(it)) {
    return std::nullopt;
  }
  const Vector without = on.rows.Y - on.rows.W * on.rows.chi;
  const Vector with = without - on.rows.W * alone.front().shift - same->effect * alone.front().estimate;
  const double torques = on.rows.Y.norm();
  return Trial{without.norm() / torques, with.norm() / torques};
}

// What is found of an alternative that was taken.
struct Evidence {
  bool replicated = true;
  std::optional<Trial> trial;

  [[nodiscard]] bool contradicted() const { return trial && !(trial->with < trial->without); }
};

std::string percents(double part, double beside) {
  return number_beside(100.0 * part, 100.0 * beside, 3) + " %";
}

void add_finding(const Robot& robot, const Identification& result, const Alternative& named,
                 const AlternativeTest& test, std::span<const ModelTest> rivals, const Evidence& evidence,
                 double f_m, Findings& out) {
  const Harm harm = harm_of(result, test.shift);
  const AlternativeKind& kind = kind_of(named);
  const AlternativeWords words = kind.words(robot, named, test);
  std::string text =
      words.what + ": " + number(std::round(100.0 * test.held_out), 3) +
      " % of the squared residual goes with it, on blocks of time that took no part; it moves " +
      harm.parameter + " by " + number_that_says(harm.sigmas, 2) + " σ";
  if (!evidence.replicated) {
    text += "; both halves of the motion do not agree on it";
  }
  if (evidence.trial) {
    const auto [without, with] = *evidence.trial;
    text += evidence.contradicted()
                ? "; on the validation logs it does not help: it leaves " + percents(with, without) +
                      " of the torques instead of " + percents(without, with)
                : "; on the validation logs it leaves " + percents(with, without) + " instead of " +
                      percents(without, with);
  }
  if (!words.cure.empty() && !evidence.contradicted()) {
    text += "; " + words.cure;
  }
  std::vector<std::string> near;
  for (const ModelTest& other : rivals) {
    if (other.explained > rival_part * test.held_out &&
        (other.code != named.code || other.subject != named.subject)) {
      near.push_back(other.code + " of " + other.subject);
    }
  }
  if (!near.empty()) {
    text += "; nearly as much goes with " + listed(near);
  }
  bool refused = ((harm.is_grave && test.held_out > convincing_part) ||
                  (kind.large > 0.0 && test.estimate.norm() > kind.large)) &&
                 evidence.replicated && !evidence.contradicted();
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

void add_untested(const Robot& robot, const std::vector<UntestedJoint>& joints,
                  const std::vector<Alternative>& all, const std::vector<std::size_t>& alternatives,
                  Findings& out) {
  for (const UntestedJoint& it : joints) {
    out.add("not_tested", robot.joints[static_cast<std::size_t>(it.joint)].name,
            "gain, zero, friction and what else its torques would tell of, because it moves at " +
                std::to_string(it.instants) + " of the instants that are looked at, " +
                std::to_string(it.wanted) + " are needed");
  }
  std::map<std::string_view, std::vector<std::string>> subjects;
  for (const std::size_t a : alternatives) {
    std::vector<std::string>& of_code = subjects[all[a].code];
    if (std::ranges::find(of_code, all[a].subject) == of_code.end()) {
      of_code.push_back(all[a].subject);
    }
  }
  for (const auto& [code, of_code] : subjects) {
    out.add("not_tested", std::string(code),
            "of " + listed(of_code) + ", because what would tell of it lies in too few blocks of time");
  }
}

}  // namespace

Alternatives check_model(const TorqueProbe& probe, const Robot& robot, std::span<const Log> validation,
                         const Identification& result, Findings& out) {
  std::vector<UntestedJoint> untested;
  const std::optional<ProbedRows> rows = ProbedRows::of(probe, robot, result, &untested);
  if (!rows) {
    add_untested(robot, untested, {}, {}, out);
    return {};
  }
  const std::vector<Alternative> all = alternatives(robot, result.base, *rows);
  std::vector<std::size_t> left_out;
  const std::vector<AlternativeTest> found = believed(all, result, tests(*rows, all, &left_out));
  add_untested(robot, untested, all, left_out, out);
  const std::vector<ModelTest> rivals = rivals_of(all, result, found);
  std::vector<Taken> taken = taken_from(*rows, all, result, found);
  fit_jointly(*rows, all, result, taken);
  Alternatives report;
  if (!taken.empty()) {
    report.shift = shift_by(*rows, beside_others(*rows, taken, taken.size()));
  }
  const std::optional<TrialRows> trial = trial_rows(robot, validation, result, all, taken);
  for (std::size_t i = 0; i < taken.size(); ++i) {
    const Alternative& named = all[taken[i].of];
    report.believed.push_back(in_report(named, result, taken[i].beside));
    const Evidence evidence = {.replicated = !kind_of(named).fault || of_these_logs(named) ||
                                             replicates(beside_others(*rows, taken, i), named),
                               .trial = trial ? tried(*trial, named, *rows) : std::nullopt};
    add_finding(robot, result, named, taken[i].beside, rivals, evidence, probe.logs().front().log->f_m, out);
  }
  for (const ModelTest& rival : rivals) {
    if (std::ranges::none_of(report.believed, [&](const ModelTest& it) { return same_test(it, rival); })) {
      report.believed.push_back(rival);
    }
  }
  return report;
}

}  // namespace rivid::detail
