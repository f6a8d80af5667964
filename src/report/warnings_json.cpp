#include "report/warnings_json.hpp"

#include <nlohmann/json.hpp>

namespace rivid::detail {

nlohmann::ordered_json warnings_json(const std::vector<Finding>& warnings) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Finding& warning : warnings) {
    out.push_back({{"code", warning.code},
                   {"text", warning.text},
                   {"severity", name(severity(warning))},
                   {"subject", warning.subject}});
  }
  return out;
}

}  // namespace rivid::detail
