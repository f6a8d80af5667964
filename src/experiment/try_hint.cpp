#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "experiment/changed_text.hpp"
#include "experiment/from_program.hpp"
#include "experiment/text_file.hpp"
#include "identify/describe/describe.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/hint.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double error_of_halves(Experiment experiment, std::span<const Log> logs) {
  experiment.estimation.judge = false;
  std::array<std::vector<Log>, 2> halves;
  for (const Log& log : logs) {
    const Index half = log.samples() / 2;
    halves[0].push_back(excerpt(log, 0, half));
    halves[1].push_back(excerpt(log, half, log.samples() - half));
  }
  const auto error = [&](std::size_t of, std::size_t on) {
    try {
      return detail::error_on_validation(identify_logs(experiment, halves.at(of), halves.at(on)));
    } catch (const InputError&) {
      return unknown;
    }
  };
  return std::sqrt(0.5 * (std::pow(error(0, 1), 2) + std::pow(error(1, 0), 2)));
}

// An experiment file in one version or another, and what it comes to.
struct Version {
  std::string text;
  std::vector<std::string> lines;  // that are new in it
  Experiment experiment;
  Identification result;

  Version(const std::filesystem::path& file, detail::ChangedText changed, Reading& reading)
      : text(std::move(changed.text)),
        lines(std::move(changed.lines)),
        experiment(detail::experiment_of_text(file, text)) {
    take_friction(experiment, reading);
    take_gains(experiment, reading);
    result = run(experiment, reading);
  }

  [[nodiscard]] double error() const { return result.answer_fit().relative_error; }

  [[nodiscard]] HintOutcome outcome(Reading& reading) const {
    return {.status = result.status,
            .fit = error(),
            .held_out = result.validation.empty()
                            ? error_of_halves(experiment, reading.logs(experiment.log, experiment.robot))
                            : detail::error_on_validation(result)};
  }
};

const Finding* hint_of(const Identification& result, std::string_view code, std::string_view subject) {
  const auto at = std::ranges::find_if(result.warnings, [&](const Finding& f) {
    return f.code == code && (subject.empty() || f.subject == subject);
  });
  return at == result.warnings.end() ? nullptr : &*at;
}

// What is left of a size once its hint is taken; it may be no error any more.
const Finding* rest_of(const Identification& result, const Finding& taken) {
  const auto is_size = [](const Change& change) {
    return change.word.empty() && change.key != "signal.cutoff_hz";
  };
  if (!std::ranges::all_of(taken.changes, is_size)) {
    return nullptr;
  }
  const auto at = std::ranges::find_if(result.warnings, [&](const Finding& f) {
    return f.subject == taken.subject &&
           std::ranges::equal(f.changes, taken.changes, {}, &Change::key, &Change::key);
  });
  return at == result.warnings.end() ? nullptr : &*at;
}

Finding required_hint(const Identification& result, const std::filesystem::path& file, std::string_view code,
                      std::string_view subject) {
  const Finding* const found = hint_of(result, code, subject);
  if (found == nullptr) {
    std::vector<std::string> hints;
    for (const Finding& f : result.warnings) {
      if (!f.changes.empty()) {
        hints.push_back(f.code + (f.subject.empty() ? "" : " of " + f.subject));
      }
    }
    throw InputError("try: " + file.string() + " has no finding " + in_quotes(std::string(code)) +
                     (subject.empty() ? "" : " of " + in_quotes(std::string(subject))) +
                     (hints.empty() ? ", and none with a hint that can be taken"
                                    : "; hints that can be taken: " + listed(hints)));
  }
  if (found->changes.empty()) {
    throw InputError("try: no key of the experiment file stands for the hint of " +
                     in_quotes(std::string(code)) + "; rivid explain " + std::string(code) +
                     " says what to do");
  }
  return *found;
}

}  // namespace

bool HintTrial::helps() const {
  if (std::isnan(before.held_out) || std::isnan(after.held_out)) {
    return std::isnan(before.held_out) && (!std::isnan(after.held_out) || after.fit < before.fit);
  }
  return after.held_out < before.held_out;
}

HintTrial try_hint(const std::filesystem::path& file, std::string_view code, std::string_view subject,
                   const Progress& progress) {
  constexpr int rounds = 3;  // of hints, each after the one before; a choice: each identifies anew
  Reading reading(progress);
  const std::string text = detail::description_text(file, "the experiment file", robot_limit);
  const Version told(file, {text, {}}, reading);
  const Finding finding = required_hint(told.result, file, code, subject);
  const auto with = [&](const Version& version, const Finding& hint) {
    const Experiment& experiment = version.experiment;
    return Version(file,
                   detail::changed_text(version.text, experiment,
                                        reading.logs(experiment.log, experiment.robot).front(), hint.changes),
                   reading);
  };
  Version taken = with(told, finding);
  for (int round = 1; round < rounds; ++round) {
    const Finding* const rest = rest_of(taken.result, finding);
    if (rest == nullptr) {
      break;
    }
    Version next = with(taken, *rest);
    if (!(next.error() < taken.error())) {
      break;
    }
    taken = std::move(next);
  }
  return {.finding = finding,
          .lines = std::move(taken.lines),
          .text = std::move(taken.text),
          .before = told.outcome(reading),
          .after = taken.outcome(reading)};
}

}  // namespace rivid
