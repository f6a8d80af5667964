#pragma once

// The hot paths of filters and decimation, compiled once an instruction set, see instruction_sets.hpp.

#include "instruction_sets.hpp"

namespace rivid::detail {

inline constexpr int decimation_modes = 4;  // pairs of conjugate poles of the order-8 filter

// What the kernel reads of a StreamingDecimator. The states of the modes are eight numbers, real parts before
// imaginary ones.
struct DecimationTables {
  long n_d = 0;
  // (16 × terms): the weights of the folded samples of a segment in half the sum and half the difference of
  // its forward and its backward projection.
  const double* weights = nullptr;
  const double* step =
      nullptr;  // p_i^n_d: (8) factors of a state, (8) factors of it with its halves exchanged
  const double* residue = nullptr;  // (8): inner product with a state is what it adds to the row at its place
  double direct = 0.0;              // coefficient of x[k] beside the modes
  // (8 × length), row by row of this list one part of a mode: what a backward state adds to the rows before
  // it, the farthest first.
  const double* fading = nullptr;
  long length = 0;
  const long* reach =
      nullptr;  // (4): how many of the nearest rows a mode reaches; the first one reaches farthest
};

// Segments that one call may take at most.
inline constexpr long most_segments = 80;
// Folded samples of a segment: pairs m, n_d − 2 − m; the middle one where n_d is even; the last one.
inline long folded_terms(long n_d) { return (n_d - 1) / 2 + (n_d % 2 == 0 ? 1 : 0) + 1; }

struct SignalKernels {
  /// One column of a decimation. Takes `segments` of n_d samples at x; moves its open rows first … first +
  /// count − 1, the youngest last, to the place of row 0, with what the segments add to them; and appends one
  /// row for each segment.
  ///
  /// later  (8): backward state that the samples behind these segments leave at the last of them
  /// state  (8): forward state at the youngest row, brought forward
  /// folded (2 folded_terms × segments): scratch
  void (*decimate)(const DecimationTables& tables, const double* x, long segments, const double* later,
                   double* state, double* open, long first, long count, double* folded);
  /// A cascade of second-order sections in place over n instants of eight columns.
  ///
  /// coefficients (5 × sections): b0 b1 b2 a1 a2
  /// states       (16 × sections): the two of each section for eight columns, brought forward
  /// x            (8 × n)
  void (*cascade)(const double* coefficients, long sections, double* states, double* x, long n);
};

/// The fastest that this machine can run.
[[nodiscard]] inline const SignalKernels& signal_kernels() {
  static const SignalKernels& once = kernel_for<SignalKernels>();
  return once;
}

}  // namespace rivid::detail
