#pragma once

#include "instruction_sets.hpp"
#include "rivid/simulate/dynamics_kernel.hpp"

// Direct dynamics for packs of samples. This file is compiled once for each instruction set;
// rivid/regressor/kernel.hpp says what that forbids.
namespace rivid::detail {

// First samples of columns, one a joint, that lie so many doubles apart.
struct DynamicsBatchInput {
  const double* q;
  const double* qd;
  const double* tau;
  double* qdd;
  std::ptrdiff_t q_stride, qd_stride, tau_stride, qdd_stride;
};

// What one file for an instruction set offers: q̈ = M⁻¹ (τ − N) of `packs` times `lanes` consecutive samples.
struct DynamicsBatchKernel {
  int lanes;
  // Returns the number of packs done: all, or those before the first one where some M is not positive
  // definite. scratch: dynamics_scratch(), aligned to 64 bytes.
  std::size_t (*run)(const DynamicsPlan& plan, const DynamicsBatchInput& in, std::size_t packs,
                     double* scratch);
};

// Doubles of scratch for packs of so many lanes.
[[gnu::always_inline]] constexpr std::size_t dynamics_scratch(std::size_t lanes, std::size_t joints,
                                                              std::size_t forks) {
  const std::size_t stride = dynamics_stride(joints);
  return lanes * (7 * joints + 2 + 6 * joints + (6 + 2 * joints) * stride + forks * fork_scalars(stride));
}

template <typename Scalar>
std::size_t accelerate_packs(const DynamicsPlan& plan, const DynamicsBatchInput& in, std::size_t packs,
                             double* memory) {
  const std::size_t n = plan.joints;
  const std::size_t stride = dynamics_stride(n);
  auto* next = reinterpret_cast<Scalar*>(memory);
  const auto taken = [&](std::size_t count) {
    Scalar* const out = next;
    next += count;
    return out;
  };
  Scalar* const q = taken(n);
  Scalar* const qd = taken(n);
  Scalar* const b = taken(n);
  Scalar* const N = taken(n);
  Scalar* const inverse_D = taken(n);
  Scalar* const M = taken(n * stride);
  Scalar* const L = taken(n * stride);
  Scalar* const cosines = taken(n + 1);
  Scalar* const sines = taken(n + 1);
  auto* const own = reinterpret_cast<Wrench<Scalar>*>(taken(6 * n));
  Scalar* const wrenches = taken(6 * stride);
  auto* const forks = reinterpret_cast<DynamicsFork<Scalar>*>(taken(34 * plan.forks));
  const DynamicsScratch<Scalar> scratch = {
      cosines, sines, own, wrenches, stride, forks, taken(6 * stride * plan.forks)};
  for (std::size_t k = 0; k < packs; ++k) {
    const auto first = static_cast<std::ptrdiff_t>(k) * Scalar::lanes;
    for (std::size_t j = 0; j < n; ++j) {
      const auto column = static_cast<std::ptrdiff_t>(j);
      q[j] = Scalar::load(in.q + column * in.q_stride + first);
      qd[j] = Scalar::load(in.qd + column * in.qd_stride + first);
    }
    mass_and_bias(plan, q, qd, scratch, M, N);
    if (!factor(n, stride, M, L, inverse_D, scratch.wrenches)) {
      return k;
    }
    for (std::size_t j = 0; j < n; ++j) {
      b[j] = Scalar::load(in.tau + static_cast<std::ptrdiff_t>(j) * in.tau_stride + first) - N[j];
    }
    solve_factored(n, stride, L, inverse_D, b);
    for (std::size_t j = 0; j < n; ++j) {
      b[j].store(in.qdd + static_cast<std::ptrdiff_t>(j) * in.qdd_stride + first);
    }
  }
  return packs;
}

}  // namespace rivid::detail
