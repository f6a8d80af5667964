#include "forward_backward.hpp"

#include <algorithm>
#include <vector>

#include "message.hpp"
#include "rivid/error.hpp"

namespace rivid::detail {

namespace {

constexpr double forgotten = 1e-6;

// A state that dies out in a standstill would end in subnormal numbers, which cost thirty times as much.
constexpr double dead = 1e-250;

// Samples of one instant, of several columns: the recursion of one column waits for its own last result, so
// eight columns side by side cost little more than two.
template <int Columns>
using Lanes = Eigen::Array<double, Columns, 1>;

template <int Columns>
Lanes<Columns> flushed(const Lanes<Columns>& state) {
  return (state.abs() < dead).select(0.0, state);
}

template <int Columns>
struct State {
  Lanes<Columns> z1;
  Lanes<Columns> z2;
};

// Steady state of each section for a constant input of the cascade.
template <int Columns>
std::vector<State<Columns>> steady_state(const Filter& filter, const Lanes<Columns>& input) {
  std::vector<State<Columns>> states;
  Lanes<Columns> x = input;
  for (const SecondOrderSection& s : filter.sections) {
    const Lanes<Columns> y = x * (((s.b0 + s.b1) + s.b2) / ((1.0 + s.a1) + s.a2));
    states.push_back({y - s.b0 * x, s.b2 * x - s.a2 * y});
    x = y;
  }
  return states;
}

// Transposed direct form II in place over n samples from x on, `step` apart. Sections take turns on blocks
// that stay in the first-level cache.
template <int Columns>
void run(const Filter& filter, Lanes<Columns>* x, Index n, Index step) {
  constexpr Index block = 256;
  std::vector<State<Columns>> states = steady_state<Columns>(filter, *x);
  for (Index begin = 0; begin < n; begin += block) {
    const Index end = std::min(begin + block, n);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const SecondOrderSection s = filter.sections[i];
      Lanes<Columns> z1 = states[i].z1;
      Lanes<Columns> z2 = states[i].z2;
      for (Index k = begin; k < end; ++k) {
        Lanes<Columns>& sample = x[k * step];
        const Lanes<Columns> y = s.b0 * sample + z1;
        z1 = s.b1 * sample - s.a1 * y + z2;
        z2 = s.b2 * sample - s.a2 * y;
        sample = y;
      }
      states[i] = {flushed<Columns>(z1), flushed<Columns>(z2)};
    }
  }
}

struct Task {
  const Eigen::Ref<const Matrix>& x;
  const Filter& filter;
  Index padding;
  Index first;
  Index step;
  Matrix& out;
};

// Columns from `column` on, at most as many as there are lanes; idle lanes carry zeros.
template <int Columns>
void filter_columns(const Task& task, Index column, Index count, std::vector<Lanes<Columns>>& series) {
  const Index n_m = task.x.rows();
  const Index pad = task.padding;
  series.assign(static_cast<std::size_t>(n_m + 2 * pad), Lanes<Columns>::Zero());
  Lanes<Columns>* const data = series.data() + pad;
  for (Index c = 0; c < count; ++c) {
    const double* const x = task.x.col(column + c).data();
    for (Index k = 0; k < n_m; ++k) {
      data[k][c] = x[k];
    }
  }
  for (Index k = 1; k <= pad; ++k) {
    data[-k] = 2.0 * data[0] - data[k];
    data[n_m - 1 + k] = 2.0 * data[n_m - 1] - data[n_m - 1 - k];
  }
  run<Columns>(task.filter, series.data(), n_m + 2 * pad, 1);
  run<Columns>(task.filter, data + n_m - 1 + pad, n_m + pad, -1);
  for (Index c = 0; c < count; ++c) {
    double* const y = task.out.col(column + c).data();
    for (Index i = 0, k = task.first; k < n_m; ++i, k += task.step) {
      y[i] = data[k][c];
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
  std::vector<Lanes<8>> eight;
  std::vector<Lanes<4>> four;
  std::vector<Lanes<1>> one;
  for (Index column = 0; column < x.cols(); column += 8) {
    const Index count = std::min<Index>(8, x.cols() - column);
    if (count > 4) {
      filter_columns<8>(task, column, count, eight);
    } else if (count > 1) {
      filter_columns<4>(task, column, count, four);
    } else {
      filter_columns<1>(task, column, count, one);
    }
  }
  return out;
}

}  // namespace rivid::detail
