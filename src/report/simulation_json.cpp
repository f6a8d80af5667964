#include <nlohmann/json.hpp>
#include <sstream>

#include "report/provenance_json.hpp"
#include "report/warnings_json.hpp"
#include "rivid/report/json.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using Json = nlohmann::ordered_json;

Json list(const Vector& values) { return std::vector<double>(values.begin(), values.end()); }

Json parameters(const SimulationRecord& record) {
  Json out = Json::array();
  for (std::size_t i = 0; i < record.base.parameters.size(); ++i) {
    const BaseParameter& p = record.base.parameters[i];
    out.push_back({{"name", p.name},
                   {"value", record.chi[static_cast<Index>(i)]},
                   {"unit", p.unit},
                   {"regrouped", p.regrouped}});
  }
  return out;
}

Json joints(const Robot& robot, const SimulationRecord& record) {
  const Vector& error = record.simulation.max_tracking_error;
  Json out = Json::array();
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const auto i = static_cast<Index>(j);
    const Joint& joint = robot.joints[j];
    Json members = {{"name", joint.name},
                    {"largest_tracking_error", nullptr},
                    {"unit", joint.type == JointType::revolute ? "rad" : "m"}};
    if (i < error.size()) {
      members["largest_tracking_error"] = error[i];
    }
    out.push_back(std::move(members));
  }
  return out;
}

Json friction(const Simulation& simulation) {
  Json out = Json::array();
  for (std::size_t e = 0; e < simulation.element_names.size(); ++e) {
    out.push_back({{"name", simulation.element_names[e]}, {"mode_changes", simulation.element_changes[e]}});
  }
  return out;
}

Json control(const SimulationRecord& record) {
  Json gains = Json::object();
  for (const Gain& gain : record.control.gains) {
    gains[gain.name] = list(gain.values);
  }
  Json out = {{"law", record.control.law},
              {"assumed", record.control_assumed},
              {"rate_hz", nullptr},
              {"J", list(record.J)},
              {"gains", std::move(gains)}};
  if (record.control_hz > 0.0) {
    out["rate_hz"] = record.control_hz;
  }
  return out;
}

Json effort(const SimulationEffort& effort) {
  return {{"steps", effort.steps},
          {"right_hand_sides", effort.right_hand_sides},
          {"restarts", effort.restarts},
          {"mode_changes", effort.mode_changes},
          {"seconds", effort.seconds}};
}

}  // namespace

std::string to_json(const Robot& robot, const SimulationRecord& record, const Provenance& provenance) {
  const Simulation& simulation = record.simulation;
  const Json out = {{"format", 1},
                    {"outcome", name(simulation.outcome)},
                    {"reason", simulation.reason},
                    {"warnings", detail::warnings_json(record.warnings)},
                    {"robot", robot.name},
                    {"samples", record.log.samples()},
                    {"rate_hz", record.log.f_m},
                    {"seed", record.seed},
                    {"parameters", parameters(record)},
                    {"control", control(record)},
                    {"joints", joints(robot, record)},
                    {"friction", friction(simulation)},
                    {"effort", effort(simulation.effort)},
                    {"provenance", detail::provenance_json(provenance, Json::object())}};
  // A path may hold any bytes; JSON is UTF-8.
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string summary(const Robot& robot, const SimulationRecord& record) {
  const Simulation& simulation = record.simulation;
  const SimulationEffort& effort = simulation.effort;
  std::ostringstream out;
  out << "Simulation: " << name(simulation.outcome) << ", " << counted(record.log.samples(), "sample")
      << " at " << number(record.log.f_m) << " Hz\n";
  if (!simulation.reason.empty()) {
    out << "  " << simulation.reason << '\n';
  }
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (const auto i = static_cast<Index>(j); i < simulation.max_tracking_error.size()) {
      out << "  " << robot.joints[j].name << ": largest tracking error "
          << number(simulation.max_tracking_error[i], 4)
          << (robot.joints[j].type == JointType::revolute ? " rad\n" : " m\n");
    }
  }
  for (std::size_t e = 0; e < simulation.element_names.size(); ++e) {
    out << "  friction of " << simulation.element_names[e] << ": "
        << counted(simulation.element_changes[e], "mode change") << '\n';
  }
  out << "  " << counted(effort.steps, "step") << ", " << counted(effort.right_hand_sides, "right-hand side")
      << ", " << number(effort.seconds, 3) << " s\n";
  return out.str();
}

}  // namespace rivid
