#include <algorithm>
#include <cmath>
#include <functional>

#include "report/analysis.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Pairs of estimates with a strong correlation in words, the strongest first.
std::string strong_pairs(const std::vector<ParameterEstimate>& parameters, const Matrix& correlations) {
  constexpr double strong = 0.9;
  constexpr std::size_t most = 12;
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
  std::string out = counted(std::ssize(pairs), "pair") + " above 0.9: ";
  for (std::size_t k = 0; k < std::min(pairs.size(), most); ++k) {
    out += (k == 0 ? "" : ", ") + pairs[k].names + " (" + fixed(pairs[k].r, 2) + ")";
  }
  return out + (pairs.size() > most ? ", …" : "");
}

}  // namespace

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
      {Plots{"", {}, {{"", "", {std::move(map)}}}}},
      {Sentence{words}}};
  return out;
}

}  // namespace rivid::detail
