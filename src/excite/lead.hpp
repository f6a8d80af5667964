#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "excite/problem.hpp"
#include "rivid/simulate/references.hpp"

namespace rivid::detail {

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

}  // namespace rivid::detail
