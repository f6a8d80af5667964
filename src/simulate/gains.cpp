#include "simulate/gains.hpp"

#include <Eigen/LU>
#include <cmath>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::string joint_name(const Robot& robot, Index j) {
  return "joint \"" + robot.joints[static_cast<std::size_t>(j)].name + "\"";
}

// One complaint for the first entry that is not finite or that `accepts(j, value)` refuses.
template <typename Accepts>
Complaint each(const Robot& robot, const char* name, const Vector& values, const char* required,
               const Accepts& accepts) {
  if (values.size() != robot.size()) {
    return std::string(name) + " has " + std::to_string(values.size()) + " entries for " +
           counted(robot.size(), "joint");
  }
  for (Index j = 0; j < values.size(); ++j) {
    if (!std::isfinite(values[j]) || !accepts(j, values[j])) {
      return std::string(name) + " of " + joint_name(robot, j) + " is " + number(values[j]) + ", must be " +
             required;
    }
  }
  return std::nullopt;
}

const Vector& checked_inertias(const char* who, const Plant& plant) {
  require(who, positive(plant.robot, "the design inertia J", plant.J));
  return plant.J;
}

}  // namespace

Complaint first(std::initializer_list<Complaint> complaints) {
  for (const Complaint& complaint : complaints) {
    if (complaint) {
      return complaint;
    }
  }
  return std::nullopt;
}

void require(const char* who, const Complaint& complaint) {
  if (complaint) {
    throw InputError(std::string(who) + ": " + *complaint);
  }
}

Complaint positive(const Robot& robot, const char* name, const Vector& values) {
  return each(robot, name, values, "positive and finite", [](Index, double value) { return value > 0.0; });
}

Complaint optional_positive(const Robot& robot, const char* name, const Vector& values) {
  return values.size() == 0 ? std::nullopt : positive(robot, name, values);
}

Complaint optional_not_negative(const Robot& robot, const char* name, const Vector& values) {
  if (values.size() == 0) {
    return std::nullopt;
  }
  return each(robot, name, values, "finite and not negative",
              [](Index, double value) { return value >= 0.0; });
}

Complaint feedback(const Robot& robot, const char* name, const Vector& values, Zero zero) {
  const auto g_tau = [&](Index j) { return robot.joints[static_cast<std::size_t>(j)].g_tau(); };
  const bool may_be_zero = zero == Zero::allowed;
  return each(robot, name, values,
              may_be_zero ? "finite and zero or of the sign of the drive gain g_tau"
                          : "finite and of the sign of the drive gain g_tau, not zero",
              [&](Index j, double value) {
                return value == 0.0 ? may_be_zero : std::signbit(value) == std::signbit(g_tau(j));
              });
}

Complaint known_gains(const Robot& robot, const Vector& J_apriori) {
  if (!is_diagonal(robot.drive_matrix())) {
    return "the robot's gear_matrix couples its joints, so that no control signal belongs to one joint "
           "alone; "
           "give the poles, omega_n and zeta, instead of gains";
  }
  return optional_positive(robot, "J_apriori", J_apriori);
}

Complaint one_form(Index poles, Index gains, const char* pole_names, const char* gain_names) {
  if ((poles > 0) != (gains > 0)) {
    return std::nullopt;
  }
  return std::string("give either ") + pole_names + ", or " + gain_names + (poles > 0 ? ", not both" : "");
}

GainScale scale_of_poles(const char* who, const Plant& plant) {
  const Vector& J = checked_inertias(who, plant);
  const Matrix G = plant.robot.drive_matrix();
  if (is_diagonal(G)) {
    return {.factor = J.cwiseQuotient(G.diagonal()), .mixing = {}};
  }
  return {.factor = J, .mixing = G.inverse()};
}

GainScale scale_of_known_gains(const char* who, const Plant& plant, const Vector& J_apriori) {
  const Index n = plant.robot.size();
  GainScale out{.factor = Vector::Ones(n), .mixing = {}};
  if (J_apriori.size() > 0) {
    out.factor = checked_inertias(who, plant).cwiseQuotient(J_apriori);
  }
  return out;
}

bool is_diagonal(const Matrix& G) { return G.isDiagonal(0.0); }

Vector or_constant(const Vector& values, Index n, double otherwise) {
  return values.size() == 0 ? Vector::Constant(n, otherwise) : values;
}

}  // namespace rivid::detail
