#include "rivid/regressor/columns.hpp"

namespace rivid {

namespace {

// The coupling that a parameter belongs to, if it is felt by more joints than its own.
const Coupling* coupling_of(const Robot& robot, const StandardParameter& p) {
  for (const Coupling& coupling : robot.couplings) {
    const bool coupled =
        about(p.kind).coupled || (p.kind == ParameterKind::Ia && coupling.inertia == Coupling::Inertia::tied);
    if (coupling.motor == p.joint && coupled) {
      return &coupling;
    }
  }
  return nullptr;
}

}  // namespace

RegressorColumns::RegressorColumns(const Robot& robot, std::span<const StandardParameter> parameters)
    : size_(static_cast<Index>(parameters.size())),
      wanted_(robot.chain.links.size(), 0),
      joints_(robot.chain.links.size()) {
  const std::size_t n = joints_.size();
  for (std::size_t i = 0; i < n; ++i) {
    joints_[i].blocks.resize(n - i);
  }
  for (std::size_t c = 0; c < parameters.size(); ++c) {
    const auto j = static_cast<std::size_t>(parameters[c].joint);
    if (const Coupling* const coupling = coupling_of(robot, parameters[c])) {
      for (CoupledEntry& entry : coupled_entries(*coupling, parameters[c].kind, robot.size())) {
        entry.sign_speed = robot.joints[j].sign_speed;
        for (CoupledEntry::Term& term : entry.terms) {
          term.sign_speed = robot.joints[term.joint].sign_speed;
        }
        JointRow& row = joints_[entry.joint];
        row.coupled.push_back({std::move(entry), static_cast<Index>(row.columns.size())});
        row.columns.push_back(static_cast<Index>(c));
      }
      continue;
    }
    if (role(parameters[c].kind) != Role::inertial) {
      const KindRow& row = about(parameters[c].kind);
      joints_[j].own.push_back({row.basis, row.direction, static_cast<Index>(joints_[j].columns.size()),
                                robot.joints[j].sign_speed});
      joints_[j].columns.push_back(static_cast<Index>(c));
      continue;
    }
    const InertialColumn at = inertial_column(robot.chain.links[j], parameters[c].kind);
    wanted_[j] = static_cast<InertialMask>(wanted_[j] | (1U << at.index));
    for (std::size_t i = 0; i <= j; ++i) {
      JointRow& row = joints_[i];
      row.blocks[j - i].push_back(
          {at.index, static_cast<double>(at.sign), static_cast<Index>(row.columns.size())});
      row.columns.push_back(static_cast<Index>(c));
    }
  }
}

}  // namespace rivid
