#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"

namespace rivid::detail {

namespace {

using Align = HtmlTable::Align;

std::string price(const Fit& plain, const Fit& other, const std::string& title) {
  HtmlTable table({{"joint", Align::text},
                   {"relative error", Align::number},
                   {title, Align::number},
                   {"centred", Align::number},
                   {title, Align::number}});
  for (std::size_t j = 0; j < plain.joints.size(); ++j) {
    table.add({escaped(plain.joints[j].name), percent(plain.joints[j].relative_error),
               percent(other.joints[j].relative_error), percent(plain.joints[j].centred_relative_error),
               percent(other.joints[j].centred_relative_error)});
  }
  table.add({"all", percent(plain.relative_error), percent(other.relative_error),
             percent(plain.centred_relative_error), percent(other.centred_relative_error)},
            "sum");
  return table.markup();
}

}  // namespace

std::string prices(const Identification& result, const Fit& fit,
                   std::optional<Fit> Validation::* of_validation, const std::string& title) {
  std::string out = element("h3", "Their price in fit") + price(result.fit, fit, title);
  for (const Validation& validation : result.validation) {
    if (const std::optional<Fit>& other = validation.*of_validation) {
      out +=
          element("h3", "Their price on " + escaped(validation.file)) + price(validation.fit, *other, title);
    }
  }
  return out;
}

}  // namespace rivid::detail
