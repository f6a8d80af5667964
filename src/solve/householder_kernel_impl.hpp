#pragma once

// Included by one file an instruction set; see instruction_sets.hpp for why, and for what must not be
// included.
//
// [R; B] is eliminated in panels of eight columns. The reflector of column k has a 1 in row k of the
// triangle, zeros in its other rows, and a vector v over the rows of the block: so the triangle costs one row
// a reflector.
//
//  - panel:  one pass over its eight columns a reflector: the pass that applies reflector j also takes the
//    inner products of the next column with the later columns (its reflection) and with the earlier ones (the
//    factor T of the compact WY form).
//  - update: the columns on the right, three at a time, see all eight reflectors at once:
//      z = R_panel + Vᵀ B,  y = Tᵀ z,  R_panel −= y,  B −= V y,
//    with the eight by three inner products, and then the eight by three coefficients, in registers.

#include "solve/householder_kernel.hpp"

namespace rivid::detail {
namespace {

constexpr std::ptrdiff_t ld = block_stride;
constexpr int width = panel_columns;

// A vector of doubles: `sums`, the sums of the lanes of as many vectors as there are lanes; and `keep`, which
// has the compiler load a value once into a register where it would read it from memory for each use: with
// three uses that makes loads the bottleneck.
template <int Lanes>
struct Vectors;

template <>
struct Vectors<2> {
  using Vec [[gnu::vector_size(16)]] = double;
  using Bits [[gnu::vector_size(16)]] = long long;

  static void keep(Vec& /*v*/) {}
  static Vec sums(const Vec* a) {
    return __builtin_shufflevector(a[0], a[1], 0, 2) + __builtin_shufflevector(a[0], a[1], 1, 3);
  }
};

#if defined(__AVX2__)
template <>
struct Vectors<4> {
  using Vec [[gnu::vector_size(32)]] = double;
  using Bits [[gnu::vector_size(32)]] = long long;

  static void keep(Vec& v) { asm("" : "+x"(v)); }
  static Vec pair(Vec a, Vec b) {
    return __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  }
  static Vec sums(const Vec* a) {
    const Vec low = pair(a[0], a[1]);
    const Vec high = pair(a[2], a[3]);
    return __builtin_shufflevector(low, high, 0, 1, 4, 5) + __builtin_shufflevector(low, high, 2, 3, 6, 7);
  }
};
#endif

#if defined(__AVX512F__)
template <>
struct Vectors<8> {
  using Vec [[gnu::vector_size(64)]] = double;
  using Bits [[gnu::vector_size(64)]] = long long;

  static void keep(Vec& v) { asm("" : "+v"(v)); }
  static Vec pair(Vec a, Vec b) {
    return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14) +
           __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  }
  static Vec quad(Vec a, Vec b) {
    return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
           __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  }
  static Vec sums(const Vec* a) {
    const Vec low = quad(pair(a[0], a[1]), pair(a[2], a[3]));
    const Vec high = quad(pair(a[4], a[5]), pair(a[6], a[7]));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 8, 9, 10, 11) +
           __builtin_shufflevector(low, high, 4, 5, 6, 7, 12, 13, 14, 15);
  }
};
#endif

template <int lanes>
class Householder {
  using Vec = typename Vectors<lanes>::Vec;
  using Bits = typename Vectors<lanes>::Bits;
  // Reflectors whose inner products (or coefficients) with three columns fit the registers: 32 of AVX-512, 16
  // of others.
  static constexpr int tile_size = lanes == 8 ? 8 : 4;

  static Vec load(const double* p) {
    Vec v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
  }
  static void store(double* p, Vec v) { __builtin_memcpy(p, &v, sizeof v); }
  static Vec broadcast(double x) { return x - Vec{}; }

  static double total(Vec v) {
    double out = 0.0;
    for (int i = 0; i < lanes; ++i) {
      out += v[i];
    }
    return out;
  }

  // out[i] = sum of the lanes of a[i].
  template <int Count>
  static void lane_sums(const Vec* a, double* out) {
    for (int i = 0; i < Count; i += lanes) {
      store(out + i, Vectors<lanes>::sums(a + i));
    }
  }

  struct Panel {
    double* V = nullptr;     // eight columns of the block; the reflectors when done
    double R[width][width];  // [column][row] of the triangle
    double S[width][width];  // [column j][i] = v_i · v_j for i < j
    double tau[width];
    double T[width][width];  // [row][column], zero below the diagonal
  };

  // What the pass over the rows needs to apply a reflector to the columns behind it.
  struct Reflector {
    double scale = 0.0;  // v = scale × column
    double w[width]{};   // column c −= v w[c]
  };

  // From the inner products of column j with all eight.
  static Reflector reflector(Panel& p, int j, const double* products) {
    Reflector h;
    const double alpha = p.R[j][j];
    const double squares = products[j];
    p.tau[j] = 0.0;
    if (squares > 0.0) {
      const double norm = __builtin_sqrt(alpha * alpha + squares);
      const double beta = alpha > 0.0 ? -norm : norm;
      p.tau[j] = (beta - alpha) / beta;
      h.scale = 1.0 / (alpha - beta);
      p.R[j][j] = beta;
    }
    for (int i = 0; i < j; ++i) {
      p.S[j][i] = h.scale * products[i];
    }
    for (int c = j + 1; c < width; ++c) {
      h.w[c] = p.tau[j] * (p.R[c][j] + h.scale * products[c]);
      p.R[c][j] -= h.w[c];
    }
    return h;
  }

  // Applies reflector J, and takes the inner products of column J + 1 with all.
  template <int J>
  static void pass(double* V, const Reflector& h, std::ptrdiff_t rows, double* products) {
    Vec sum[width] = {};
    Vec w[width];
    for (int c = J + 1; c < width; ++c) {
      w[c] = broadcast(h.w[c]);
    }
    const Vec scale = broadcast(h.scale);
    for (std::ptrdiff_t r = 0; r < rows; r += lanes) {
      double* const at = V + r;
      const Vec v = load(at + J * ld) * scale;
      store(at + J * ld, v);
      if constexpr (J + 1 < width) {
        const Vec next = load(at + (J + 1) * ld) - v * w[J + 1];
        store(at + (J + 1) * ld, next);
        sum[J + 1] += next * next;
        for (int c = J + 2; c < width; ++c) {
          const Vec later = load(at + c * ld) - v * w[c];
          store(at + c * ld, later);
          sum[c] += next * later;
        }
        sum[J] += next * v;
        for (int c = 0; c < J; ++c) {
          sum[c] += next * load(at + c * ld);
        }
      }
    }
    lane_sums<width>(sum, products);
  }

  template <int J>
  static void columns_from(Panel& p, std::ptrdiff_t rows, double* products) {
    if constexpr (J < width) {
      const Reflector h = reflector(p, J, products);
      pass<J>(p.V, h, rows, products);
      columns_from<J + 1>(p, rows, products);
    }
  }

  // The first pass of the first panel sums the columns, too.
  template <bool First>
  static void factor(Panel& p, std::ptrdiff_t rows, double* sums) {
    Vec sum[width] = {};
    Vec plain[width] = {};  // NOLINT(misc-const-correctness): the first panel adds to it
    for (std::ptrdiff_t r = 0; r < rows; r += lanes) {
      const Vec first = load(p.V + r);
      for (int c = 0; c < width; ++c) {
        const Vec value = load(p.V + r + c * ld);
        sum[c] += first * value;
        if constexpr (First) {
          plain[c] += value;
        }
      }
    }
    if constexpr (First) {
      lane_sums<width>(plain, sums);
    }
    double products[width];
    lane_sums<width>(sum, products);
    columns_from<0>(p, rows, products);
    // H_0 … H_7 = I − V T Vᵀ, column by column: T(0:j, j) = −tau_j T(0:j, 0:j) Vᵀ v_j.
    for (int j = 0; j < width; ++j) {
      for (int i = 0; i < width; ++i) {
        double t = i == j ? p.tau[j] : 0.0;
        for (int l = i; l < j; ++l) {
          t -= p.tau[j] * p.T[i][l] * p.S[j][l];
        }
        p.T[i][j] = t;
      }
    }
  }

  // All reflectors of the panel on `Count` columns; R points to the panel's rows of the first of them.
  template <int Count, bool First>
  static void update(const Panel& p, double* R, std::ptrdiff_t R_stride, double* B, std::ptrdiff_t rows,
                     double* sums) {
    Vec plain[std::size_t{Count}] = {};  // NOLINT(misc-const-correctness): the first panel adds to it
    double y[std::size_t{Count}][width];
    for (int tile = 0; tile < width; tile += tile_size) {
      const double* const V = p.V + tile * ld;
      Vec sum[std::size_t{Count}][std::size_t{tile_size}] = {};
      for (std::ptrdiff_t r = 0; r < rows; r += lanes) {
        Vec b[std::size_t{Count}];
        for (int c = 0; c < Count; ++c) {
          b[c] = load(B + c * ld + r);
          if constexpr (First) {
            plain[c] += tile == 0 ? b[c] : Vec{};
          }
        }
        for (int i = 0; i < tile_size; ++i) {
          Vec v = load(V + i * ld + r);
          Vectors<lanes>::keep(v);
          for (int c = 0; c < Count; ++c) {
            sum[c][i] += v * b[c];
          }
        }
      }
      for (int c = 0; c < Count; ++c) {
        lane_sums<tile_size>(sum[c], y[c] + tile);
      }
    }
    if constexpr (First) {
      for (int c = 0; c < Count; ++c) {
        sums[c] += total(plain[c]);
      }
    }
    for (int c = 0; c < Count; ++c) {
      double* const top = R + c * R_stride;
      Vec out[std::size_t{width / lanes}] = {};
      for (int i = 0; i < width; ++i) {
        const Vec z = broadcast(y[c][i] + top[i]);
        for (std::ptrdiff_t part = 0; part < width / lanes; ++part) {
          out[part] += z * load(p.T[i] + part * lanes);
        }
      }
      for (std::ptrdiff_t part = 0; part < width / lanes; ++part) {
        store(y[c] + part * lanes, out[part]);
        store(top + part * lanes, load(top + part * lanes) - out[part]);
      }
    }
    for (int tile = 0; tile < width; tile += tile_size) {
      const double* const V = p.V + tile * ld;
      Vec factor[std::size_t{Count}][std::size_t{tile_size}];
      for (int c = 0; c < Count; ++c) {
        for (int i = 0; i < tile_size; ++i) {
          factor[c][i] = broadcast(y[c][tile + i]);
        }
      }
      for (std::ptrdiff_t r = 0; r < rows; r += lanes) {
        Vec b[std::size_t{Count}];
        for (int c = 0; c < Count; ++c) {
          b[c] = load(B + c * ld + r);
        }
        for (int i = 0; i < tile_size; ++i) {
          Vec v = load(V + i * ld + r);
          Vectors<lanes>::keep(v);
          for (int c = 0; c < Count; ++c) {
            b[c] -= v * factor[c][i];
          }
        }
        for (int c = 0; c < Count; ++c) {
          store(B + c * ld + r, b[c]);
        }
      }
    }
  }

  static double squares(const double* x, std::ptrdiff_t count) {
    Vec parts = {};
    for (std::ptrdiff_t r = 0; r < count; r += lanes) {
      parts += load(x + r) * load(x + r);
    }
    return total(parts);
  }

  static void sum_carried(const HouseholderBlock& block) {
    for (std::ptrdiff_t c = 0; c < block.carried; ++c) {
      Vec plain = {};
      for (std::ptrdiff_t r = 0; r < block.row_count; r += lanes) {
        plain += load(block.rows + c * ld + r);
      }
      block.sums[c] += total(plain);
    }
  }

  template <bool First>
  static void eliminate_panel(const HouseholderBlock& block, std::ptrdiff_t first) {
    const std::ptrdiff_t all = block.columns + block.carried;
    const std::ptrdiff_t rows = block.row_count;
    const std::ptrdiff_t left = block.columns - first;
    const std::ptrdiff_t own = left < width ? left : width;
    Panel p;
    alignas(64) double scratch[width * ld];
    p.V = block.rows + first * ld;
    if (own < width) {
      // The last panel is narrower: zero columns, whose reflectors do nothing, fill it up.
      for (std::ptrdiff_t c = 0; c < width; ++c) {
        for (std::ptrdiff_t r = 0; r < rows; r += lanes) {
          store(scratch + c * ld + r, c < own ? load(p.V + c * ld + r) : Vec{});
        }
      }
      p.V = scratch;
    }
    double* const corner = block.R + first * block.R_stride + first;
    for (std::ptrdiff_t c = 0; c < width; ++c) {
      for (std::ptrdiff_t i = 0; i < width; ++i) {
        p.R[c][i] = c < own ? corner[c * block.R_stride + i] : 0.0;
      }
    }
    double sums[width];
    factor<First>(p, rows, sums);
    for (std::ptrdiff_t c = 0; c < own; ++c) {
      for (std::ptrdiff_t i = 0; i <= c; ++i) {
        corner[c * block.R_stride + i] = p.R[c][i];
      }
      if constexpr (First) {
        block.sums[c] += sums[c];
      }
    }
    std::ptrdiff_t c = first + own;
    while (c < all) {
      double* const R = block.R + c * block.R_stride + first;
      double* const B = block.rows + c * ld;
      // Two and two rather than three and one.
      const std::ptrdiff_t open = all - c;
      if (open == 3 || open > 4) {
        update<3, First>(p, R, block.R_stride, B, rows, block.sums + c);
        c += 3;
      } else if (open >= 2) {
        update<2, First>(p, R, block.R_stride, B, rows, block.sums + c);
        c += 2;
      } else {
        update<1, First>(p, R, block.R_stride, B, rows, block.sums + c);
        c += 1;
      }
    }
  }

  // Magnitudes compare as the integers that their bits make, and those of a nan lie above infinity's: so the
  // sign of limit − magnitude, gathered by or, says so without a branch.
  template <typename See>
  static bool within(const double* values, std::ptrdiff_t count, double limit, const See& see) {
    constexpr long long magnitude = __LONG_LONG_MAX__;
    const auto most = __builtin_bit_cast(long long, limit);
    Bits outside = {};
    std::ptrdiff_t r = 0;
    for (; r + lanes <= count; r += lanes) {
      const Vec v = load(values + r);
      see(r, v);
      outside |= most - (__builtin_bit_cast(Bits, v) & magnitude);
    }
    long long any = 0;
    for (int i = 0; i < lanes; ++i) {
      any |= outside[i];
    }
    for (; r < count; ++r) {
      see(r, values[r]);
      any |= most - (__builtin_bit_cast(long long, values[r]) & magnitude);
    }
    return any >= 0;
  }

 public:
  static void eliminate(const HouseholderBlock& block) {
    if (block.columns > 0) {
      eliminate_panel<true>(block, 0);
    } else {
      sum_carried(block);
    }
    for (std::ptrdiff_t first = width; first < block.columns; first += width) {
      eliminate_panel<false>(block, first);
    }
    for (std::ptrdiff_t c = 0; c < block.carried; ++c) {
      block.rest_squares[c] = squares(block.rows + (block.columns + c) * ld, block.row_count);
    }
  }

  static bool copy_within(const double* from, std::ptrdiff_t count, double limit, double* to,
                          const double* next) {
    return within(from, count, limit, [to, next](std::ptrdiff_t r, auto value) {
      __builtin_prefetch(next + r);
      __builtin_memcpy(to + r, &value, sizeof value);
    });
  }

  static bool all_within(const double* values, std::ptrdiff_t count, double limit) {
    return within(values, count, limit, [](std::ptrdiff_t, auto) {});
  }

  static constexpr HouseholderKernel kernel() { return {lanes, eliminate, copy_within, all_within}; }
};

}  // namespace
}  // namespace rivid::detail
