#include "rivid/regressor/load.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "rivid/error.hpp"

namespace rivid {

namespace {

bool follows_load(ParameterKind kind) { return about(kind).basis == Basis::load; }

bool is_rigid(ParameterKind kind) { return role(kind) == Role::inertial || role(kind) == Role::rotor; }

Friction law_without_load(Friction law) {
  std::vector<ParameterKind> others;
  std::ranges::copy_if(parameters(law), std::back_inserter(others),
                       [](ParameterKind kind) { return !follows_load(kind); });
  return std::ranges::find_if(
             friction_rows,
             [&](const FrictionRow& row) { return std::ranges::equal(row.parameters, others); })
      ->law;
}

}  // namespace

LoadColumns::LoadColumns(std::string_view who, const Robot& robot, const BaseParameters& base,
                         const RegressorBatch& batch) {
  const std::vector<StandardParameter> parameters = base.columns();
  const auto at_load =
      std::ranges::find_if(parameters, [](const StandardParameter& p) { return follows_load(p.kind); });
  if (at_load == parameters.end()) {
    return;
  }
  if (base.load.chi.size() != base.size()) {
    throw InputError(std::string(who) + ": friction of joint \"" +
                     robot.joints[static_cast<std::size_t>(at_load->joint)].name +
                     "\" follows its load, and base.load.chi has " + std::to_string(base.load.chi.size()) +
                     " values; it must have the " + std::to_string(base.size()) +
                     " parameters that the load is computed with, see at_load()");
  }
  if (base.load.width && base.load.width->size() != robot.size()) {
    throw InputError(std::string(who) + ": base.load.width has " + std::to_string(base.load.width->size()) +
                     " values, must have one for each of the " + std::to_string(robot.size()) + " joints");
  }
  joints_.resize(batch.joints());
  for (std::size_t j = 0; j < batch.joints(); ++j) {
    JointLoad& joint = joints_[j];
    for (std::size_t c = 0; c < batch.of_joint(j).size(); ++c) {
      const Index at = batch.of_joint(j)[c];
      const ParameterKind kind = parameters[static_cast<std::size_t>(at)].kind;
      if (follows_load(kind)) {
        joint.column = static_cast<Index>(c);
        joint.slope = base.load.width ? base.load.chi[at] : 0.0;
        joint.width = base.load.width ? (*base.load.width)[static_cast<Index>(j)] : 0.0;
      } else if (is_rigid(kind)) {
        joint.rigid.push_back(static_cast<Index>(c));
        joint.value.push_back(base.load.chi[at]);
      }
    }
  }
}

void LoadColumns::complete(std::size_t j, const RowsTarget& W, Index count, double* y) const {
  if (joints_.empty() || joints_[j].column < 0) {
    return;
  }
  const JointLoad& joint = joints_[j];
  double* const load = W.data + joint.column * W.ld;
  constexpr Index piece = 128;  // samples at a time, 1 KiB of the stack; a choice
  std::array<double, piece> torque{};
  for (Index first = 0; first < count; first += piece) {
    const Index rows = std::min(piece, count - first);
    std::fill_n(torque.begin(), rows, 0.0);
    for (std::size_t r = 0; r < joint.rigid.size(); ++r) {
      const double* const column = W.data + joint.rigid[r] * W.ld + first;
      for (Index k = 0; k < rows; ++k) {
        torque[static_cast<std::size_t>(k)] += column[k] * joint.value[r];
      }
    }
    for (Index k = 0; k < rows; ++k) {
      double& at = torque[static_cast<std::size_t>(k)];
      double& entry = load[first + k];
      const double size = std::sqrt(at * at + joint.width * joint.width);
      const double slope = size > 0.0 ? joint.slope * entry * at / size : 0.0;
      if (y != nullptr) {
        y[first + k] += slope * at;
      }
      entry *= std::abs(at);
      at = 1.0 + slope;  // from here on the factor of M q̈ + N
    }
    for (std::size_t r = 0; joint.slope != 0.0 && r < joint.rigid.size(); ++r) {
      double* const column = W.data + joint.rigid[r] * W.ld + first;
      for (Index k = 0; k < rows; ++k) {
        column[k] *= torque[static_cast<std::size_t>(k)];
      }
    }
  }
}

BaseParameters at_load(BaseParameters base, const Eigen::Ref<const Vector>& chi,
                       std::optional<Vector> width) {
  base.load = {chi, std::move(width)};
  return base;
}

Robot without_load(Robot robot) {
  for (Joint& joint : robot.joints) {
    joint.friction = law_without_load(joint.friction);
  }
  return robot;
}

bool has_load(const Robot& robot) {
  return std::ranges::any_of(robot.joints,
                             [](const Joint& joint) { return has(joint.friction, Basis::load); });
}

}  // namespace rivid
