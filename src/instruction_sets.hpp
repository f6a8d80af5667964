#pragma once

// Kernels that are compiled once an instruction set, from kernel.cpp.in with flags for these files alone, and
// the choice among them at run time.
//
// An inline function or a template instance that such a file and another one both emit is kept once by the
// linker, for whichever machine it was compiled, and ends in an illegal instruction on an older one. So these
// files see plain pointers, neither Eigen nor the standard library, and everything in them has internal
// linkage. Function attributes (target, target_clones) would spare the files, but clang does not inline
// across them, and a register-blocked kernel that is not inlined is none.

namespace rivid::detail {

// `Set` below is this, or another enum with these names: rivid::Simd.
enum class InstructionSet { baseline, avx2, avx512 };

/// Whether this machine has it.
template <typename Set>
[[nodiscard]] bool available(Set set) {
  const bool any_machine = set != Set::avx2 && set != Set::avx512;
#if defined(__x86_64__)
  return any_machine || (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0 &&
                         (set == Set::avx2 || __builtin_cpu_supports("avx512f") != 0));
#else
  return any_machine;
#endif
}

/// The best that this machine has.
template <typename Set = InstructionSet>
[[nodiscard]] Set fastest() {
  return available(Set::avx512) ? Set::avx512 : available(Set::avx2) ? Set::avx2 : Set::baseline;
}

/// What the file of an instruction set defines of a kind of kernel, see kernel.cpp.in.
template <typename Kernel, InstructionSet set>
[[nodiscard]] const Kernel& instance();

/// A kind of kernel for an instruction set.
template <typename Kernel, typename Set = InstructionSet>
[[nodiscard]] const Kernel& kernel_for(Set set = fastest<Set>()) {
  return set == Set::avx512 ? instance<Kernel, InstructionSet::avx512>()
         : set == Set::avx2 ? instance<Kernel, InstructionSet::avx2>()
                            : instance<Kernel, InstructionSet::baseline>();
}

}  // namespace rivid::detail
