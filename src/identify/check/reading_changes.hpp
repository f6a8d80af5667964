#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "identify/check/torque_probe.hpp"

namespace rivid::detail {

// A change of a reading and what it would be called.
struct Change {
  std::string_view code;
  std::string subject;
  std::string text;
  Reading reading;
};

// Every single change of a reading that is looked at. Those that change torques alone come first: they win
// ties.
[[nodiscard]] std::vector<Change> changes(const Robot& robot, const Reading& reading);

// Names for subjects.
[[nodiscard]] std::string joint_name(const Robot& robot, Index j);
[[nodiscard]] std::string base_name(const Robot& robot);

}  // namespace rivid::detail
