#pragma once

#include <cstddef>

#include "instruction_sets.hpp"
#include "rivid/regressor/pack.hpp"

// Products of the tall, narrow matrices of a design. Compiled once an instruction set; see
// rivid/regressor/kernel.hpp for what that forbids.
namespace rivid::detail {

// A matrix, column by column.
struct TallMatrix {
  const double* data;
  std::ptrdiff_t ld;
  std::ptrdiff_t rows;
  std::ptrdiff_t columns;
};

template <typename Scalar>
class Products {
 public:
  // out = lower triangle of Wᵀ W, (columns × columns).
  static void gram(const TallMatrix& W, double* out) {
    for (std::ptrdiff_t c = 0; c < W.columns; c += tile) {
      for (std::ptrdiff_t r = c; r < W.columns; r += tile) {
        gram_tile(W, r, c, out);
      }
    }
  }

  // out = W K, K symmetric.
  static void product(const TallMatrix& W, const double* K, double* out, std::ptrdiff_t out_ld) {
    for (std::ptrdiff_t c = 0; c < W.columns; c += tile) {
      std::ptrdiff_t r = 0;
      for (; r + deep * lanes <= W.rows; r += deep * lanes) {
        product_tile<deep>(W, K, r, c, out, out_ld);
      }
      for (; r + lanes <= W.rows; r += lanes) {
        product_tile<1>(W, K, r, c, out, out_ld);
      }
      for (; r < W.rows; ++r) {
        for (std::ptrdiff_t i = c; i < c + tile && i < W.columns; ++i) {
          double sum = 0.0;
          for (std::ptrdiff_t d = 0; d < W.columns; ++d) {
            sum += W.data[d * W.ld + r] * K[i * W.columns + d];
          }
          out[i * out_ld + r] = sum;
        }
      }
    }
  }

 private:
  static constexpr std::ptrdiff_t lanes = Scalar::lanes;
  // So many accumulators fit the registers: 32 of AVX-512, 16 of others.
  static constexpr std::ptrdiff_t tile = lanes == 8 ? 4 : 3;
  static constexpr std::ptrdiff_t deep = lanes == 8 ? 4 : 3;

  // A tile that reaches over the edge takes the last column again, and throws it away.
  static void gram_tile(const TallMatrix& W, std::ptrdiff_t first, std::ptrdiff_t second, double* out) {
    const double* a[std::size_t{tile}];
    const double* b[std::size_t{tile}];
    for (std::ptrdiff_t i = 0; i < tile; ++i) {
      const auto column = [&](std::ptrdiff_t c) {
        return W.data + (c < W.columns ? c : W.columns - 1) * W.ld;
      };
      a[i] = column(first + i);
      b[i] = column(second + i);
    }
    Scalar sum[std::size_t{tile}][std::size_t{tile}];
    for (auto& row : sum) {
      for (Scalar& x : row) {
        x = Scalar(0.0);
      }
    }
    std::ptrdiff_t r = 0;
    for (; r + lanes <= W.rows; r += lanes) {
      Scalar left[std::size_t{tile}];
      for (std::ptrdiff_t i = 0; i < tile; ++i) {
        left[i] = Scalar::load(a[i] + r);
      }
      for (std::ptrdiff_t j = 0; j < tile; ++j) {
        const Scalar right = Scalar::load(b[j] + r);
        for (std::ptrdiff_t i = 0; i < tile; ++i) {
          sum[i][j] = sum[i][j] + left[i] * right;
        }
      }
    }
    for (std::ptrdiff_t i = 0; i < tile && first + i < W.columns; ++i) {
      for (std::ptrdiff_t j = 0; j < tile && second + j < W.columns; ++j) {
        double total = 0.0;
        for (int lane = 0; lane < lanes; ++lane) {
          total += sum[i][j][lane];
        }
        for (std::ptrdiff_t k = r; k < W.rows; ++k) {
          total += a[i][k] * b[j][k];
        }
        out[(second + j) * W.columns + first + i] = total;
      }
    }
  }

  template <std::ptrdiff_t packs>
  static void product_tile(const TallMatrix& W, const double* K, std::ptrdiff_t r, std::ptrdiff_t first,
                           double* out, std::ptrdiff_t out_ld) {
    const double* k[std::size_t{tile}];
    Scalar sum[std::size_t{packs}][std::size_t{tile}];
    for (std::ptrdiff_t i = 0; i < tile; ++i) {
      k[i] = K + (first + i < W.columns ? first + i : W.columns - 1) * W.columns;
      for (std::ptrdiff_t p = 0; p < packs; ++p) {
        sum[p][i] = Scalar(0.0);
      }
    }
    for (std::ptrdiff_t d = 0; d < W.columns; ++d) {
      Scalar w[std::size_t{packs}];
      for (std::ptrdiff_t p = 0; p < packs; ++p) {
        w[p] = Scalar::load(W.data + d * W.ld + r + p * lanes);
      }
      for (std::ptrdiff_t i = 0; i < tile; ++i) {
        const Scalar factor(k[i][d]);
        for (std::ptrdiff_t p = 0; p < packs; ++p) {
          sum[p][i] = sum[p][i] + w[p] * factor;
        }
      }
    }
    for (std::ptrdiff_t i = 0; i < tile && first + i < W.columns; ++i) {
      for (std::ptrdiff_t p = 0; p < packs; ++p) {
        sum[p][i].store(out + (first + i) * out_ld + r + p * lanes);
      }
    }
  }
};

// What one file for an instruction set offers.
struct ProductsKernel {
  void (*gram)(const TallMatrix& W, double* out);
  void (*product)(const TallMatrix& W, const double* K, double* out, std::ptrdiff_t out_ld);
};

}  // namespace rivid::detail
