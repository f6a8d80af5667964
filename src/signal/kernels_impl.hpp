#pragma once

// Included by one file an instruction set, see signal_kernels.hpp.

#include "signal/signal_kernels.hpp"

namespace rivid::detail {

namespace {

// Shuffles of vectors that the machine has to split would be taken apart number by number: only Half is
// shuffled.
using Lanes = double __attribute__((vector_size(64)));
using Half = double __attribute__((vector_size(32)));

// Transposed direct form II, section after section: the recursion of one column waits for its own last
// result, so eight columns side by side cost no more than one.
void run_cascade(const double* coefficients, long sections, double* states, double* x, long n) {
  for (long i = 0; i < sections; ++i) {
    const double* const s = coefficients + 5 * i;
    Lanes z1;
    Lanes z2;
    __builtin_memcpy(&z1, states + 16 * i, sizeof z1);
    __builtin_memcpy(&z2, states + 16 * i + 8, sizeof z2);
    for (long k = 0; k < n; ++k) {
      Lanes in;
      __builtin_memcpy(&in, x + 8 * k, sizeof in);
      const Lanes out = s[0] * in + z1;
      z1 = (s[1] * in + z2) - s[3] * out;
      z2 = s[2] * in - s[4] * out;
      __builtin_memcpy(x + 8 * k, &out, sizeof out);
    }
    __builtin_memcpy(states + 16 * i, &z1, sizeof z1);
    __builtin_memcpy(states + 16 * i + 8, &z2, sizeof z2);
  }
}

static_assert(decimation_modes == 4, "the real parts of a state fill one half");

template <typename Vec>
Vec load(const double* p) {
  Vec out;
  __builtin_memcpy(&out, p, sizeof out);
  return out;
}

template <typename Vec>
void store(double* p, const Vec& x) {
  __builtin_memcpy(p, &x, sizeof x);
}

// Sums and differences of the samples that share their weights, since the forward weights are the backward
// ones read from the other end.
void fold(const double* x, long n_d, double* sum, double* difference) {
  const long pairs = (n_d - 1) / 2;
  const double* const last = x + n_d - 2;
  long k = 0;
  for (; k + 4 <= pairs; k += 4) {
    const Half near = load<Half>(x + k);
    const Half mirrored = load<Half>(last - k - 3);
    const Half far = __builtin_shufflevector(mirrored, mirrored, 3, 2, 1, 0);
    store(sum + k, near + far);
    store(difference + k, near - far);
  }
  for (; k < pairs; ++k) {
    sum[k] = x[k] + last[-k];
    difference[k] = x[k] - last[-k];
  }
  if (n_d % 2 == 0) {
    sum[k] = x[k];
    difference[k] = x[k];
    ++k;
  }
  sum[k] = x[n_d - 1];
  difference[k] = x[n_d - 1];
}

// Forward projections of segments side by side, which hides the latency of the additions, and backward ones
// behind them.
template <unsigned long Together>
void project(const double* weights, long terms, const double* folded, double* out) {
  Lanes half_sum[Together] = {};
  Lanes half_difference[Together] = {};
  const auto row = [terms](unsigned long s) { return 2 * terms * static_cast<long>(s); };
  for (long k = 0; k < terms; ++k) {
    const Lanes even = load<Lanes>(weights + 16 * k);
    const Lanes odd = load<Lanes>(weights + 16 * k + 8);
    for (unsigned long s = 0; s < Together; ++s) {
      half_sum[s] += even * folded[row(s) + k];
      half_difference[s] += odd * folded[row(s) + terms + k];
    }
  }
  for (unsigned long s = 0; s < Together; ++s) {
    store(out + 16 * s, half_sum[s] + half_difference[s]);
    store(out + 16 * s + 8, half_sum[s] - half_difference[s]);
  }
}

struct State {
  Half re;
  Half im;

  static State at(const double* p) { return {load<Half>(p), load<Half>(p + 4)}; }
  void to(double* p) const {
    store(p, re);
    store(p + 4, im);
  }
  // step · this + added, by as few operations in a row as can be.
  [[nodiscard]] State advanced(const State& step, const State& added) const {
    return {step.re * re + (added.re - step.im * im), step.re * im + (added.im + step.im * re)};
  }
  // What each mode adds to the row at the place of the state.
  [[nodiscard]] Half shown(const State& residue) const { return residue.re * re - residue.im * im; }
};

double total(const Half& x) { return (x[0] + x[2]) + (x[1] + x[3]); }

// The sums of the lanes of four vectors, each the sum of two.
Half totals(const double* v, const double* w) {
  const Half a = load<Half>(v) + load<Half>(w);
  const Half b = load<Half>(v + 4) + load<Half>(w + 4);
  const Half c = load<Half>(v + 8) + load<Half>(w + 8);
  const Half d = load<Half>(v + 12) + load<Half>(w + 12);
  const Half ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Half cd = __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

// to[r] = from[r] + re · real[r] + im · imaginary[r]; `to` may lie before `from`.
void add_mode(double re, double im, const double* real, const double* imaginary, long count,
              const double* from, double* to) {
  long r = 0;
  for (; r + 8 <= count; r += 8) {
    store(to + r, load<Lanes>(from + r) + re * load<Lanes>(real + r) + im * load<Lanes>(imaginary + r));
  }
  for (; r < count; ++r) {
    to[r] = from[r] + re * real[r] + im * imaginary[r];
  }
}

void decimate_segments(const DecimationTables& tables, const double* x, long segments, const double* later,
                       double* state, double* open, long first, long count, double* folded) {
  const long n_d = tables.n_d;
  const long terms = folded_terms(n_d);
  double projected[16 * most_segments];
  double shown[4 * most_segments];
  double shown_later[4 * most_segments];
  for (long s = 0; s < segments; ++s) {
    fold(x + n_d * s, n_d, folded + 2 * terms * s, folded + 2 * terms * s + terms);
  }
  long s = 0;
  for (; s + 4 <= segments; s += 4) {
    project<4>(tables.weights, terms, folded + 2 * terms * s, projected + 16 * s);
  }
  for (; s < segments; ++s) {
    project<1>(tables.weights, terms, folded + 2 * terms * s, projected + 16 * s);
  }

  const State step = State::at(tables.step);
  const State residue = State::at(tables.residue);
  // Both ways at once, since each waits for its own last result.
  State forward = State::at(state);
  State backward = State::at(later);
  for (s = 0; s < segments; ++s) {
    const long back = segments - 1 - s;
    store(shown_later + 4 * back, backward.shown(residue));
    backward = backward.advanced(step, State::at(projected + 16 * back + 8));
    forward = forward.advanced(step, State::at(projected + 16 * s));
    store(shown + 4 * s, forward.shown(residue));
  }
  forward.to(state);

  const long youngest = count - 1;
  const long reached = tables.reach[0] < youngest ? tables.reach[0] : youngest;
  for (long r = 0; first > 0 && r < youngest - reached; ++r) {
    open[r] = open[first + r];
  }
  const double youngest_row = open[first + youngest];
  for (long i = 0; i < decimation_modes; ++i) {
    const long near = tables.reach[i] < reached ? tables.reach[i] : reached;
    const double* const real = tables.fading + (i + 1) * tables.length - near;
    double* const to = open + youngest - near;
    add_mode(backward.re[i], backward.im[i], real, real + decimation_modes * tables.length, near,
             i == 0 ? to + first : to, to);
  }
  open[youngest] = youngest_row + total(backward.shown(residue));

  double* const fresh = open + count;
  for (s = 0; s + 4 <= segments; s += 4) {
    store(fresh + s, totals(shown + 4 * s, shown_later + 4 * s));
  }
  for (; s < segments; ++s) {
    fresh[s] = total(load<Half>(shown + 4 * s) + load<Half>(shown_later + 4 * s));
  }
  for (s = 0; s < segments; ++s) {
    fresh[s] += tables.direct * x[n_d * (s + 1) - 1];
  }
}

}  // namespace
}  // namespace rivid::detail
