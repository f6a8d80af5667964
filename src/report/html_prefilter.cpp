#include <algorithm>
#include <cmath>

#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Align = HtmlTable::Align;

std::string noise_table(const Identification& result, const PrefilterReport& report) {
  HtmlTable table({{"joint", Align::text},
                   {"order", Align::number},
                   {"σ of e", Align::number},
                   {"unit", Align::text},
                   {"a₁, a₂, …", Align::text}});
  for (std::size_t j = 0; j < report.noise.size(); ++j) {
    const NoiseModel& model = report.noise[j];
    std::string coefficients;
    for (const double a : model.ar) {
      coefficients += (coefficients.empty() ? "" : ", ") + number(a, 3);
    }
    table.add({escaped(model.joint), std::to_string(model.ar.size()), number(model.innovation, 4),
               j < result.fit.joints.size() ? escaped(result.fit.joints[j].unit) : "", coefficients});
  }
  return table.markup();
}

// The estimate beside the one without the prefilter; red where they are apart by more than both intervals.
std::string shift_table(const Identification& result, const PrefilterReport& plain) {
  HtmlTable table({{"parameter", Align::text},
                   {"without", Align::number},
                   {"σ", Align::number},
                   {"with prefilter", Align::number},
                   {"σ", Align::number},
                   {"unit", Align::text},
                   {"apart by", Align::number}});
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const ParameterEstimate& p = result.parameters[i];
    const double shift = std::abs(p.value - plain.chi[at]);
    const double half_width =
        std::max(plain.covariance.quantile_975 * plain.sigma[at], result.covariance.quantile_975 * p.sigma);
    const double apart = shift / plain.sigma[at];
    table.add({element("b", escaped(p.name)), with_decimals_of(plain.chi[at], plain.sigma[at]),
               with_decimals_of(plain.sigma[at], plain.sigma[at]), with_decimals_of(p.value, p.sigma),
               with_decimals_of(p.sigma, p.sigma), escaped(p.unit),
               std::isfinite(apart) ? fixed(apart, 2) + " σ" : "-"},
              shift > half_width ? "undetermined" : "");
  }
  return table.markup();
}

}  // namespace

std::string prefilter_section(const Identification& result) {
  if (!result.prefilter) {
    return {};
  }
  const PrefilterReport& report = *result.prefilter;
  std::string out = element("h2", "Prefilter", "id=\"prefilter\"");
  out += element("p",
                 "The error of each joint's rows is taken for ρ<sub>t</sub> = Σ a<sub>i</sub> "
                 "ρ<sub>t−i</sub> + e<sub>t</sub> with white e, and taken off " +
                     counted(report.rows, "row") + ". Noise models and parameters settled in " +
                     counted(report.rounds, "round") + ".") +
         noise_table(result, report);
  if (report.chi.size() == static_cast<Index>(result.parameters.size())) {
    out += element("h3", "Against the estimate without it") +
           element(
               "p",
               "Whitening moves no parameter far where the model is right. How far they are apart is told in "
               "deviations of the estimate without the prefilter; red where that is beyond both 95 % "
               "intervals.") +
           shift_table(result, report);
  }
  return element("section", out);
}

}  // namespace rivid::detail
