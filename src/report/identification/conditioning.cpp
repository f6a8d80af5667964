#include <algorithm>
#include <cmath>
#include <limits>

#include "report/identification/sections.hpp"
#include "report/lists.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

Section conditioning_section(const Identification& result) {
  constexpr std::size_t few = 16;
  const Vector& R = result.R_diagonal;
  const double largest = R.size() > 0 ? R.maxCoeff() : 0.0;
  // On a logarithmic scale: 1 for the largest, 0 for one that is zero to rounding.
  const auto share = [&](std::size_t i) {
    const double decades = -std::log10(std::numeric_limits<double>::epsilon());
    return at(R, i) > 0.0 ? std::max(1.0 + std::log10(at(R, i) / largest) / decades, 0.0) : 0.0;
  };
  std::vector<Indexed> fields = {
      {{"parameter", format::name}, [&](std::size_t i) { return result.parameters[i].name; }},
      {{"|R_ii|", format::significant(4)}, [&](std::size_t i) { return at(R, i); }},
      {{"", format::share}, share}};
  if (result.iv && result.iv->first_stage_F.size() == result.base.size()) {
    fields.push_back({{"strength of the instruments, F", format::significant(4)},
                      [&](std::size_t i) { return at(result.iv->first_stage_F, i); }});
  }
  Table pivots =
      table_of(places(std::min(result.parameters.size(), static_cast<std::size_t>(R.size()))), fields);
  pivots.fold = {"Pivots of all parameters, on a logarithmic scale", result.parameters.size() <= few};
  Section out{"conditioning", "Conditioning", "Conditioning", {}, Shown::page};
  out.blocks = {
      {Sentence{(std::isfinite(result.condition)
                     ? "The condition number of the problem is " + number(result.condition, 4)
                     : "The data do not determine all parameters: there is no condition number") +
                ". A parameter is hard to distinguish from the others where its pivot |R_ii| of the "
                "factored observation matrix is small" +
                (result.iv ? ", or where the simulated motion, F below 10, hardly shows it" : "")}},
      {std::move(pivots)}};
  return out;
}

}  // namespace rivid::detail
