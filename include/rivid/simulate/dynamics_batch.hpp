#pragma once

#include <optional>
#include <vector>

#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/dynamics.hpp"

namespace rivid {

namespace detail {
struct DynamicsBatchKernel;
}

/// Where M(q) of a batch of samples is not positive definite.
struct IndefiniteMass {
  Index sample = 0;
  Index joint = 0;  ///< counted from 0, see Dynamics::failed_joint()
};

/// Direct dynamics of many samples at once, q̈ = M⁻¹ (τ − N): several samples in the lanes of a vector
/// register, by the widest instruction set of the machine, which is chosen when the program runs.
///
/// It has scratch: each thread needs one of its own. The model need not outlive the constructor.
class DynamicsBatch {
 public:
  /// @throws InputError  the model's complaint(); where the machine has not the instruction set asked for
  explicit DynamicsBatch(const ModelData& model, Simd simd = Simd::best);

  [[nodiscard]] Index joints() const { return one_.size(); }
  /// The instruction set in use, never `best`.
  [[nodiscard]] Simd simd() const { return simd_; }

  /// Accelerations without friction: whoever knows its torques, by friction_torque() or by what holds a
  /// joint, takes them off `tau`. No allocation.
  ///
  /// @param q    (n_m × n) [rad | m]
  /// @param qd   (n_m × n) [rad/s | m/s]
  /// @param tau  (n_m × n) [N·m | N]
  /// @param qdd  (n_m × n), overwritten: all rows, or those before the sample that is returned [rad/s² |
  ///             m/s²]
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
