#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "identify/iv_problem.hpp"
#include "identify/loop.hpp"

namespace rivid::detail {

// The loops of all logs, simulated with some parameters.
struct SimulatedLoops {
  std::string failure;                  // empty where all were simulated
  std::vector<Motion> motions;          // one a log
  std::unique_ptr<DynamicModel> model;  // that the law may look into
  std::unique_ptr<ControlLaw> law;
  Vector J;  // design inertias that its gains follow
  SimulationEffort effort;
};

// The closed loops of all logs, to be simulated with any parameters.
class ClosedLoops {
 public:
  // throws InputError where a log lacks what its loop follows
  explicit ClosedLoops(const IvProblem& problem);

  // earlier  iterations: their effort bounds that of this one
  [[nodiscard]] SimulatedLoops simulated(const Vector& chi, std::span<const IvIteration> earlier) const;

  [[nodiscard]] std::size_t size() const { return loops_.size(); }
  [[nodiscard]] const AuxiliaryLoop& of_log(std::size_t k) const { return *loops_[k]; }

 private:
  const IvProblem& problem_;
  std::vector<std::unique_ptr<AuxiliaryLoop>> loops_;
  Vector mean_speed_;  // |q̇| of the measured motions
  Vector mean_square_;
};

}  // namespace rivid::detail
