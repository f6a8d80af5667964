#include "report/warnings_json.hpp"

#include <nlohmann/json.hpp>

namespace rivid::detail {

nlohmann::ordered_json warnings_json(const std::vector<Warning>& warnings) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Warning& warning : warnings) {
    out.push_back({{"code", warning.code}, {"text", warning.text}});
  }
  return out;
}

}  // namespace rivid::detail
