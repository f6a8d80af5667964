#pragma once

#include <string>

#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/report/provenance.hpp"

namespace rivid {

/// A result as JSON, the content of result.json; docs/result.md describes its members. Numbers are written so that
/// they read back bit by bit; what is not a number or infinite becomes null.
[[nodiscard]] std::string to_json(const Robot& robot, const Identification& result,
                                  const Provenance& provenance);

}  // namespace rivid
