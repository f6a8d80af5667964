#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>

#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

std::string padded(const std::string& text, std::size_t width) {
  const std::size_t shown = display_width(text);
  return shown < width ? std::string(width - shown, ' ') + text : text;
}

}  // namespace

std::ostream& operator<<(std::ostream& out, std::span<const MonteCarloSummary> summaries) {
  constexpr std::size_t name_width = 10;
  constexpr std::size_t width = 14;
  for (const MonteCarloSummary& s : summaries) {
    out << s.label << ": " << s.identified << " of " << counted(s.runs, "run") << " identified";
    if (s.mean_iterations > 0.0) {
      out << ", " << fixed(s.mean_iterations, 1) << " iterations";
    }
    out << ", " << number(s.mean_seconds, 2) << " s each";
    out << '\n' << padded("parameter", name_width);
    for (const char* const title :
         {"truth", "bias", "bias/spread", "RMSE/bound", "sigma/spread", "coverage"}) {
      out << padded(title, width);
    }
    out << '\n';
    for (const MonteCarloParameter& p : s.parameters) {
      constexpr int digits = 4;
      out << padded(p.name, name_width) << padded(number(p.truth, digits), width)
          << padded(number(p.bias, digits), width) << padded(fixed(p.bias_in_spreads, 2), width)
          << padded(fixed(p.rmse_over_bound, 2), width) << padded(fixed(p.sigma_over_spread, 2), width)
          << padded(fixed(100.0 * p.coverage, 1) + " %", width) << '\n';
    }
    out << padded("mean", name_width) << padded(fixed(100.0 * s.mean_coverage, 1) + " %", 6 * width)
        << "\n\n";
  }
  return out;
}

std::string to_json(std::span<const MonteCarloSummary> summaries) {
  using Json = nlohmann::ordered_json;
  Json trials = Json::array();
  for (const MonteCarloSummary& s : summaries) {
    Json parameters = Json::array();
    for (const MonteCarloParameter& p : s.parameters) {
      parameters.push_back({{"name", p.name},
                            {"unit", p.unit},
                            {"truth", p.truth},
                            {"bias", p.bias},
                            {"spread", p.spread},
                            {"rmse", p.rmse},
                            {"bias_in_spreads", p.bias_in_spreads},
                            {"rmse_over_bound", p.rmse_over_bound},
                            {"sigma_over_spread", p.sigma_over_spread},
                            {"coverage", p.coverage},
                            {"bias_in_spreads_95", p.bias_in_spreads_95},
                            {"rmse_over_bound_95", p.rmse_over_bound_95},
                            {"coverage_95", p.coverage_95}});
    }
    Json verdict = {{"unbiased", s.verdict.unbiased}, {"honest", s.verdict.honest}};
    verdict["efficient"] = s.verdict.efficient ? Json(*s.verdict.efficient) : Json();
    trials.push_back({{"label", s.label},
                      {"runs", s.runs},
                      {"identified", s.identified},
                      {"outcomes", s.outcomes},
                      {"mean_iterations", s.mean_iterations},
                      {"most_iterations", s.most_iterations},
                      {"mean_coverage", s.mean_coverage},
                      {"verdict", verdict},
                      {"parameters", std::move(parameters)}});
  }
  const Json out = {{"format", 1}, {"trials", std::move(trials)}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rivid
