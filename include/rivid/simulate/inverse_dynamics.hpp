#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/simulate/dynamics.hpp"
#include "rivid/text.hpp"

namespace rivid {

/// How InverseDynamics goes about friction.
struct InverseDynamicsOptions {
  /// v_s of each joint, (n) [rad/s | m/s], positive: sign(q̇) becomes tanh(q̇ / v_s). The sign of a measured
  /// velocity flickers about rest with the noise of the encoder, and the torque with it. A motor that several
  /// joints turn takes Σ |c_k| v_s,k. Empty: sign(q̇) as it is identified, 0 at rest. What has a
  /// Joint::sign_speed keeps that one.
  Vector smoothing_speed = {};
};

/// Torques of a robot with numbers for its parameters, for the loop of a controller:
///
///   τ = M(q) q̈ + N(q, q̇) + friction(q̇),   Eq. (1) of [RIV].
///
/// Base parameters are all that it needs: give it a DynamicModel of them, or the numbers themselves.
/// Recursive Newton-Euler over links from which everything has been taken that their joints turn without
/// showing it, see DynamicModel for what it makes of friction that drives.
///
/// After the constructor no member allocates, throws or locks, provided that arguments are plain vectors,
/// columns, or maps of contiguous memory: Eigen::Ref copies what is not. Where a size is wrong the output is
/// filled with NaN, which every drive refuses. Scratch is in the object: a thread has a copy of its own,
/// which shares nothing with the others.
///
/// Positions, velocities and accelerations below 1e-102 (float: 1e-12) count as zero: a filter that decays
/// leaves denormal numbers behind, which take processors several times as long.
///
/// @tparam Scalar  double, float, or any number type with + − × /, comparison, sin, cos and tanh that Eigen
///                 knows
template <typename Scalar>
class BasicInverseDynamics {
 public:
  using Values = Eigen::Ref<const Eigen::VectorX<Scalar>>;
  using Result = Eigen::Ref<Eigen::VectorX<Scalar>>;

  /// The numbers are copied. Those of an identification or its result.json are identified_model() and
  /// read_identified_model(), which refuse what a controller should not have.
  ///
  /// @throws InputError  the model's complaint(); where an option can not be used
  explicit BasicInverseDynamics(const ModelData& model, const InverseDynamicsOptions& options = {});

  [[nodiscard]] Index size() const noexcept { return model_.size(); }

  /// τ = M(q) q̈ + N(q, q̇) + friction(q̇).
  ///
  /// @param q    (n) [rad | m]
  /// @param qd   (n) [rad/s | m/s]
  /// @param qdd  (n) [rad/s² | m/s²]
  /// @param tau  (n) [N·m | N]; none of the others' memory
  void torque(const Values& q, const Values& qd, const Values& qdd, Result tau) noexcept;

  /// M(q) q̈ + N(q, q̇), without friction, (n) [N·m | N].
  void rigid_body(const Values& q, const Values& qd, const Values& qdd, Result tau) noexcept;

  /// N(q, 0): what holds the robot against gravity, without friction, (n) [N·m | N].
  void gravity(const Values& q, Result tau) noexcept;

  /// N(q, q̇): Coriolis, centrifugal and gravity torques, without friction, (n) [N·m | N].
  void bias(const Values& q, const Values& qd, Result tau) noexcept;

  /// N(q, q̇) − N(q, 0), (n) [N·m | N].
  void coriolis(const Values& q, const Values& qd, Result tau) noexcept;

  /// Friction at these velocities, smoothed where the options say so, without what follows the load, (n) [N·m
  /// | N]. A feed-forward takes the velocities of the reference, which do not flicker; compensation of what
  /// is measured takes measured ones and a smoothing speed.
  void friction(const Values& qd, Result tau) const noexcept;

  /// M(q), rotors included, (n × n) [kg·m² | kg·m | kg].
  void M(const Values& q, Eigen::Ref<Eigen::MatrixX<Scalar>> M) noexcept;

 private:
  using Vec3 = detail::Vec3<Scalar>;
  using Mat3 = detail::Mat3<Scalar>;
  using Motion3 = detail::FrameMotion<Scalar>;
  using Wrench = detail::Wrench<Scalar>;
  using Link = detail::DynamicsLink;

  // What the link's motion takes. Of a revolute joint's link the tables have taken YY, of a prismatic one's
  // the tensor.
  [[nodiscard]] static Wrench wrench(const Link& link, const Motion3& m, const Mat3& U);

  // x without values that are too small to move a torque.
  [[nodiscard]] static const Eigen::VectorX<Scalar>& without_traces(const Values& x,
                                                                    Eigen::VectorX<Scalar>& out) noexcept {
    for (Index j = 0; j < out.size(); ++j) {
      out[j] = x[j];
      if constexpr (std::is_floating_point_v<Scalar>) {
        constexpr auto trace = static_cast<Scalar>(sizeof(Scalar) < sizeof(double) ? 1e-12 : 1e-102);
        out[j] = std::abs(x[j]) < trace ? Scalar(0) : x[j];
      }
    }
    return out;
  }

  // M q̈ + N without rotors; q̈ = 0 where qdd is null.
  void newton_euler(const Scalar* q, const Scalar* qd, const Scalar* qdd, Scalar* tau) noexcept;
  // Motion of all links' joints where joints depend on others.
  [[nodiscard]] detail::JointMotion<Scalar> of_links(detail::JointMotion<Scalar> motion) noexcept {
    if (of_links_.empty()) {
      return motion;
    }
    frames_.dependence().expand(motion, 1, of_links_.data());
    const Scalar* const all = of_links_.data();
    return {all, all + frames_.size(), all + 2 * frames_.size()};
  }
  // From the wrenches of the links to the torques of the joints.
  void sum_up(Scalar* tau) noexcept;
  template <typename... Sizes>
  [[nodiscard]] bool fits(Result& tau, Sizes... sizes) const noexcept;

  ModelData model_;
  detail::JointFrames<Scalar> frames_;  // checks the model, before what follows reads it
  Eigen::VectorX<Scalar> smoothing_;    // of each element of dry friction, zeros for none
  Dynamics<Scalar> dynamics_;           // for M
  std::vector<Wrench> wrenches_;        // of the links
  std::vector<detail::ForkState<Scalar>> forks_;
  std::vector<Scalar>
      of_links_;  // where joints depend on others: their motion, of all links; q is lost to the torques
  Eigen::VectorX<Scalar> at_rest_;  // zeros
  Eigen::VectorX<Scalar> scratch_;
  Eigen::VectorX<Scalar> q_;  // arguments without traces
  Eigen::VectorX<Scalar> qd_;
  Eigen::VectorX<Scalar> qdd_;
};

using InverseDynamics = BasicInverseDynamics<double>;

namespace detail {

// v_s of each element of dry friction, from those of the joints.
template <typename Scalar>
[[nodiscard]] Eigen::VectorX<Scalar> smoothing_of_elements(const ModelData& model, const Scalar* speeds) {
  Eigen::VectorX<Scalar> out(static_cast<Index>(model.dry_friction.size()));
  for (Index e = 0; e < out.size(); ++e) {
    out[e] = Scalar(0.0);
    for (Index j = 0; j < model.size(); ++j) {
      const double c = model.dry_friction[static_cast<std::size_t>(e)].direction[j];
      out[e] = out[e] + Scalar(std::abs(c)) * speeds[j];
    }
  }
  return out;
}

// The v_s that the options have for the joints, zeros for none.
[[nodiscard]] inline Vector smoothing_of(const ModelData& model, const Vector& speeds) {
  if (speeds.size() == 0) {
    return Vector::Zero(model.size());
  }
  if (speeds.size() != model.size()) {
    throw InputError("InverseDynamics: smoothing_speed has " + std::to_string(speeds.size()) +
                     " values, the robot has " + std::to_string(model.size()) + " joints");
  }
  for (Index j = 0; j < speeds.size(); ++j) {
    if (!std::isfinite(speeds[j]) || speeds[j] <= 0.0) {
      throw InputError("InverseDynamics: smoothing_speed of joint \"" +
                       model.names[static_cast<std::size_t>(j)] + "\" is " + number(speeds[j]) +
                       ", must be positive and finite; leave smoothing_speed empty for none");
    }
  }
  return speeds;
}

// tau += A x.
template <typename Scalar>
void add_product(const Matrix& A, const Scalar* x, Scalar* tau) noexcept {
  for (Index i = 0; i < A.rows(); ++i) {
    Scalar sum(0.0);
    for (Index j = 0; j < A.cols(); ++j) {
      sum = sum + Scalar(A(i, j)) * x[j];
    }
    tau[i] = tau[i] + sum;
  }
}

// One of two numbers that take long; only that one is made where the condition is a bool.
template <typename Condition, typename First, typename Second>
[[nodiscard]] auto chosen(const Condition& condition, const First& first, const Second& second) {
  if constexpr (std::is_same_v<Condition, bool>) {
    return condition ? first() : second();
  } else {
    return select(condition, first(), second());
  }
}

// sign(speed), or tanh(speed / v_s) where v_s is above zero.
template <typename Scalar>
[[nodiscard]] Scalar smooth_sign(const Scalar& speed, const Scalar& v_s) {
  using std::tanh;
  return chosen(
      v_s > Scalar(0.0), [&] { return Scalar(tanh(Scalar(speed / v_s))); },
      [&] { return rivid::sign(speed); });
}

// λ of friction along one direction, whose sign v_s smooths where that is above zero; at rest it is silent.
template <typename Scalar>
[[nodiscard]] Scalar smooth_lambda(const DryFriction& element, const Scalar& speed, const Scalar& v_s) {
  if (element.sign_speed > 0.0) {  // it was identified smooth
    return element.lambda(speed);
  }
  using std::tanh;
  const Scalar one(1.0);
  const Scalar half(0.5);
  const Scalar zero(0.0);
  const auto smooth = v_s > zero;
  const Scalar forward = chosen(
      smooth, [&] { return Scalar(half + half * tanh(Scalar(speed / v_s))); },
      [&] { return Scalar(select(speed > zero, one, zero)); });
  const Scalar backward = chosen(
      smooth, [&] { return Scalar(one - forward); }, [&] { return Scalar(select(speed < zero, one, zero)); });
  return element.dry(true, speed, one) * forward + element.dry(false, speed, Scalar(-one)) * backward +
         element.viscous(speed > zero, speed);
}

// Friction of a model without what follows the load; v_s of each element, zeros for the sign itself.
template <typename Scalar>
void friction_of(const ModelData& model, const Scalar* qd, const Scalar* v_s, Scalar* tau) noexcept {
  const Index n = model.size();
  for (Index j = 0; j < n; ++j) {
    tau[j] = Scalar(model.offset[j]);
  }
  add_product(model.viscous, qd, tau);
  for (const DryFriction& element : model.dry_friction) {
    Scalar speed(0.0);
    for (Index j = 0; j < n; ++j) {
      speed = speed + Scalar(element.direction[j]) * qd[j];
    }
    const Scalar lambda = smooth_lambda(element, speed, *v_s++);
    for (Index j = 0; j < n; ++j) {
      tau[j] = tau[j] + Scalar(element.torque[j]) * lambda;
    }
  }
}

// Adds friction that follows the load: tau is M q̈ + N.
template <typename Scalar>
void add_load_friction(const ModelData& model, const Scalar* tau, const Scalar* qd, const Scalar* v_s,
                       Scalar* friction) noexcept {
  using std::abs;
  for (const DryFriction& element : model.dry_friction) {
    if (element.load > 0.0) {
      const Index j = element.joint();
      const Scalar own = element.sign_speed > 0.0 ? Scalar(element.sign_speed) : *v_s;
      friction[j] = friction[j] + Scalar(element.load) * smooth_sign(qd[j], own) * Scalar(abs(tau[j]));
    }
    ++v_s;
  }
}

}  // namespace detail

template <typename Scalar>
BasicInverseDynamics<Scalar>::BasicInverseDynamics(const ModelData& model,
                                                   const InverseDynamicsOptions& options)
    : model_(model),
      frames_(model),
      smoothing_(
          detail::smoothing_of_elements(model, detail::smoothing_of(model, options.smoothing_speed).data())
              .template cast<Scalar>()),
      dynamics_(model),
      wrenches_(frames_.size()),
      forks_(frames_.forks()),
      of_links_(frames_.dependence().empty() ? 0 : frames_.dependence().memory(1), Scalar(0.0)),
      at_rest_(Eigen::VectorX<Scalar>::Zero(model.size())),
      scratch_(Eigen::VectorX<Scalar>::Zero(model.size())),
      q_(scratch_),
      qd_(scratch_),
      qdd_(scratch_) {}

template <typename Scalar>
auto BasicInverseDynamics<Scalar>::wrench(const Link& link, const Motion3& m, const Mat3& U) -> Wrench {
  const double* const I = link.inertial;
  const Vec3 h = detail::constant<Scalar>(I + 6);
  Wrench out = {U.times(h), detail::cross(h, m.accel)};
  if (link.revolute) {
    const auto moments = detail::TensorMoments<Scalar>::of(m, U);
    for (const int k : {0, 1, 2, 4, 5}) {
      out.n = out.n + detail::scaled(Scalar(I[k]), moments.k[k]);
    }
  }
  out.f = out.f + detail::scaled(Scalar(I[9]), m.accel);
  return out;
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::newton_euler(const Scalar* q, const Scalar* qd, const Scalar* qdd,
                                                Scalar* tau) noexcept {
  const detail::JointMotion<Scalar> motion = of_links({q, qd, qdd});
  q = motion.q;
  qd = motion.qd;
  qdd = motion.qdd;
  frames_.set(q);
  const Scalar zero(0.0);
  const Vec3 none = {zero, zero, zero};
  Motion3 m = {none, none, none};
  Mat3 U = {none, none, none};
  for (std::size_t j = 0; j < frames_.size(); ++j) {
    const Link& link = frames_.link(j);
    if (link.from >= 0) {
      m = forks_[static_cast<std::size_t>(link.from)].motion;
      U = forks_[static_cast<std::size_t>(link.from)].U;
    }
    if (frames_.parent(j) < 0) {
      m = {none, none, frames_.base_acceleration(j)};
    } else {
      m = {frames_.into(j, m.omega), frames_.into(j, m.omega_dot),
           frames_.into(j, m.accel + U.times(frames_.origins[j]))};
    }
    const Scalar acceleration = qdd != nullptr ? qdd[j] : zero;
    if (link.revolute) {
      m.omega_dot = m.omega_dot + Vec3{m.omega.y * qd[j], -m.omega.x * qd[j], acceleration};
      m.omega.z = m.omega.z + qd[j];
    } else {
      const Scalar twice(2.0);
      m.accel = m.accel + Vec3{twice * m.omega.y * qd[j], -(twice * m.omega.x * qd[j]), acceleration};
    }
    U = detail::acceleration_field(m);
    wrenches_[j] = wrench(link, m, U);
    if (link.fork >= 0) {
      forks_[static_cast<std::size_t>(link.fork)] = {m, U};
    }
  }
  sum_up(tau);
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::sum_up(Scalar* tau) noexcept {
  const bool independent = of_links_.empty();
  Scalar* const torques = independent ? tau : of_links_.data();
  for (std::size_t j = frames_.size(); j-- > 0;) {
    const Wrench& w = wrenches_[j];
    torques[j] = frames_.link(j).revolute ? w.n.z : w.f.z;
    if (const int parent = frames_.parent(j); parent >= 0) {
      Wrench& carrier = wrenches_[static_cast<std::size_t>(parent)];
      const Vec3 f = frames_.out_of(j, w.f);
      carrier.f = carrier.f + f;
      carrier.n = carrier.n + frames_.out_of(j, w.n) + detail::cross(frames_.origins[j], f);
    }
  }
  if (!independent) {
    frames_.dependence().fold(torques, static_cast<std::size_t>(size()), torques, tau);
  }
}

// Whether all sizes are right; else the result is no number.
template <typename Scalar>
template <typename... Sizes>
bool BasicInverseDynamics<Scalar>::fits(Result& tau, Sizes... sizes) const noexcept {
  if (tau.size() == size() && ((sizes == size()) && ...)) {
    return true;
  }
  tau.setConstant(Scalar(std::numeric_limits<double>::quiet_NaN()));
  return false;
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::torque(const Values& q, const Values& qd, const Values& qdd,
                                          Result tau) noexcept {
  if (!fits(tau, q.size(), qd.size(), qdd.size())) {
    return;
  }
  rigid_body(q, qd, qdd, tau);
  detail::friction_of(model_, qd_.data(), smoothing_.data(), scratch_.data());
  detail::add_load_friction(model_, tau.data(), qd_.data(), smoothing_.data(), scratch_.data());
  tau += scratch_;
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::rigid_body(const Values& q, const Values& qd, const Values& qdd,
                                              Result tau) noexcept {
  if (fits(tau, q.size(), qd.size(), qdd.size())) {
    newton_euler(without_traces(q, q_).data(), without_traces(qd, qd_).data(),
                 without_traces(qdd, qdd_).data(), tau.data());
    detail::add_product(model_.rotor, qdd_.data(), tau.data());
  }
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::gravity(const Values& q, Result tau) noexcept {
  if (!fits(tau, q.size())) {
    return;
  }
  frames_.set(of_links({without_traces(q, q_).data(), nullptr, nullptr}).q);
  Vec3 accel = {Scalar(0.0), Scalar(0.0), Scalar(0.0)};
  for (std::size_t j = 0; j < frames_.size(); ++j) {
    const Link& link = frames_.link(j);
    if (link.from >= 0) {
      accel = forks_[static_cast<std::size_t>(link.from)].motion.accel;
    }
    accel = frames_.parent(j) < 0 ? frames_.base_acceleration(j) : frames_.into(j, accel);
    if (link.fork >= 0) {
      forks_[static_cast<std::size_t>(link.fork)].motion.accel = accel;
    }
    const double* const I = frames_.link(j).inertial;
    wrenches_[j] = {detail::scaled(Scalar(I[9]), accel),
                    detail::cross(detail::constant<Scalar>(I + 6), accel)};
  }
  sum_up(tau.data());
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::bias(const Values& q, const Values& qd, Result tau) noexcept {
  if (fits(tau, q.size(), qd.size())) {
    newton_euler(without_traces(q, q_).data(), without_traces(qd, qd_).data(), nullptr, tau.data());
  }
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::coriolis(const Values& q, const Values& qd, Result tau) noexcept {
  gravity(q, scratch_);
  bias(q, qd, tau);
  if (tau.size() == size()) {
    tau -= scratch_;
  }
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::friction(const Values& qd, Result tau) const noexcept {
  if (fits(tau, qd.size())) {
    detail::friction_of(model_, qd.data(), smoothing_.data(), tau.data());
  }
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::M(const Values& q, Eigen::Ref<Eigen::MatrixX<Scalar>> M) noexcept {
  if (q.size() != size() || M.rows() != size() || M.cols() != size()) {
    M.setConstant(Scalar(std::numeric_limits<double>::quiet_NaN()));
    return;
  }
  const auto n = static_cast<std::size_t>(size());
  // Whether M is positive definite is for the caller to judge: it is right in either case.
  static_cast<void>(dynamics_.set_state({q.data(), n}, {at_rest_.data(), n}));
  for (Index j = 0; j < size(); ++j) {
    for (Index i = 0; i < size(); ++i) {
      M(i, j) = dynamics_.M(i, j);
    }
  }
}

#ifdef RIVID_LIBRARY
extern template class BasicInverseDynamics<double>;
#endif

}  // namespace rivid
