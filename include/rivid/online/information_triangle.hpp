#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

#include "rivid/online/saved_state.hpp"
#include "rivid/regressor/pack.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Positive definite coefficients, in the last column the right-hand side.
template <std::size_t n>
using Equations = std::array<std::array<double, n + 1>, n>;

struct Unknown {
  double value = 0.0;
  double variance = 0.0;  // entry of the diagonal of the inverse
};

// Of L D Lᵀ x = b; the inverse has the columns of L⁻¹.
template <std::size_t n>
[[nodiscard]] std::array<Unknown, n> solved(Equations<n> A) noexcept {
  std::array<std::array<double, n>, n> lower{};  // L⁻¹
  for (std::size_t k = 0; k < n; ++k) {
    lower[k][k] = 1.0;
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = A[i][k] / A[k][k];
      for (std::size_t c = k; c <= n; ++c) {
        A[i][c] -= factor * A[k][c];
      }
      for (std::size_t c = 0; c <= k; ++c) {
        lower[i][c] -= factor * lower[k][c];
      }
    }
  }
  std::array<Unknown, n> out{};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i; k < n; ++k) {
      out[i].value += lower[k][i] * A[k][n] / A[k][k];
      out[i].variance += lower[k][i] * lower[k][i] / A[k][k];
    }
  }
  return out;
}

// Square-root information of a linear estimate: the triangle [R z] with R χ = z, to which rows w χ = y are
// added by Givens rotations, one after the other and a part at a time, so that no tick of a control loop gets
// the work of many. At every moment [R z] is the triangle of all rows that have passed and of what has been
// done of the one at hand: it can be solved.
//
// The unknowns that stand first can be forgotten by themselves: the rows of R below theirs are what is known
// of the others, whatever the first ones are.
//
// Columns beside y go through the same rotations: what is left of them in a row's Outcome is what a change of
// y by them makes of its residual, once the estimate has followed as far as it does.
template <typename Scalar>
class InformationTriangle {
 public:
  // What became of a row: with weights 1 / σ, and R the square root of the information before it, `residual`
  // is its prediction error over the deviation of that, and `beside` the same of the columns beside y.
  struct Outcome {
    int tag;
    Scalar residual;
    const Scalar* beside;
  };

  // size     unknowns
  // waiting  rows that may wait
  // beside   columns beside y
  InformationTriangle(Index size, Index waiting, Index beside = 0)
      : n_(size),
        width_(size + 1 + beside),
        ld_((width_ + lanes + lanes - 1) / lanes * lanes),
        waiting_(waiting),
        R_(static_cast<std::size_t>(n_ * ld_), Scalar(0)),
        rows_(static_cast<std::size_t>(waiting * ld_), Scalar(0)),
        tags_(static_cast<std::size_t>(waiting), 0),
        watched_(static_cast<std::size_t>(ld_), Scalar(0)) {}

  [[nodiscard]] Index size() const noexcept { return n_; }
  [[nodiscard]] bool full() const noexcept { return at_.count == waiting_; }
  // Operations on pairs of entries that a row takes.
  [[nodiscard]] Index cost_of_row() const noexcept { return n_ * (2 * width_ - n_ + 1) / 2; }

  [[nodiscard]] Scalar* row_of_R(Index k) noexcept { return &R_[static_cast<std::size_t>(k * ld_)]; }
  [[nodiscard]] const Scalar* row_of_R(Index k) const noexcept {
    return &R_[static_cast<std::size_t>(k * ld_)];
  }
  [[nodiscard]] Scalar R(Index i, Index j) const noexcept { return row_of_R(i)[j]; }
  [[nodiscard]] Scalar z(Index i) const noexcept { return row_of_R(i)[n_]; }

  // Room for the next row, full of zeros; entry size() is y, what is beside it follows. Only where it is not
  // full().
  [[nodiscard]] Scalar* room() noexcept {
    Scalar* const out = row(at_.count);
    std::fill_n(out, ld_, Scalar(0));
    return out;
  }
  void commit(int tag) noexcept {
    tags_[static_cast<std::size_t>((at_.first + at_.count) % waiting_)] = tag;
    ++at_.count;
  }

  // Goes on with the rows that wait, for so many operations at least; calls report(Outcome) for each that is
  // done. Returns what is left of the operations, 0 where rows are left.
  template <typename Report>
  Index work(Index operations, const Report& report) noexcept {
    while (operations > 0 && at_.count > 0) {
      Scalar* const w = row(0);
      for (; at_.column < n_ && operations > 0; ++at_.column) {
        operations -= rotate(at_.column, w);
      }
      if (at_.column < n_) {
        return 0;
      }
      report(Outcome{tags_[static_cast<std::size_t>(at_.first)], w[n_], w + n_ + 1});
      at_.first = (at_.first + 1) % waiting_;
      --at_.count;
      at_.column = 0;
    }
    return std::max<Index>(operations, 0);
  }
  template <typename Report>
  void finish(const Report& report) noexcept {
    static_cast<void>(work(std::numeric_limits<Index>::max(), report));
  }

  // All of [R z], to keep and to put back: `count` rows, the others as they are.
  [[nodiscard]] const std::vector<Scalar>& entries() const noexcept { return R_; }
  void keep_entries(std::vector<Scalar>& in, Index count) const noexcept { copy_rows(R_, in, count); }
  void set_entries(const std::vector<Scalar>& from, Index count) noexcept { copy_rows(from, R_, count); }

  // Whether rows are reported alone, and R stays as it is.
  void watch(bool alone) noexcept { watching_ = alone; }
  // The first rows of another R, into which go those that are watched: what they say of the first unknowns,
  // given the others.
  [[nodiscard]] std::vector<Scalar>& instead() noexcept { return instead_; }

  // Rows that wait, and the one at hand, are lost.
  void drop_waiting() noexcept { at_ = {}; }

  // Information on the unknowns first … first + count − 1, given those behind them, times factor².
  void fade(Index first, Index count, Scalar factor) noexcept {
    for (Index k = first; k < first + count; ++k) {
      Scalar* const r = row_of_R(k);
      for (Index c = k; c < width_; ++c) {
        r[c] = r[c] * factor;
      }
    }
  }
  // `count` columns beside y from column `first` on begin anew.
  void clear_beside(Index first, Index count) noexcept {
    for (Index k = 0; k < n_; ++k) {
      std::fill_n(row_of_R(k) + n_ + 1 + first, count, Scalar(0));
    }
  }
  void clear() noexcept {
    std::ranges::fill(R_, Scalar(0));
    drop_waiting();
  }

  // χ of R χ = z; false, and no numbers, where R is singular to working precision.
  bool solve(Scalar* chi) const noexcept {
    for (Index k = n_; k-- > 0;) {
      const Scalar* const r = row_of_R(k);
      if (singular(k)) {
        std::fill_n(chi, n_, Scalar(std::numeric_limits<double>::quiet_NaN()));
        return false;
      }
      Scalar sum = r[n_];
      for (Index c = k + 1; c < n_; ++c) {
        sum = sum - r[c] * chi[c];
      }
      chi[k] = sum / r[k];
    }
    return true;
  }

  // Row i of R⁻¹: zeros before its diagonal. Its squares add up to the variance of unknown i, its product
  // with z is the unknown. No numbers where an entry of R's diagonal is zero.
  //
  // x  (room_of_row())
  void inverse_row(Index i, Scalar* x) const noexcept {
    std::fill_n(x, ld_, Scalar(0));
    x[i] = Scalar(1);
    for (Index k = i; k < n_; ++k) {
      const Scalar* const r = row_of_R(k);
      x[k] = x[k] / r[k];
      subtract(x + k + 1, r + k + 1, n_ - k - 1, x[k]);
    }
  }
  [[nodiscard]] Index room_of_row() const noexcept { return ld_; }

  // Unknown i and its variance; x becomes row i of R⁻¹.
  struct Estimate {
    Scalar value, variance;
  };
  [[nodiscard]] Estimate estimate(Index i, Scalar* x) const noexcept {
    inverse_row(i, x);
    Estimate out{Scalar(0), Scalar(0)};
    for (Index k = i; k < n_; ++k) {
      out.value = out.value + x[k] * z(k);
      out.variance = out.variance + x[k] * x[k];
    }
    return out;
  }

  // The information of another triangle, whole.
  template <typename Report>
  void merge(const InformationTriangle& other, const Report& report) noexcept {
    for (Index k = 0; k < n_; ++k) {
      finish(report);
      Scalar* const w = room();
      std::copy_n(other.row_of_R(k) + k, n_ + 1 - k, w + k);
      commit(-1);
    }
    finish(report);
  }

  [[nodiscard]] auto state() noexcept { return std::tie(R_, rows_, tags_, at_, watching_, instead_); }

 private:
  static constexpr Index lanes = 4;  // numbers that rows are padded to a multiple of

  [[nodiscard]] Scalar* row(Index k) noexcept {
    return &rows_[static_cast<std::size_t>((at_.first + k) % waiting_ * ld_)];
  }

  // Below the diagonal are zeros. What is beside y stays.
  void copy_rows(const std::vector<Scalar>& from, std::vector<Scalar>& to, Index count) const noexcept {
    for (Index k = 0; k < count; ++k) {
      std::copy_n(from.begin() + k * ld_ + k, n_ + 1 - k, to.begin() + k * ld_ + k);
    }
  }

  [[nodiscard]] bool singular(Index k) const noexcept {
    using std::abs;
    Scalar above(0);
    for (Index i = 0; i <= k; ++i) {
      above = std::max(above, Scalar(abs(R(i, k))));
    }
    constexpr double rounding = std::is_same_v<Scalar, float> ? 0x1p-23 : 0x1p-52;  // ε of the Scalar
    return !(abs(R(k, k)) > Scalar(static_cast<double>(n_) * rounding) * above);
  }

  // Takes entry k of the row into R; returns the operations.
  Index rotate(Index k, Scalar* w) noexcept {
    if (!watching_) {
      return turn(k, row_of_R(k), w);
    }
    Index operations = 0;
    if (k == 0) {
      std::copy_n(w, ld_, watched_.begin());
      for (Index i = 0; i < std::ssize(instead_) / ld_; ++i) {
        operations += turn(i, &instead_[static_cast<std::size_t>(i * ld_)], watched_.data());
      }
    }
    std::copy_n(row_of_R(k) + k, ld_ - k, watched_.begin() + k);
    return operations + turn(k, watched_.data(), w);
  }

  // The same into a row like that of R.
  Index turn(Index k, Scalar* r, Scalar* w) noexcept {
    using std::sqrt;
    if (w[k] == Scalar(0)) {
      return 1;
    }
    const Scalar rho = sqrt(Scalar(r[k] * r[k] + w[k] * w[k]));
    if (!(rho > Scalar(0))) {
      return 1;
    }
    const Scalar c = r[k] / rho;
    const Scalar s = w[k] / rho;
    turn_rows(r + k, w + k, width_ - k, c, s);
    r[k] = rho;
    w[k] = Scalar(0);
    return width_ - k;
  }

  // Both rows have room behind their end, which holds zeros.
  static void turn_rows(Scalar* r, Scalar* w, Index count, const Scalar& c, const Scalar& s) noexcept {
    if constexpr (std::is_same_v<Scalar, double>) {
      using Four = BasicPack<lanes>;
      const Four cc(c);
      const Four ss(s);
      for (Index k = 0; k < count; k += lanes) {
        const Four a = Four::load(r + k);
        const Four b = Four::load(w + k);
        (cc * a + ss * b).store(r + k);
        (cc * b - ss * a).store(w + k);
      }
    } else {
      for (Index k = 0; k < count; ++k) {
        const Scalar a = r[k];
        r[k] = c * a + s * w[k];
        w[k] = c * w[k] - s * a;
      }
    }
  }

  // x −= value r, with room behind the end; what is written there means nothing.
  static void subtract(Scalar* x, const Scalar* r, Index count, const Scalar& value) noexcept {
    if constexpr (std::is_same_v<Scalar, double>) {
      using Four = BasicPack<lanes>;
      const Four factor(value);
      for (Index k = 0; k < count; k += lanes) {
        (Four::load(x + k) - factor * Four::load(r + k)).store(x + k);
      }
    } else {
      for (Index k = 0; k < count; ++k) {
        x[k] = x[k] - value * r[k];
      }
    }
  }

  // Where the work stands.
  struct Place {
    Index first = 0;   // row that is at hand …
    Index count = 0;   // … and how many wait with it
    Index column = 0;  // of it that is next
  };

  Index n_;
  Index width_;  // of a row, y and what is beside it included
  Index ld_;
  Index waiting_;
  std::vector<Scalar> R_;  // by rows of length ld_
  std::vector<Scalar> rows_;
  std::vector<int> tags_;
  std::vector<Scalar> watched_;  // a row of R that is watched
  std::vector<Scalar> instead_;
  Place at_;
  bool watching_ = false;
};

}  // namespace rivid::detail
