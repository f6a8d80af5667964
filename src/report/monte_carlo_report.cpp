#include <vector>

#include "experiment/json_fields.hpp"
#include "rivid/report/monte_carlo.hpp"

namespace rivid {

std::string to_json(std::span<const MonteCarloSummary> summaries) {
  using detail::Json;
  const Json out = {{"format", 1},
                    {"trials", detail::json_of(std::vector(summaries.begin(), summaries.end()))}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rivid
