#pragma once

#include <span>
#include <vector>

#include "report/document.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"

// What the page of an identification shows in pictures.
namespace rivid::detail {

// A result with its logs, those of the identification first.
struct Evidence {
  const Robot& robot;
  const Identification& result;
  std::span<const Prediction> logs;

  [[nodiscard]] std::span<const Prediction> fitted() const;      // logs of the identification
  [[nodiscard]] std::span<const Prediction> validation() const;  // the others
  [[nodiscard]] std::size_t joints() const { return result.fit.joints.size(); }
  [[nodiscard]] bool empty() const { return logs.empty() || joints() == 0; }
};

// The joints at a glance, and the torque of the one with the largest error.
[[nodiscard]] std::vector<Block> first_look(const Evidence& evidence);
// Measured and predicted torque and the residual, for each log and joint.
[[nodiscard]] Section torques_section(const Evidence& evidence);
[[nodiscard]] Section friction_section(const Evidence& evidence);
// Residual of each joint over speed, position and frequency, its distribution and autocorrelation.
[[nodiscard]] std::vector<Block> residual_charts(const Evidence& evidence);
// What the robot description would have predicted.
[[nodiscard]] Section description_section(const Evidence& evidence);
[[nodiscard]] Section coverage_section(const Evidence& evidence);
[[nodiscard]] Section correlation_section(const Identification& result);
[[nodiscard]] Section robot_section(const Evidence& evidence);

// Torque and motion errors of the iterations of IDIM-IV.
[[nodiscard]] Chart torque_error_chart(const Identification& result);
[[nodiscard]] Plots motion_error_charts(const Identification& result);

}  // namespace rivid::detail
