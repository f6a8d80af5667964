#include <algorithm>
#include <cmath>

#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Align = HtmlTable::Align;

std::string summary(const Identification& result, const EssentialModel& model) {
  const EssentialParameters& found = model.parameters;
  if (found.eliminated.empty()) {
    return element("p", "All " + std::to_string(result.base.size()) + " are needed: none can go.");
  }
  const std::string out =
      std::to_string(found.kept.size()) + " of " + std::to_string(result.base.size()) +
      " parameters are enough for these data. The others are taken out one by one, the least certain first, "
      "as "
      "long as an F-test at " +
      number(100.0 * model.options.significance, 3) + " %" +
      " does not tell the loss from chance. Of all removals together F = " + number(found.F, 3) +
      ", p = " + number(found.p, 2) + ".";
  std::string held;
  for (const std::string& name : found.held) {
    held += (held.empty() ? "" : ", ") + escaped(name);
  }
  return element("p", out) +
         (held.empty() ? "" : element("p", "Held, since no robot would move without: " + held + "."));
}

// Which removal took parameter p away; empty where it stays.
std::string removal(const EssentialParameters& found, const std::string& name) {
  const auto at = std::ranges::find(found.eliminated, name, &EliminatedParameter::name);
  if (at == found.eliminated.end()) {
    return {};
  }
  return "removal " + std::to_string(at - found.eliminated.begin() + 1) + ": F = " + number(at->F, 3) +
         ", p = " + number(at->p, 2);
}

std::string parameters_table(const Identification& result, const EssentialParameters& found) {
  HtmlTable table({{"parameter", Align::text},
                   {"all: value", Align::number},
                   {"%σ", Align::number},
                   {"essential: value", Align::number},
                   {"%σ", Align::number},
                   {"unit", Align::text},
                   {"", Align::text}});
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const auto at = static_cast<Index>(i);
    const std::string gone = removal(found, p.name);
    const double sigma = std::sqrt(found.C_chi(at, at));
    table.add(
        {element("b", escaped(p.name)), with_decimals_of(p.value, p.sigma),
         number(p.relative_sigma_percent, 3), gone.empty() ? with_decimals_of(found.chi[at], sigma) : "–",
         gone.empty() ? number(100.0 * sigma / std::abs(found.chi[at]), 3) : "", escaped(p.unit), gone},
        gone.empty() ? "" : "gone");
  }
  return table.markup();
}

}  // namespace

std::string essential_section(const Identification& result) {
  if (!result.essential) {
    return {};
  }
  const EssentialModel& model = *result.essential;
  std::string out = element("h2", "Essential parameters", "id=\"essential\"") + summary(result, model);
  if (!model.parameters.eliminated.empty()) {
    out += parameters_table(result, model.parameters) +
           prices(result, model.fit, &Validation::essential, "essential");
  }
  return element("section", out);
}

}  // namespace rivid::detail
