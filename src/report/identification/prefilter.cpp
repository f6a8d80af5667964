#include <algorithm>
#include <cmath>

#include "comma_list.hpp"
#include "report/identification/sections.hpp"
#include "report/lists.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using enum Shown;

Table noise_table(const Identification& result, const PrefilterReport& report) {
  return table_of(
      places(report.noise.size()),
      {{{"joint"}, [&](std::size_t j) { return report.noise[j].joint; }},
       {{"order", format::count},
        [&](std::size_t j) { return static_cast<double>(report.noise[j].ar.size()); }},
       {{"sigma of e", format::significant(4)}, [&](std::size_t j) { return report.noise[j].innovation; }},
       {{"unit"},
        [&](std::size_t j) {
          return j < result.fit.joints.size() ? result.fit.joints[j].unit : std::string();
        }},
       {{"a_1, a_2, …"}, [&](std::size_t j) {
          std::vector<std::string> coefficients;
          for (const double a : report.noise[j].ar) {
            coefficients.push_back(number(a, 3));
          }
          return comma_list(coefficients);
        }}});
}

// The estimate beside another one, in deviations of that one; marked where they are apart by more than both intervals.
Table shift_table(const Identification& result, const PrefilterReport& plain) {
  const auto shift = [&](std::size_t i) { return std::abs(result.parameters[i].value - at(plain.chi, i)); };
  const auto sigma = [&](std::size_t i) { return at(plain.sigma, i); };
  const auto mark = [&](std::size_t i) {
    const double half_width = std::max(plain.covariance.quantile_975 * sigma(i),
                                       result.covariance.quantile_975 * result.parameters[i].sigma);
    return shift(i) > half_width ? Mark::apart : Mark::none;
  };
  const std::vector<ParameterEstimate>& all = result.parameters;
  return table_of(
      places(all.size()),
      {{{"parameter", format::name}, [&](std::size_t i) { return all[i].name; }},
       {{"without", format::deviation}, [&](std::size_t i) { return Cell(at(plain.chi, i), sigma(i)); }},
       {{"sigma", format::deviation}, [&](std::size_t i) { return Cell(sigma(i), sigma(i)); }},
       {{"with prefilter", format::deviation},
        [&](std::size_t i) { return Cell(all[i].value, all[i].sigma); }},
       {{"sigma", format::deviation}, [&](std::size_t i) { return Cell(all[i].sigma, all[i].sigma); }},
       {{"unit"}, [&](std::size_t i) { return all[i].unit; }},
       {{"apart by", format::fixed(2), "σ"}, [&](std::size_t i) { return shift(i) / sigma(i); }}},
      mark);
}

}  // namespace

Section prefilter_section(const Identification& result, const PrefilterReport& report) {
  std::vector<std::string> orders;
  for (const NoiseModel& model : report.noise) {
    orders.push_back(std::to_string(model.ar.size()));
  }
  Section out{"prefilter", "Prefilter", "Prefilter"};
  out.blocks = {
      {Sentence{"prefilter: autoregressive noise of order " + comma_list(orders) + " taken off " +
                counted(report.rows, "row") + ", in " + counted(report.rounds, "round")}},
      {Sentence{"The error of each joint's rows is taken for ρ_t = Σ a_i ρ_{t−i} + e_t with white e"}, page},
      {noise_table(result, report), page}};
  if (report.chi.size() == static_cast<Index>(result.parameters.size())) {
    out.blocks.push_back({Heading{"Against the estimate without it"}, page});
    out.blocks.push_back(
        {Sentence{
             "Whitening moves no parameter far where the model is right. How far they are apart is given "
             "in deviations of the estimate without the prefilter; marked where that is beyond both 95 % "
             "intervals"},
         page});
    out.blocks.push_back({shift_table(result, report), page});
  }
  return out;
}

}  // namespace rivid::detail
