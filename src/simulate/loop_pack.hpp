#pragma once

#include <span>
#include <vector>

#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/dynamics.hpp"
#include "simulate/loop.hpp"
#include "simulate/loop_step_kernel.hpp"

namespace rivid::detail {

// A step of one loop of a LoopPack.
struct LoopPackStep {
  LoopOde* ode = nullptr;     // simple()
  const double* y = nullptr;  // state at the beginning, (2n)
  bool follows = false;       // whether this lane's last step ended at y
  double h = 0.0;             // length; 0: no step
  double rtol = 0.0;
  double atol = 0.0;
  double max_velocity = 0.0;
};

// Closed loops in the lanes of registers: one Bogacki-Shampine step of each at a time, with the bits of
// RungeKutta.
class LoopPack {
 public:
  // Loops that are worth the widest registers of this machine; 1 where one by one is as fast, or has other
  // bits.
  [[nodiscard]] static int lanes();

  // Loops of robots that differ in inertias and friction alone, lanes() of them at most.
  explicit LoopPack(std::span<LoopOde* const> loops);
  [[nodiscard]] static bool fit(const LoopOde& a, const LoopOde& b);

  // Takes a step in each lane.
  //
  // @param steps  one a loop, one at least of some length
  // @return       whether steps were taken: else some lane's M is not positive definite
  [[nodiscard]] bool step(std::span<const LoopPackStep> steps);

  // Of a lane, after step(): whether nothing happened in it that one by one has to find out, its error
  // relative to the tolerance, its state at the end and its accelerations at the beginning.
  [[nodiscard]] bool valid(std::size_t lane) const { return error(lane) != LoopStepKernel::not_valid; }
  [[nodiscard]] double error(std::size_t lane) const { return *at(LoopBlock::error, 0, lane); }
  void state(std::size_t lane, Vector& y) const;
  [[nodiscard]] double acceleration(std::size_t lane, Index joint) const {
    return *at(LoopBlock::qdd, static_cast<std::size_t>(joint), lane);
  }

 private:
  [[nodiscard]] double* at(LoopBlock block, std::size_t joint, std::size_t lane) const {
    return blocks_.get() + (static_cast<std::size_t>(block) * n_ + joint) * lanes_ + lane;
  }
  void seat(std::size_t lane, std::size_t loop);
  void enter(std::size_t lane, const LoopPackStep& step);

  const LoopStepKernel* kernel_;
  std::size_t lanes_;
  std::size_t n_;
  std::vector<DynamicsTables> robots_;
  std::vector<std::size_t> seated_;  // the loop whose robot is in each lane
  AlignedDoubles blocks_;
  AlignedDoubles scratch_;
};

}  // namespace rivid::detail
