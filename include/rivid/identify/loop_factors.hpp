#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/log_factors.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/solve/instrumental.hpp"
#include "rivid/types.hpp"

// Instrumental variables from many logs that are read in different places: in each iteration identify() asks
// for the closed loops of all logs with some parameters, these are simulated where the logs are, and what
// comes back are merged factors.
namespace rivid {

/// What a pass over the logs is for.
enum class LoopPass {
  speeds,    ///< how fast the joints move, which does not depend on the parameters
  inertias,  ///< what the gains of the control law follow
  rows       ///< simulated loops, and the rows with their motion as instruments
};

/// What identify() asks of each log.
struct LoopRequest {
  LoopPass pass = LoopPass::speeds;
  Vector chi_st = {};         ///< values of BaseParameters::standard; empty for the speeds
  Vector J = {};              ///< design inertias of the control law, (n); for the rows
  bool simulated_signs = {};  ///< whether W takes its columns of dry friction from the simulated motion
  Index steps_before = 0;     ///< most that the integrator took in one of the passes before, over all logs
};

/// Sums over the samples of logs and of their simulated loops.
struct LoopSums {
  /// Squares of q, q̇ and q̈, (n × 3): simulated without measured, measured, simulated without reference,
  /// reference.
  Matrix off_measured, measured, off_reference, reference;
  Vector tracking;         ///< squares of reference without measured positions, (n)
  Vector missed, control;  ///< squares of rebuilt without recorded control signals, and of these, (n)
  Vector moving;           ///< samples in which a joint moves in the simulation, (n)
  double samples = 0.0;
};

/// What one pass comes to. Its size does not grow with the logs.
struct LoopFactors {
  Index logs = 0;
  Vector mean_speeds;    ///< sum over the logs of the mean |q̇|, (n)
  Vector mean_squares;   ///< of the mean q̇², (n)
  Vector J;              ///< largest design inertias, (n)
  std::string failure;   ///< of the first log whose loop could not be simulated: there are no rows then
  bool gave_up = false;  ///< the failure is a budget of the options that was used up
  bool simulated_signs = false;
  std::vector<InstrumentalGroup> groups;               ///< [V | W Y] of each joint
  std::vector<RowGroup> used;                          ///< [W Y] where W took columns of V; empty otherwise
  std::vector<std::vector<InstrumentalGroup>> blocks;  ///< of blocks of time, (blocks × n)
  LoopSums sums;
  SimulationEffort effort;
};

/// One log's part of a pass.
///
/// @param estimation  by instrumental variables; its signal options leave nothing open, see chosen_signal()
/// @param blocks      of equal time that the log is divided into, from 1 to LogFactors::most_blocks
/// @throws InputError  where identify() by these options would throw it for the log
[[nodiscard]] LoopFactors loop_factors(const Robot& robot, const Log& log, const Estimation& estimation,
                                       const LoopRequest& request, int blocks = 10);

/// Adds the same pass over other logs.
///
/// @throws InputError  where they have other columns
void merge(LoopFactors& into, const LoopFactors& other);

/// Carries out a pass over all logs and merges what it comes to.
using LoopAsk = std::function<LoopFactors(const LoopRequest&)>;

/// Identification by instrumental variables from factors: the iteration, its safeguards and the estimate are
/// those of identify() from the logs themselves, to rounding.
///
/// Budgets of wall-clock time are those of single simulations. Standard deviations are those of identify() by
/// least squares from factors.
///
/// @param factors  of the same logs and signal options
/// @throws InputError  where `ask` is empty; for what needs single rows: prefilter, robust and essential
///                     parameters, transient, DIDIM, output error, CovarianceKind::hac
[[nodiscard]] Identification identify(const Robot& robot, const LogFactors& factors,
                                      const Estimation& estimation, const LoopAsk& ask);

}  // namespace rivid
