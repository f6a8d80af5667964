#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "rivid/regressor/kinematics.hpp"
#include "rivid/regressor/pack.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

namespace detail {

// All lanes of a comparison; see BasicPack::Mask for packs.
inline bool all(bool condition) { return condition; }

}  // namespace detail

/// M(q) and N(q, q̇) of Eq. (21) of [RIV] at one state, M factored:
///
///   M(q) q̈ + N(q, q̇) = τ − friction.
///
/// Scratch is made once; no member allocates afterwards. A thread has one of its own; the model is only read, and need
/// not outlive the constructor.
///
/// @tparam Scalar  double, float, Pack (as many samples at once as it has lanes), or any number type with + − × /,
///                 comparison, sin and cos
template <typename Scalar>
class Dynamics {
 public:
  explicit Dynamics(const DynamicModel& model);

  [[nodiscard]] Index size() const { return static_cast<Index>(n_); }

  /// Fills M, N and the factor of M.
  ///
  /// Whether M is positive definite shows in the factor: one of its pivots, the inertia that a joint feels while all
  /// joints behind it are free, is not positive, or less than rounding leaves of M(j, j). M and N are right even then.
  ///
  /// @param q   positions, (n) [rad | m]
  /// @param qd  velocities, (n) [rad/s | m/s]
  /// @return    whether M is positive definite, in all lanes; else failed_joint() tells where not, and solve() must
  ///            not be called
  [[nodiscard]] bool set_state(std::span<const Scalar> q, std::span<const Scalar> qd);

  /// Coriolis, centrifugal and gravity torques without any friction, (n) [N·m | N].
  [[nodiscard]] std::span<const Scalar> N() const { return N_; }

  /// Entry of M, symmetric, rotors included [kg·m² | kg·m | kg].
  [[nodiscard]] const Scalar& M(Index i, Index j) const {
    return M_[static_cast<std::size_t>(std::max(i, j)) * n_ + static_cast<std::size_t>(std::min(i, j))];
  }

  /// b ← M⁻¹ b, (n).
  void solve(std::span<Scalar> b) const;

  /// The joint, counted from 0, whose pivot is not positive after set_state() returned false; −1 after true.
  [[nodiscard]] Index failed_joint() const { return failed_joint_; }

 private:
  bool factor();

  std::size_t n_;
  Chain chain_;
  std::vector<Inertial> inertials_;
  Matrix rotor_;
  std::vector<detail::Screw<Scalar>> screws_;
  std::vector<Scalar> M_;  // lower triangle, row by row
  std::vector<Scalar> L_;  // M = Lᵀ D L, L unit lower triangular
  std::vector<Scalar> inverse_D_;
  std::vector<Scalar> N_;
  Index failed_joint_ = -1;
};

template <typename Scalar>
Dynamics<Scalar>::Dynamics(const DynamicModel& model)
    : n_(static_cast<std::size_t>(model.size())),
      chain_(model.chain()),
      inertials_(model.inertials()),
      rotor_(model.rotor()),
      screws_(n_),
      M_(n_ * n_),
      L_(n_ * n_),
      inverse_D_(n_),
      N_(n_) {}

template <typename Scalar>
bool Dynamics<Scalar>::set_state(std::span<const Scalar> q, std::span<const Scalar> qd) {
  using namespace detail;
  const Scalar zero(0);
  for (std::size_t i = 0; i < n_; ++i) {
    N_[i] = zero;
    for (std::size_t k = 0; k <= i; ++k) {
      M_[i * n_ + k] = Scalar(rotor_(static_cast<Index>(i), static_cast<Index>(k)));
    }
  }
  FrameMotion<Scalar> motion = base_motion<Scalar>(chain_);
  for (std::size_t j = 0; j < n_; ++j) {
    const Passage<Scalar> passage(chain_.links[j], q[j]);
    for (std::size_t i = 0; i < j; ++i) {
      screws_[i] = passage.carried(screws_[i]);
    }
    screws_[j] = passage.own_screw();
    motion = passage.carried(motion, qd[j], zero);

    const auto parameter = [&](int k) { return Scalar(inertials_[j][k]); };
    const Mat3<Scalar> I = {{parameter(0), parameter(1), parameter(2)},
                            {parameter(1), parameter(3), parameter(4)},
                            {parameter(2), parameter(4), parameter(5)}};
    const Vec3<Scalar> h = {parameter(6), parameter(7), parameter(8)};
    const Scalar m = parameter(9);
    const auto scaled = [&](const Vec3<Scalar>& v) { return Vec3<Scalar>{m * v.x, m * v.y, m * v.z}; };
    const Vec3<Scalar> force = scaled(motion.accel) + acceleration_field(motion).times(h);
    const Vec3<Scalar> moment =
        I.times(motion.omega_dot) + cross(motion.omega, I.times(motion.omega)) + cross(h, motion.accel);
    for (std::size_t i = 0; i <= j; ++i) {
      const Screw<Scalar>& s = screws_[i];
      N_[i] = N_[i] + dot(s.v, force) + dot(s.w, moment);
      const Vec3<Scalar> linear = scaled(s.v) + cross(s.w, h);
      const Vec3<Scalar> angular = I.times(s.w) + cross(h, s.v);
      for (std::size_t k = 0; k <= i; ++k) {
        M_[i * n_ + k] = M_[i * n_ + k] + dot(screws_[k].v, linear) + dot(screws_[k].w, angular);
      }
    }
  }
  return factor();
}

template <typename Scalar>
bool Dynamics<Scalar>::factor() {
  using detail::all;
  const Scalar zero(0);
  const Scalar rounding(static_cast<double>(n_) * std::numeric_limits<double>::epsilon());
  failed_joint_ = -1;
  L_ = M_;
  for (std::size_t k = n_; k-- > 0;) {
    Scalar* const row = &L_[k * n_];
    if (!all(row[k] - rounding * M_[k * n_ + k] > zero)) {
      failed_joint_ = static_cast<Index>(k);
      return false;
    }
    inverse_D_[k] = Scalar(1) / row[k];
    for (std::size_t i = 0; i < k; ++i) {
      const Scalar l = row[i] * inverse_D_[k];
      for (std::size_t j = 0; j <= i; ++j) {
        L_[i * n_ + j] = L_[i * n_ + j] - l * row[j];
      }
    }
    for (std::size_t i = 0; i < k; ++i) {
      row[i] = row[i] * inverse_D_[k];
    }
  }
  return true;
}

template <typename Scalar>
void Dynamics<Scalar>::solve(std::span<Scalar> b) const {
  for (std::size_t k = n_; k-- > 0;) {
    for (std::size_t i = 0; i < k; ++i) {
      b[i] = b[i] - L_[k * n_ + i] * b[k];
    }
  }
  for (std::size_t k = 0; k < n_; ++k) {
    b[k] = b[k] * inverse_D_[k];
    for (std::size_t i = 0; i < k; ++i) {
      b[k] = b[k] - L_[k * n_ + i] * b[i];
    }
  }
}

extern template class Dynamics<double>;

/// M(q) of Eq. (21) of [RIV], links and rotors, (n × n) [kg·m² | kg·m | kg].
///
/// @param q  (n) [rad | m]
/// @throws InputError  where a size differs
[[nodiscard]] Matrix mass_matrix(const DynamicModel& model, const Eigen::Ref<const Vector>& q);

/// N(q, q̇) of Eq. (21) of [RIV]: Coriolis, centrifugal and gravity torques without any friction, (n) [N·m | N].
///
/// @param q   (n) [rad | m]
/// @param qd  (n) [rad/s | m/s]
/// @throws InputError  where a size differs
[[nodiscard]] Vector bias(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                          const Eigen::Ref<const Vector>& qd);

/// Friction torques of a motion, viscous q̇ + offset + Σ torque_e λ_e, (n) [N·m | N].
///
/// Elements at rest are silent, as sign(0) = 0 in the regressor. What they hold depends on the other torques.
///
/// @param qd  (n) [rad/s | m/s]
/// @throws InputError  where a size differs
[[nodiscard]] Vector friction_torque(const DynamicModel& model, const Eigen::Ref<const Vector>& qd);

/// τ = M q̈ + N + friction_torque(), (n) [N·m | N]: Eq. (1) of [RIV] with numbers, the torques of the regressor.
///
/// @param q    (n) [rad | m]
/// @param qd   (n) [rad/s | m/s]
/// @param qdd  (n) [rad/s² | m/s²]
/// @throws InputError  where a size differs
[[nodiscard]] Vector inverse_dynamics(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                                      const Eigen::Ref<const Vector>& qd,
                                      const Eigen::Ref<const Vector>& qdd);

/// q̈ = M⁻¹ (τ − N − friction_torque()), Eq. (21) of [RIV], (n) [rad/s² | m/s²], the inverse of inverse_dynamics().
///
/// Away from rest this is the motion; a joint at rest moves as if it had no Coulomb friction, so whoever integrates
/// through reversals must say which joints stick.
///
/// @param q    (n) [rad | m]
/// @param qd   (n) [rad/s | m/s]
/// @param tau  (n) [N·m | N]
/// @throws InputError  where a size differs
/// @throws NumericsError  where M is not positive definite, with joint and eigenvalue
[[nodiscard]] Vector direct_dynamics(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                                     const Eigen::Ref<const Vector>& qd, const Eigen::Ref<const Vector>& tau);

/// Smallest eigenvalue of M(q), for messages about an M that is not positive definite. (Where revolute and prismatic
/// joints meet, its size depends on the units, its sign does not.)
///
/// @param q  (n) [rad | m]
/// @throws InputError  where a size differs
[[nodiscard]] double smallest_eigenvalue(const DynamicModel& model, const Eigen::Ref<const Vector>& q);

}  // namespace rivid
