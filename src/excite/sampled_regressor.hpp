#pragma once

#include <functional>
#include <span>
#include <vector>

#include "excite/slopes_kernel.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// Derivatives of a quantity of each sample by that sample's positions, velocities and accelerations,
/// (samples × n).
struct Slopes {
  Matrix q;
  Matrix qd;
  Matrix qdd;

  void resize(Index samples, Index joints);
};

/// Observation matrix of a motion joint by joint, and exact derivatives of what is made of it.
///
/// Rows of a sample depend on that sample alone. What the links contribute is differentiated backwards
/// through the recursion, friction and coupled motors by dual numbers; so is all of a robot with linkages or
/// tables.
class SampledRegressor {
 public:
  SampledRegressor(const Robot& robot, const BaseParameters& base);
  SampledRegressor(const SampledRegressor&) = delete;
  SampledRegressor& operator=(const SampledRegressor&) = delete;

  [[nodiscard]] Index joints() const { return static_cast<Index>(batch_.joints()); }
  [[nodiscard]] Index size() const { return batch_.size(); }
  /// Base parameters that joint i's rows touch, in the order of the columns of W.
  [[nodiscard]] const std::vector<Index>& columns(std::size_t i) const { return batch_.of_joint(i); }

  /// Rows of all joints, (samples × columns(i).size()) each.
  void rows(const Motion& motion, std::vector<Matrix>& W);
  /// The same of a long motion, some samples at a time: `take` gets the first of them and their rows.
  void pieces(const Motion& motion, const std::function<void(Index first, std::span<const Matrix> W)>& take);

  /// Derivatives of
  ///
  ///   s = Σ_i Σ_c G_i(k, c) W_i(k, c)   and   τ_i = W_i χ
  ///
  /// at each sample k.
  ///
  /// @param G           like the rows
  /// @param chi         base parameters, (b); empty: no derivatives of torques are wanted
  /// @param of_torque   one a joint, where they are wanted
  void slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi, Slopes& of_sum,
              std::vector<Slopes>& of_torque);

 private:
  void bent_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi, Slopes& of_sum,
                   std::vector<Slopes>& of_torque) const;
  void link_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi, Slopes& of_sum,
                   std::vector<Slopes>& of_torque);
  void add_own_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi, Slopes& of_sum,
                      std::vector<Slopes>& of_torque) const;
  void add_motor_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi, Slopes& of_sum,
                        std::vector<Slopes>& of_torque) const;
  void fold(const Slopes& sum, std::span<const Slopes> torques, Slopes& of_sum,
            std::vector<Slopes>& of_torque) const;
  [[nodiscard]] std::vector<double> by_link(const Vector& chi) const;

  RegressorBatch batch_;
  BatchWorkspace workspace_;
  RegressorColumns columns_;  // the batch's, with the place of each entry
  std::vector<RegressorColumns::Entry>
      places_;                // where an entry goes, at least, where joints depend on others
  std::size_t link_entries_;  // entries that links make; the others are own ones of joints
  const SlopesKernel* kernel_;
  AlignedDoubles scratch_;
};

}  // namespace rivid::detail
