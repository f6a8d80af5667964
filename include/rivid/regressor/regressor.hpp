#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/kernel.hpp"

namespace rivid {

namespace detail {

// A link's frame as R = turn · Rz(θ), and what the kernels choose their steps by.
struct FrameCase {
  Frame frame{};
  Turn turn = Turn::any;
  unsigned offsets = 0;  // bits 0, 1, 2: which components of the origin are not zero

  // Rᵀ of `turn`.
  [[nodiscard]] Eigen::Map<const Eigen::Matrix3d> turned() const {
    return Eigen::Map<const Eigen::Matrix3d>(frame.R);
  }
};

[[nodiscard]] inline FrameCase frame_case(const Chain::Link& link) {
  // An entry of a rotation this small is a rounding error of the sine or cosine of a quarter turn.
  const auto is_nil = [](double x) { return std::abs(x) <= 4.0 * std::numeric_limits<double>::epsilon(); };
  FrameCase out;
  Frame& frame = out.frame;
  frame.revolute = link.type == JointType::revolute;
  frame.cos_theta = 1.0;
  Eigen::Matrix3d R = link.R;
  if (is_nil(link.R(0, 2))) {
    const double c = link.R(2, 2);
    const double s = -link.R(1, 2);
    R << 1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c;
    frame.cos_theta = link.R(0, 0);
    frame.sin_theta = -link.R(0, 1);
    if (is_nil(frame.sin_theta) && frame.cos_theta > 0.0) {
      frame.cos_theta = 1.0;
      frame.sin_theta = 0.0;
    }
    out.turn = is_nil(s) && c > 0.0 ? Turn::none
               : !is_nil(c)         ? Turn::about_x
               : s > 0.0            ? Turn::plus
                                    : Turn::minus;
  }
  frame.shifted_angle = frame.sin_theta != 0.0 || frame.cos_theta != 1.0;
  Eigen::Matrix3d::Map(frame.R) = R.transpose();  // column-major, so its transpose row by row
  Eigen::Vector3d::Map(frame.p) = link.p;
  for (int k = 0; k < 3; ++k) {
    out.offsets |= link.p[k] != 0.0 ? 1U << k : 0U;
  }
  return out;
}

}  // namespace detail

/// Positions, velocities and accelerations of the n joints at one instant.
template <typename Scalar>
struct State {
  std::span<const Scalar> q;    ///< (n) [rad | m]
  std::span<const Scalar> qd;   ///< (n) [rad/s | m/s]
  std::span<const Scalar> qdd;  ///< (n) [rad/s² | m/s²]
};

template <typename Scalar>
class RegressorWorkspace;

/// Regressor of a robot for a choice of its standard parameters: the rows of IDM_st of Eq. (2) of [RIV], or
/// of IDM of Eq. (6), without the zeros of the block upper triangle. The row of each joint holds only the
/// columns that this joint can feel: the inertial parameters of its link and of those that this carries (of a
/// chain, links j ≥ i), its own rotor inertia and friction, and those of the motors that it is coupled to.
///
/// Every link's motion is carried from base to tip (recursive Newton-Euler), and with it the screws of all
/// joints before it; a joint's torque is the power of the link's wrench on that joint's screw. RegressorBatch
/// does the same for many samples, by the same template. The column of friction that follows the load holds
/// the sign of the velocity alone, see LoadColumns.
///
/// Where joints depend on others the kernel has the rows of all links' joints, and those of a robot's joints
/// are Gᵀ of them, with q_all = G q + q0.
class RegressorColumns {
 public:
  /// Where a value of the kernel goes.
  struct Entry {
    std::size_t joint = 0;
    Index column = 0;  ///< within the joint's own columns, see of_joint()
  };
  /// Entry of joint i's row from a motor that several joints turn.
  struct MotorEntry {
    CoupledEntry entry;
    Index column = 0;
  };

  /// @param parameters  columns in the order of the regressor wanted, (b), each at most once
  /// @throws InputError where a parameter occurs twice, or is none of this robot
  RegressorColumns(const Robot& robot, std::span<const StandardParameter> parameters);

  /// An entry of a joint's row where joints depend on others: values of the kernel, each with the term of
  /// dependence() whose slope multiplies it.
  struct FoldedEntry {
    Entry to;
    std::vector<std::pair<std::size_t, std::size_t>> terms;
  };

  [[nodiscard]] Index size() const { return size_; }
  [[nodiscard]] std::size_t joints() const { return columns_.size(); }

  /// Columns that joint i's rows touch: indices into the choice, ascending.
  [[nodiscard]] const std::vector<Index>& of_joint(std::size_t i) const { return columns_[i]; }

  /// Where the values of the kernel go, in its order: all but those of coupled motors. Where joints depend on
  /// others, the number of its values alone; see folded().
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
  /// What is made of the kernel's values where joints depend on others; else empty.
  [[nodiscard]] std::span<const FoldedEntry> folded() const { return folded_; }
  /// How joints depend on others, by the links of plan(); empty where none does.
  [[nodiscard]] const detail::Dependence& dependence() const { return dependence_; }
  /// Entries of joint i's row from the motors that it is coupled to.
  [[nodiscard]] std::span<const MotorEntry> of_motors(std::size_t i) const { return motors_[i]; }
  /// What the kernel reads.
  [[nodiscard]] detail::RegressorPlan plan() const {
    return {links_.data(), links_.size(), own_.data(), own_.size(), forks_};
  }

  /// Value of an entry of a coupled motor.
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

  /// Fills the rows of all joints at one instant. No allocation.
  ///
  /// Scalar is double, float, Pack, std::complex, Eigen::AutoDiffScalar (for derivatives by q, q̇ and q̈), or
  /// any number type that is made from a double, with + − × /, sin, cos and tanh, and for friction with
  /// is_positive() and select(), see rivid/model/kinds.hpp.
  ///
  /// @param put  called as put(i, column, value) for every entry of joint i's row; column counts in
  ///             of_joint(i)
  template <typename Scalar, typename Put>
  void rows(const State<Scalar>& state, RegressorWorkspace<Scalar>& workspace, const Put& put) const {
    detail::RegressorInput<Scalar> input = {state.q.data(), state.qd.data(), state.qdd.data(), 1, 1, 1};
    if (!dependence_.empty()) {
      input = expanded(input, 0, 1, workspace.motion_.data());
    }
    detail::fill_rows<Scalar>(plan(), input, 1, workspace.places_.data(),
                              {workspace.screws_.data(), workspace.angles_.data(), workspace.forks_.data(),
                               workspace.fork_screws_.data()});
    for (std::size_t e = 0; dependence_.empty() && e < entries_.size(); ++e) {
      put(entries_[e].joint, entries_[e].column, workspace.values_[e]);
    }
    for (const FoldedEntry& folded : folded_) {
      Scalar sum(0.0);
      for (const auto& [e, term] : folded.terms) {
        sum = sum + dependence_.slope<Scalar>(term, 1, 0, workspace.motion_.data()) * workspace.values_[e];
      }
      put(folded.to.joint, folded.to.column, sum);
    }
    for (std::size_t i = 0; i < motors_.size(); ++i) {
      for (const MotorEntry& e : motors_[i]) {
        put(i, e.column, coupled_value(e.entry, state));
      }
    }
  }

  /// Motion of all links' joints where joints depend on others.
  ///
  /// @param first, count  samples of the input
  /// @param memory        (dependence().memory(count)), which the result lies in
  template <typename Value>
  detail::RegressorInput<Value> expanded(const detail::RegressorInput<Value>& input, std::ptrdiff_t first,
                                         std::ptrdiff_t count, Value* memory) const {
    const auto size = static_cast<std::ptrdiff_t>(links_.size()) * count;
    dependence_.expand<Value>({input.q + first, input.qd + first, input.qdd + first, input.q_stride,
                               input.qd_stride, input.qdd_stride},
                              count, memory);
    return {memory, memory + size, memory + 2 * size, count, count, count};
  }

 private:
  void add_coupled(const Robot& robot, const Coupling& coupling, const StandardParameter& parameter,
                   Index column, std::span<const std::size_t> places);
  void fold(const Robot& robot, std::span<const std::size_t> places);

  Index size_ = 0;
  std::size_t forks_ = 0;
  std::vector<detail::LinkPlan> links_;
  std::vector<detail::OwnEntry> own_;
  std::vector<Entry> entries_;
  std::vector<std::vector<MotorEntry>> motors_;  // by joint
  std::vector<std::vector<Index>> columns_;      // by joint
  std::vector<FoldedEntry> folded_;
  detail::Dependence dependence_;
};

/// Scratch of RegressorColumns::rows(), made once and used for any number of samples by one thread.
template <typename Scalar>
class RegressorWorkspace {
 public:
  explicit RegressorWorkspace(const RegressorColumns& columns)
      : screws_(columns.plan().joints),
        angles_(columns.plan().joints),
        forks_(columns.plan().forks),
        fork_screws_(forks_.size() * columns.plan().joints),
        motion_(columns.dependence().memory(1)),
        values_(columns.entries().size()) {
    for (Scalar& value : values_) {
      places_.push_back(&value);
    }
  }
  RegressorWorkspace(const RegressorWorkspace&) = delete;
  RegressorWorkspace& operator=(const RegressorWorkspace&) = delete;

 private:
  friend class RegressorColumns;
  std::vector<detail::Screw<Scalar>> screws_;
  std::vector<detail::CosSin<Scalar>> angles_;
  std::vector<detail::ForkState<Scalar>> forks_;
  std::vector<detail::Screw<Scalar>> fork_screws_;
  std::vector<Scalar> motion_;  // of all links, where joints depend on others
  std::vector<Scalar> values_;
  std::vector<Scalar*> places_;
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

inline LinkPlan link_plan(const Chain& chain, std::size_t j, unsigned mask) {
  const Chain::Link& link = chain.links[j];
  const FrameCase at = frame_case(link);
  LinkPlan out{};
  static_cast<Frame&>(out) = at.frame;
  const Eigen::Matrix3d turned = at.turned();
  Eigen::Vector3d::Map(out.accel) = applied(turned, -chain.gravity);
  const int parent = chain.parent(j);
  out.parent = parent;
  out.depth = static_cast<int>(chain.path(j).size()) - 1;
  out.end = static_cast<int>(j) + 1;
  const auto is_carried = [&](int other) {
    while (other > static_cast<int>(j)) {
      other = chain.parent(static_cast<std::size_t>(other));
    }
    return other == static_cast<int>(j);
  };
  while (out.end < static_cast<int>(chain.links.size()) && is_carried(out.end)) {
    ++out.end;
  }
  if (parent >= 0) {
    const bool revolute = chain.links[static_cast<std::size_t>(parent)].type == JointType::revolute;
    const Eigen::Vector3d along = turned.col(2);  // z of frame j−1
    const Eigen::Vector3d across = applied(turned, {-link.p.y(), link.p.x(), 0.0});
    Eigen::Vector3d::Map(out.parent_w) = revolute ? along : Eigen::Vector3d::Zero();
    Eigen::Vector3d::Map(out.parent_v) = revolute ? across : along;
  }
  out.mask = mask;
  std::ranges::fill(out.sign, 1.0);
  bool plain = mask == usual_mask;
  for (int k = 0; k < inertial_count; ++k) {
    const InertialColumn column = inertial_column(link, static_cast<ParameterKind>(k));
    out.sign[column.index] = column.sign;
    plain = plain && column.sign > 0;
  }
  out.step = step_number(at.turn, at.offsets, out.revolute, plain);
  return out;
}

inline void require_parameters(const Robot& robot, std::span<const StandardParameter> parameters) {
  if (robot.chain.joints() != std::ssize(robot.joints)) {
    throw InputError("RegressorColumns: robot \"" + robot.name + "\" has " +
                     std::to_string(robot.chain.joints()) + " links, must have one for each of its " +
                     std::to_string(robot.joints.size()) + " joints");
  }
  if (const auto fault = order_complaint(robot.chain)) {
    throw InputError("RegressorColumns: robot \"" + robot.name + "\": " + *fault);
  }
  for (const StandardParameter& p : parameters) {
    if (static_cast<std::size_t>(p.kind) >= kind_rows.size()) {
      throw InputError("RegressorColumns: kind of a parameter is " +
                       std::to_string(static_cast<int>(p.kind)) + ", must be a ParameterKind");
    }
    const auto places = role(p.kind) == Role::inertial ? std::ssize(robot.chain.links) : robot.size();
    if (p.joint < 0 || p.joint >= places) {
      throw InputError("RegressorColumns: joint of a parameter " + std::string(symbol(p.kind)) + " is " +
                       std::to_string(p.joint) + ", must be one of the " + std::to_string(places) +
                       " joints of robot \"" + robot.name + "\", counted from 0");
    }
  }
}

}  // namespace detail

RIVID_INLINE void RegressorColumns::add_coupled(const Robot& robot, const Coupling& coupling,
                                                const StandardParameter& parameter, Index column,
                                                std::span<const std::size_t> places) {
  for (CoupledEntry& entry : coupled_entries(coupling, parameter.kind, robot.size())) {
    entry.sign_speed = robot.joints[static_cast<std::size_t>(parameter.joint)].sign_speed;
    for (CoupledEntry::Term& term : entry.terms) {
      term.sign_speed = robot.joints[term.joint].sign_speed;
    }
    std::vector<Index>& felt = columns_[places[entry.joint]];
    motors_[entry.joint].push_back({std::move(entry), static_cast<Index>(felt.size())});
    felt.push_back(column);
  }
}

// From the columns of all links' joints to those of the robot's joints.
RIVID_INLINE void RegressorColumns::fold(const Robot& robot, std::span<const std::size_t> places) {
  const std::vector<std::vector<Index>> of_links =
      std::exchange(columns_, std::vector<std::vector<Index>>(robot.joints.size()));
  std::map<std::pair<std::size_t, Index>, std::vector<std::pair<std::size_t, std::size_t>>> felt;
  for (std::size_t e = 0; e < entries_.size(); ++e) {
    const auto [link, column] = entries_[e];
    for (std::size_t t = 0; t < dependence_.terms.size(); ++t) {
      if (static_cast<std::size_t>(dependence_.terms[t].link) == link) {
        felt[{static_cast<std::size_t>(dependence_.terms[t].joint),
              of_links[link][static_cast<std::size_t>(column)]}]
            .emplace_back(e, t);
      }
    }
  }
  const auto column_of = [&](std::size_t joint, const MotorEntry& motor) {
    return of_links[places[joint]][static_cast<std::size_t>(motor.column)];
  };
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    for (const MotorEntry& motor : motors_[i]) {
      felt[{i, column_of(i, motor)}];
    }
  }
  for (auto& [at, terms] : felt) {
    std::vector<Index>& columns = columns_[at.first];
    if (!terms.empty()) {
      folded_.push_back({{at.first, static_cast<Index>(columns.size())}, std::move(terms)});
    }
    columns.push_back(at.second);
  }
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    for (MotorEntry& motor : motors_[i]) {
      motor.column = std::ranges::find(columns_[i], column_of(i, motor)) - columns_[i].begin();
    }
  }
}

RIVID_INLINE RegressorColumns::RegressorColumns(const Robot& robot,
                                                std::span<const StandardParameter> parameters)
    : size_(static_cast<Index>(parameters.size())), motors_(robot.joints.size()) {
  detail::require_parameters(robot, parameters);
  detail::LinkTree tree = detail::link_tree(robot.chain);
  dependence_ = std::move(tree.dependence);
  const std::size_t n = tree.order.size();
  std::vector<std::size_t> links(n);  // place in the tree of each of the robot's links
  for (std::size_t k = 0; k < n; ++k) {
    links[tree.order[k]] = k;
  }
  columns_.resize(n);
  // Place of column k of frame j in the row of each joint on the way to it, −1 where it is not wanted.
  std::array<Index, inertial_count> none{};
  none.fill(-1);
  std::vector<std::vector<std::array<Index, inertial_count>>> places(n);
  std::vector<std::vector<std::size_t>> paths(n);
  for (std::size_t j = 0; j < n; ++j) {
    paths[j] = tree.chain.path(j);
    places[j].assign(paths[j].size(), none);
  }
  std::vector<std::vector<std::pair<detail::OwnEntry, Entry>>> own(n);
  for (std::size_t c = 0; c < parameters.size(); ++c) {
    const auto [kind, joint] = parameters[c];
    const std::size_t j = links[static_cast<std::size_t>(joint)];
    const auto same = [&](const StandardParameter& p) { return p.kind == kind && p.joint == joint; };
    if (std::ranges::any_of(parameters.first(c), same)) {
      throw InputError("RegressorColumns: " + parameters[c].name() + " occurs twice, must occur once");
    }
    const auto column = static_cast<Index>(c);
    if (const Coupling* const coupling = detail::coupling_of(robot, parameters[c])) {
      add_coupled(robot, *coupling, parameters[c], column, links);
    } else if (role(kind) != Role::inertial) {
      own[j].push_back({{static_cast<int>(j), about(kind).basis, about(kind).direction,
                         robot.joints[static_cast<std::size_t>(joint)].sign_speed},
                        {j, static_cast<Index>(columns_[j].size())}});
      columns_[j].push_back(column);
    } else {
      const auto k = static_cast<std::size_t>(inertial_column(tree.chain.links[j], kind).index);
      for (std::size_t i = 0; i < paths[j].size(); ++i) {
        std::vector<Index>& felt = columns_[paths[j][i]];
        places[j][i][k] = static_cast<Index>(felt.size());
        felt.push_back(column);
      }
    }
  }
  const std::vector<int> forks = tree.chain.forks();
  for (std::size_t j = 0; j < n; ++j) {
    unsigned mask = 0;
    for (std::size_t i = 0; i < paths[j].size(); ++i) {
      for (std::size_t k = 0; k < inertial_count; ++k) {
        if (places[j][i][k] >= 0) {
          entries_.push_back({paths[j][i], places[j][i][k]});
          mask |= 1U << k;
        }
      }
    }
    links_.push_back(detail::link_plan(tree.chain, j, mask));
    links_.back().fork = forks[j];
    forks_ += forks[j] >= 0 ? 1U : 0U;
  }
  for (const auto& of_joint : own) {
    for (const auto& [entry, place] : of_joint) {
      own_.push_back(entry);
      entries_.push_back(place);
    }
  }
  if (!dependence_.empty()) {
    fold(robot, links);
  }
}

#endif

}  // namespace rivid
