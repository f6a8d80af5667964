#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "identify/estimate/closed_loops.hpp"
#include "identify/estimate/instruments.hpp"

namespace rivid::detail {

// (Vᵀ Ω⁻¹ W)⁻¹ of instruments with full rank.
[[nodiscard]] Matrix bread_of(const InstrumentalVariables& solution);

// The iteration (29) with its stop rule and its safeguards; or that of DIDIM, where W is V: its steps are
// Newton's, with the derivative of V χ by differences of simulations. Plain steps, as if V did not depend on
// χ, lead away from the fixed point of many loops.
class IvSolver {
 public:
  // out       its status and reasons tell why an iteration did not settle
  // compares  instruments or torques
  //
  // throws InputError where loops and logs do not fit together or a joint's torque is zero throughout
  IvSolver(const EstimationProblem& problem, Estimated& out,
           Iv::Compares compares = Iv::Compares::instruments);

  // The parameters that the options begin with.
  [[nodiscard]] Vector start() const;

  // Iterates from `chi` on; whether it settled.
  bool iterate(Vector chi);

  // Goes on from the last iterate once rows are made otherwise, with the loops that were simulated last;
  // whether it settled.
  //
  // what  the instruments are called where they lack rank
  bool iterate_again(const std::string& what);

  [[nodiscard]] std::vector<IvIteration>& history() { return history_; }
  [[nodiscard]] const std::vector<IvIteration>& history() const { return history_; }
  // The last iterate that the instruments of its own loop have been solved for.
  [[nodiscard]] const std::optional<Estimate>& estimate() const { return estimate_; }
  // Simulated last, with the estimate where there is one.
  [[nodiscard]] const SimulatedLoops& last_loops() const { return last_; }
  [[nodiscard]] const ClosedLoops& loops() const { return loops_; }
  [[nodiscard]] Instruments& instruments() { return instruments_; }
  [[nodiscard]] const Instruments& instruments() const { return instruments_; }
  // 1/σ of each joint's rows that the next iterate would take.
  [[nodiscard]] const std::vector<double>& weights() const { return weights_; }

  // Rows with the instruments of these loops.
  [[nodiscard]] std::vector<InstrumentalGroup> factors(const SimulatedLoops& loops);

  // Largest entry of a step in standard deviations of the solution of the last instruments.
  [[nodiscard]] double step_in_sigmas(const Vector& step) const;
  // Whether that is next to nothing.
  [[nodiscard]] bool stands_still(const Vector& step) const;

 private:
  [[nodiscard]] const BaseParameters& base() const { return problem_.base; }
  [[nodiscard]] bool simulated_signs() const;
  [[nodiscard]] FromV from_V() const;
  bool find_bread(const Vector& chi);
  [[nodiscard]] Vector torque_slope(std::span<const Motion> V, const Vector& chi,
                                    std::span<const Motion> V_changed, const Vector& changed,
                                    double step) const;
  [[nodiscard]] Vector newton_step(const Vector& chi) const;
  [[nodiscard]] Matrix unit_covariance() const;
  [[nodiscard]] SimulatedLoops simulated(const Vector& chi) const;
  [[nodiscard]] SimulatedLoops loops_of(Vector& chi, std::string& remark);
  [[nodiscard]] SimulatedLoops safeguarded(SimulatedLoops loops, Vector& chi, std::string& remark);
  [[nodiscard]] Vector nearest_physical(const Vector& chi) const;
  std::vector<InstrumentalGroup> solve(const SimulatedLoops& loops, const Vector* weighted_by = nullptr);
  std::vector<InstrumentalGroup> solve_or_halve(SimulatedLoops& loops, Vector& chi, std::string& remark);
  [[nodiscard]] IvIteration told(const Vector& chi, const SimulatedLoops& loops,
                                 std::span<const InstrumentalGroup> groups) const;
  [[nodiscard]] bool settled(const IvIteration& before, double part) const;
  [[nodiscard]] bool cycles(const Vector& next) const;
  void reweight(const Vector& chi);
  void keep(const Vector& chi);
  [[nodiscard]] double deviation_of(const Vector& chi) const;
  [[nodiscard]] Vector first_stage_F() const;

  const EstimationProblem& problem_;
  const Iv& method_;
  Estimated& out_;
  Iv::Compares compares_;
  ClosedLoops loops_;
  Instruments instruments_;
  std::vector<double> weights_;
  InstrumentalVariables solution_;  // of the instruments that were made last
  Matrix bread_;                    // of the same; of DIDIM (Vᵀ Ω⁻¹ ∂(V χ)/∂χ)⁻¹
  SimulatedLoops last_;
  std::vector<IvIteration> history_;
  std::optional<Estimate> estimate_;
};

}  // namespace rivid::detail
