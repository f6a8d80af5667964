#pragma once

#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/finding.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/robot_state.hpp"

namespace rivid {

/// How a log is replayed.
struct OnlineReplayOptions {
  /// A log says nothing of grippers: each change that is found is a payload's.
  RobotStateOptions state = {.payload = {.friction_change = 0.2, .longest_touch = 0.0}};
  double learn = 30.0;  ///< time from the beginning in which thresholds of contacts are learned, at most half
                        ///< of the log [s]
  double interval = 0.05;  ///< from one record to the next [s]
};

/// What the estimators say along a log: one entry or row a record.
struct OnlineReplay {
  std::string source;
  std::vector<std::string> joints;
  double f_m = 0.0;
  Vector t;        ///< [s]
  Matrix payload;  ///< mass, half width of its 95 % interval, centre of mass (3), largest half width of that;
                   ///< [kg], [m]
  Vector suspicion;     ///< of a change of the payload, over its threshold
  Matrix torque_error;  ///< by friction that has changed since the identification, a column a joint [N·m | N]
  Matrix external;      ///< external torque over its threshold, a column a joint
  struct Event {
    double t = 0.0;
    std::string text;
  };
  std::vector<Event> events;
  OnlinePayload<double> last;  ///< payload at the end
  double since = 0.0;          ///< when its last change was found [s]
  /// Errors of the log since then, as identify_payloads() and examine() find them: no number of `last` is
  /// good with one.
  std::vector<Finding> warnings;
};

/// Replays a log as a control loop would have seen it: RobotState takes its ticks with their times.
///
/// @param options  f_m of the state is that of the log, and its time to learn is `learn`, whatever stands
///                 there
/// @throws InputError  where model, log and options do not fit together
[[nodiscard]] OnlineReplay replay(const OnlineModel& model, const ModelData& dynamics, const Log& log,
                                  OnlineReplayOptions options = {});

}  // namespace rivid
