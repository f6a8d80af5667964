#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "rivid/regressor/batch.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Columns of friction that follows the load of a joint's gear, Basis::load:
///
///   τ_j += Fl_j |τ_load,j| sign q̇_j,   τ_load = (M(q) q̈ + N(q, q̇))_j,
///
/// where M has the rotors as well: base parameters do not distinguish their inertia from that of the links.
/// The column is made with the parameters BaseParameters::load, so that the torque is linear in the others as
/// long as these stand still.
class LoadColumns {
 public:
  /// @throws InputError  in the name of `who`, where a joint has such a column and base.load.chi is not (b),
  ///                     or its width not (n)
  LoadColumns(std::string_view who, const Robot& robot, const BaseParameters& base,
              const RegressorBatch& batch);

  /// Whether no joint has such a column.
  [[nodiscard]] bool empty() const { return joints_.empty(); }

  /// Completes rows of joint j that RegressorBatch or an average of its rows filled, whose column of
  /// Basis::load holds the sign alone. With LoadPoint::width they become rows of the tangent instead, see
  /// there.
  ///
  /// @param y  torques of these rows; null: none
  void complete(std::size_t j, const RowsTarget& W, Index count, double* y) const;

 private:
  struct JointLoad {
    Index column = -1;          // of Fl in the joint's rows; −1: none
    double slope = 0.0;         // Fl of a tangent
    double width = 0.0;         // of its kink
    std::vector<Index> rigid;   // columns of M q̈ + N …
    std::vector<double> value;  // … and their parameters
  };

  std::vector<JointLoad> joints_;  // (n), or none
};

/// The same parameters with another BaseParameters::load.
///
/// @param chi    (b)
/// @param width  (n) of a tangent
[[nodiscard]] BaseParameters at_load(BaseParameters base, const Eigen::Ref<const Vector>& chi,
                                     std::optional<Vector> width = std::nullopt);

/// The same robot without friction that follows the load: each joint has the law with its other parameters.
[[nodiscard]] Robot without_load(Robot robot);

/// Whether a joint's friction follows its load.
[[nodiscard]] bool has_load(const Robot& robot);

}  // namespace rivid
