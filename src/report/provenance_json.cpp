#include "report/provenance_json.hpp"

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "rivid/version.hpp"

namespace rivid::detail {

nlohmann::ordered_json provenance_json(const Provenance& provenance, nlohmann::ordered_json options) {
  using Json = nlohmann::ordered_json;
  Json inputs = Json::array();
  for (const InputFile& file : provenance.inputs) {
    inputs.push_back({{"path", file.path}, {"sha256", file.sha256}});
  }
  Json overrides = Json::object();
  for (const auto& [flag, value] : provenance.overrides) {
    overrides[flag] = value;
  }
  options["overrides"] = std::move(overrides);
  return {{"program", provenance.program},
          {"rivid", version},
          {"eigen", std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                        std::to_string(EIGEN_MINOR_VERSION)},
          {"compiler", __VERSION__},
          {"inputs", std::move(inputs)},
          {"options", std::move(options)}};
}

}  // namespace rivid::detail
