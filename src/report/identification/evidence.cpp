#include "report/identification/evidence.hpp"

#include <algorithm>
#include <array>

#include "report/analysis.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Whether the series of a joint have the sizes that predict() gives them.
bool fits(const JointPrediction& joint, Index samples, Index b) {
  const FittedRows& fitted = joint.fitted;
  const auto is_a_row_each = [&](const Vector* x) { return x->size() == std::ssize(joint.rows); };
  const auto may_lack = [&](Index size) { return size == samples || size == 0; };
  return joint.measured.size() == samples && may_lack(joint.predicted.size()) &&
         may_lack(std::ssize(joint.kept)) && fitted.column_rms.size() == b &&
         std::ranges::all_of(std::array{&joint.residual, &fitted.position, &fitted.velocity, &fitted.measured,
                                        &fitted.a_priori, &fitted.gravity, &fitted.inertia, &fitted.coriolis,
                                        &fitted.friction},
                             is_a_row_each);
}

}  // namespace

void require_fitting(std::string_view who, const Robot& robot, const Identification& result,
                     std::span<const Prediction> predictions) {
  const auto require = [&](bool fits, const std::string& words) {
    if (!fits) {
      throw InputError(std::string(who) + ": " + words);
    }
  };
  const Index joints = std::ssize(result.fit.joints);
  require(joints == 0 || joints == robot.size(), "the result is of " + counted(joints, "joint") +
                                                     ", robot \"" + robot.name + "\" has " +
                                                     std::to_string(robot.size()));
  if (!result.base.standard.empty()) {
    const auto fault = result.base.complaint(robot);
    require(!fault, fault.value_or(""));
  }
  for (const Prediction& log : predictions) {
    require(std::ssize(log.joints) == robot.size(),
            "the prediction of \"" + log.source + "\" is of " + counted(std::ssize(log.joints), "joint") +
                ", robot \"" + robot.name + "\" has " + std::to_string(robot.size()));
    for (std::size_t j = 0; j < log.joints.size(); ++j) {
      require(fits(log.joints[j], log.samples(), result.base.size()),
              "the prediction of \"" + log.source + "\" for joint \"" + robot.joints[j].name +
                  "\" has series of different lengths; give what predict() returned");
    }
  }
}

std::span<const Prediction> Evidence::fitted() const {
  const auto first = std::ranges::find(logs, true, &Prediction::validation);
  return {logs.begin(), first};
}

std::span<const Prediction> Evidence::validation() const { return logs.subspan(fitted().size()); }

std::string chart_id(const std::string& kind, std::size_t joint, std::size_t log) {
  return kind + "-" + std::to_string(joint + 1) + (log == 0 ? "" : "-log-" + std::to_string(log + 1));
}

std::string speed_unit(const Joint& joint) { return joint.type == JointType::revolute ? "rad/s" : "m/s"; }

std::string position_unit(const Joint& joint) { return joint.type == JointType::revolute ? "rad" : "m"; }

Series cloud(const std::string& name, const std::string& style, const Vector& x, const Vector& y) {
  const std::vector<Index> some = every_few(x.size(), most_points);
  return {name, style, Series::Kind::points, x(some), y(some)};
}

}  // namespace rivid::detail
