#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "excite/problem.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/simulate/references.hpp"

// What design() is made of: the search of mma.cpp, the leads of lead.cpp, the target of target.cpp.
namespace rivid::detail {

/// Objective and limits at some variables; limits are wanted not to be positive.
struct MmaValue {
  double objective = 0.0;
  Vector limits = {};  ///< (m)
};

struct MmaOptions {
  double bound = 4.0;       ///< −bound ≤ z ≤ bound
  double tolerance = 0.01;  ///< change of the objective below which the search ends
  int evaluations = 500;    ///< at most
  std::function<bool()> stopped = {};
};

struct MmaResult {
  Vector z;  ///< the best that kept all limits, or the start
  double objective = 0.0;
  int evaluations = 0;
};

/// Minimum by the method of moving asymptotes [Svanberg 2002] of NLopt.
///
/// @param f  value(z, gradient (variables), jacobian (variables × limits))
/// @throws InputError  where rivid was built without NLopt
[[nodiscard]] MmaResult minimised(const std::function<MmaValue(const Vector&, Vector&, Matrix&)>& f, Vector z,
                                  const MmaOptions& options);

/// Quintic moves from rest at one pose to rest at another, as slow as the task's limits ask: along a straight
/// line in joint space, or where that is not free through a middle of the motion or of the positions. Limits
/// are those of DenseCheck.
///
/// @param who      names the lead in the message where there is no such way
/// @param rate_hz  durations are whole samples, the first one `more` seconds longer
/// @param suits    whether a move is slow enough for what else is asked of it
/// @throws InputError  with limit, place and body that keep from the straight line
[[nodiscard]] PointToPoint lead(const std::string& who, const Task& task, const Vector& from,
                                const Vector& to, const Vector& middle, double rate_hz, double more,
                                const std::function<bool(const Curve&)>& suits);

/// References one after the other, from t = 0.
class SequenceReference final : public Reference {
 public:
  explicit SequenceReference(std::vector<std::unique_ptr<const Reference>> parts)
      : parts_(std::move(parts)) {}

  [[nodiscard]] Index joints() const override { return parts_.front()->joints(); }
  [[nodiscard]] double duration() const override;
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  std::vector<std::unique_ptr<const Reference>> parts_;
};

/// A motion of as few seconds as reach the options' target.
///
/// @param once  design of one period, for given harmonics and duration
/// @throws InputError  where the target can not be reached; the message says what keeps from it
[[nodiscard]] Excitation designed_for_target(const Robot& robot, const ExcitationOptions& options,
                                             const std::function<Excitation(const ExcitationOptions&)>& once);

}  // namespace rivid::detail
