// The model of robot and log against its nearest alternatives: another gain, zero, clock, geometry, load or
// friction that explains the torques better, on blocks of time that took no part as well, is named.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "identify/check/alternatives.hpp"
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
constexpr std::size_t most_told = 5;  // alternatives in a report; a choice: a reader tries the first ones
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

// Bodies that are others in one log, or for a part of the time, make blocks of time differ, and so the
// deviations by which harm is measured. A load that changes has to be half of the residual then.
bool widens_blocks(const Alternative& it, const AlternativeTest& test) {
  constexpr double three_quarters = 0.75;  // of the squares
  return it.code == "logs_differ" || (it.code == "load_changed" && test.held_out > three_quarters);
}

// What of the tests is more than chance, can be and does harm: first those that explain most, and of those
// that explain as much the one with the fewest parameters.
std::vector<AlternativeTest> believed(const std::vector<Alternative>& all, const Identification& result,
                                      std::vector<AlternativeTest> found) {
  std::erase_if(found, [&](const AlternativeTest& test) {
    return !(test.p < by_chance) || test.held_out < notable_part ||
           (kind_of(all[test.of]).positive && test.estimate[0] < 0.0) ||
           (harm_of(result, test.shift).sigmas < harmful_shift && !widens_blocks(all[test.of], test));
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

// tests  those of `believed`; the first one is of `named`
void add_finding(const Robot& robot, const Identification& result, const Alternative& named,
                 std::span<const AlternativeTest> tests, std::span<const ModelTest> believed, double f_m,
                 Findings& out) {
  const AlternativeTest& test = tests.front();
  const Harm harm = harm_of(result, test.shift);
  const AlternativeKind& kind = kind_of(named);
  const Told told{robot, named, test, f_m};
  const AlternativeWords words = kind.words(told);
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
  std::vector<Change> changes = kind.changes == nullptr ? std::vector<Change>() : kind.changes(told);
  // Which of those that explain nearly as much is the fault is not known.
  const bool is_grave = std::ranges::any_of(tests, [&](const AlternativeTest& other) {
    return other.held_out > rival_part * test.held_out && harm_of(result, other.shift).is_grave;
  });
  bool refused = ((is_grave || widens_blocks(named, test)) && test.held_out > convincing_part) ||
                 (kind.large > 0.0 && test.estimate.norm() > kind.large);
  if (named.code == "torque_delay") {
    refused = refused && std::abs(test.estimate[0]) * f_m > least_delay;
  }
  if (!refused && named.code == "torque_delay") {
    if (!out.has("torque_lag")) {
      out.add("torque_lag", named.subject, std::move(text), std::move(changes));
    }
    return;
  }
  out.add(kind.fault && !refused ? "model_mismatch" : named.code, named.subject, std::move(text),
          std::move(changes));
}

// Logs that took no part, by the model and by what alternatives were taken beside it.
class HeldOut {
 public:
  // Nothing is held out where these logs tell nothing.
  HeldOut(const Robot& robot, std::span<const Log> logs, const Identification& result,
          const ProbedRows& fitted) {
    if (logs.empty()) {
      return;
    }
    const TorqueProbe probe(robot, result.base, logs, result.estimation.signal);
    rows_.emplace(probe, robot, result);
    rows_->chi = fitted.chi;
    all_ = alternatives(robot, result.base, *rows_);
    // What single logs of the fit have of their own.
    rows_->take(Matrix::Zero(rows_->W.rows(), fitted.W.cols() - rows_->W.cols()));
  }

  // Whether the model with an alternative explains them worse. A fault may be one of the other logs alone.
  [[nodiscard]] bool contradicts(const AlternativeTest& test, const ProbedRows& without,
                                 const ProbedRows& with, double scale) const {
    if (!rows_) {
      return false;
    }
    const Alternative& it = all_[test.of];
    const double left = (rows_->Y - rows_->W * without.solution).squaredNorm();
    const Index before = without.solution.size();
    const Vector elsewhere = rows_->Y - rows_->W * with.solution.head(before);
    const Vector here =
        elsewhere - scale * it.effect * (test.directions * with.solution.tail(with.solution.size() - before));
    return here.squaredNorm() > left && !(kind_of(it).fault && elsewhere.squaredNorm() <= left);
  }

  void take(const AlternativeTest& test, double scale) {
    if (rows_) {
      rows_->take(scale * all_[test.of].effect * test.directions);
    }
  }

 private:
  std::optional<ProbedRows> rows_;
  std::vector<Alternative> all_;
};

// Alternatives of joints that move too little to be tested, which is reported.
std::vector<std::size_t> untested(const Robot& robot, const ProbedRows& rows,
                                  const std::vector<Alternative>& all, Findings& out) {
  std::vector<std::size_t> places;
  for (Index j = 0; j < robot.size(); ++j) {
    const std::string& joint = robot.joints[static_cast<std::size_t>(j)].name;
    if (rows.tested(j)) {
      continue;
    }
    add_not_tested(joint, "its gain, zero, origin, friction law and elasticity", rows.rows_of(j),
                   rows.wanted[static_cast<std::size_t>(j)], out);
    for (std::size_t a = 0; a < all.size(); ++a) {
      const std::string& subject = all[a].subject;
      if (all[a].code != "load_changed" &&
          (subject == joint || subject.starts_with(joint + " and ") || subject.ends_with(" and " + joint))) {
        places.push_back(a);
      }
    }
  }
  return places;
}

// Logs with bodies of their own, where friction may be another one in each: the log that differs most is
// reported and takes parameters of its own.
void check_sameness(const TorqueProbe& probe, const Robot& robot, const Identification& result,
                    ProbedRows& rows, Alternatives& report, Findings& out) {
  constexpr std::size_t most_logs = 12;  // each takes a fit of its own; a choice that bounds the time
  const std::size_t logs = rows.logs.size();
  if (logs < 2 || logs > most_logs) {
    return;
  }
  struct Found {
    ProbedRows rows;  // with friction of its own
    std::vector<Alternative> bodies;
    std::vector<AlternativeTest> tests;
  };
  std::optional<Found> best;
  // Of two logs either one says the same.
  for (std::size_t l = logs == 2 ? 1 : 0; l < logs; ++l) {
    OwnLog own = own_log(robot, result.base, rows, l);
    ProbedRows with = rows;
    with.take(own.friction);
    if (!with.fit()) {
      continue;
    }
    std::vector<AlternativeTest> found = believed(own.bodies, result, tests(with, own.bodies));
    if (!found.empty() && (!best || found.front().held_out > best->tests.front().held_out)) {
      best = Found{std::move(with), std::move(own.bodies), std::move(found)};
    }
  }
  if (!best) {
    return;
  }
  const AlternativeTest& test = best->tests.front();
  const Alternative& named = best->bodies[test.of];
  report.believed = in_report(best->bodies, result, {test});
  report.shift = test.shift;
  add_finding(robot, result, named, std::span(best->tests).first(1), report.believed,
              probe.logs().front().log->f_m, out);
  best->rows.take(named.effect * test.directions);
  if (best->rows.fit()) {
    rows = std::move(best->rows);
  }
}

// A block of time of which much more of a joint's torque is left than of others: by the joint where it is
// most.
void check_evenness(const Robot& robot, const ProbedRows& rows, Findings& out) {
  // Than of the middle block: of 177 real logs and pieces 3 % have more.
  constexpr double much_more = 5.0;
  constexpr double notable_rest = 0.03;     // of the torque
  constexpr Index fewest_rows = 5;          // of a block; a choice: the rms of fewer is a matter of chance
  constexpr std::size_t fewest_blocks = 5;  // of a joint; a choice: the middle one of fewer is no measure
  struct Block {
    Vector rest;
    const Log* log = nullptr;
    double from = 0.0;  // [s]
    double to = 0.0;

    [[nodiscard]] double rms() const { return rest.norm() / std::sqrt(static_cast<double>(rest.size())); }
  };
  double most = much_more;
  std::string subject;
  std::string text;
  for (Index j = 0; j < robot.size(); ++j) {
    std::vector<Block> blocks;
    double squares = 0.0;  // of the torque
    for (const ProbedRows::Piece& piece : rows.pieces) {
      if (piece.joint != j) {
        continue;
      }
      const PickedLog& picked = rows.logs[piece.log];
      squares += rows.Y.segment(piece.first, piece.size()).squaredNorm();
      const auto time_of = [&](Index i) {
        const Index instant =
            picked.instants[static_cast<std::size_t>(piece.instants[static_cast<std::size_t>(i)])];
        return picked.log->log->t[picked.log->samples[static_cast<std::size_t>(instant)]];
      };
      const auto block_of = [&](Index i) { return rows.block_of[static_cast<std::size_t>(piece.first + i)]; };
      for (Index first = 0, end = 0; first < piece.size(); first = end) {
        while (end < piece.size() && block_of(end) == block_of(first)) {
          ++end;
        }
        if (end - first >= fewest_rows) {
          blocks.push_back({rows.residual.segment(piece.first + first, end - first), picked.log->log,
                            time_of(first), time_of(end - 1)});
        }
      }
    }
    if (blocks.size() < fewest_blocks) {
      continue;
    }
    std::ranges::sort(blocks, {}, &Block::rms);
    const Block& worst = blocks.back();
    const double times = worst.rms() / blocks[blocks.size() / 2].rms();
    const double part = worst.rms() / std::sqrt(squares / static_cast<double>(rows.rows_of(j)));
    if (times > most && part > notable_rest) {
      most = times;
      subject = robot.joints[static_cast<std::size_t>(j)].name;
      text = "from " + number(worst.from, 4) + " to " + number(worst.to, 4) + " s of " + worst.log->source +
             " the model leaves " + number(100.0 * part, 2) + " % of its torque, " + number(times, 2) +
             " times what it leaves of the middle one of " + std::to_string(blocks.size()) +
             " blocks of time";
    }
  }
  if (!subject.empty()) {
    out.add("uneven_residual", subject, std::move(text));
  }
}

}  // namespace

Alternatives check_model(const TorqueProbe& probe, const Robot& robot, std::span<const Log> logs,
                         std::span<const Log> validation, const Identification& result, Findings& out) {
  std::optional<ProbedRows> rows = ProbedRows::fitted(probe, robot, result);
  if (!rows) {
    out.add(
        "not_tested", "all joints",
        "gains, zeros, gravity, clock and friction laws are not tested, because the instants at which the "
        "joints move do not determine all parameters");
    return {};
  }
  const std::vector<Alternative> all = alternatives(robot, result.base, *rows);
  Alternatives report;
  check_sameness(probe, robot, result, *rows, report, out);
  std::vector<ModelTest> rivals;
  bool first = true;
  std::optional<HeldOut> held_out;
  std::vector<std::size_t> left_out = untested(robot, *rows, all, out);
  while (std::ssize(report.believed) < most_rounds) {
    std::vector<AlternativeTest> found = believed(all, result, tests(*rows, all));
    std::erase_if(found, [&](const AlternativeTest& test) {
      return std::ranges::find(left_out, test.of) != left_out.end();
    });
    if (found.empty()) {
      break;
    }
    const AlternativeTest& best = found.front();
    const Alternative& named = all[best.of];
    const Matrix columns = named.effect * best.directions;
    const double scale = rows->W.norm() / columns.norm();
    ProbedRows with = *rows;
    with.take(scale * columns);
    const bool fits = with.fit();
    if (!held_out) {
      held_out.emplace(robot, validation, result, *rows);
    }
    const double f_m = logs.front().f_m;
    if (fits && held_out->contradicts(best, *rows, with, scale)) {
      left_out.push_back(best.of);
      continue;
    }
    const std::vector<ModelTest> told = in_report(all, result, found);
    if (std::exchange(first, false)) {
      rivals.assign(told.begin() + 1, told.end());
    }
    report.shift = report.believed.empty() ? best.shift : Vector(report.shift + best.shift);
    report.believed.push_back(told.front());
    add_finding(robot, result, named, found, told, f_m, out);
    if (!fits) {
      break;
    }
    held_out->take(best, scale);
    rows = std::move(with);
  }
  for (const ModelTest& rival : rivals) {
    if (std::ranges::none_of(report.believed, [&](const ModelTest& it) { return same_test(it, rival); })) {
      report.believed.push_back(rival);
    }
  }
  check_evenness(robot, *rows, out);
  return report;
}

void check_together(const Robot& robot, std::span<const Log> logs, const Log& validation,
                    const Identification& result, Findings& out) {
  std::vector<Log> together(logs.begin(), logs.end());
  together.push_back(validation);
  const TorqueProbe probe(robot, result.base, together, result.estimation.signal);
  const std::optional<ProbedRows> rows = ProbedRows::fitted(probe, robot, result);
  if (!rows) {
    return;
  }
  const std::vector<Alternative> all = alternatives(robot, result.base, *rows);
  const std::vector<AlternativeTest> found = believed(all, result, tests(*rows, all));
  if (found.empty() || found.front().held_out < convincing_part) {
    return;
  }
  const Alternative& named = all[found.front().of];
  const AlternativeKind& kind = kind_of(named);
  if (kind.changes == nullptr || out.has(named.code, named.subject) ||
      out.has("model_mismatch", named.subject)) {
    return;
  }
  const Told told{robot, named, found.front(), validation.f_m};
  out.add("model_mismatch", named.subject,
          kind.words(told).what + ": so say the logs of the fit and " + validation.source +
              " together, of whose squared residual " +
              number(std::round(100.0 * found.front().held_out), 3) + " % goes with it",
          kind.changes(told));
}

}  // namespace rivid::detail
