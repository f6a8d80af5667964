#include "forward_backward.hpp"

#include <algorithm>
#include <vector>

#include "message.hpp"
#include "rivid/error.hpp"
#include "signal_kernels.hpp"

namespace rivid::detail {

namespace {

constexpr double forgotten = 1e-6;

// A state that dies out in a standstill would end in subnormal numbers, which cost thirty times as much.
constexpr double dead = 1e-250;

// Columns side by side, and instants that are filtered at a time: they stay in the first-level cache.
constexpr Index lanes = 8;
constexpr Index block = 256;
using Block = Eigen::Array<double, lanes, block>;
using Instant = Eigen::Array<double, lanes, 1>;

// A cascade for eight columns and the states of its sections.
class Cascade {
 public:
  explicit Cascade(const Filter& filter) {
    for (const SecondOrderSection& s : filter.sections) {
      coefficients_.insert(coefficients_.end(), {s.b0, s.b1, s.b2, s.a1, s.a2});
    }
    states_.resize(2 * lanes, static_cast<Index>(filter.sections.size()));
  }

  // The steady state for a constant input.
  void settle(const Instant& input) {
    Instant x = input;
    for (Index i = 0; i < states_.cols(); ++i) {
      const double* const s = coefficients_.data() + 5 * i;
      const Instant y = x * (((s[0] + s[1]) + s[2]) / ((1.0 + s[3]) + s[4]));
      states_.col(i) << y - s[0] * x, s[2] * x - s[4] * y;
      x = y;
    }
  }

  void run(Block& x, Index count) {
    signal_kernels().cascade(coefficients_.data(), states_.cols(), states_.data(), x.data(), count);
    states_ = (states_.abs() < dead).select(0.0, states_);
  }

 private:
  std::vector<double> coefficients_;
  Eigen::ArrayXXd states_;
};

struct Task {
  const Eigen::Ref<const Matrix>& x;
  const Filter& filter;
  Index padding;
  Index first;
  Index step;
  Matrix& out;
};

// At most eight columns from `column` on; idle lanes carry zeros. What the way forwards leaves is kept in `forward`, which
// may be the columns of the result itself.
void filter_columns(const Task& task, Index column, Index count, Eigen::Ref<Matrix> forward) {
  const Index n_m = task.x.rows();
  const Index pad = task.padding;
  const auto x = task.x.middleCols(column, count);
  Eigen::ArrayXXd behind = Eigen::ArrayXXd::Zero(lanes, pad);  // the way forwards beyond the last sample
  Block data = Block::Zero();
  Cascade cascade(task.filter);
  const auto reflected = [&](Index k) -> Eigen::ArrayXd {
    const Index end = k < 0 ? 0 : n_m - 1;
    return 2.0 * x.row(end).array() - x.row(2 * end - k).array();
  };

  for (Index begin = -pad; begin < n_m + pad; begin += block) {
    const Index end = std::min(begin + block, n_m + pad);
    const Index inner_begin = std::clamp<Index>(0, begin, end);
    const Index inner_end = std::clamp<Index>(n_m, begin, end);
    for (Index k = begin; k < inner_begin; ++k) {
      data.col(k - begin).head(count) = reflected(k);
    }
    for (Index c = 0; c < count; ++c) {
      for (Index k = inner_begin; k < inner_end; ++k) {
        data(c, k - begin) = x(k, c);
      }
    }
    for (Index k = inner_end; k < end; ++k) {
      data.col(k - begin).head(count) = reflected(k);
    }
    if (begin == -pad) {
      cascade.settle(data.col(0));
    }
    cascade.run(data, end - begin);
    for (Index c = 0; c < count; ++c) {
      for (Index k = inner_begin; k < inner_end; ++k) {
        forward(k, c) = data(c, k - begin);
      }
    }
    for (Index k = inner_end; k < end; ++k) {
      behind.col(k - n_m) = data.col(k - begin);
    }
  }

  for (Index end = n_m + pad; end > 0; end -= block) {
    const Index begin = std::max<Index>(end - block, 0);
    const Index inner_end = std::min(end, n_m);
    for (Index k = end - 1; k >= n_m && k >= begin; --k) {
      data.col(end - 1 - k) = behind.col(k - n_m);
    }
    for (Index c = 0; c < count; ++c) {
      for (Index k = begin; k < inner_end; ++k) {
        data(c, end - 1 - k) = forward(k, c);
      }
    }
    if (end == n_m + pad) {
      cascade.settle(data.col(0));
    }
    cascade.run(data, end - begin);
    const Index first_row = (std::max(begin - task.first, Index{0}) + task.step - 1) / task.step;
    for (Index c = 0; c < count; ++c) {
      for (Index row = first_row; task.first + row * task.step < inner_end; ++row) {
        task.out(row, column + c) = data(c, end - 1 - task.first - row * task.step);
      }
    }
  }
}

}  // namespace

Matrix forward_backward(const char* function, const Eigen::Ref<const Matrix>& x, const Filter& filter,
                        Convention convention, Index first, Index step) {
  const Index n_m = x.rows();
  const Index shortest = 3 * static_cast<Index>(filter.order);
  if (n_m <= shortest) {
    throw InputError(message(function, ": x has ", n_m, " samples, must have more than ", shortest,
                             " = 3 times the order of the filter"));
  }
  const Index padding =
      convention == Convention::matlab ? shortest : std::min(settling_samples(filter, forgotten), n_m - 1);
  Matrix out((n_m - first + step - 1) / step, x.cols());
  const Task task{x, filter, padding, first, step, out};
  const bool in_place = first == 0 && step == 1;
  Matrix apart(in_place ? 0 : n_m, in_place ? 0 : std::min(lanes, x.cols()));
  for (Index column = 0; column < x.cols(); column += lanes) {
    const Index count = std::min(lanes, x.cols() - column);
    filter_columns(task, column, count, in_place ? out.middleCols(column, count) : apart.leftCols(count));
  }
  return out;
}

}  // namespace rivid::detail
