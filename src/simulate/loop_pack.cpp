#include "simulate/loop_pack.hpp"

#include <algorithm>
#include <cassert>

namespace rivid::detail {

int LoopPack::lanes() {
  // Plain registers hold two numbers, and a single loop fills these as well. Machines other than x86-64 have
  // fused operations everywhere, so that their loops by themselves round in another way.
  constexpr int worthwhile = 4;
  const int widest = kernel_for<LoopStepKernel>().lanes;
  return widest >= worthwhile ? widest : 1;
}

LoopPack::LoopPack(std::span<LoopOde* const> loops)
    : kernel_(&kernel_for<LoopStepKernel>()),
      lanes_(static_cast<std::size_t>(kernel_->lanes)),
      n_(static_cast<std::size_t>(loops.front()->joints())),
      seated_(lanes_, loops.size()) {
  assert(loops.size() <= lanes_);
  for (const LoopOde* loop : loops) {
    robots_.emplace_back(loop->model());
  }
  const std::size_t rows = static_cast<std::size_t>(LoopBlock::count) * n_;
  blocks_ = aligned_doubles(rows * lanes_);
  std::fill_n(blocks_.get(), rows * lanes_, 0.0);
  const std::size_t scratch = kernel_->scratch(n_, robots_.front().forks);
  scratch_ = aligned_doubles(scratch);
  std::fill_n(scratch_.get(), scratch, 0.0);
}

bool LoopPack::fit(const LoopOde& a, const LoopOde& b) {
  const Chain& first = a.model().chain();
  const Chain& second = b.model().chain();
  return a.simple() && b.simple() && first.dependents.empty() && first.gravity == second.gravity &&
         first.parents == second.parents &&
         std::ranges::equal(first.links, second.links, [](const Chain::Link& x, const Chain::Link& y) {
           return x.type == y.type && x.R == y.R && x.p == y.p;
         });
}

void LoopPack::seat(std::size_t lane, std::size_t loop) {
  seated_[lane] = loop;
  kernel_->seat(robots_[loop].plan(), static_cast<int>(lane), scratch_.get());
}

// State, friction in its present mode and tolerances.
void LoopPack::enter(std::size_t lane, const LoopPackStep& step) {
  const DynamicModel& model = step.ode->model();
  for (std::size_t j = 0; j < n_; ++j) {
    const auto joint = static_cast<Index>(j);
    *at(LoopBlock::q, j, lane) = step.y[j];
    *at(LoopBlock::qd, j, lane) = step.y[n_ + j];
    *at(LoopBlock::viscous, j, lane) = model.viscous()(joint, joint);
    for (const LoopBlock block :
         {LoopBlock::direction, LoopBlock::torque, LoopBlock::dry, LoopBlock::slope, LoopBlock::sense}) {
      *at(block, j, lane) = 0.0;
    }
    *at(LoopBlock::stuck, j, lane) = no_joint;
    *at(LoopBlock::least, j, lane) = -1.0;
    *at(LoopBlock::most, j, lane) = 1.0;
  }
  std::size_t stuck = 0;
  for (Index e = 0; e < step.ode->stick_slip().size(); ++e) {
    const DryFriction& law = model.dry_friction()[static_cast<std::size_t>(e)];
    const auto j = static_cast<std::size_t>(law.joint());
    const FrictionMode mode = step.ode->stick_slip().mode(e);
    *at(LoopBlock::direction, j, lane) = law.direction[law.joint()];
    *at(LoopBlock::torque, j, lane) = law.torque[law.joint()];
    if (mode == FrictionMode::stick) {
      *at(LoopBlock::stuck, stuck, lane) = static_cast<double>(j);
      *at(LoopBlock::most, stuck, lane) = law.Fc_plus;
      *at(LoopBlock::least, stuck, lane) = -law.Fc_minus;
      ++stuck;
      continue;
    }
    const bool plus = mode == FrictionMode::slip_plus;
    const double sense = plus ? 1.0 : -1.0;
    *at(LoopBlock::dry, j, lane) = law.dry(plus, 0.0, sense);
    *at(LoopBlock::slope, j, lane) = law.viscous(plus, 1.0);
    *at(LoopBlock::sense, j, lane) = sense;
  }
  *at(LoopBlock::rtol, 0, lane) = step.rtol;
  *at(LoopBlock::atol, 0, lane) = step.atol;
  *at(LoopBlock::fastest, 0, lane) = step.max_velocity;
}

bool LoopPack::step(std::span<const LoopPackStep> steps) {
  const auto some = static_cast<std::size_t>(
      std::ranges::find_if(steps, [](const LoopPackStep& step) { return step.h > 0.0; }) - steps.begin());
  bool known = true;
  Index sticking = 0;
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    // A lane without a step of its own goes along with another one: numbers of nothing could stop all.
    const std::size_t loop = lane < steps.size() && steps[lane].h > 0.0 ? lane : some;
    const LoopPackStep& step = steps[loop];
    const bool moves_in = seated_[lane] != loop;
    if (moves_in) {
      seat(lane, loop);
    }
    if (moves_in || !step.follows) {
      enter(lane, step);
      known = false;
    }
    sticking = std::max(sticking, step.ode->stick_slip().sticking());
    const Vector& torque = step.ode->held_torque();
    for (std::size_t j = 0; j < n_; ++j) {
      *at(LoopBlock::drive, j, lane) = torque[static_cast<Index>(j)];
    }
    *at(LoopBlock::h, 0, lane) = step.h;
  }
  return kernel_->step(robots_[some].plan(), known, static_cast<std::size_t>(sticking), blocks_.get(),
                       scratch_.get());
}

void LoopPack::state(std::size_t lane, Vector& y) const {
  for (std::size_t j = 0; j < n_; ++j) {
    y[static_cast<Index>(j)] = *at(LoopBlock::q, j, lane);
    y[static_cast<Index>(n_ + j)] = *at(LoopBlock::qd, j, lane);
  }
}

}  // namespace rivid::detail
