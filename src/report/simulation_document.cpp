#include "report/documents.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

Document document_of(const Robot& robot, const SimulationRecord& record) {
  const Simulation& simulation = record.simulation;
  const SimulationEffort& effort = simulation.effort;
  Document out;
  out.line = "Simulation: " + std::string(name(simulation.outcome)) + ", " +
             counted(record.log.samples(), "sample") + " at " + number(record.log.f_m) + " Hz";
  const auto say = [&](std::string sentence) { out.opening.push_back({Sentence{std::move(sentence)}}); };
  if (!simulation.reason.empty()) {
    say(simulation.reason);
  }
  for (Index j = 0; j < simulation.max_tracking_error.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    say(joint.name + ": largest tracking error " + number(simulation.max_tracking_error[j], 4) + " " +
        position_unit(joint));
  }
  for (std::size_t e = 0; e < simulation.element_names.size(); ++e) {
    say("friction of " + simulation.element_names[e] + ": " +
        counted(simulation.element_changes[e], "mode change"));
  }
  say(counted(effort.steps, "step") + ", " + counted(effort.right_hand_sides, "right-hand side") + ", " +
      number(effort.seconds, 3) + " s");
  return out;
}

}  // namespace rivid::detail
