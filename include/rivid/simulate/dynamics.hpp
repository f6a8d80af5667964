#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics_kernel.hpp"

namespace rivid {

namespace detail {

// What the kernels read of a model.
struct DynamicsTables {
  explicit DynamicsTables(const DynamicModel& model);

  std::vector<DynamicsLink> links;
  std::array<double, 3> accel{};
  std::vector<double> rotor;

  [[nodiscard]] DynamicsPlan plan() const {
    return {links.data(), links.size(), {accel[0], accel[1], accel[2]}, rotor.data()};
  }
};

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
    const auto r = static_cast<std::size_t>(size() - 1 - std::min(i, j));
    return M_[r * stride_ + static_cast<std::size_t>(size() - 1 - std::max(i, j))];
  }

  /// b ← M⁻¹ b, (n).
  void solve(std::span<Scalar> b) const;

  /// The joint, counted from 0, whose pivot is not positive after set_state() returned false; −1 after true.
  [[nodiscard]] Index failed_joint() const { return failed_joint_; }

 private:
  std::size_t n_;
  std::size_t stride_;
  detail::DynamicsTables tables_;
  std::vector<Scalar> angles_;
  std::vector<detail::Wrench<Scalar>> own_;
  std::vector<Scalar> wrenches_;
  std::vector<Scalar> M_;  // see dynamics_stride()
  std::vector<Scalar> L_;
  std::vector<Scalar> inverse_D_;
  std::vector<Scalar> N_;
  Index failed_joint_ = -1;
};

template <typename Scalar>
Dynamics<Scalar>::Dynamics(const DynamicModel& model)
    : n_(static_cast<std::size_t>(model.size())),
      stride_(detail::dynamics_stride(n_)),
      tables_(model),
      angles_(2 * (n_ + 1), Scalar(0)),
      own_(n_),
      wrenches_(6 * stride_, Scalar(0)),
      M_(n_ * stride_, Scalar(0)),
      L_(n_ * stride_, Scalar(0)),
      inverse_D_(n_, Scalar(0)),
      N_(n_, Scalar(0)) {}

template <typename Scalar>
bool Dynamics<Scalar>::set_state(std::span<const Scalar> q, std::span<const Scalar> qd) {
  const detail::DynamicsScratch<Scalar> scratch = {angles_.data(), angles_.data() + n_ + 1, own_.data(),
                                                   wrenches_.data(), stride_};
  detail::mass_and_bias(tables_.plan(), q.data(), qd.data(), scratch, M_.data(), N_.data());
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

namespace detail {
struct DynamicsBatchKernel;
}

/// Where M(q) of a batch of samples is not positive definite.
struct IndefiniteMass {
  Index sample = 0;
  Index joint = 0;  ///< counted from 0, see Dynamics::failed_joint()
};

/// Direct dynamics of many samples at once, q̈ = M⁻¹ (τ − N): several samples in the lanes of a vector register, by the
/// widest instruction set of the machine, which is chosen when the program runs.
///
/// It has scratch: each thread needs one of its own. The model need not outlive the constructor.
class DynamicsBatch {
 public:
  /// @throws InputError  where the machine has not the instruction set asked for
  explicit DynamicsBatch(const DynamicModel& model, Simd simd = Simd::best);

  [[nodiscard]] Index joints() const { return one_.size(); }
  /// The instruction set in use, never `best`.
  [[nodiscard]] Simd simd() const { return simd_; }

  /// Accelerations without friction: whoever knows its torques, by friction_torque() or by what holds a joint, takes
  /// them off `tau`. No allocation.
  ///
  /// @param q    (n_m × n) [rad | m]
  /// @param qd   (n_m × n) [rad/s | m/s]
  /// @param tau  (n_m × n) [N·m | N]
  /// @param qdd  (n_m × n), overwritten: all rows, or those before the sample that is returned [rad/s² | m/s²]
  /// @return     the first sample whose M is not positive definite; nothing where all are
  /// @throws InputError  where a size differs
  std::optional<IndefiniteMass> accelerations(const Eigen::Ref<const Matrix>& q,
                                              const Eigen::Ref<const Matrix>& qd,
                                              const Eigen::Ref<const Matrix>& tau, Eigen::Ref<Matrix> qdd);

 private:
  Simd simd_;
  const detail::DynamicsBatchKernel* kernel_;
  detail::DynamicsTables tables_;
  detail::AlignedDoubles scratch_;
  detail::AlignedDoubles tail_;  // inputs and outputs of samples that fill no whole pack
  Dynamics<double> one_;         // for packs whose M is not positive definite in all lanes
  std::vector<double> state_;
};

}  // namespace rivid
