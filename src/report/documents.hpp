#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/figures/joint_rows.hpp"
#include "report/document.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/report/json.hpp"
#include "rivid/simulate/closed_loop.hpp"

// The documents of rivid, and what they are made of.
namespace rivid::detail {

// What a result says of itself.
[[nodiscard]] Document document_of(const Identification& result);
// Its first screen: what it found and will predict, joint by joint, and the gravest findings.
[[nodiscard]] Document first_screen_of(const Robot& robot, const Identification& result);
// All of it with plots of its torques, its robot and where it comes from.
[[nodiscard]] Document document_of(const Robot& robot, const Identification& result,
                                   std::span<const Prediction> predictions, const Provenance& provenance);

// One way to identify, on many simulated experiments.
[[nodiscard]] Document document_of(const MonteCarloSummary& summary);
// All ways of a plan with plots of their errors and where they come from.
[[nodiscard]] Document document_of(const MonteCarlo& plan, std::span<const MonteCarloSummary> summaries,
                                   std::span<const MonteCarloRow> rows, const Provenance& provenance);

// What keeps a result from being identified; nothing where it is.
[[nodiscard]] std::string_view why_not(Status status);

// What was set, and to what.
using Settings = std::vector<std::pair<std::string, std::string>>;

// How rows are made of the samples.
[[nodiscard]] Settings row_settings(const SignalOptions& signal);

// A table without titles of program and run, of these settings and of the flags.
[[nodiscard]] Table run_table(const Provenance& provenance, const Settings& settings);

// The files with their SHA-256.
[[nodiscard]] Table inputs_table(const Provenance& provenance);

// Errors of the identified runs of one trial in their standard deviations, (estimate − truth) / σ: one list a
// parameter.
[[nodiscard]] std::vector<std::vector<double>> standardised_errors(const MonteCarloSummary& summary,
                                                                   std::span<const MonteCarloRow> rows);

// Joints' origins, in the frame of the base.
[[nodiscard]] Skeleton skeleton_of(const Robot& robot, const Vector& q);

// The equivalent ellipsoids of the links, of uniform density with the mass and inertia of the link; links
// without mass, or whose inertia no body can have, have none.
void add_ellipsoids(const Robot& robot, const Vector& q, const std::vector<Inertial>& inertials,
                    const std::string& style, Skeleton& out);

[[nodiscard]] inline std::string position_unit(const Joint& joint) {
  return joint.type == JointType::revolute ? "rad" : "m";
}
[[nodiscard]] inline std::string speed_unit(const Joint& joint) { return position_unit(joint) + "/s"; }

}  // namespace rivid::detail
