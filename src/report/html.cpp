#include "rivid/report/html.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "report/html_assets.hpp"
#include "report/html_page.hpp"
#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"
#include "rivid/finding.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::bullets;
using detail::element;
using detail::escaped;
using detail::key_figure;
using detail::percent;

std::string in_words(Status status) {
  return status == Status::identified ? "Identified"
                                      : "Not identified: " + std::string(detail::why_not(status));
}

// Each with its code, and what to do about it.
std::string list_of(const std::vector<Finding>& warnings) {
  std::string out;
  for (const Finding& warning : warnings) {
    const std::string item = element("code", escaped(warning.code)) + " " + escaped(sentence(warning)) +
                             ". " + element("span", escaped(cure(warning)), "class=\"cure\"");
    out += element("li", item) + "\n";
  }
  return element("ul", out, "class=\"warnings\"");
}

std::string verdict(const Identification& result) {
  const bool identified = result.status == Status::identified;
  std::string out =
      element("h2", element("span", identified ? "✓" : "✗", "class=\"sign\" aria-hidden=\"true\"") + " " +
                        in_words(result.status));
  out += bullets(result.reasons, "reasons");
  std::string figures = key_figure(std::to_string(result.columns), "base parameters") +
                        key_figure(std::to_string(result.fit.rows), "rows");
  if (detail::predicted(result)) {
    figures += key_figure(percent(result.fit.relative_error), "torque error of the fit");
  }
  for (const Validation& validation : result.validation) {
    figures +=
        key_figure(percent(validation.fit.relative_error),
                   "torque error on " + escaped(std::filesystem::path(validation.file).filename().string()));
  }
  figures += key_figure(std::isfinite(result.condition) ? number(result.condition, 3) : "infinite",
                        "condition number");
  out += element("div", figures, "class=\"figures\"");
  if (!result.warnings.empty()) {
    out += element("h3", counted(static_cast<std::ptrdiff_t>(result.warnings.size()), "warning")) +
           list_of(result.warnings);
  }
  return element("section", out, std::string("class=\"verdict ") + (identified ? "good" : "bad") + "\"");
}

std::string notes(const Identification& result) {
  return result.notes.empty()
             ? std::string()
             : element("section", element("h2", "Notes", "id=\"notes\"") + bullets(result.notes, "notes"));
}

constexpr std::array<detail::PageSection, 10> sections = {{{"parameters", "Parameters"},
                                                           {"prefilter", "Prefilter"},
                                                           {"essential", "Essential"},
                                                           {"physical", "Physical"},
                                                           {"torques", "Torques"},
                                                           {"residual", "Residual"},
                                                           {"iterations", "Iterations"},
                                                           {"conditioning", "Conditioning"},
                                                           {"notes", "Notes"},
                                                           {"provenance", "Provenance"}}};

}  // namespace

std::string html_report(const Robot& robot, const Identification& result,
                        std::span<const Prediction> predictions, const Provenance& provenance) {
  const std::string title = escaped(robot.name + " · " + result.title);
  const std::string content = detail::parameters_section(result) + detail::prefilter_section(result) +
                              detail::essential_section(result) + detail::physical_section(result) +
                              detail::torques_section(result, predictions) +
                              detail::residuals_section(result, predictions) +
                              detail::iterations_section(result) + detail::conditioning_section(result) +
                              notes(result) + detail::provenance_section(robot, result, provenance);
  std::string body = element(
      "header",
      element("h1", escaped(robot.name)) +
          element("p", escaped(result.title) + (provenance.inputs.empty()
                                                    ? std::string()
                                                    : " · " + escaped(provenance.inputs.front().path))));
  body += verdict(result) + detail::navigation(sections, content) +
          "<noscript><p>The plots need JavaScript; everything else is here without it.</p></noscript>\n" +
          content;
  std::string scripts =
      element("script", detail::plot_data(result, predictions), "type=\"application/json\" id=\"data\"") +
      "\n";
  scripts.append("<!-- uPlot:\n").append(detail::uplot_licence()).append("\n-->\n");
  scripts += element("script", detail::uplot_js()) + "\n" + element("script", detail::report_js()) + "\n";
  return detail::html_page(title, detail::uplot_css(), body, scripts);
}

}  // namespace rivid
