#include <algorithm>
#include <cmath>

#include "report/documents.hpp"
#include "rivid/report/comparison.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

Table error_table(const Comparison& comparison) {
  Table out;
  out.columns.push_back({"joint", format::name});
  for (const Comparison::Error& model : comparison.models) {
    out.columns.push_back({model.name, format::percents(2)});
  }
  const auto add = [&](const std::string& name, const auto& error, Mark mark) {
    Row& row = out.rows.emplace_back(Row{{Cell(name)}, mark});
    for (const Comparison::Error& model : comparison.models) {
      row.cells.emplace_back(error(model));
    }
  };
  for (std::size_t j = 0; j < comparison.joints.size(); ++j) {
    add(comparison.joints[j], [j](const Comparison::Error& model) { return model.joints[j]; }, Mark::none);
  }
  add("all", [](const Comparison::Error& model) { return model.relative_error; }, Mark::sum);
  return out;
}

std::string p_text(double p) {
  return std::isfinite(p) ? (p < 1e-4 ? "p < 0.0001" : "p = " + number(p, 2)) : "no p";
}

// "A predicts better than B (p = 0.001, 12 blocks): its squared error is 0.61 times that of B"
std::string test_sentence(const Comparison& comparison, const PairedTest& test) {
  const std::string& a = comparison.models[test.a].name;
  const std::string& b = comparison.models[test.b].name;
  if (!std::isfinite(test.p)) {
    return a + " and " + b + ": not decided, the logs are too short for six blocks of independent errors";
  }
  const std::string basis = " (" + p_text(test.p) + ", " + counted(test.blocks, "block") + ")";
  if (!test.better) {
    return a + " and " + b + ": no significant difference" + basis + ", the squared error of " + a + " is " +
           number(test.ratio, 3) + " times that of " + b;
  }
  const bool first = *test.better == test.a;
  return (first ? a : b) + " predicts better than " + (first ? b : a) + basis + ": its squared error is " +
         number(first ? test.ratio : 1.0 / test.ratio, 3) + " times that of " + (first ? b : a);
}

Section changes_section(const ResultChanges& pair, double level) {
  Section out{.id = "changes", .title = "Changes", .heading = "From " + pair.a + " to " + pair.b};
  Table table;
  table.columns = {{"parameter", format::name},        {pair.a, format::deviation},
                   {pair.b, format::deviation},        {"unit", format::text},
                   {"difference/σ", format::fixed(1)}, {"p", format::significant(2)}};
  for (const ParameterChange& change : pair.parameters) {
    if (change.p < level) {
      table.rows.push_back({{Cell(change.name), Cell(change.a, change.sigma), Cell(change.b, change.sigma),
                             Cell(change.unit), Cell(change.z), Cell(change.p)},
                            Mark::apart});
    }
  }
  const auto all = static_cast<std::ptrdiff_t>(pair.parameters.size());
  if (table.rows.empty()) {
    out.blocks.push_back({Sentence{"none of " + counted(all, "parameter") +
                                   " changed by more than the standard deviations of both results explain"}});
    return out;
  }
  const auto changed = static_cast<std::ptrdiff_t>(table.rows.size());
  out.blocks.push_back({Sentence{counted(changed, "parameter") + " of " + std::to_string(all) +
                                 " changed by more than the standard deviations of both results explain"}});
  out.blocks.push_back({std::move(table)});
  return out;
}

Document comparison_document(const Comparison& comparison, std::span<const ResultChanges> changes,
                             std::span<const Finding> warnings, double level) {
  Document out;
  const std::string logs = quoted_list(comparison.logs);
  out.title = "Comparison of models";
  out.heading = out.title;
  out.subtitle = "on " + logs + ", " + counted(comparison.rows, "row");
  out.line = "Relative error ‖Y − Wχ‖ / ‖Y‖ " + out.subtitle;
  out.headline = "Relative error ‖Y − Wχ‖ / ‖Y‖";
  out.opening.push_back({FindingList{{warnings.begin(), warnings.end()}}});
  out.opening.push_back({error_table(comparison)});
  if (!comparison.tests.empty()) {
    Section tests{.id = "tests", .title = "Tests", .heading = "Which model predicts better"};
    for (const PairedTest& test : comparison.tests) {
      tests.blocks.push_back({Sentence{test_sentence(comparison, test)}});
    }
    out.sections.push_back(std::move(tests));
  }
  for (const ResultChanges& pair : changes) {
    out.sections.push_back(changes_section(pair, level));
  }
  return out;
}

}  // namespace

}  // namespace rivid::detail

namespace rivid {

std::string in_words(const Comparison& comparison, std::span<const ResultChanges> changes,
                     std::span<const Finding> warnings, double level, std::size_t screen) {
  return detail::text_of(detail::comparison_document(comparison, changes, warnings, level), screen);
}

std::string html_report(const Comparison& comparison, std::span<const ResultChanges> changes,
                        std::span<const Finding> warnings, double level, const Provenance& provenance) {
  detail::Document document = detail::comparison_document(comparison, changes, warnings, level);
  document.sections.push_back({.id = "origin",
                               .title = "Origin",
                               .heading = "Files",
                               .blocks = {{detail::inputs_table(provenance)}}});
  return detail::html_of(document);
}

}  // namespace rivid
