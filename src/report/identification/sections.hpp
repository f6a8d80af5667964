#pragma once

#include "report/identification/evidence.hpp"

// The sections of the document of an identification. Those of the evidence are for pages alone; one without
// blocks has nothing to say.
namespace rivid::detail {

// The joints at a glance, and the torque of the one with the largest error.
[[nodiscard]] std::vector<Block> first_look(const Evidence& evidence);
// The joint with the largest relative error.
[[nodiscard]] std::size_t worst_joint(const Fit& fit);
[[nodiscard]] Section friction_section(const Evidence& evidence);
// Measured and predicted torque and the residual, for each log and joint.
[[nodiscard]] Section torques_section(const Evidence& evidence);
[[nodiscard]] Section parameters_section(const Identification& result);
// Drive gains that were estimated.
[[nodiscard]] Section gains_section(const Identification& result);
[[nodiscard]] Section loop_section(const OutputErrorReport& report);
[[nodiscard]] Section correlation_section(const Identification& result);
[[nodiscard]] Section prefilter_section(const Identification& result, const PrefilterReport& report);
[[nodiscard]] Section iterations_section(const Identification& result, const IvHistory& history);
[[nodiscard]] Table fit_table(const Fit& fit);
// What another set of parameters than the estimate costs in fit, and on the logs of the validation.
void add_prices(Section& out, const Identification& result, const Fit& fit,
                std::optional<Fit> Validation::* of_validation, const std::string& title);
// Tests of the residual of the rows of the fit; with evidence its shape over speed, position and frequency.
[[nodiscard]] Section residual_section(const Identification& result, const Evidence* evidence);
[[nodiscard]] Section weights_section(const RobustReport& report);
// What the robot description would have predicted.
[[nodiscard]] Section description_section(const Evidence& evidence);
[[nodiscard]] Section coverage_section(const Evidence& evidence);
[[nodiscard]] Section robot_section(const Evidence& evidence);
[[nodiscard]] Section essential_section(const Identification& result, const EssentialModel& model);
[[nodiscard]] Section physical_section(const Identification& result, const PhysicalModel& model);
[[nodiscard]] Section conditioning_section(const Identification& result);
[[nodiscard]] Section provenance_section(const Robot& robot, const Identification& result,
                                         const Provenance& provenance);

}  // namespace rivid::detail
