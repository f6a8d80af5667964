#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "report/documents.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using enum Shown;

List list_of(std::string kind, const std::vector<std::string>& texts) {
  List out{std::move(kind)};
  for (const std::string& text : texts) {
    out.items.push_back({.text = text});
  }
  return out;
}

// What was chosen in place of what was left open.
std::vector<std::string> choices_of(const Identification& result) {
  std::vector<std::string> out;
  if (result.method_choice) {
    out.push_back("method: " + result.method_choice->reason);
  }
  if (result.row_choice) {
    out.push_back("rows: " + result.row_choice->reason);
  }
  return out;
}

std::string known_of_all(const Identification& result) {
  const auto known = std::ranges::count(result.parameters, Verdict::identified, &ParameterEstimate::verdict);
  return std::to_string(known) + " of " + std::to_string(result.columns);
}

std::vector<std::string> answer_of(const Identification& result) {
  if (!result.physical_answers()) {
    return {};
  }
  return {"answer: the physically consistent parameters, " +
          std::string(result.status == Status::rank_deficient
                          ? "for which the robot description settles what the data leave open"
                          : "which predict blocks of time that are left out better")};
}

std::string forecast_in_words(double error) {
  return std::isfinite(error) ? percent(error) : "unknown, it shows what is not determined";
}

// What the model will do on other motion, and what it does; the page has it as key figures.
std::vector<std::string> predictions_of(const Identification& result) {
  std::vector<std::string> out = answer_of(result);
  if (result.forecast) {
    out.push_back("torque error forecast for random motion: " +
                  forecast_in_words(result.forecast->relative_error));
  }
  for (const Validation& validation : result.validation) {
    out.push_back("torque error on " + std::filesystem::path(validation.file).filename().string() + ": " +
                  percent(result.answer_fit(validation).relative_error) + ", forecast " +
                  forecast_in_words(validation.forecast.relative_error));
  }
  return out;
}

KeyFigures figures_of(const Identification& result) {
  KeyFigures out{
      {{known_of_all(result), "base parameters identified"}, {std::to_string(result.fit.rows), "rows"}}};
  if (predicted(result)) {
    out.figures.emplace_back(percent(result.answer_fit().relative_error), "torque error of the fit");
  }
  if (result.forecast) {
    const double error = result.forecast->relative_error;
    out.figures.emplace_back(std::isfinite(error) ? percent(error) : "unknown", "forecast for random motion");
  }
  for (const Validation& validation : result.validation) {
    out.figures.emplace_back(percent(result.answer_fit(validation).relative_error),
                             "torque error on " + std::filesystem::path(validation.file).filename().string());
  }
  return out;
}

Document verdict_of(const Identification& result) {
  const bool identified = result.status == Status::identified;
  Document out;
  out.subtitle = result.title;
  out.verdict = identified ? Mark::good : Mark::bad;
  out.headline = identified ? "Identified"
                 : result.status == Status::doubtful
                     ? "Doubtful: " + std::string(why_not(result.status))
                     : "Not identified: " + std::string(why_not(result.status));
  out.line = result.title + ": " + std::string(name(result.status)) + ", " + known_of_all(result) +
             " base parameters from " + std::to_string(result.fit.rows) + " rows, relative error " +
             percent(result.answer_fit().relative_error) +
             (std::isfinite(result.answer_fit().reference_error)
                  ? " (" + percent(result.answer_fit().reference_error) + " by the paper's rows)"
                  : "") +
             (std::isfinite(result.condition) ? ", condition " + number(result.condition, 4) : "");
  // The reasons of a doubtful result are findings, which say what to do as well.
  const bool told_below = result.status == Status::doubtful;
  out.opening = {{list_of("choices", answer_of(result)), page},
                 {list_of("choices", predictions_of(result)), screen},
                 {list_of("reasons", told_below ? std::vector<std::string>() : result.reasons)},
                 {FindingList{told_once(result.warnings)}},
                 {list_of("choices", choices_of(result))},
                 {figures_of(result), page}};
  return out;
}

// The joints at a glance.
Table joints_table(const Robot& robot, const Identification& result) {
  constexpr std::size_t most_logs = 3;  // of validation, a column each; a choice
  const std::size_t logs = std::min(most_logs, result.validation.size());
  Table out{{{"joint"}, {"fit", format::percent}}};
  for (std::size_t k = 0; k < logs; ++k) {
    out.columns.push_back({"validation" + (logs > 1 ? " " + std::to_string(k + 1) : ""), format::percent});
  }
  out.columns.insert(out.columns.end(), {{"residual", format::significant(3)}, {"unit"}, {"friction law"}});
  const auto add = [&](const std::string& name, const auto& error, std::vector<Cell> more, Mark mark) {
    Row& row = out.rows.emplace_back(Row{{name, error(result.answer_fit())}, mark});
    for (std::size_t k = 0; k < logs; ++k) {
      row.cells.emplace_back(error(result.answer_fit(result.validation[k])));
    }
    row.cells.insert(row.cells.end(), more.begin(), more.end());
  };
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const JointFit& joint = result.fit.joints[j];
    add(
        joint.name, [j](const Fit& fit) { return fit.joints[j].relative_error; },
        {joint.sigma_rho, joint.unit, std::string(name(robot.joints[j].friction))}, Mark::none);
  }
  if (robot.joints.size() > 1) {
    add("all", [](const Fit& fit) { return fit.relative_error; }, {"", "", ""}, Mark::sum);
  }
  return out;
}

// "weak: 35; not excited: MX6 and MZ6; --verbose lists all parameters".
std::string parameters_in_words(const Identification& result) {
  constexpr std::size_t most_names = 8;  // of parameters in a line; a choice
  std::vector<std::string> unseen;
  for (const ParameterEstimate& p : result.parameters) {
    if (p.verdict == Verdict::not_excited) {
      unseen.push_back(p.name);
    }
  }
  const auto weak = std::ranges::count(result.parameters, Verdict::weak, &ParameterEstimate::verdict);
  return (weak > 0 ? "weak: " + std::to_string(weak) + "; " : "") +
         (unseen.empty()
              ? ""
              : "not excited: " +
                    (unseen.size() > most_names ? std::to_string(unseen.size()) : listed(unseen)) + "; ") +
         "--verbose lists all parameters";
}

// Section that is there only if it says anything.
void add_if_any(Section section, std::vector<Section>& out) {
  if (!section.blocks.empty()) {
    out.push_back(std::move(section));
  }
}

// Those parts of a result that are there, in the order in which they are read. Without evidence there are no
// pictures.
std::vector<Section> sections_of(const Identification& result, const Evidence* evidence) {
  std::vector<Section> out;
  if (evidence != nullptr) {
    add_if_any(friction_section(*evidence), out);
    out.push_back(torques_section(*evidence));
  }
  out.push_back(parameters_section(result));
  if (result.gains) {
    out.push_back(gains_section(result));
  }
  if (result.output_error && !result.output_error->loop.empty()) {
    out.push_back(loop_section(*result.output_error));
  }
  if (evidence != nullptr) {
    add_if_any(correlation_section(result), out);
  }
  if (result.prefilter) {
    out.push_back(prefilter_section(result, *result.prefilter));
  }
  if (result.iv && !result.iv->iterations.empty()) {
    out.push_back(iterations_section(result, *result.iv));
  }
  out.push_back({"fit", "Fit", "Fit", {{fit_table(result.fit)}}});
  add_if_any(residual_section(result, evidence), out);
  if (result.robust) {
    out.push_back(weights_section(*result.robust));
  }
  for (const Validation& validation : result.validation) {
    out.push_back(
        {"",
         "",
         "Validation on " + validation.file,
         {{Sentence{"Forecast torque error: " + forecast_in_words(validation.forecast.relative_error)}, page},
          {fit_table(validation.fit)}}});
  }
  if (evidence != nullptr) {
    if (predicted(result)) {
      out.push_back(description_section(*evidence));
    }
    out.push_back(coverage_section(*evidence));
    add_if_any(robot_section(*evidence), out);
  }
  if (result.essential) {
    out.push_back(essential_section(result, *result.essential));
  }
  if (result.physical) {
    out.push_back(physical_section(result, *result.physical));
  }
  out.push_back(conditioning_section(result));
  if (!result.notes.empty()) {
    out.push_back({"notes", "Notes", "Notes on the data", {{list_of("notes", result.notes)}}, page});
  }
  // What is read first stays open.
  constexpr auto open =
      std::to_array<std::string_view>({"friction", "torques", "parameters", "fit", "residual"});
  for (Section& section : out) {
    section.folded = std::ranges::find(open, section.id) == open.end();
  }
  return out;
}

}  // namespace

std::string_view why_not(Status status) {
  switch (status) {
    case Status::identified:
      return "";
    case Status::doubtful:
      return "there are reasons not to trust the estimate";
    case Status::rank_deficient:
      return "the data do not determine all parameters";
    case Status::not_converged:
      return "the iteration did not settle";
    case Status::cycling:
      return "the iteration goes round among a few estimates";
    case Status::weak_instruments:
      return "the simulated motion says too little about some parameters";
    case Status::not_simulable:
      return "no closed loop could be simulated with the estimate";
    case Status::gave_up:
      break;
  }
  return "a budget of steps or seconds was used up first";
}

Document first_screen_of(const Robot& robot, const Identification& result) {
  Document out;
  out.line = result.title + ": " + std::string(name(result.status)) + ", " + known_of_all(result) +
             " base parameters from " + std::to_string(result.fit.rows) + " rows";
  std::vector<std::string> predictions = predictions_of(result);
  predictions.insert(predictions.begin(),
                     "torque error of the fit: " + percent(result.answer_fit().relative_error));
  constexpr std::size_t most = 5;  // predictions in a list; a choice
  if (predictions.size() > most) {
    predictions.resize(most);
  }
  out.opening = {{list_of("choices", predictions)}};
  out.sections = {{"", "", "", {{joints_table(robot, result)}}}};
  const bool told_below = result.status == Status::doubtful;
  Section findings{"", "", "", {}};
  if (!told_below && !result.reasons.empty()) {
    findings.blocks.push_back({list_of("reasons", result.reasons)});
  }
  if (!result.warnings.empty()) {
    findings.blocks.push_back({FindingList{told_once(result.warnings)}});
  }
  findings.blocks.push_back({Sentence{parameters_in_words(result)}});
  out.sections.push_back(findings);
  return out;
}

Document document_of(const Identification& result) {
  Document out = verdict_of(result);
  out.sections = sections_of(result, nullptr);
  return out;
}

Document document_of(const Robot& robot, const Identification& result,
                     std::span<const Prediction> predictions, const Provenance& provenance) {
  Document out = verdict_of(result);
  out.title = robot.name + " · " + result.title;
  out.heading = robot.name;
  out.subtitle += provenance.inputs.empty() ? "" : " · " + provenance.inputs.front().path;
  const Evidence evidence{robot, result, predictions};
  if (!evidence.empty()) {
    out.first_look = first_look(evidence);
  }
  out.sections = sections_of(result, evidence.empty() ? nullptr : &evidence);
  out.sections.push_back(provenance_section(robot, result, provenance));
  out.sections.back().folded = true;
  return out;
}

}  // namespace rivid::detail
