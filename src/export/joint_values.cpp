#include "export/joint_values.hpp"

#include <cmath>

#include "export/recorded.hpp"
#include "joined.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

void take(JointValues& to, const StandardParameter& parameter, double value, JointType type) {
  const auto text = [&] {
    const std::string_view its_unit = unit(parameter.kind, type);
    return parameter.name() + " = " + number(value, 4) + (its_unit == "1" ? "" : " " + std::string(its_unit));
  };
  const KindRow& row = about(parameter.kind);
  switch (role(parameter.kind)) {
    case Role::inertial:
      to.inertial[static_cast<Index>(parameter.kind)] = value;
      return;
    case Role::rotor:
      if (!row.coupled) {
        to.Ia = value;
        to.rotor = value != 0.0 ? text() : std::string();
        return;
      }
      break;
    case Role::viscous:
    case Role::dry:
    case Role::constant:
      break;
  }
  if (row.coupled && value != 0.0) {
    to.coupled.push_back(text());
  } else if (row.basis == Basis::load) {
    to.load_friction = value;
  } else if (!row.coupled) {
    Recording in;
    const Recorded phi = friction_function(row.basis, in.input("speed"), in.input("sign"));
    to.friction_terms.push_back({value, in.expression(phi), row.direction});
  }
  std::optional<double>* const place = row.coupled                 ? nullptr
                                       : row.basis == Basis::speed ? &to.damping
                                       : row.basis == Basis::sign  ? &to.friction
                                                                   : nullptr;
  if (place != nullptr && row.direction == Direction::both) {
    *place = value;
    return;
  }
  if (place != nullptr) {
    *place = place->value_or(0.0) + 0.5 * value;
  }
  if (value != 0.0) {
    to.rest.push_back(text());
  }
}

}  // namespace

std::vector<std::string> JointValues::unsaid(bool with_rotor) const {
  std::vector<std::string> out = rest;
  if (with_rotor && !rotor.empty()) {
    out.insert(out.begin(), rotor);
  }
  return out;
}

std::string exact_list(const Eigen::Ref<const Vector>& values) { return joined(values, " ", exact); }

std::vector<JointValues> joint_values(const Robot& robot, const Eigen::Ref<const Vector>& chi_st,
                                      std::string_view who) {
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  if (chi_st.size() != static_cast<Index>(parameters.size())) {
    throw InputError(std::string(who) + ": chi_st has " + std::to_string(chi_st.size()) +
                     " values, the robot has " + std::to_string(parameters.size()) + " standard parameters");
  }
  std::vector<JointValues> out(robot.chain.links.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double value = chi_st[static_cast<Index>(i)];
    if (!std::isfinite(value)) {
      throw InputError(std::string(who) + ": " + parameters[i].name() + " is " + number(value) +
                       ", must be finite");
    }
    const auto joint = static_cast<std::size_t>(parameters[i].joint);
    take(out[joint], parameters[i], value, robot.chain.links[joint].type);
  }
  return out;
}

}  // namespace rivid::detail
