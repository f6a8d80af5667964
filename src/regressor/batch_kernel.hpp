#pragma once

#include "instruction_sets.hpp"
#include "rivid/regressor/kernel.hpp"

// The batches' part of the kernel, see there for what the files of one instruction set forbid.
namespace rivid::detail {

// Doubles that a kernel of so many lanes writes its intermediate values to.
[[gnu::always_inline]] constexpr std::size_t kernel_scratch(std::size_t lanes, std::size_t joints,
                                                            std::size_t forks) {
  return lanes * (8 * joints + forks * (18 + 6 * joints));
}

// What one file for an instruction set offers: rows of `packs` times `lanes` consecutive samples.
struct BatchKernel {
  int lanes;
  // columns: as for fill_rows(). scratch: kernel_scratch(), aligned to 64 bytes.
  void (*fill)(const RegressorPlan& plan, const RegressorInput<double>& input, std::size_t packs,
               double* const* columns, double* scratch);
};

template <typename Scalar>
void fill_packs(const RegressorPlan& plan, const RegressorInput<double>& input, std::size_t packs,
                double* const* columns, double* scratch) {
  auto* const screws = reinterpret_cast<Screw<Scalar>*>(scratch);
  auto* const angles = reinterpret_cast<CosSin<Scalar>*>(screws + plan.joints);
  auto* const forks = reinterpret_cast<ForkState<Scalar>*>(angles + plan.joints);
  fill_rows<Scalar>(plan, input, packs, columns,
                    {screws, angles, forks, reinterpret_cast<Screw<Scalar>*>(forks + plan.forks)});
}

}  // namespace rivid::detail
