#pragma once

#include <algorithm>
#include <array>
#include <string>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid::detail {

// Columns of a robot and of a body on its last link: the base parameters, and behind them those of the ten inertial
// parameters of the last link that lead none.
struct BodyColumns {
  BodyColumns(const Robot& robot, const BaseParameters& base) : all(base) {
    const int last = static_cast<int>(robot.size()) - 1;
    for (int k = 0; k < inertial_count; ++k) {
      const StandardParameter wanted = {static_cast<ParameterKind>(k), last};
      const auto at = std::ranges::find_if(all.parameters, [&](const BaseParameter& p) {
        return p.leading.kind == wanted.kind && p.leading.joint == wanted.joint;
      });
      body[static_cast<std::size_t>(k)] = at - all.parameters.begin();
      if (at == all.parameters.end()) {
        all.parameters.push_back({wanted, wanted.name(), wanted.name(), ""});
      }
    }
  }

  BaseParameters all;
  std::array<Index, inertial_count> body{};  // where XX … M of the last link stand
};

}  // namespace rivid::detail
