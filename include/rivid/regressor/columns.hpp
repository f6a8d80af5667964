#pragma once

#include <span>
#include <vector>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/regressor.hpp"

namespace rivid {

/// A choice of standard parameters whose regressor columns are wanted, laid out so that the rows of each joint
/// hold only the columns that this joint can feel: the inertial parameters of links j ≥ i, its own rotor inertia
/// and friction, and those of the motors that it is coupled to. This is the block
/// upper triangular structure of IDM, with the zero blocks left out.
class RegressorColumns {
 public:
  /// Entry of joint i's row from an inertial column of frame j.
  struct InertialEntry {
    int index = 0;     ///< in the ten columns of frame j
    double sign = 1;   ///< −1 where the link frame's axis is the reverse of frame j's
    Index column = 0;  ///< within the joint's own columns, see of_joint()
  };
  /// Entry of joint i's row from its own rotor inertia or friction.
  struct JointEntry {
    Basis basis = Basis::acceleration;
    Direction direction = Direction::both;
    Index column = 0;
    double sign_speed = 0.0;  ///< Joint::sign_speed
  };

  /// Entry of joint i's row from a motor that several joints turn.
  struct MotorEntry {
    CoupledEntry entry;
    Index column = 0;
  };

  /// @param parameters  columns in the order of the regressor wanted, (b)
  RegressorColumns(const Robot& robot, std::span<const StandardParameter> parameters);

  [[nodiscard]] Index size() const { return size_; }
  [[nodiscard]] std::span<const InertialMask> wanted() const { return wanted_; }

  /// Columns that joint i's rows touch: indices into the choice, ascending.
  [[nodiscard]] const std::vector<Index>& of_joint(std::size_t i) const { return joints_[i].columns; }

  /// Entries of joint i's row from link j ≥ i.
  [[nodiscard]] std::span<const InertialEntry> of_link(std::size_t i, std::size_t j) const {
    return joints_[i].blocks[j - i];
  }
  /// Entries of joint i's row from its own rotor inertia and friction.
  [[nodiscard]] std::span<const JointEntry> of_own(std::size_t i) const { return joints_[i].own; }

  /// Entries of joint i's row from the motors that it is coupled to.
  [[nodiscard]] std::span<const MotorEntry> of_motors(std::size_t i) const { return joints_[i].coupled; }

  /// Value of one such entry.
  template <typename Scalar>
  static Scalar coupled_value(const CoupledEntry& entry, const State<Scalar>& state) {
    using enum CoupledEntry::Quantity;
    Scalar sum(0);
    for (const CoupledEntry::Term& term : entry.terms) {
      const auto weight = static_cast<Scalar>(term.weight);
      if (entry.quantity == acceleration) {
        sum = sum + weight * state.qdd[term.joint];
      } else if (entry.quantity == single_signs) {
        sum = sum + weight * sign<Scalar>(state.qd[term.joint], term.sign_speed);
      } else {
        sum = sum + weight * state.qd[term.joint];
      }
    }
    return entry.quantity == sign_of_motion
               ? static_cast<Scalar>(entry.scale) * sign<Scalar>(sum, entry.sign_speed)
               : sum;
  }

  /// Fills the rows of all joints at one instant.
  ///
  /// @param put  called as put(i, column, value) for every entry of joint i's row; column counts in of_joint(i)
  template <typename Scalar, typename Put>
  void rows(const Chain& chain, const State<Scalar>& state, RegressorWorkspace<Scalar>& workspace,
            Put&& put) const {
    const std::size_t n = joints_.size();
    inertial_regressor(chain, state, wanted(), workspace,
                       [&](std::size_t i, std::size_t j, const detail::InertialEntries<Scalar>& entries) {
                         for (const InertialEntry& e : joints_[i].blocks[j - i]) {
                           put(i, e.column, Scalar(e.sign) * entries[static_cast<std::size_t>(e.index)]);
                         }
                       });
    for (std::size_t i = 0; i < n; ++i) {
      for (const JointEntry& e : joints_[i].own) {
        put(i, e.column,
            e.basis == Basis::acceleration
                ? state.qdd[i]
                : friction_entry<Scalar>(e.basis, e.direction, state.qd[i], e.sign_speed));
      }
      for (const MotorEntry& e : joints_[i].coupled) {
        put(i, e.column, coupled_value(e.entry, state));
      }
    }
  }

 private:
  struct JointRow {
    std::vector<Index> columns;
    std::vector<std::vector<InertialEntry>> blocks;  // for links i, i + 1, …, n − 1
    std::vector<JointEntry> own;
    std::vector<MotorEntry> coupled;
  };

  Index size_ = 0;
  std::vector<InertialMask> wanted_;
  std::vector<JointRow> joints_;
};

#ifdef RIVID_DEFINITIONS

namespace detail {

// The coupling that a parameter belongs to, if it is felt by more joints than its own.
inline const Coupling* coupling_of(const Robot& robot, const StandardParameter& p) {
  for (const Coupling& coupling : robot.couplings) {
    const bool coupled =
        about(p.kind).coupled || (p.kind == ParameterKind::Ia && coupling.inertia == Coupling::Inertia::tied);
    if (coupling.motor == p.joint && coupled) {
      return &coupling;
    }
  }
  return nullptr;
}

}  // namespace detail

RIVID_INLINE RegressorColumns::RegressorColumns(const Robot& robot,
                                                std::span<const StandardParameter> parameters)
    : size_(static_cast<Index>(parameters.size())),
      wanted_(robot.chain.links.size(), 0),
      joints_(robot.chain.links.size()) {
  const std::size_t n = joints_.size();
  for (std::size_t i = 0; i < n; ++i) {
    joints_[i].blocks.resize(n - i);
  }
  for (std::size_t c = 0; c < parameters.size(); ++c) {
    const auto j = static_cast<std::size_t>(parameters[c].joint);
    if (const Coupling* const coupling = detail::coupling_of(robot, parameters[c])) {
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

#endif

}  // namespace rivid
