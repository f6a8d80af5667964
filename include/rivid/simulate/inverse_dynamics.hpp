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
  /// v_s of each joint, (n) [rad/s | m/s], positive: sign(q̇) becomes tanh(q̇ / v_s). The sign of a measured velocity
  /// flickers about rest with the noise of the encoder, and the torque with it. A motor that several joints turn takes
  /// Σ |c_k| v_s,k. Empty: sign(q̇) as it is identified, 0 at rest. What has a Joint::sign_speed keeps that one.
  Vector smoothing_speed = {};
};

/// Torques of a robot with numbers for its parameters, for the loop of a controller:
///
///   τ = M(q) q̈ + N(q, q̇) + friction(q̇),   Eq. (1) of [RIV].
///
/// Base parameters are all that it needs: give it a DynamicModel of them, or the numbers themselves. Recursive Newton-Euler over links from which everything has been taken that
/// their joints turn without showing it, see DynamicModel for what it makes of friction that drives.
///
/// After the constructor no member allocates, throws or locks, provided that arguments are plain vectors, columns, or
/// maps of contiguous memory: Eigen::Ref copies what is not. Where a size is wrong the output is filled with NaN, which
/// every drive refuses. Scratch is in the object: a thread has a copy of its own, which shares nothing with the others.
///
/// Positions, velocities and accelerations below 1e-102 (float: 1e-12) count as zero: a filter that decays leaves denormal
/// numbers behind, which take processors several times as long.
///
/// @tparam Scalar  double, float, or any number type with + − × /, comparison, sin, cos and tanh that Eigen knows
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

  [[nodiscard]] Index size() const noexcept { return static_cast<Index>(turns_.size()); }

  /// τ = M(q) q̈ + N(q, q̇) + friction(q̇).
  ///
  /// @param q    (n) [rad | m]
  /// @param qd   (n) [rad/s | m/s]
  /// @param qdd  (n) [rad/s² | m/s²]
  /// @param tau  (n) [N·m | N]; none of the others' memory
  void torque(const Values& q, const Values& qd, const Values& qdd, Result tau) noexcept;

  /// N(q, 0): what holds the robot against gravity, without friction, (n) [N·m | N].
  void gravity(const Values& q, Result tau) noexcept;

  /// N(q, q̇): Coriolis, centrifugal and gravity torques, without friction, (n) [N·m | N].
  void bias(const Values& q, const Values& qd, Result tau) noexcept;

  /// N(q, q̇) − N(q, 0), (n) [N·m | N].
  void coriolis(const Values& q, const Values& qd, Result tau) noexcept;

  /// Friction at these velocities, smoothed where the options say so, without what follows the load, (n) [N·m | N]. A feed-forward takes the velocities
  /// of the reference, which do not flicker; compensation of what is measured takes measured ones and a smoothing speed.
  void friction(const Values& qd, Result tau) const noexcept;

  /// M(q), rotors included, (n × n) [kg·m² | kg·m | kg].
  void M(const Values& q, Eigen::Ref<Eigen::MatrixX<Scalar>> M) noexcept;

 private:
  using Vec3 = detail::Vec3<Scalar>;
  using Mat3 = detail::Mat3<Scalar>;
  using Motion3 = detail::FrameMotion<Scalar>;
  using Wrench = detail::Wrench<Scalar>;
  using Link = detail::DynamicsLink;

  [[nodiscard]] static Vec3 times(double factor, const Vec3& v) {
    return {Scalar(factor) * v.x, Scalar(factor) * v.y, Scalar(factor) * v.z};
  }
  // Of friction along one direction, whose sign this speed smooths.
  [[nodiscard]] static Scalar dry(const DryFriction& element, const Scalar& speed, double smoothing);
  [[nodiscard]] static Scalar smooth_sign(const Scalar& speed, double smoothing);
  [[nodiscard]] double smoothing_of(std::size_t e) const {
    return smoothing_.size() > 0 ? smoothing_[static_cast<Index>(e)] : 0.0;
  }
  [[nodiscard]] static Vec3 origin(const Link& link, const Scalar& q);
  // What the link's motion takes. Of a revolute joint's link the tables have taken YY, of a prismatic one's the tensor.
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

  // A vector of frame j−1 in the axes of frame j.
  [[nodiscard]] Vec3 into_link(std::size_t j, const Vec3& v) const {
    return detail::rotated(detail::turned<detail::Turn::any>(tables_.links[j].R, v), turns_[j].c,
                           turns_[j].s);
  }
  void turn(const Scalar* q) noexcept;
  [[nodiscard]] Vec3 first_acceleration() const noexcept;
  // M q̈ + N without rotors; q̈ = 0 where qdd is null.
  void newton_euler(const Scalar* q, const Scalar* qd, const Scalar* qdd, Scalar* tau) noexcept;
  // From the wrenches of the links to the torques of the joints.
  void sum_up(const Scalar* q, Scalar* tau) noexcept;
  // tau += A x.
  void add_product(const Matrix& A, const Values& x, Result& tau) const noexcept;
  template <typename... Sizes>
  [[nodiscard]] bool fits(Result& tau, Sizes... sizes) const noexcept;

  ModelData model_;
  detail::DynamicsTables tables_;              // checks the model, before what follows reads it
  Vector smoothing_;                           // of each element of dry friction; empty: none
  Dynamics<Scalar> dynamics_;                  // for M
  std::vector<Wrench> wrenches_;               // of the links
  std::vector<detail::CosSin<Scalar>> turns_;  // of the joints
  Eigen::VectorX<Scalar> at_rest_;             // zeros
  Eigen::VectorX<Scalar> scratch_;
  Eigen::VectorX<Scalar> q_;  // arguments without traces
  Eigen::VectorX<Scalar> qd_;
  Eigen::VectorX<Scalar> qdd_;
};

using InverseDynamics = BasicInverseDynamics<double>;

namespace detail {

// v_s of each element of dry friction.
[[nodiscard]] inline Vector smoothing_of(const ModelData& model, const Vector& speeds) {
  if (speeds.size() == 0) {
    return {};
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
  Vector out(static_cast<Index>(model.dry_friction.size()));
  for (Index e = 0; e < out.size(); ++e) {
    out[e] = model.dry_friction[static_cast<std::size_t>(e)].direction.cwiseAbs().dot(speeds);
  }
  return out;
}

}  // namespace detail

template <typename Scalar>
BasicInverseDynamics<Scalar>::BasicInverseDynamics(const ModelData& model,
                                                   const InverseDynamicsOptions& options)
    : model_(model),
      tables_(model),
      smoothing_(detail::smoothing_of(model, options.smoothing_speed)),
      dynamics_(model),
      wrenches_(static_cast<std::size_t>(model.size())),
      turns_(static_cast<std::size_t>(model.size())),
      at_rest_(Eigen::VectorX<Scalar>::Zero(model.size())),
      scratch_(Eigen::VectorX<Scalar>::Zero(model.size())),
      q_(scratch_),
      qd_(scratch_),
      qdd_(scratch_) {}

template <typename Scalar>
Scalar BasicInverseDynamics<Scalar>::dry(const DryFriction& element, const Scalar& speed, double smoothing) {
  if (element.sign_speed > 0.0) {  // it was identified smooth
    return element.lambda(speed);
  }
  using std::tanh;
  const Scalar one(1.0);
  const Scalar half(0.5);
  const Scalar zero(0.0);
  const Scalar forward = smoothing > 0.0 ? Scalar(half + half * tanh(Scalar(speed / Scalar(smoothing))))
                                         : (speed > zero ? one : zero);
  const Scalar backward = smoothing > 0.0 ? Scalar(one - forward) : (speed < zero ? one : zero);
  return element.dry(true, speed, one) * forward + element.dry(false, speed, Scalar(-one)) * backward +
         element.viscous(speed > zero, speed);
}

template <typename Scalar>
Scalar BasicInverseDynamics<Scalar>::smooth_sign(const Scalar& speed, double smoothing) {
  using std::tanh;
  const Scalar zero(0.0);
  return smoothing > 0.0 ? Scalar(tanh(Scalar(speed / Scalar(smoothing))))
                         : Scalar(speed > zero   ? 1.0
                                  : speed < zero ? -1.0
                                                 : 0.0);
}

template <typename Scalar>
auto BasicInverseDynamics<Scalar>::origin(const Link& link, const Scalar& q) -> Vec3 {
  const Vec3 p = detail::constant<Scalar>(link.p);
  return link.revolute ? p : p + Vec3{Scalar(link.R[2]) * q, Scalar(link.R[5]) * q, Scalar(link.R[8]) * q};
}

template <typename Scalar>
auto BasicInverseDynamics<Scalar>::wrench(const Link& link, const Motion3& m, const Mat3& U) -> Wrench {
  const double* const I = link.inertial;
  const Vec3 h = detail::constant<Scalar>(I + 6);
  Wrench out = {U.times(h), detail::cross(h, m.accel)};
  if (link.revolute) {
    const auto moments = detail::TensorMoments<Scalar>::of(m, U);
    for (const int k : {0, 1, 2, 4, 5}) {
      out.n = out.n + times(I[k], moments.k[k]);
    }
  }
  out.f = out.f + times(I[9], m.accel);
  return out;
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::turn(const Scalar* q) noexcept {
  for (std::size_t j = 0; j < turns_.size(); ++j) {
    const Link& link = tables_.links[j];
    Scalar s(0.0);
    Scalar c(1.0);
    if (link.revolute) {
      detail::sin_cos(q[j], s, c);
    }
    turns_[j] = {c * Scalar(link.cos_theta) - s * Scalar(link.sin_theta),
                 s * Scalar(link.cos_theta) + c * Scalar(link.sin_theta)};
  }
}

// Acceleration of the first link's origin. The tables hold that of the base in the link's axes at θ = 0.
template <typename Scalar>
auto BasicInverseDynamics<Scalar>::first_acceleration() const noexcept -> Vec3 {
  return detail::rotated(detail::constant<Scalar>(tables_.accel.data()), turns_[0].c, turns_[0].s);
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::newton_euler(const Scalar* q, const Scalar* qd, const Scalar* qdd,
                                                Scalar* tau) noexcept {
  turn(q);
  const Scalar zero(0.0);
  Motion3 m = {{zero, zero, zero}, {zero, zero, zero}, first_acceleration()};
  Mat3 U = {m.omega, m.omega, m.omega};
  for (std::size_t j = 0; j < turns_.size(); ++j) {
    const Link& link = tables_.links[j];
    if (j > 0) {
      m = {into_link(j, m.omega), into_link(j, m.omega_dot),
           into_link(j, m.accel + U.times(origin(link, q[j])))};
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
  }
  sum_up(q, tau);
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::sum_up(const Scalar* q, Scalar* tau) noexcept {
  for (std::size_t j = turns_.size(); j-- > 0;) {
    const Link& link = tables_.links[j];
    const Wrench& w = wrenches_[j];
    tau[j] = link.revolute ? w.n.z : w.f.z;
    if (j > 0) {
      const auto back = [&](const Vec3& v) {
        return detail::turned_back<detail::Turn::any>(link.R,
                                                      detail::rotated_back(v, turns_[j].c, turns_[j].s));
      };
      const Vec3 f = back(w.f);
      wrenches_[j - 1].f = wrenches_[j - 1].f + f;
      wrenches_[j - 1].n = wrenches_[j - 1].n + back(w.n) + detail::cross(origin(link, q[j]), f);
    }
  }
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::add_product(const Matrix& A, const Values& x, Result& tau) const noexcept {
  for (Index i = 0; i < tau.size(); ++i) {
    Scalar sum(0.0);
    for (Index j = 0; j < x.size(); ++j) {
      sum = sum + Scalar(A(i, j)) * x[j];
    }
    tau[i] = tau[i] + sum;
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
  friction(without_traces(qd, qd_), scratch_);
  newton_euler(without_traces(q, q_).data(), qd_.data(), without_traces(qdd, qdd_).data(), tau.data());
  add_product(model_.rotor, qdd_, tau);
  for (std::size_t e = 0; e < model_.dry_friction.size(); ++e) {
    const DryFriction& element = model_.dry_friction[e];
    if (element.load > 0.0) {
      using std::abs;
      const Index j = element.joint();
      const Scalar sign =
          smooth_sign(qd_[j], element.sign_speed > 0.0 ? element.sign_speed : smoothing_of(e));
      scratch_[j] = scratch_[j] + Scalar(element.load) * sign * Scalar(abs(tau[j]));
    }
  }
  tau += scratch_;
}

template <typename Scalar>
void BasicInverseDynamics<Scalar>::gravity(const Values& q, Result tau) noexcept {
  if (!fits(tau, q.size())) {
    return;
  }
  turn(without_traces(q, q_).data());
  Vec3 accel = first_acceleration();
  for (std::size_t j = 0; j < turns_.size(); ++j) {
    accel = j > 0 ? into_link(j, accel) : accel;
    const double* const I = tables_.links[j].inertial;
    wrenches_[j] = {times(I[9], accel), detail::cross(detail::constant<Scalar>(I + 6), accel)};
  }
  sum_up(q_.data(), tau.data());
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
  if (!fits(tau, qd.size())) {
    return;
  }
  for (Index j = 0; j < size(); ++j) {
    tau[j] = Scalar(model_.offset[j]);
  }
  add_product(model_.viscous, qd, tau);
  for (std::size_t e = 0; e < model_.dry_friction.size(); ++e) {
    const DryFriction& element = model_.dry_friction[e];
    Scalar speed(0.0);
    for (Index j = 0; j < size(); ++j) {
      speed = speed + Scalar(element.direction[j]) * qd[j];
    }
    const Scalar lambda = dry(element, speed, smoothing_of(e));
    for (Index j = 0; j < size(); ++j) {
      tau[j] = tau[j] + Scalar(element.torque[j]) * lambda;
    }
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
