#include "solve/householder_kernel.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "rivid/types.hpp"
#include "support/random_matrix.hpp"

namespace rivid::detail {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

Matrix without_signs(const Matrix& R) {
  const Vector signs = R.diagonal().unaryExpr([](double r) { return r < 0.0 ? -1.0 : 1.0; });
  return signs.asDiagonal() * R;
}

struct Free {
  void operator()(double* p) const { ::operator delete(p, std::align_val_t{64}); }
};

struct Reduced {
  Matrix triangle;  // [R | Qᵀ carried] and the zero rows that fill the last panel
  Vector sums;
  Vector rest_squares;
};

// Rows are eliminated in the blocks that `blocks` gives, multiples of 8.
Reduced reduced(const HouseholderKernel& kernel, const Matrix& rows, Index carried,
                const std::vector<Index>& blocks) {
  const Index all = rows.cols();
  const Index columns = all - carried;
  Reduced out{Matrix::Zero((columns + panel_columns - 1) / panel_columns * panel_columns, all),
              Vector::Zero(all), Vector::Zero(carried)};
  const auto size = static_cast<std::size_t>(block_stride * all);
  const std::unique_ptr<double[], Free> block(
      static_cast<double*>(::operator new(size * sizeof(double), std::align_val_t{64})));
  Index first = 0;
  for (const Index count : blocks) {
    for (Index c = 0; c < all; ++c) {
      Vector::Map(block.get() + c * block_stride, count) = rows.col(c).segment(first, count);
    }
    Vector rest(carried);
    kernel.eliminate({.columns = columns,
                      .carried = carried,
                      .R = out.triangle.data(),
                      .R_stride = out.triangle.rows(),
                      .rows = block.get(),
                      .row_count = count,
                      .sums = out.sums.data(),
                      .rest_squares = rest.data()});
    out.rest_squares += rest;
    first += count;
  }
  return out;
}

class EveryKernel : public testing::TestWithParam<InstructionSet> {
 protected:
  [[nodiscard]] static const HouseholderKernel& kernel() { return kernel_for<HouseholderKernel>(GetParam()); }
};

std::vector<InstructionSet> available_sets() {
  std::vector<InstructionSet> out = {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512};
  std::erase_if(out, [](InstructionSet set) { return !available(set); });
  return out;
}

// Every width of the last panel and every number of columns on its right, against Eigen in long double.
TEST_P(EveryKernel, FactorsAsHouseholderQrDoes) {
  for (const Index columns : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 13, 16, 27, 40, 61}) {
    for (const Index carried : {1, 2, 3, 4, 5, 8}) {
      const Index all = columns + carried;
      const auto seed = static_cast<std::uint64_t>(100 * columns + carried);
      const Matrix rows = test::random_matrix(1136, all, seed);
      const Reduced found = reduced(kernel(), rows, carried, {512, 8, 104, 512});

      LongMatrix eliminated = rows.cast<long double>();
      for (Index k = 0; k < columns; ++k) {
        Eigen::Matrix<long double, Eigen::Dynamic, 1> essential(eliminated.rows() - k - 1);
        long double tau = 0.0L;
        long double beta = 0.0L;
        eliminated.col(k).tail(eliminated.rows() - k).makeHouseholder(essential, tau, beta);
        Eigen::Matrix<long double, 1, Eigen::Dynamic> workspace(all);
        eliminated.bottomRightCorner(eliminated.rows() - k, all - k)
            .applyHouseholderOnTheLeft(essential, tau, workspace.data());
      }
      Matrix expected = Matrix::Zero(columns, all);
      expected.leftCols(columns) =
          eliminated.topLeftCorner(columns, columns).cast<double>().triangularView<Eigen::Upper>();
      expected.rightCols(carried) = eliminated.topRightCorner(columns, carried).cast<double>();

      // Another algorithm, same quantity: 1e-12 of the scale.
      const double tolerance = 1e-12 * rows.norm();
      EXPECT_LT((without_signs(found.triangle.topRows(columns)) - without_signs(expected)).norm(), tolerance)
          << "seed " << seed;
      EXPECT_TRUE(found.triangle.bottomRows(found.triangle.rows() - columns).isZero(0.0));
      for (Index c = 0; c < carried; ++c) {
        const double rest =
            static_cast<double>(eliminated.col(columns + c).tail(eliminated.rows() - columns).norm());
        EXPECT_NEAR(std::sqrt(found.rest_squares[c]), rest, tolerance);
      }
      EXPECT_LT((found.sums.transpose() - rows.colwise().sum()).norm(), tolerance);
    }
  }
}

TEST_P(EveryKernel, AgreesWithTheBaselineToRounding) {
  for (const Index columns : {40, 61, 69, 100}) {
    const Matrix rows = test::random_matrix(1024, columns + 1, static_cast<std::uint64_t>(columns));
    const Reduced found = reduced(kernel(), rows, 1, {512, 512});
    const Reduced expected =
        reduced(kernel_for<HouseholderKernel>(InstructionSet::baseline), rows, 1, {512, 512});
    EXPECT_LT((found.triangle - expected.triangle).norm(), 1e3 * epsilon * rows.norm());
    EXPECT_NEAR(found.rest_squares[0], expected.rest_squares[0], 1e3 * epsilon * rows.squaredNorm());
  }
}

TEST_P(EveryKernel, TakesZeroAndDependentColumnsAndNoReflectorIsNotANumber) {
  Matrix rows = test::random_matrix(512, 12, 7);
  rows.col(0).setZero();
  rows.col(5) = 3.0 * rows.col(4);
  rows.col(10).setZero();
  const Reduced found = reduced(kernel(), rows, 1, {256, 256});
  const Matrix R = found.triangle.topLeftCorner(11, 11);
  ASSERT_TRUE(found.triangle.allFinite());
  EXPECT_TRUE(R.col(0).isZero(0.0));
  EXPECT_TRUE(R.col(10).isZero(0.0));
  EXPECT_NEAR(R(5, 5), 0.0, 64 * epsilon * rows.norm());
  EXPECT_LT((R.transpose() * R - rows.leftCols(11).transpose() * rows.leftCols(11)).norm(),
            1e3 * epsilon * rows.squaredNorm());
}

TEST_P(EveryKernel, IsIndifferentToScalesFrom1e150To1eMinus150) {
  const Matrix rows = test::random_matrix(512, 10, 8);
  Vector scales(10);
  scales << 1e-150, 1e150, 1.0, 1e-150, 1e150, 1e-8, 1e100, 1e-100, 1e150, 1.0;
  const Reduced plain = reduced(kernel(), rows, 1, {512});
  const Reduced scaled = reduced(kernel(), rows * scales.asDiagonal(), 1, {512});
  const Matrix back = scaled.triangle * scales.cwiseInverse().asDiagonal();
  EXPECT_LT((back - plain.triangle).norm(), 1e3 * epsilon * rows.norm());
}

TEST_P(EveryKernel, FindsWhatIsNotWithinTheLimitWhereverItStands) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double limit = 1e150;
  for (const Index count : {0, 1, 3, 8, 21}) {
    Vector values = test::random_matrix(count, 1, 9);
    Vector copy = Vector::Zero(count);
    EXPECT_TRUE(kernel().copy_within(values.data(), count, limit, copy.data(), values.data()));
    EXPECT_EQ(copy, values);
    for (Index i = 0; i < count; ++i) {
      for (const double bad : {infinity, -infinity, std::nan(""), -std::nan(""), 1.1e150, -1.1e150}) {
        Vector spoilt = values;
        spoilt[i] = bad;
        EXPECT_FALSE(kernel().copy_within(spoilt.data(), count, limit, copy.data(), values.data()));
        EXPECT_FALSE(kernel().all_within(spoilt.data(), count, limit));
      }
      for (const double good : {0.0, -0.0, limit, -limit, 5e-324}) {
        Vector fine = values;
        fine[i] = good;
        EXPECT_TRUE(kernel().all_within(fine.data(), count, limit));
      }
    }
  }
}

std::string name_of(const testing::TestParamInfo<InstructionSet>& instance) {
  constexpr std::array names = {"baseline", "avx2", "avx512"};
  return names.at(static_cast<std::size_t>(instance.param));
}

INSTANTIATE_TEST_SUITE_P(Householder, EveryKernel, testing::ValuesIn(available_sets()), name_of);

}  // namespace
}  // namespace rivid::detail
