#pragma once

#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/prediction.hpp"

namespace rivid {

/// What a report can show of the logs of an experiment within its memory.
struct ShownPredictions {
  std::vector<Prediction> predictions;  ///< as predictions() makes them
  std::vector<std::string> left_out;    ///< logs that are not among them
};

/// predictions() of the logs that a report holds: a sample of a joint takes up to 100 bytes, so that the default is 5 GB.
///
/// @param most  samples, counted over joints and logs
/// @throws InputError  where predictions() throws it
[[nodiscard]] ShownPredictions shown_predictions(const Experiment& experiment, const Identification& result,
                                                 Index most = 50'000'000);

}  // namespace rivid
