#pragma once

namespace rivid::detail {

inline constexpr int projections = 16;

// out[16 s + i] = Σ_m weights[16 m + i] x[n_d s + m]: inner products of consecutive segments of n_d samples with 16 weight
// vectors. Runs at the widest vectors that the machine has.
void project_segments(const double* weights, long n_d, const double* x, long segments, double* out);

}  // namespace rivid::detail
