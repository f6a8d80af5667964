#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "rivid/error.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/signal/filter.hpp"

namespace rivid {
namespace {

// Modes and second-order sections are two algorithms for the same quantity; the sections lose digits as their
// poles come near to 1, 1.4e-12 against SciPy at n_d = 100.
double tolerance(int n_d) { return n_d <= 20 ? 1e-12 : 1e-11; }

Matrix random_walk(Index rows, Index columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Matrix x(rows, columns);
  for (Index c = 0; c < columns; ++c) {
    double value = normal(random);
    for (Index k = 0; k < rows; ++k) {
      value += 0.1 * normal(random);
      x(k, c) = value;
    }
  }
  return x;
}

// The filter by sections on the series continued by constants, far enough that the ends are forgotten.
Matrix by_sections(const Matrix& x, int n_d) {
  const Index margin = 300 * n_d;
  Matrix continued(x.rows() + 2 * margin, x.cols());
  continued.topRows(margin).rowwise() = x.row(0);
  continued.middleRows(margin, x.rows()) = x;
  continued.bottomRows(margin).rowwise() = x.row(x.rows() - 1);
  const Matrix filtered = zero_phase(continued, decimation_filter(n_d));
  Matrix out((x.rows() + n_d - 1) / n_d, x.cols());
  for (Index k = 0; k < out.rows(); ++k) {
    out.row(k) = filtered.row(margin + k * n_d);
  }
  return out;
}

TEST(StreamingDecimator, IsTheFilterBySectionsOfASeriesContinuedByConstants) {
  for (const int n_d : {2, 5, 14, 20, 100}) {
    for (const Index rows : {1, 2, 37, 1000, 7001}) {
      const Matrix x = random_walk(rows, 3, static_cast<std::uint64_t>(n_d + rows));
      const Matrix y = decimate(x, n_d);
      const Matrix expected = by_sections(x, n_d);
      ASSERT_EQ(y.rows(), expected.rows()) << "n_d " << n_d << ", rows " << rows;
      EXPECT_LT((y - expected).cwiseAbs().maxCoeff(), tolerance(n_d) * x.cwiseAbs().maxCoeff())
          << "n_d " << n_d << ", rows " << rows;
    }
  }
}

TEST(StreamingDecimator, GivesTheSameWhateverTheBlocks) {
  const Matrix x = random_walk(20011, 2, 3);
  const Matrix whole = decimate(x, 7);
  for (const Index block : {1, 6, 7, 500, 9999}) {
    StreamingDecimator decimator(2, 7);
    Matrix y(whole.rows(), 2);
    Index rows = 0;
    const auto take = [&](const Matrix& part) {
      ASSERT_LE(rows + part.rows(), y.rows());
      y.middleRows(rows, part.rows()) = part;
      rows += part.rows();
    };
    for (Index k = 0; k < x.rows(); k += block) {
      take(decimator.add(x.middleRows(k, std::min(block, x.rows() - k))));
    }
    EXPECT_GT(rows, whole.rows() / 2) << "rows come out on the way, not at the end";
    take(decimator.finish());
    EXPECT_EQ(rows, whole.rows());
    EXPECT_EQ(y, whole) << "blocks of " << block;
  }
}

TEST(StreamingDecimator, TakesSamplesInPlaceAndKeepsRowsThatNobodyTakes) {
  const Matrix x = random_walk(9001, 2, 5);
  const Matrix whole = decimate(x, 10);
  for (const Index wanted : {0, 1000}) {
    StreamingDecimator decimator(2, 10, wanted);
    EXPECT_GE(decimator.room().rows, wanted);
    for (Index next = 0; next < x.rows();) {
      const RowsRoom room = decimator.room();
      const Index count = std::min(room.rows, x.rows() - next);
      for (Index c = 0; c < 2; ++c) {
        std::copy_n(x.col(c).data() + next, count, room.target.data + c * room.target.ld);
      }
      decimator.commit(count);
      next += count;
    }
    decimator.end();
    ASSERT_EQ(decimator.finished(), whole.rows());
    EXPECT_THROW(decimator.commit(1), InputError) << "the rows of the series before are not taken";
    Matrix y(whole.rows(), 2);
    decimator.take(whole.rows(), {y.data(), y.rows()});
    EXPECT_EQ(y, whole);
    EXPECT_THROW(decimator.take(1, {y.data(), y.rows()}), InputError);
  }
}

TEST(StreamingDecimator, LeavesAConstantAlone) {
  const Matrix x = Matrix::Constant(5000, 1, 3.7);
  EXPECT_LT((decimate(x, 20).array() - 3.7).abs().maxCoeff(), 1e-13);
}

TEST(StreamingDecimator, BeginsAnewAfterTheEnd) {
  const Matrix x = random_walk(3000, 2, 4);
  StreamingDecimator decimator(2, 10);
  const auto run = [&] {
    const Matrix early = decimator.add(x);
    const Matrix late = decimator.finish();
    Matrix y(early.rows() + late.rows(), 2);
    y << early, late;
    return y;
  };
  const Matrix first = run();
  EXPECT_EQ(run(), first);
  EXPECT_EQ(StreamingDecimator(2, 10).finish().rows(), 0);
}

TEST(StreamingDecimator, RefusesWhatItCanNotDecimate) {
  EXPECT_THROW(StreamingDecimator(2, 1), InputError);
  EXPECT_THROW(StreamingDecimator(-1, 5), InputError);
  StreamingDecimator decimator(2, 5);
  EXPECT_THROW((void)decimator.add(Matrix::Zero(4, 3)), InputError);
}

}  // namespace
}  // namespace rivid
