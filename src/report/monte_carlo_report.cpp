#include <nlohmann/json.hpp>

#include "rivid/report/monte_carlo.hpp"

namespace rivid {

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
