#pragma once

#include <initializer_list>
#include <optional>
#include <string>

#include "rivid/simulate/control.hpp"

// What the specifications of control laws share: checks of their gains, and how gains follow the plant.
namespace rivid::detail {

using Complaint = std::optional<std::string>;

// The first one that there is.
[[nodiscard]] Complaint first(std::initializer_list<Complaint> complaints);

// @throws InputError  the complaint in the name of `who`
void require(const char* who, const Complaint& complaint);

// Each of these wants one finite entry a joint; `optional` ones may be empty.
[[nodiscard]] Complaint positive(const Robot& robot, const char* name, const Vector& values);
[[nodiscard]] Complaint optional_positive(const Robot& robot, const char* name, const Vector& values);
[[nodiscard]] Complaint optional_not_negative(const Robot& robot, const char* name, const Vector& values);

// Gains in units of the control signal act against the error only with the sign of the drive gain.
enum class Zero { refused, allowed };
[[nodiscard]] Complaint feedback(const Robot& robot, const char* name, const Vector& values, Zero zero);

// What known gains ask of the robot and of what they are adapted from.
[[nodiscard]] Complaint known_gains(const Robot& robot, const Vector& J_apriori);

// Whether a law is given by its poles; `poles` and `gains` count the entries of either form.
[[nodiscard]] Complaint one_form(Index poles, Index gains, const char* pole_names, const char* gain_names);

// Factor of the velocity gains, and how the joints' signals become those of the drives.
struct GainScale {
  Vector factor;  // (n)
  Matrix mixing;  // (n × n), empty where each drive moves its own joint
};

// From gains of a unit inertia with a unit drive: J / g_τ as in (45), or G⁻¹ J where gears couple the joints.
[[nodiscard]] GainScale scale_of_poles(const char* who, const Plant& plant);
// From gains known of a controller: J / J_apriori as in (46), or 1.
[[nodiscard]] GainScale scale_of_known_gains(const char* who, const Plant& plant, const Vector& J_apriori);

[[nodiscard]] bool is_diagonal(const Matrix& G);

// `values`, or so many times `otherwise` where they are empty.
[[nodiscard]] Vector or_constant(const Vector& values, Index n, double otherwise);

}  // namespace rivid::detail
