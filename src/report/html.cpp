#include "rivid/report/html.hpp"

#include "report/documents.hpp"
#include "report/markup.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

std::string attribute(std::string_view name, std::string_view value) {
  return std::string(name) + "=\"" + escaped(value) + "\"";
}

std::string css_class(std::string_view names) {
  return names.empty() ? std::string() : attribute("class", names);
}

// A mark in front of or behind what it is about.
std::string badge(Mark mark) {
  return sign(mark).empty() ? std::string()
                            : element("span", sign(mark), css_class("sign " + std::string(name(mark))));
}

std::string in_fold(const Fold& fold, const std::string& content) {
  return fold.title.empty()
             ? content
             : element("details", element("summary", escaped(fold.title)) + content, fold.open ? "open" : "");
}

std::string stack_markup(const Stack& stack) {
  std::string out;
  for (const auto& [style, share] : stack.parts) {
    out += element("span", "", css_class(style) + " style=\"width:" + fixed(100.0 * share, 2) + "%\"");
  }
  return element("span", out,
                 "class=\"stack\" role=\"img\" " + attribute("aria-label", stack.label) + " " +
                     attribute("title", stack.label));
}

std::string cell_markup(const Column& column, const Cell& cell) {
  if (const auto* const interval = std::get_if<Interval>(&cell.value)) {
    return markup_of(*interval);
  }
  if (const auto* const stack = std::get_if<Stack>(&cell.value)) {
    return stack_markup(*stack);
  }
  if (column.format.kind == Format::Kind::share) {
    constexpr double width = 220.0;  // [px] of the widest bar; a choice of layout
    return element(
        "span", "",
        "class=\"pivot\" style=\"width:" + fixed(width * std::get<double>(cell.value), 1) + "px\"");
  }
  const auto text = [&] { return escaped(shown(column, cell)); };
  switch (column.format.kind) {
    case Format::Kind::name:
      return element("b", text());
    case Format::Kind::code:
      return element("code", text());
    default:
      return text();
  }
}

class HtmlRenderer {
 public:
  std::string operator()(const Sentence& sentence) const {
    return element("p", escaped(sentence.text) + ".");
  }

  std::string operator()(const Heading& heading) const { return element("h3", escaped(heading.text)); }

  std::string operator()(const Table& table) const {
    const auto line = [&](std::string_view tag, const auto& cell, std::string_view behind, Mark mark) {
      std::string out;
      for (std::size_t c = 0; c < table.columns.size(); ++c) {
        if (is_on(Shown::page, table.columns[c].shown)) {
          out += element(tag, cell(c) + (out.empty() ? std::string(behind) : ""),
                         table.columns[c].format.number() ? "class=\"number\"" : "");
        }
      }
      return element("tr", out, css_class(name(mark))) + "\n";
    };
    std::string head;
    for (const Column& column : table.columns) {
      head += column.heading;
    }
    if (!head.empty()) {
      head = element("thead", line(
                                  "th", [&](std::size_t c) { return escaped(table.columns[c].heading); }, "",
                                  Mark::none)) +
             "\n";
    }
    std::string body;
    for (const Row& row : table.rows) {
      const std::string mark = badge(row.mark);
      body += line(
          "td", [&](std::size_t c) { return cell_markup(table.columns[c], row.cells[c]); },
          mark.empty() ? mark : " " + mark, row.mark);
    }
    return in_fold(
        table.fold,
        element("div", element("table", head + element("tbody", body)), css_class("scroll")) + "\n");
  }

  std::string operator()(const List& list) const {
    std::string out;
    for (const Item& item : list.items) {
      const std::string mark = badge(item.mark);
      out += element("li", (mark.empty() ? mark : mark + " ") +
                               (item.name.empty() ? "" : element("b", escaped(item.name))) +
                               escaped(item.text)) +
             "\n";
    }
    return out.empty() ? out : in_fold(list.fold, element("ul", out, css_class(list.kind)));
  }

  // The first ones are seen at once, many others on demand.
  std::string operator()(const FindingList& list) const {
    std::string out;
    std::string rest;
    for (std::size_t k = 0; k < list.findings.size(); ++k) {
      const Finding& finding = list.findings[k];
      const std::string item =
          element("li", escaped(name(severity(finding))) + " " + element("code", escaped(finding.code)) +
                            " " + escaped(sentence(finding)) + ". " +
                            element("span", escaped(advice(finding)), css_class("cure"))) +
          "\n";
      (k < FindingList::shown ? out : rest) += item;
    }
    if (out.empty()) {
      return out;
    }
    const auto more = std::ssize(list.findings) - static_cast<std::ptrdiff_t>(FindingList::shown);
    return element("h3", counted(std::ssize(list.findings), "finding")) +
           element("ul", out, css_class("warnings")) +
           (rest.empty()
                ? rest
                : in_fold({counted(more, "more finding")}, element("ul", rest, css_class("warnings"))));
  }

  std::string operator()(const KeyFigures& list) const {
    std::string out;
    for (const auto& [value, what] : list.figures) {
      out += element("div", element("b", escaped(value)) + element("span", escaped(what)));
    }
    return element("div", out, css_class("figures"));
  }

  std::string operator()(const Legend& legend) const {
    std::string out;
    for (const auto& [key, meaning] : legend.keys) {
      out += element("span", element("span", "", css_class("key " + key)) + escaped(meaning),
                     css_class("item")) +
             "\n";
    }
    return element("p", out + escaped(legend.remark), css_class("legend"));
  }

  std::string operator()(const Plots& plots) const {
    std::string out;
    for (const Plots::Group& group : plots.groups) {
      std::string content;
      if (!group.heading.empty()) {
        content = element("h4", escaped(group.heading) +
                                    (group.remark.empty() ? "" : element("small", escaped(group.remark))));
      }
      std::string pictures;
      for (const Plot& plot : group.plots) {
        pictures += markup_of(plot);
      }
      content += plots.layout.empty() ? pictures : element("div", pictures, css_class(plots.layout));
      out += group.heading.empty() ? content : element("div", content, css_class("group"));
    }
    return in_fold(plots.fold, out);
  }

  [[nodiscard]] std::string of(const std::vector<Block>& blocks) const {
    std::string out;
    for (const Block& block : blocks) {
      out += is_on(Shown::page, block.shown) ? std::visit(*this, block.content) : std::string();
    }
    return out;
  }
};

// Nothing but what stands in the page may be used.
std::string head(const Document& document) {
  return "<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"generator\" content=\"rivid\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
         "'unsafe-inline'; script-src 'unsafe-inline'\">\n" +
         element("title", escaped(document.title)) + "\n" + element("style", report_css()) + "\n";
}

std::string verdict(const Document& document) {
  const std::string title = badge(document.verdict) + " " + escaped(document.headline);
  return element("section", element("h2", title) + HtmlRenderer().of(document.opening),
                 css_class("verdict " + std::string(name(document.verdict))));
}

std::string scripts(const Document& document) {
  return element("script", data_of(document), "type=\"application/json\" id=\"data\"") + "\n" +
         element("script", report_js()) + "\n";
}

}  // namespace

std::string html_of(const Document& document) {
  const HtmlRenderer html;
  std::string links;
  std::string content;
  for (const Section& section : document.sections) {
    if (is_on(Shown::page, section.shown)) {
      if (!section.title.empty()) {
        links += element("a", escaped(section.title), attribute("href", "#" + section.id));
      }
      const std::string title =
          element("h2", escaped(section.heading), section.id.empty() ? "" : attribute("id", section.id));
      const std::string blocks = html.of(section.blocks);
      content += element("section", section.folded ? element("details", element("summary", title) + blocks)
                                                   : title + blocks) +
                 "\n";
    }
  }
  const std::string header =
      element("header", element("h1", escaped(document.heading)) + element("p", escaped(document.subtitle)));
  const std::string nav = element("nav", links, "aria-label=\"Sections\"");
  const std::string no_script =
      element("noscript", element("p", "Plots are drawn by a script; tables are complete without it."));
  const std::string first = document.first_look.empty()
                                ? ""
                                : element("div", html.of(document.first_look), "class=\"first-look\"") + "\n";
  return "<!DOCTYPE html>\n<html lang=\"en\">\n" + element("head", head(document)) + "\n<body>\n" +
         element("main", header + nav + no_script + verdict(document) + first + content) + "\n" +
         scripts(document) + "</body>\n</html>\n";
}

}  // namespace detail

std::string html_report(const Robot& robot, const Identification& result,
                        std::span<const Prediction> predictions, const Provenance& provenance) {
  detail::require_fitting("html_report", robot, result, predictions);
  return detail::html_of(detail::document_of(robot, result, predictions, provenance));
}

std::string html_report(const MonteCarlo& plan, std::span<const MonteCarloSummary> summaries,
                        std::span<const MonteCarloRow> rows, const Provenance& provenance) {
  return detail::html_of(detail::document_of(plan, summaries, rows, provenance));
}

}  // namespace rivid
