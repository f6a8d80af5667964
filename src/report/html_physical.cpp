#include <cmath>

#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Align = HtmlTable::Align;

std::string base_table(const Identification& result, const Vector& chi) {
  HtmlTable table({{"parameter", Align::text},
                   {"estimate", Align::number},
                   {"physical", Align::number},
                   {"unit", Align::text},
                   {"apart by", Align::number}});
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const double value = chi[static_cast<Index>(i)];
    const double apart = std::abs(value - p.value) / p.sigma;
    table.add({element("b", escaped(p.name)), with_decimals_of(p.value, p.sigma),
               with_decimals_of(value, p.sigma), escaped(p.unit),
               std::isfinite(apart) ? fixed(apart, 2) + " σ" : "-"});
  }
  return table.markup();
}

std::string standard_table(const Identification& result, const Vector& chi_st) {
  HtmlTable table({{"parameter", Align::text}, {"value, SI on the joint side", Align::number}});
  for (std::size_t i = 0; i < result.base.standard.size(); ++i) {
    table.add(
        {element("b", escaped(result.base.standard[i].name())), number(chi_st[static_cast<Index>(i)], 6)});
  }
  return table.markup();
}

}  // namespace

std::string physical_section(const Identification& result) {
  if (!result.physical) {
    return {};
  }
  const PhysicalModel& model = *result.physical;
  std::string out = element("h2", "Physically consistent parameters", "id=\"physical\"");
  out += element("p", "The nearest parameters of a robot of physical bodies: prior " +
                          std::string(name(model.options.prior)) + " with weight " +
                          number(model.options.weight, 4) + ", divergence " +
                          number(model.parameters.divergence, 4) + " from the robot description.");
  out += base_table(result, model.parameters.chi);
  out += prices(result, model.fit, &Validation::physical, "physical");
  out += element("details", element("summary", "Standard parameters of all links") +
                                standard_table(result, model.parameters.chi_st));
  return element("section", out);
}

}  // namespace rivid::detail
