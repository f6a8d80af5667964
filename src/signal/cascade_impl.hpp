#pragma once

// Included by one file an instruction set, see signal_kernels.hpp.

#include "signal/signal_kernels.hpp"

namespace rivid::detail {

namespace {

using CascadeLanes = double __attribute__((vector_size(64)));

// Transposed direct form II, section after section: the recursion of one column waits for its own last result, so eight
// columns side by side cost no more than one.
void run_cascade(const double* coefficients, long sections, double* states, double* x, long n) {
  for (long i = 0; i < sections; ++i) {
    const double* const s = coefficients + 5 * i;
    CascadeLanes z1;
    CascadeLanes z2;
    __builtin_memcpy(&z1, states + 16 * i, sizeof z1);
    __builtin_memcpy(&z2, states + 16 * i + 8, sizeof z2);
    for (long k = 0; k < n; ++k) {
      CascadeLanes in;
      __builtin_memcpy(&in, x + 8 * k, sizeof in);
      const CascadeLanes out = s[0] * in + z1;
      z1 = (s[1] * in + z2) - s[3] * out;
      z2 = s[2] * in - s[4] * out;
      __builtin_memcpy(x + 8 * k, &out, sizeof out);
    }
    __builtin_memcpy(states + 16 * i, &z1, sizeof z1);
    __builtin_memcpy(states + 16 * i + 8, &z2, sizeof z2);
  }
}

}  // namespace
}  // namespace rivid::detail
