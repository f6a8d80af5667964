#include "report/html_page.hpp"

#include "report/html_assets.hpp"
#include "report/markup.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid::detail {

namespace {

std::string cutoff(double hz, int order) {
  return hz > 0.0 ? number(hz, 4) + " Hz, order " + std::to_string(order) + ", forward and backward" : "none";
}

std::string head(const std::string& title, std::string_view styles) {
  // Nothing but what stands in the page may be used.
  return "<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
         "'unsafe-inline'; "
         "script-src 'unsafe-inline'\">\n" +
         element("title", title) + "\n" + (styles.empty() ? "" : element("style", styles) + "\n") +
         element("style", report_css()) + "\n";
}

std::string decimation(const std::vector<int>& factors) {
  std::string out;
  for (const int n_d : factors) {
    out += (out.empty() ? "by " : ", then by ") + std::to_string(n_d);
  }
  return out.empty() ? "none" : out;
}

std::string thresholds(const SignalOptions& signal) {
  std::string out;
  for (const double speed : signal.velocity_threshold) {
    out += (out.empty() ? "" : ", ") + number(speed, 4);
  }
  return out.empty() ? std::string(signal.exact_rows() ? "about reversals and standstill" : "none")
                     : "below " + out + " rad/s or m/s, joint by joint";
}

}  // namespace

std::string html_page(const std::string& title, std::string_view styles, const std::string& body,
                      const std::string& scripts) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n" + element("head", head(title, styles)) + "\n<body>\n" +
         element("main", body) + "\n" + scripts + "</body>\n</html>\n";
}

std::string navigation(std::span<const PageSection> sections, const std::string& content) {
  std::string out;
  for (const PageSection& section : sections) {
    if (content.find("id=\"" + std::string(section.id) + "\"") != std::string::npos) {
      out += element("a", section.title, "href=\"#" + std::string(section.id) + "\"");
    }
  }
  return element("nav", out);
}

std::string bullets(const std::vector<std::string>& lines, std::string_view kind) {
  std::string out;
  for (const std::string& text : lines) {
    out += element("li", escaped(text)) + "\n";
  }
  return out.empty() ? out : element("ul", out, "class=\"" + std::string(kind) + "\"");
}

std::string key_figure(const std::string& value, const std::string& what) {
  return element("div", element("b", value) + element("span", what));
}

std::vector<std::pair<std::string, std::string>> row_settings(const SignalOptions& signal) {
  std::vector<std::pair<std::string, std::string>> out = {
      {"Rows", std::string(name(signal.exact_rows() ? RowScheme::exact : RowScheme::paper)) +
                   (signal.convention == Convention::matlab ? ", convention matlab" : "") +
                   (signal.torque_held ? ", torques held between samples" : "")},
      {"Filter of the positions", cutoff(signal.cutoff_hz, signal.order)},
      {"Filter of the torques", cutoff(signal.torque_cutoff_hz, signal.torque_order)},
      {"Decimation", decimation(signal.decimation)},
      {"Left out", thresholds(signal)}};
  if (signal.trim) {
    out.emplace_back("Trimmed at either end", std::to_string((*signal.trim)[0]) + " and " +
                                                  std::to_string((*signal.trim)[1]) + " samples");
  }
  if (signal.window) {
    out.emplace_back("Window", number((*signal.window)[0]) + " to " + number((*signal.window)[1]) + " s");
  }
  return out;
}

std::string inputs_table(const Provenance& provenance) {
  HtmlTable inputs({{"input", HtmlTable::Align::text}, {"SHA-256", HtmlTable::Align::text}});
  for (const InputFile& file : provenance.inputs) {
    inputs.add({escaped(file.path), element("code", escaped(file.sha256))});
  }
  return inputs.markup();
}

}  // namespace rivid::detail
