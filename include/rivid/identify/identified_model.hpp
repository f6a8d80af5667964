#pragma once

#include <optional>

#include "rivid/identify/identification.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

/// A set of parameters that a result has.
enum class ParameterSet {
  estimate,  ///< the base parameters as they were estimated, Identification::chi
  physical   ///< the physically consistent ones that are nearest to them, Identification::physical
};

/// Which numbers of a result a model is made of.
struct IdentifiedModelOptions {
  /// Empty: the physically consistent set where the result has one, else the estimate. That set is the better one for a
  /// controller: M(q) is positive definite everywhere, friction brakes, and on motions that took no part in the fit
  /// its torques were at least as good on all real logs tried, see docs/physical.md.
  std::optional<ParameterSet> parameters = std::nullopt;
  bool force = false;  ///< takes a result whose status is not `identified`
};

/// The robot with the numbers of a result, for a controller or a simulation:
///
///   InverseDynamics dynamics(identified_model(robot, result));
///
/// Friction that would drive is taken as zero, see DynamicModel::clamped(); a physically consistent set has none.
/// read_identified_model() makes the same of result.json.
///
/// @param robot   that was identified
/// @throws InputError  where the result is not identified and force was not asked for; where it has not the set that was
///                     asked for, or is that of another robot; as DynamicModel does
[[nodiscard]] DynamicModel identified_model(const Robot& robot, const Identification& result,
                                            const IdentifiedModelOptions& options = {});

}  // namespace rivid
