#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/model/chain.hpp"
#include "rivid/regressor/regressor.hpp"
#include "rivid/simulate/dynamics_kernel.hpp"
#include "rivid/text.hpp"

namespace rivid {

/// Friction along one direction of the joint velocities that is no matter of the viscous matrix alone: of a
/// joint, or of a motor that several joints turn.
///
/// At the speed s = directionᵀ q̇ it brakes with λ(s) = Σ c φ(s, sign s) over its terms, which have a
/// coefficient c for each direction of motion, and at rest with whatever −Fc_minus ≤ λ ≤ Fc_plus holds it
/// there; the torques on the joints are −torque λ. The two vectors are the same but for
/// Coupling::Coulomb::single.
///
/// Friction of a single joint may follow its load as well, by load |τ_load| sign s with τ_load = (M q̈ +
/// N)_j. Since the rotors are part of M, each joint's τ_load follows from its own torque: see carried().
struct DryFriction {
  /// Coefficients of one function while the speed is positive, and while it is negative; ≥ 0. Of
  /// Basis::speed, what a direction has beyond the other one, which is in DynamicModel::viscous().
  struct Term {
    Basis basis = Basis::sign;
    double plus = 0.0;
    double minus = 0.0;
  };

  std::string name;  ///< of the joint; of a motor that several joints turn, "motor of <joint>"
  Vector direction;  ///< c, (n)
  Vector torque;     ///< b, (n)
  std::vector<Term> terms;
  double Fc_plus = 0.0;   ///< λ where a positive speed begins, dry(true, 0, 1) [N·m | N], ≥ 0
  double Fc_minus = 0.0;  ///< −λ where a negative one begins [N·m | N], ≥ 0
  /// Joint::sign_speed: where it is not 0, tanh(s / sign_speed) takes the place of sign s, and nothing
  /// sticks.
  double sign_speed = 0.0;
  double load = 0.0;  ///< Fl, from 0 to below 1, of a joint whose friction follows its load; not part of λ

  /// The joint that friction with `load` belongs to.
  [[nodiscard]] Index joint() const {
    Index j = 0;
    while (direction[j] == 0.0) {
      ++j;
    }
    return j;
  }
  /// τ_load = M q̈ + N that a torque carries which is left when all other friction has been taken off: the
  /// solution of τ_load + slope |τ_load| = driving.
  ///
  /// @param slope  load × sign of the speed
  template <typename Scalar>
  [[nodiscard]] static Scalar carried(const Scalar& driving, const Scalar& slope) {
    return driving / (Scalar(1.0) + select(driving > Scalar(0.0), slope, Scalar(-slope)));
  }

  /// What follows the sign in λ, of one direction of motion. `sign`: ±1, or what smooths it. `plus` is a
  /// bool, or what a comparison of this Scalar gives.
  template <typename Scalar, typename Condition>
  [[nodiscard]] Scalar dry(const Condition& plus, const Scalar& speed, const Scalar& sign) const {
    return sum(plus, speed, sign, true);
  }
  /// What follows the speed in λ, of one direction of motion.
  template <typename Scalar, typename Condition>
  [[nodiscard]] Scalar viscous(const Condition& plus, const Scalar& speed) const {
    return sum(plus, speed, Scalar(select(plus, Scalar(1.0), Scalar(-1.0))), false);
  }
  /// λ of a speed, with `smallest` for a sign_speed of 0; 0 is the sign itself, and silent at rest.
  template <typename Scalar>
  [[nodiscard]] Scalar lambda(const Scalar& speed, double smallest = 0.0) const {
    const auto plus = speed > Scalar(0.0);
    return dry(plus, speed, sign(speed, sign_speed > 0.0 ? sign_speed : smallest)) + viscous(plus, speed);
  }

 private:
  template <typename Scalar, typename Condition>
  [[nodiscard]] Scalar sum(const Condition& plus, const Scalar& speed, const Scalar& sign,
                           bool of_dry) const {
    Scalar out(0.0);
    for (const Term& term : terms) {
      if ((about(term.basis).role == Role::dry) == of_dry) {
        out = out + select(plus, Scalar(term.plus), Scalar(term.minus)) *
                        friction_function(term.basis, speed, sign);
      }
    }
    return out;
  }
};

/// What a controller has of a robot: the numbers of its dynamics (21) of [RIV],
///
///   M(q) q̈ + N(q, q̇) + viscous q̇ + offset + Σ torque_e λ_e = τ,   M(q) = M_links(q) + rotor,
///
/// where λ_e of friction that follows the load grows by DryFriction::load |M q̈ + N|.
///
/// A DynamicModel makes them from a robot and its identified parameters; a controller may as well fill them
/// by itself. One entry a joint everywhere, but for `inertials`: joints that depend on others have none.
struct ModelData {
  Chain chain;
  std::vector<std::string> names;   ///< of the joints, for messages
  std::vector<Inertial> inertials;  ///< of the links in the frames j of the chain
  Matrix
      rotor;  ///< what rotors add to M(q): Ia on the diagonal, Iam of coupled motors, symmetric [kg·m² | kg]
  Matrix viscous;  ///< Fv on the diagonal, Fvm of coupled motors, symmetric, positive semidefinite
  Vector offset;   ///< friction offsets [N·m | N]
  std::vector<DryFriction> dry_friction =
      {};  ///< friction that is not in proportion to the velocities, if any

  [[nodiscard]] Index size() const { return chain.joints(); }

  /// The first fault found, in words that name the member; nothing if dynamics can be made of it.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

namespace detail {

// What the kernels read of a model.
struct DynamicsTables {
  /// @throws InputError  the model's complaint()
  explicit DynamicsTables(const ModelData& model);

  std::vector<DynamicsLink> links;  // in the order of the tree, with those of dependent joints
  std::vector<int> parents;         // of the links, −1 for the base
  Dependence dependence;
  std::array<double, 3> accel{};
  std::array<double, 3> base{};
  std::vector<double> rotor;
  std::size_t forks = 0;

  [[nodiscard]] DynamicsPlan plan() const {
    return {
        links.data(), links.size(), {accel[0], accel[1], accel[2]}, rotor.data(), {base[0], base[1], base[2]},
        forks};
  }
};

// The frames of these links at some positions, for sweeps over single samples.
template <typename Scalar>
class JointFrames {
 public:
  explicit JointFrames(const ModelData& model)
      : tables_(model), turns(tables_.links.size()), origins(tables_.links.size()) {
    for (std::size_t j = 0; j < size(); ++j) {
      origins[j] = constant<Scalar>(link(j).p);
    }
  }

  [[nodiscard]] std::size_t size() const noexcept { return tables_.links.size(); }
  [[nodiscard]] const DynamicsLink& link(std::size_t j) const noexcept { return tables_.links[j]; }
  [[nodiscard]] std::size_t forks() const noexcept { return tables_.forks; }
  [[nodiscard]] const Dependence& dependence() const noexcept { return tables_.dependence; }

  void set(const Scalar* q) noexcept {
    for (std::size_t j = 0; j < size(); ++j) {
      CosSin<Scalar> angle = {Scalar(1.0), Scalar(0.0)};
      if (link(j).revolute) {
        sin_cos(q[j], angle.s, angle.c);
      } else {
        set_way(j, q[j]);
      }
      turns[j] = with_theta(link(j), angle);
    }
  }
  // Position of a prismatic joint.
  void set_way(std::size_t j, const Scalar& q) noexcept {
    const double* const R = link(j).R;
    origins[j] =
        constant<Scalar>(link(j).p) + scaled(q, Vec3<Scalar>{Scalar(R[2]), Scalar(R[5]), Scalar(R[8])});
  }

  // The link that carries link j, −1 for the base.
  [[nodiscard]] int parent(std::size_t j) const noexcept { return tables_.parents[j]; }

  // A vector of the frame that carries link j in the axes of frame j, and back.
  [[nodiscard]] Vec3<Scalar> into(std::size_t j, const Vec3<Scalar>& v) const noexcept {
    return rotated(turned<Turn::any>(link(j).R, v), turns[j].c, turns[j].s);
  }
  [[nodiscard]] Vec3<Scalar> out_of(std::size_t j, const Vec3<Scalar>& v) const noexcept {
    return turned_back<Turn::any>(link(j).R, rotated_back(v, turns[j].c, turns[j].s));
  }
  // Acceleration of the base in the frame of a link on it, less that of free fall: the tables have it in the
  // first link's axes at θ = 0.
  [[nodiscard]] Vec3<Scalar> base_acceleration(std::size_t j) const noexcept {
    return j == 0 ? rotated(constant<Scalar>(tables_.accel.data()), turns[0].c, turns[0].s)
                  : into(j, constant<Scalar>(tables_.base.data()));
  }

 private:
  DynamicsTables tables_;

 public:
  std::vector<CosSin<Scalar>> turns;  // of the joints, constant angles included
  std::vector<Vec3<Scalar>> origins;  // of frame j in the frame that carries it
};

}  // namespace detail

/// M(q) and N(q, q̇) of Eq. (21) of [RIV] at one state, M factored:
///
///   M(q) q̈ + N(q, q̇) = τ − friction.
///
/// Members check neither sizes nor indices: wrong ones are undefined behaviour. Scratch is made once; no
/// member allocates afterwards. A thread has one of its own; the model is only read, and need not outlive the
/// constructor.
///
/// @tparam Scalar  double, float, Pack (as many samples at once as it has lanes), or any number type with + −
///                 × /, comparison, sin and cos
template <typename Scalar>
class Dynamics {
 public:
  /// @throws InputError  the model's complaint()
  explicit Dynamics(const ModelData& model);

  [[nodiscard]] Index size() const { return static_cast<Index>(n_); }

  /// Fills M, N and the factor of M.
  ///
  /// Whether M is positive definite shows in the factor: one of its pivots, the inertia that a joint feels
  /// while all joints behind it are free, is not positive, or less than rounding leaves of M(j, j). M and N
  /// are right even then.
  ///
  /// @param q   positions, (n) [rad | m]
  /// @param qd  velocities, (n) [rad/s | m/s]
  /// @return    whether M is positive definite, in all lanes; else failed_joint() says where not, and solve()
  ///            must not be called
  [[nodiscard]] bool set_state(std::span<const Scalar> q, std::span<const Scalar> qd);

  /// Coriolis, centrifugal and gravity torques without any friction, (n) [N·m | N].
  [[nodiscard]] std::span<const Scalar> N() const { return N_; }

  /// Entry of M, symmetric, rotors included [kg·m² | kg·m | kg].
  [[nodiscard]] const Scalar& M(Index i, Index j) const {
    const auto r = static_cast<std::size_t>(size() - 1 - std::min(i, j));
    return M_[r * stride_ + static_cast<std::size_t>(size() - 1 - std::max(i, j))];
  }

  /// b ← M⁻¹ b, (n).
  void solve(std::span<Scalar> b) const;

  /// The joint, counted from 0, whose pivot is not positive after set_state() returned false; −1 after true.
  [[nodiscard]] Index failed_joint() const { return failed_joint_; }

 private:
  void fold();

  std::size_t n_;
  detail::DynamicsTables tables_;
  std::size_t links_;
  std::size_t stride_;
  std::vector<Scalar> angles_;
  std::vector<detail::Wrench<Scalar>> own_;
  std::vector<Scalar> wrenches_;
  std::vector<detail::DynamicsFork<Scalar>> forks_;
  std::vector<Scalar> fork_wrenches_;
  std::vector<Scalar> M_;  // see dynamics_stride()
  std::vector<Scalar> L_;
  std::vector<Scalar> inverse_D_;
  std::vector<Scalar> N_;
  std::vector<Scalar> of_links_;  // where joints depend on others: q and q̇ of all links, M and N
  Index failed_joint_ = -1;
};

template <typename Scalar>
Dynamics<Scalar>::Dynamics(const ModelData& model)
    : n_(static_cast<std::size_t>(model.size())),
      tables_(model),
      links_(tables_.links.size()),
      stride_(detail::dynamics_stride(links_)),
      angles_(2 * (links_ + 1), Scalar(0)),
      own_(links_),
      wrenches_(6 * stride_, Scalar(0)),
      forks_(tables_.forks),
      fork_wrenches_(tables_.forks * 6 * stride_, Scalar(0)),
      M_(n_ * stride_, Scalar(0)),
      L_(n_ * stride_, Scalar(0)),
      inverse_D_(n_, Scalar(0)),
      N_(n_, Scalar(0)),
      of_links_(tables_.dependence.empty() ? 0 : tables_.dependence.memory(1) + links_ * (1 + stride_),
                Scalar(0)) {}

// M = Gᵀ M_all G and N = Gᵀ (N_all + M_all Ġ q̇).
template <typename Scalar>
void Dynamics<Scalar>::fold() {
  const detail::Dependence& dependence = tables_.dependence;
  const Scalar* const all = of_links_.data();
  const Scalar* const mass = all + dependence.memory(1);
  const auto mass_at = [&](int a, int b) {
    return mass[(links_ - 1 - static_cast<std::size_t>(std::min(a, b))) * stride_ + links_ - 1 -
                static_cast<std::size_t>(std::max(a, b))];
  };
  Scalar* const bias = of_links_.data() + dependence.memory(1) + links_ * stride_;
  for (int a = 0; dependence.bends() && a < static_cast<int>(links_); ++a) {
    for (int b = 0; b < static_cast<int>(links_); ++b) {
      bias[a] = bias[a] + mass_at(a, b) * all[2 * links_ + static_cast<std::size_t>(b)];
    }
  }
  dependence.fold<Scalar>(bias, n_, all, N_.data());
  std::ranges::fill(M_, Scalar(0.0));
  for (std::size_t s = 0; s < dependence.terms.size(); ++s) {
    for (std::size_t t = 0; t < dependence.terms.size(); ++t) {
      const detail::Dependence::Term& a = dependence.terms[s];
      const detail::Dependence::Term& b = dependence.terms[t];
      if (a.joint <= b.joint) {
        Scalar& sum = M_[(n_ - 1 - static_cast<std::size_t>(a.joint)) * stride_ + n_ - 1 -
                         static_cast<std::size_t>(b.joint)];
        sum = sum + dependence.slope(s, 1, 0, all) * dependence.slope(t, 1, 0, all) * mass_at(a.link, b.link);
      }
    }
  }
}

template <typename Scalar>
bool Dynamics<Scalar>::set_state(std::span<const Scalar> q, std::span<const Scalar> qd) {
  const detail::DynamicsScratch<Scalar> scratch = {
      angles_.data(), angles_.data() + links_ + 1, own_.data(), wrenches_.data(), stride_,
      forks_.data(),  fork_wrenches_.data()};
  if (tables_.dependence.empty()) {
    detail::mass_and_bias(tables_.plan(), q.data(), qd.data(), scratch, M_.data(), N_.data());
  } else {
    Scalar* const all = of_links_.data();
    tables_.dependence.expand<Scalar>({q.data(), qd.data(), nullptr}, 1, all);
    Scalar* const mass = all + tables_.dependence.memory(1);
    detail::mass_and_bias(tables_.plan(), all, all + links_, scratch, mass, mass + stride_ * links_);
    fold();
  }
  if (detail::factor(n_, stride_, M_.data(), L_.data(), inverse_D_.data(), wrenches_.data())) {
    failed_joint_ = -1;
    return true;
  }
  const std::size_t row = detail::failed_row(n_, stride_, M_.data(), inverse_D_.data());
  failed_joint_ = static_cast<Index>(n_ - 1 - row);
  return false;
}

template <typename Scalar>
void Dynamics<Scalar>::solve(std::span<Scalar> b) const {
  detail::solve_factored(n_, stride_, L_.data(), inverse_D_.data(), b.data());
}

#ifdef RIVID_LIBRARY
extern template class Dynamics<double>;
#endif

#ifdef RIVID_DEFINITIONS

namespace detail {

// Parameters in frame j that joint j turns or slides without showing it, by the rules of Gautier & Khalil
// (1990).
inline Inertial unseen(const Inertial& inertial, JointType type) {
  constexpr Index XX = 0, YY = 3, MZ = 8, M = 9;  // places in an Inertial
  Inertial out = Inertial::Zero();
  if (type == JointType::prismatic) {
    out.head<6>() = inertial.head<6>();
  } else {
    out[XX] = out[YY] = inertial[YY];
    out[MZ] = inertial[MZ];
    out[M] = inertial[M];
  }
  return out;
}

struct DynamicsBodies {
  Chain chain;
  std::vector<Inertial> inertials;
};

// The same robot in frames that are turned about their own z axes, so that the z axis of each lies in the y-z
// plane of the one before: no joint notices, and rotations between frames become R = Rx(α) Rz(θ). A frame
// that carries several links can not please all.
inline DynamicsBodies turned_about_z(const LinkTree& tree, const std::vector<Inertial>& of_links) {
  DynamicsBodies out{tree.chain, {}};
  for (const std::size_t j : tree.order) {
    out.inertials.push_back(of_links[j]);
  }
  std::vector<int> carried(out.chain.links.size() + 1, 0);
  for (std::size_t j = 0; j < out.chain.links.size(); ++j) {
    ++carried[static_cast<std::size_t>(Index{out.chain.parent(j)} + 1)];
  }
  for (std::size_t j = 0; j < out.chain.links.size(); ++j) {
    Chain::Link& link = out.chain.links[j];
    const int parent = out.chain.parent(j);
    if (frame_case(link).turn != Turn::any || carried[static_cast<std::size_t>(Index{parent} + 1)] > 1) {
      continue;
    }
    // Frame j−1 turns until the axis of joint j has no x component.
    const Eigen::Vector3d z = link.R.col(2);
    const double length = z.head<2>().norm();
    const double c = z.y() / length;
    const double s = -z.x() / length;
    const Eigen::Matrix3d back = (Eigen::Matrix3d() << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0).finished();
    link.R = product(back, link.R);
    link.R(0, 2) = 0.0;
    link.p = applied(back, link.p);
    if (parent < 0) {
      out.chain.gravity = applied(back, out.chain.gravity);
    } else {
      Chain::Link& carrier = out.chain.links[static_cast<std::size_t>(parent)];
      carrier.R = product(carrier.R, back.transpose());
      Inertial& inertial = out.inertials[static_cast<std::size_t>(parent)];
      inertial = transformed(inertial, back, Eigen::Vector3d::Zero());
    }
  }
  return out;
}

inline std::optional<std::string> element_complaint(const DryFriction& element, Index n) {
  if (element.direction.size() != n || element.torque.size() != n) {
    return "direction has " + counted(element.direction.size(), "value") + " and torque " +
           std::to_string(element.torque.size()) + ", must have " + std::to_string(n) + ", one a joint";
  }
  if (!element.direction.allFinite() || !element.torque.allFinite() || element.direction.isZero(0.0)) {
    return "direction and torque must be finite, and direction not zero";
  }
  for (const DryFriction::Term& term : element.terms) {
    if (static_cast<std::size_t>(term.basis) >= basis_rows.size() || !std::isfinite(term.plus) ||
        !std::isfinite(term.minus)) {
      return "the basis of each term must be one of Basis, and its coefficients finite";
    }
  }
  if (!std::isfinite(element.Fc_plus) || !std::isfinite(element.Fc_minus)) {
    return "Fc_plus is " + number(element.Fc_plus) + " and Fc_minus " + number(element.Fc_minus) +
           ", must be finite";
  }
  if (!(element.sign_speed >= 0.0) || std::isinf(element.sign_speed)) {
    return "sign_speed is " + number(element.sign_speed) + ", must be finite and not negative";
  }
  if (!(element.load >= 0.0 && element.load < 1.0)) {
    return "load is " + number(element.load) + ", must be at least 0 and below 1";
  }
  return std::nullopt;
}

RIVID_INLINE DynamicsTables::DynamicsTables(const ModelData& model) {
  if (const auto fault = model.complaint()) {
    throw InputError("ModelData: " + *fault);
  }
  LinkTree tree = link_tree(model.chain);
  auto [chain, inertials] = turned_about_z(tree, model.inertials);
  dependence = std::move(tree.dependence);
  const std::size_t n = chain.links.size();
  const std::vector<int> places = chain.forks();
  links.resize(n);
  parents.resize(n);
  Eigen::Vector3d::Map(base.data()) = -chain.gravity;
  bool with_mass = false;
  for (std::size_t j = n; j-- > 0;) {
    const Chain::Link& from = chain.links[j];
    DynamicsLink& to = links[j];
    const Inertial moved = unseen(inertials[j], from.type);
    inertials[j] -= moved;
    const int parent = chain.parent(j);
    if (parent >= 0) {
      inertials[static_cast<std::size_t>(parent)] += transformed(moved, from.R, from.p);
    }
    Inertial::Map(to.inertial) = inertials[j];

    parents[j] = parent;
    to.fork = places[j];
    forks += places[j] >= 0 ? 1U : 0U;
    to.from = parent + 1 == static_cast<int>(j) ? -1
              : parent < 0                      ? on_base
                                                : places[static_cast<std::size_t>(parent)];

    const FrameCase at = frame_case(from);
    static_cast<Frame&>(to) = at.frame;
    with_mass = with_mass || !to.revolute;
    to.step = !to.revolute ? prismatic_step : with_mass ? revolute_step : dynamics_step(at.turn, at.offsets);
    if (j == 0) {
      Eigen::Vector3d::Map(accel.data()) = applied(at.turned(), -chain.gravity);
    }
  }
  const std::size_t stride = dynamics_stride(n);
  rotor.assign(n * stride, 0.0);
  const auto joints = static_cast<std::size_t>(model.size());
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t k = 0; k <= r; ++k) {
      const std::size_t i = tree.order[n - 1 - r];
      const std::size_t j = tree.order[n - 1 - k];
      if (i < joints && j < joints) {
        rotor[r * stride + k] = model.rotor(static_cast<Index>(i), static_cast<Index>(j));
      }
    }
  }
}

}  // namespace detail

RIVID_INLINE std::optional<std::string> ModelData::complaint() const {
  const Index n = size();
  if (n < 1) {
    return "chain has no moving joint";
  }
  if (inertials.size() != chain.links.size()) {
    return "inertials has " + counted(std::ssize(inertials), "entry") + ", must have " +
           std::to_string(chain.links.size()) + ", one a " + (chain.dependents.empty() ? "joint" : "link");
  }
  for (const auto& [name, count] : std::to_array<std::pair<const char*, Index>>(
           {{"names", std::ssize(names)}, {"offset", offset.size()}})) {
    if (count != n) {
      return std::string(name) + " has " + counted(count, "entry") + ", must have " + std::to_string(n) +
             ", one a joint";
    }
  }
  for (const auto& [name, matrix] :
       std::to_array<std::pair<const char*, const Matrix*>>({{"rotor", &rotor}, {"viscous", &viscous}})) {
    if (matrix->rows() != n || matrix->cols() != n) {
      const std::string size = std::to_string(n);
      return std::string(name) + " is (" + std::to_string(matrix->rows()) + " x " +
             std::to_string(matrix->cols()) + "), must be (" + size + " x " + size + ")";
    }
  }
  if (auto fault = detail::gravity_complaint(chain.gravity)) {
    return fault;
  }
  if (auto fault = detail::order_complaint(chain)) {
    return fault;
  }
  for (std::size_t j = 0; j < inertials.size(); ++j) {
    const std::string& name = j < names.size() ? names[j] : chain.dependents[j - names.size()].joint;
    const std::string who = "joint \"" + name + "\": ";
    if (const auto fault = detail::frame_complaint(chain.links[j])) {
      return who + *fault;
    }
    if (!inertials[j].allFinite()) {
      return who + "its inertial parameters must be finite";
    }
  }
  if (!rotor.allFinite() || !viscous.allFinite() || !offset.allFinite()) {
    return "rotor, viscous and offset must be finite";
  }
  for (const DryFriction& element : dry_friction) {
    if (const auto fault = detail::element_complaint(element, n)) {
      return "dry_friction of \"" + element.name + "\": " + *fault;
    }
  }
  return std::nullopt;
}

#endif

}  // namespace rivid
