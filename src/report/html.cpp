#include "rivid/report/html.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "report/html_assets.hpp"
#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

using detail::element;
using detail::escaped;
using detail::HtmlTable;
using detail::percent;

std::string in_words(Status status) {
  switch (status) {
    case Status::identified:
      return "Identified";
    case Status::rank_deficient:
      return "Not identified: the data do not determine all parameters";
    case Status::not_converged:
      return "Not identified: the iteration did not settle";
    case Status::cycling:
      return "Not identified: the iteration goes round among a few estimates";
    case Status::weak_instruments:
      return "Not identified: the simulated motion says too little about some parameters";
    case Status::not_simulable:
      break;
  }
  return "Not identified: no closed loop could be simulated with the estimate";
}

std::string list(const std::vector<std::string>& lines, std::string_view kind) {
  std::string out;
  for (const std::string& text : lines) {
    out += element("li", escaped(text)) + "\n";
  }
  return out.empty() ? out : element("ul", out, "class=\"" + std::string(kind) + "\"");
}

std::string figure(const std::string& value, const std::string& what) {
  return element("div", element("b", value) + element("span", what));
}

std::string verdict(const Identification& result) {
  const bool identified = result.status == Status::identified;
  std::string out =
      element("h2", element("span", identified ? "✓" : "✗", "class=\"sign\" aria-hidden=\"true\"") + " " +
                        in_words(result.status));
  out += list(result.reasons, "reasons");
  std::string figures = figure(std::to_string(result.columns), "base parameters") +
                        figure(std::to_string(result.fit.rows), "rows");
  if (detail::predicted(result)) {
    figures += figure(percent(result.fit.relative_error), "torque error of the fit");
  }
  for (const Validation& validation : result.validation) {
    figures +=
        figure(percent(validation.fit.relative_error),
               "torque error on " + escaped(std::filesystem::path(validation.file).filename().string()));
  }
  figures +=
      figure(std::isfinite(result.condition) ? number(result.condition, 3) : "infinite", "condition number");
  out += element("div", figures, "class=\"figures\"");
  if (!result.warnings.empty()) {
    out += element("h3", counted(static_cast<std::ptrdiff_t>(result.warnings.size()), "warning")) +
           list(result.warnings, "warnings");
  }
  return element("section", out, std::string("class=\"verdict ") + (identified ? "good" : "bad") + "\"");
}

std::string navigation(const std::string& content) {
  struct Target {
    std::string_view id;
    std::string_view title;
  };
  constexpr std::array<Target, 8> targets = {{{"parameters", "Parameters"},
                                              {"physical", "Physical"},
                                              {"torques", "Torques"},
                                              {"residual", "Residual"},
                                              {"iterations", "Iterations"},
                                              {"conditioning", "Conditioning"},
                                              {"notes", "Notes"},
                                              {"provenance", "Provenance"}}};
  std::string out;
  for (const Target& target : targets) {
    if (content.find("id=\"" + std::string(target.id) + "\"") != std::string::npos) {
      out += element("a", target.title, "href=\"#" + std::string(target.id) + "\"");
    }
  }
  return element("nav", out);
}

std::string notes(const Identification& result) {
  return result.notes.empty()
             ? std::string()
             : element("section", element("h2", "Notes", "id=\"notes\"") + list(result.notes, "notes"));
}

std::string cutoff(double hz, int order) {
  return hz > 0.0 ? number(hz, 4) + " Hz, order " + std::to_string(order) + ", forward and backward" : "none";
}

std::string provenance_section(const Robot& robot, const Identification& result,
                               const Provenance& provenance) {
  using Align = HtmlTable::Align;
  const SignalOptions& signal = result.signal;
  HtmlTable settings({{"", Align::text}, {"", Align::text}});
  const auto add = [&](const char* what, const std::string& value) { settings.add({what, escaped(value)}); };
  std::string decimation;
  for (const int n_d : signal.decimation) {
    decimation += (decimation.empty() ? "by " : ", then by ") + std::to_string(n_d);
  }
  add("Program", provenance.program + ", rivid " + version);
  add("Robot", robot.name + ", " + counted(robot.size(), "joint"));
  add("Method", result.title);
  add("Rows", std::string(name(signal.exact_rows() ? RowScheme::exact : RowScheme::paper)) +
                  (signal.convention == Convention::matlab ? ", convention matlab" : ""));
  add("Filter of the positions", cutoff(signal.cutoff_hz, signal.order));
  add("Filter of the torques", cutoff(signal.torque_cutoff_hz, signal.torque_order));
  add("Decimation", decimation.empty() ? "none" : decimation);
  for (const auto& [flag, value] : provenance.overrides) {
    settings.add({"Flag --" + escaped(flag), escaped(value)});
  }
  HtmlTable inputs({{"input", Align::text}, {"SHA-256", Align::text}});
  for (const InputFile& file : provenance.inputs) {
    inputs.add({escaped(file.path), element("code", escaped(file.sha256))});
  }
  return element("section",
                 element("h2", "Provenance", "id=\"provenance\"") + settings.markup() + inputs.markup());
}

std::string head(const std::string& title) {
  // Nothing but what stands in the page may be used.
  return "<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
         "'unsafe-inline'; "
         "script-src 'unsafe-inline'\">\n" +
         element("title", title) + "\n" + element("style", detail::uplot_css()) + "\n" +
         element("style", detail::report_css()) + "\n";
}

}  // namespace

std::string html_report(const Robot& robot, const Identification& result,
                        std::span<const Prediction> predictions, const Provenance& provenance) {
  const std::string title = escaped(robot.name + " · " + result.title);
  const std::string content = detail::parameters_section(result) + detail::physical_section(result) +
                              detail::torques_section(result, predictions) +
                              detail::residuals_section(result, predictions) +
                              detail::iterations_section(result) + detail::conditioning_section(result) +
                              notes(result) + provenance_section(robot, result, provenance);
  std::string body = element(
      "header",
      element("h1", escaped(robot.name)) +
          element("p", escaped(result.title) + (provenance.inputs.empty()
                                                    ? std::string()
                                                    : " · " + escaped(provenance.inputs.front().path))));
  body += verdict(result) + navigation(content) +
          "<noscript><p>The plots need JavaScript; everything else is here without it.</p></noscript>\n" +
          content;
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n" + element("head", head(title)) + "\n<body>\n" +
                    element("main", body) + "\n";
  out += element("script", detail::plot_data(result, predictions), "type=\"application/json\" id=\"data\"") +
         "\n";
  out.append("<!-- uPlot:\n").append(detail::uplot_licence()).append("\n-->\n");
  out += element("script", detail::uplot_js()) + "\n" + element("script", detail::report_js()) + "\n";
  return out + "</body>\n</html>\n";
}

}  // namespace rivid
