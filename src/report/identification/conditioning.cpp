#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "joined.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Pairs of estimates with a strong correlation in words, the strongest first.
std::string strong_pairs(const std::vector<ParameterEstimate>& parameters, const Matrix& correlations) {
  // correlation that is named; a choice: leaves a parameter 44 % of its deviation, others known
  constexpr double strong = 0.9;
  constexpr std::size_t most = 12;  // pairs that are named; a choice
  struct Pair {
    std::string names;
    double r = 0.0;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double r = correlations(static_cast<Index>(i), static_cast<Index>(j));
      if (std::abs(r) > strong) {
        pairs.push_back({parameters[j].name + " and " + parameters[i].name, r});
      }
    }
  }
  if (pairs.empty()) {
    return "No two estimates have a correlation above 0.9";
  }
  std::ranges::stable_sort(pairs, std::greater<>(), [](const Pair& p) { return std::abs(p.r); });
  const auto in_words = [](const Pair& p) { return p.names + " (" + fixed(p.r, 2) + ")"; };
  return counted(std::ssize(pairs), "pair") +
         " above 0.9: " + joined(std::span(pairs).first(std::min(pairs.size(), most)), ", ", in_words) +
         (pairs.size() > most ? ", …" : "");
}

}  // namespace

Section conditioning_section(const Identification& result) {
  constexpr std::size_t few = 16;  // rows of a table that is not folded; a choice
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
  Section out{
      "conditioning", "Identifiability", "How well the motion determines the parameters", {}, Shown::page};
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

Section correlation_section(const Identification& result) {
  Section out{"correlation", "Correlation", "Correlation of the estimates", {}, Shown::page};
  if (result.C_chi.rows() != std::ssize(result.parameters) || result.parameters.size() < 2) {
    return out;
  }
  HeatMap map{
      "correlation-map",        "Correlation of the estimates", "", "Correlation matrix of the estimates", {},
      correlation(result.C_chi)};
  for (const ParameterEstimate& parameter : result.parameters) {
    map.names.push_back(parameter.name);
  }
  const std::string words = strong_pairs(result.parameters, map.values);
  out.blocks = {
      {Legend{{{"together", "estimated too large together"}, {"against", "one for the other"}},
              "The stronger the colour, the harder it is to distinguish two parameters: their sum or "
              "difference is known better than either. Move over the map for names and values."}},
      plots_block("", {std::move(map)}),
      {Sentence{words}}};
  return out;
}

}  // namespace rivid::detail
