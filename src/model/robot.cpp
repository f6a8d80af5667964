#include "rivid/model/robot.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/text.hpp"

namespace rivid {

namespace {

// No robot comes near; the squares of what lies far beyond overflow.
constexpr double largest_length = 1e6;
constexpr double largest_gravity = 1e6;

}  // namespace

std::vector<StandardParameter> Robot::standard_parameters() const {
  std::vector<StandardParameter> out;
  for (int j = 0; j < size(); ++j) {
    for (int k = 0; k < inertial_count; ++k) {
      out.push_back({static_cast<ParameterKind>(k), j});
    }
    const Joint& joint = joints[static_cast<std::size_t>(j)];
    if (joint.rotor_inertia) {
      out.push_back({ParameterKind::Ia, j});
    }
    for (const ParameterKind kind : parameters(joint.friction)) {
      out.push_back({kind, j});
    }
  }
  return out;
}

Vector Robot::chi_st() const {
  const std::vector<StandardParameter> list = standard_parameters();
  Vector chi(static_cast<Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto j = static_cast<std::size_t>(list[i].joint);
    const Joint& joint = joints[j];
    double value = 0.0;
    switch (list[i].kind) {
      case ParameterKind::Ia:
        value = joint.Ia;
        break;
      case ParameterKind::Fv:
      case ParameterKind::Fv_plus:
      case ParameterKind::Fv_minus:
        value = joint.Fv;
        break;
      case ParameterKind::Fc:
      case ParameterKind::Fc_plus:
      case ParameterKind::Fc_minus:
        value = joint.Fc;
        break;
      case ParameterKind::off:
        break;
      default:
        value = inertials[j][static_cast<Index>(list[i].kind)];
    }
    chi[static_cast<Index>(i)] = value;
  }
  return chi;
}

std::optional<std::string> Robot::complaint() const {
  if (chain.links.empty()) {
    return "the robot has no moving joint";
  }
  if (joints.size() != chain.links.size() || inertials.size() != chain.links.size()) {
    return "the chain has " + std::to_string(chain.links.size()) + " links, but " +
           std::to_string(joints.size()) + " joints and " + std::to_string(inertials.size()) +
           " inertials are given";
  }
  if (!chain.gravity.allFinite()) {
    return "gravity must be finite";
  }
  if (chain.gravity.cwiseAbs().maxCoeff() > largest_gravity) {
    return "gravity is " + number(chain.gravity.cwiseAbs().maxCoeff()) + " m/s², must be at most " +
           number(largest_gravity);
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    const std::string who = "joint \"" + joint.name + "\": ";
    const auto same_name = [&](const Joint& other) { return other.name == joint.name; };
    if (std::any_of(joints.begin(), joints.begin() + static_cast<std::ptrdiff_t>(j), same_name)) {
      return "two joints are called \"" + joint.name + "\"; names must differ";
    }
    if (joint.type != chain.links[j].type) {
      return who + "its type differs from that of the chain";
    }
    if (!chain.links[j].R.allFinite() || !chain.links[j].p.allFinite()) {
      return who + "its frame is not finite";
    }
    if (chain.links[j].p.cwiseAbs().maxCoeff() > largest_length) {
      return who + "its frame lies " + number(chain.links[j].p.cwiseAbs().maxCoeff()) +
             " m from the one before, must be at most " + number(largest_length) + " m";
    }
    if (!std::isfinite(joint.g_tau()) || joint.g_tau() == 0.0) {
      return who + "drive_gain × gear_ratio is " + std::to_string(joint.g_tau()) +
             ", must be finite and not zero";
    }
    if (!inertials[j].allFinite()) {
      return who + "the inertial parameters of link \"" + joint.link + "\" are not finite";
    }
  }
  return std::nullopt;
}

}  // namespace rivid
