#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rivid/identify/rows.hpp"
#include "rivid/report/json.hpp"

// The frame that the HTML pages share, and parts that stand in all of them.
namespace rivid::detail {

struct PageSection {
  std::string_view id;
  std::string_view title;
};

// A whole page, which may use nothing but what stands in it.
// @param title    markup
// @param styles   sheets beside report.css
// @param body     markup of <main>
// @param scripts  what follows it
[[nodiscard]] std::string html_page(const std::string& title, std::string_view styles,
                                    const std::string& body, const std::string& scripts);

// Links to those of the sections that the content has.
[[nodiscard]] std::string navigation(std::span<const PageSection> sections, const std::string& content);

// Texts as a list; nothing for none.
[[nodiscard]] std::string bullets(const std::vector<std::string>& lines, std::string_view kind);

// A value with what it is, one of several in a row.
[[nodiscard]] std::string key_figure(const std::string& value, const std::string& what);

// How rows are made of the samples: what, and its setting.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> row_settings(const SignalOptions& signal);

// The files with their SHA-256.
[[nodiscard]] std::string inputs_table(const Provenance& provenance);

}  // namespace rivid::detail
