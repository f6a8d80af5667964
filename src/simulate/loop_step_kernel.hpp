#pragma once

#include "instruction_sets.hpp"
#include "rivid/simulate/dynamics_kernel.hpp"
#include "simulate/runge_kutta_pairs.hpp"

// One step of several closed loops, one in each lane of a register: the arithmetic of LoopOde, StickSlip and
// RungeKutta for loops with simple() torques in which no mode of friction ends, operation by operation. It is
// compiled without fused operations, which the plain library does not have either, so that a lane has the
// bits of a loop by itself.
//
// This file is compiled once for each instruction set; rivid/regressor/kernel.hpp says what that forbids.
namespace rivid::detail {

// What the loops of a pack are: blocks of (joints × lanes) doubles, the lanes of a joint side by side; the
// first row alone of those that have no joint.
enum class LoopBlock {
  q,  // positions and velocities: before the step, after it
  qd,
  drive,      // torques that are held
  viscous,    // Fv
  direction,  // of dry friction, as DryFriction has it; zero where there is none
  torque,
  dry,    // λ without what follows the speed, in the present mode; zero where the joint sticks
  slope,  // and what is multiplied with the speed
  sense,  // of the present mode, ±1; 0 where the joint sticks
  stuck,  // joints that stick, in the order of the elements, as numbers; then no_joint
  most,   // largest and smallest λ of joint `stuck` at rest
  least,
  h,  // length of the step
  atol,
  rtol,
  fastest,  // velocity beyond which a loop has diverged
  qdd,      // out: accelerations at the beginning of the step
  error,    // out: largest error relative to its tolerance, or not_valid: one by one has to find out what
            // happens
  count
};

inline constexpr double no_joint = -1.0;  // mark: no number of a joint

struct LoopStepKernel {
  static constexpr double not_valid = -1.0;  // mark: no error is negative

  int lanes;
  // Doubles of scratch for so many joints, and links on which several hang.
  std::size_t (*scratch)(std::size_t joints, std::size_t forks);
  // Puts the inertias of a robot into a lane. All robots of a pack have the same frames.
  void (*seat)(const DynamicsPlan& robot, int lane, double* scratch);
  // Takes the step. Returns false where M is not positive definite in some lane, after which `blocks` is as
  // it was.
  //
  // known     whether the last step ended where this one begins, in all lanes
  // sticking  joints that stick in some lane, at most
  // blocks, scratch  aligned to 64 bytes
  bool (*step)(const DynamicsPlan& frames, bool known, std::size_t sticking, double* blocks, double* scratch);
};

// Added to the diagonal of G, relative to it: makes λ unique where elements at rest depend on one another,
// and moves the instant of a release by as much of itself.
inline constexpr double stick_slip_regularisation = 1e-11;

template <typename Scalar>
[[gnu::always_inline]] inline Scalar magnitude(const Scalar& x) {
  return select(x > Scalar(0.0), x, Scalar(-x));
}

// A x = b by elimination with row pivoting, each lane with pivots of its own: x takes the place of b.
//
// A  (m × m), rows of length `stride`
template <typename Scalar>
void eliminate(std::size_t m, std::size_t stride, Scalar* A, Scalar* b) {
  const auto exchange = [](const auto& where, Scalar& x, Scalar& y) {
    const Scalar first = x;
    x = select(where, y, first);
    y = select(where, first, y);
  };
  for (std::size_t k = 0; k < m; ++k) {
    Scalar largest = magnitude(A[k * stride + k]);
    auto pivot = Scalar(static_cast<double>(k));
    for (std::size_t r = k + 1; r < m; ++r) {
      const Scalar size = magnitude(A[r * stride + k]);
      const auto more = size > largest;
      largest = select(more, size, largest);
      pivot = select(more, Scalar(static_cast<double>(r)), pivot);
    }
    for (std::size_t r = k + 1; r < m; ++r) {
      const auto chosen =
          (pivot > Scalar(static_cast<double>(r) - 0.5)) & (pivot < Scalar(static_cast<double>(r) + 0.5));
      for (std::size_t c = 0; c < m; ++c) {
        exchange(chosen, A[k * stride + c], A[r * stride + c]);
      }
      exchange(chosen, b[k], b[r]);
    }
    for (std::size_t r = k + 1; r < m; ++r) {
      const Scalar factor = A[r * stride + k] / A[k * stride + k];
      for (std::size_t c = k + 1; c < m; ++c) {
        A[r * stride + c] = A[r * stride + c] - factor * A[k * stride + c];
      }
      b[r] = b[r] - factor * b[k];
    }
  }
  for (std::size_t k = m; k-- > 0;) {
    for (std::size_t c = k + 1; c < m; ++c) {
      b[k] = b[k] - A[k * stride + c] * b[c];
    }
    b[k] = b[k] / A[k * stride + k];
  }
}

template <typename Scalar>
struct LoopStep {
  using Pair = BogackiShampine;
  using Link = DynamicsLinkOf<Scalar>;
  static_assert(sizeof(Link) % sizeof(Scalar) == 0);

  static constexpr int stages = Pair::stages;
  static constexpr double smallest_error = 1e-10;  // as in RungeKutta
  // stands for infinity: what comes near is none that a loop may have
  static constexpr double largest_number = 0x1p1000;

  static constexpr LoopStepKernel kernel() { return {Scalar::lanes, &doubles, &seat, &step}; }

 private:
  struct Scratch {
    Link* links;
    Scalar *rotor, *M, *L, *inverse_D, *N;
    DynamicsScratch<Scalar> dynamics;
    Scalar *y, *next;           // (2 joints), q and q̇
    Scalar* rates;              // (2 joints × stages)
    Scalar *response, *system;  // (joints × joints): of the joints that stick
    Scalar* lambda;             // (joints)

    [[nodiscard, gnu::always_inline]] const Scalar& rate(int stage, std::size_t i, std::size_t n) const {
      return rates[static_cast<std::size_t>(stage) * 2 * n + i];
    }
  };

  [[gnu::always_inline]] static constexpr std::size_t scalars(std::size_t n, std::size_t forks) {
    return forks * fork_scalars(dynamics_stride(n)) + n * (sizeof(Link) / sizeof(Scalar)) +
           (3 * n + 6) * dynamics_stride(n) + 2 * n + 2 * (n + 1) + 6 * n +
           (4 + 2 * static_cast<std::size_t>(stages)) * n + 2 * n * n + n;
  }
  static std::size_t doubles(std::size_t n, std::size_t forks) { return scalars(n, forks) * Scalar::lanes; }

  [[gnu::always_inline]] static Scratch scratch_at(double* memory, std::size_t n, std::size_t forks) {
    const std::size_t stride = dynamics_stride(n);
    auto* next = reinterpret_cast<Scalar*>(memory);
    const auto taken = [&](std::size_t count) {
      Scalar* const out = next;
      next += count;
      return out;
    };
    Scratch s;
    s.links = reinterpret_cast<Link*>(taken(n * (sizeof(Link) / sizeof(Scalar))));
    s.rotor = taken(n * stride);
    s.M = taken(n * stride);
    s.L = taken(n * stride);
    s.inverse_D = taken(n);
    s.N = taken(n);
    Scalar* const cosines = taken(n + 1);
    Scalar* const sines = taken(n + 1);
    auto* const own = reinterpret_cast<Wrench<Scalar>*>(taken(6 * n));
    Scalar* const wrenches = taken(6 * stride);
    auto* const kept = reinterpret_cast<DynamicsFork<Scalar>*>(taken(34 * forks));
    s.dynamics = {cosines, sines, own, wrenches, stride, kept, taken(6 * stride * forks)};
    s.y = taken(2 * n);
    s.next = taken(2 * n);
    s.rates = taken(2 * n * static_cast<std::size_t>(stages));
    s.response = taken(n * n);
    s.system = taken(n * n);
    s.lambda = taken(n);
    return s;
  }

  static void seat(const DynamicsPlan& robot, int lane, double* memory) {
    const Scratch s = scratch_at(memory, robot.joints, robot.forks);
    for (std::size_t j = 0; j < robot.joints; ++j) {
      const DynamicsLink& from = robot.links[j];
      Link& to = s.links[j];
      static_cast<Frame&>(to) = from;
      to.step = from.step;
      to.fork = from.fork;
      to.from = from.from;
      for (int k = 0; k < 10; ++k) {
        put(from.inertial[k], lane, to.inertial[k]);
      }
    }
    for (std::size_t k = 0; k < robot.joints * s.dynamics.stride; ++k) {
      put(robot.rotor[k], lane, s.rotor[k]);
    }
  }

  static bool step(const DynamicsPlan& frames, bool known, std::size_t sticking, double* blocks,
                   double* memory) {
    const std::size_t n = frames.joints;
    const Scratch s = scratch_at(memory, n, frames.forks);
    const DynamicsPlanOf<Scalar> plan = {s.links,
                                         n,
                                         {frames.accel[0], frames.accel[1], frames.accel[2]},
                                         s.rotor,
                                         {frames.base[0], frames.base[1], frames.base[2]},
                                         frames.forks};
    const Loops in = {blocks, n, sticking};
    for (std::size_t j = 0; j < n; ++j) {
      s.y[j] = in.at(LoopBlock::q, j);
      s.y[n + j] = in.at(LoopBlock::qd, j);
    }
    if (!known && !place(plan, s, s.y)) {
      return false;
    }
    rate(in, s, s.y, s.rates);
    const auto held = holds(in, s);
    const Scalar h = in.at(LoopBlock::h, 0);
    for (int stage = 1; stage < stages; ++stage) {
      for (std::size_t i = 0; i < 2 * n; ++i) {
        Scalar sum = s.y[i];
        for (int r = 0; r < stage; ++r) {
          if (Pair::stage[stage][r] != 0.0) {
            sum =
                sum + (h * Scalar(Pair::stage[stage][r])) * s.rates[static_cast<std::size_t>(r) * 2 * n + i];
          }
        }
        s.next[i] = sum;
      }
      if (!place(plan, s, s.next)) {
        return false;
      }
      rate(in, s, s.next, s.rates + static_cast<std::size_t>(stage) * 2 * n);
    }
    in.put(LoopBlock::error, 0, judged(in, s, h, held));
    for (std::size_t j = 0; j < n; ++j) {
      in.put(LoopBlock::q, j, s.next[j]);
      in.put(LoopBlock::qd, j, s.next[n + j]);
      in.put(LoopBlock::qdd, j, s.rates[n + j]);
    }
    return true;
  }

  struct Loops {
    double* blocks;
    std::size_t joints;
    std::size_t sticking;

    [[nodiscard]] double* row(LoopBlock block, std::size_t j) const {
      return blocks + (static_cast<std::size_t>(block) * joints + j) * Scalar::lanes;
    }
    [[nodiscard]] Scalar at(LoopBlock block, std::size_t j) const { return Scalar::load(row(block, j)); }
    void put(LoopBlock block, std::size_t j, const Scalar& x) const { x.store(row(block, j)); }
  };

  [[gnu::always_inline]] static void put(double value, int lane, Scalar& to) {
    double all[std::size_t{Scalar::lanes}];
    to.store(all);
    all[lane] = value;
    to = Scalar::load(all);
  }

  // M and N at y, M factored.
  [[gnu::always_inline]] static bool place(const DynamicsPlanOf<Scalar>& plan, const Scratch& s,
                                           const Scalar* y) {
    mass_and_bias(plan, y, y + plan.joints, s.dynamics, s.M, s.N);
    return factor(plan.joints, s.dynamics.stride, s.M, s.L, s.inverse_D, s.dynamics.wrenches);
  }

  // y' at the y of the last place().
  [[gnu::always_inline]] static void rate(const Loops& in, const Scratch& s, const Scalar* y, Scalar* rates) {
    const std::size_t n = in.joints;
    const Scalar* const qd = y + n;
    for (std::size_t j = 0; j < n; ++j) {
      rates[j] = qd[j];
      const Scalar f = (in.at(LoopBlock::drive, j) - in.at(LoopBlock::viscous, j) * qd[j]) - s.N[j];
      const Scalar speed = in.at(LoopBlock::direction, j) * qd[j];
      const Scalar lambda = in.at(LoopBlock::dry, j) + (Scalar(0.0) + in.at(LoopBlock::slope, j) * speed);
      rates[n + j] = f - lambda * in.at(LoopBlock::torque, j);
    }
    solve_factored(n, s.dynamics.stride, s.L, s.inverse_D, rates + n);
    if (in.sticking > 0) {
      hold(in, s, rates + n);
    }
  }

  // Of a row with an entry for each joint, that of the k-th joint that sticks; zero where there is none.
  [[gnu::always_inline]] static auto is_stuck(const Loops& in, std::size_t k, std::size_t joint) {
    const Scalar stuck = in.at(LoopBlock::stuck, k);
    const auto number = static_cast<double>(joint);
    return (stuck > Scalar(number - 0.5)) & (stuck < Scalar(number + 0.5));
  }
  template <typename Entry>
  [[gnu::always_inline]] static Scalar of_stuck(const Loops& in, std::size_t k, const Entry& entry) {
    auto out = Scalar(0.0);
    for (std::size_t j = 0; j < in.joints; ++j) {
      out = select(is_stuck(in, k, j), entry(j), out);
    }
    return out;
  }

  // StickSlip::accelerate() for the joints that stick, from the accelerations without what holds them.
  static void hold(const Loops& in, const Scratch& s, Scalar* qdd) {
    const std::size_t n = in.joints;
    const std::size_t m = in.sticking;
    const auto zero = Scalar(0.0);
    const auto A = [&](std::size_t r, std::size_t c) -> Scalar& { return s.system[r * n + c]; };
    for (std::size_t c = 0; c < m; ++c) {
      Scalar* const response = s.response + c * n;
      for (std::size_t j = 0; j < n; ++j) {
        response[j] = select(is_stuck(in, c, j), in.at(LoopBlock::torque, j), zero);
      }
      solve_factored(n, s.dynamics.stride, s.L, s.inverse_D, response);
      for (std::size_t r = 0; r < m; ++r) {
        A(r, c) =
            of_stuck(in, r, [&](std::size_t j) { return in.at(LoopBlock::direction, j) * response[j]; });
      }
      // Lanes where fewer stick have rows of the unit matrix.
      const auto none = in.at(LoopBlock::stuck, c) < zero;
      A(c, c) = select(none, Scalar(1.0), A(c, c) * Scalar(1.0 + stick_slip_regularisation));
      s.lambda[c] = of_stuck(in, c, [&](std::size_t j) { return in.at(LoopBlock::direction, j) * qdd[j]; });
    }
    eliminate(m, n, s.system, s.lambda);
    for (std::size_t c = 0; c < m; ++c) {
      for (std::size_t j = 0; j < n; ++j) {
        qdd[j] = qdd[j] - s.lambda[c] * s.response[c * n + j];
      }
    }
    for (std::size_t c = 0; c < m; ++c) {
      for (std::size_t j = 0; j < n; ++j) {
        qdd[j] = select(is_stuck(in, c, j), zero, qdd[j]);
      }
    }
  }

  // Whether the λ of the last rate() hold all joints that stick.
  [[gnu::always_inline]] static auto holds(const Loops& in, const Scratch& s) {
    auto out = Scalar(1.0) > Scalar(0.0);
    for (std::size_t k = 0; k < in.sticking; ++k) {
      out = out & (s.lambda[k] < in.at(LoopBlock::most, k)) & (s.lambda[k] > in.at(LoopBlock::least, k));
    }
    return out;
  }

  [[gnu::always_inline]] static Scalar larger(const Scalar& a, const Scalar& b) {
    return select(a < b, b, a);
  }

  // The error of the step; not_valid where a mode ends within it or a number is not finite, and one by one
  // has to find out.
  //
  // held  where the joints that stick were held at the beginning
  template <typename Mask>
  [[gnu::always_inline]] static Scalar judged(const Loops& in, const Scratch& s, const Scalar& h,
                                              const Mask& held) {
    const Scalar error = error_norm(in, s, h);
    const auto not_valid = Scalar(LoopStepKernel::not_valid);
    // An error that is too large is one, whatever happens in the step.
    const Scalar out = select(error > Scalar(1.0), error,
                              select(reverses(in, s, h), not_valid, select(holds(in, s), error, not_valid)));
    return select(held & (error < Scalar(largest_number)) & stays_finite(in, s), out, not_valid);
  }

  // RungeKutta::error_norm(); at least largest_number where a number is not finite.
  [[gnu::always_inline]] static Scalar error_norm(const Loops& in, const Scratch& s, const Scalar& h) {
    auto worst = Scalar(smallest_error);
    for (std::size_t i = 0; i < 2 * in.joints; ++i) {
      auto sum = Scalar(0.0);
      for (int stage = 0; stage < stages; ++stage) {
        sum = sum + (h * Scalar(Pair::error_weight[stage])) * s.rate(stage, i, in.joints);
      }
      const Scalar scale = in.at(LoopBlock::atol, 0) +
                           in.at(LoopBlock::rtol, 0) * larger(magnitude(s.y[i]), magnitude(s.next[i]));
      const Scalar error = magnitude(sum) / scale;
      // No comparison with what is no number holds.
      worst = larger(worst, select(error < Scalar(largest_number), error, Scalar(largest_number)));
    }
    return worst;
  }

  [[gnu::always_inline]] static auto stays_finite(const Loops& in, const Scratch& s) {
    const std::size_t n = in.joints;
    auto out = Scalar(1.0) > Scalar(0.0);
    for (std::size_t j = 0; j < n; ++j) {
      out = out & (magnitude(s.next[j]) < Scalar(largest_number)) &
            (magnitude(s.next[n + j]) < in.at(LoopBlock::fastest, 0));
    }
    return out;
  }

  // Whether something that slips comes to rest or turns round: RungeKutta::find_event() at the end and in the
  // middle of the step.
  [[gnu::always_inline]] static auto reverses(const Loops& in, const Scratch& s, const Scalar& h) {
    const std::size_t n = in.joints;
    const auto half = Scalar(0.5);
    const auto zero = Scalar(0.0);
    auto reversed = zero > Scalar(1.0);
    for (std::size_t j = 0; j < n; ++j) {
      const Scalar before = s.y[n + j];
      const Scalar change = s.next[n + j] - before;
      const Scalar bend = h * s.rate(0, n + j, n) - change;
      const Scalar twist = change - h * s.rate(stages - 1, n + j, n) - bend;
      const Scalar middle = before + half * (change + half * (bend + half * twist));
      const Scalar along = in.at(LoopBlock::sense, j) * in.at(LoopBlock::direction, j);
      reversed = reversed | (along * s.next[n + j] < zero) | (along * middle < zero);
    }
    return reversed;
  }
};

}  // namespace rivid::detail
