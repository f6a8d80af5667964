#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// Torques of one joint along a log, measured and predicted.
struct JointPrediction {
  Vector measured = {};   ///< Y as rows have it, before decimation, (samples) [N·m | N]
  Vector predicted = {};  ///< W χ, (samples) [N·m | N]
  /// Whether the fit takes the sample; else the joint is too slow there, or reverses nearby.
  std::vector<std::uint8_t> kept = {};

  std::vector<Index> rows = {};  ///< samples that the rows of the fit stand for, counted as those above
  Vector residual = {};          ///< Y − W χ of these rows, after decimation [N·m | N]
};

/// What an identified model says of the torques of a log, sample by sample.
struct Prediction {
  std::string source = {};  ///< the log's
  bool validation = false;  ///< whether the log took no part in the fit
  double start = 0.0;       ///< instant of the first sample [s]
  double f_m = 0.0;         ///< rate of the samples [Hz]
  Index row_stride = 1;     ///< samples from one row to the next, where none is left out between them
  std::vector<JointPrediction> joints = {};

  [[nodiscard]] Index samples() const { return joints.empty() ? 0 : joints.front().measured.size(); }
};

/// Measured and predicted torques of a log by the signal chain of the identification: the samples that its trim and
/// window leave, at the rate of the log. W is never held, so memory is that of the series.
///
/// @return  not a number in all predictions where chi is not a number
/// @throws InputError where rows() throws it
[[nodiscard]] Prediction predict(const Robot& robot, const Identification& identification, const Log& log);

}  // namespace rivid
