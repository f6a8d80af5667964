#include "signal/window_decimator.hpp"

#include <gtest/gtest.h>

#include "support/random_matrix.hpp"

namespace rivid {
namespace {

using detail::decimation_window;
using detail::WindowDecimator;

// All rows of a series that comes in blocks of at most `most` samples.
Matrix decimated(const Matrix& x, Index n_d, const std::vector<Index>& centres, Index most) {
  WindowDecimator decimator(x.cols(), n_d, centres);
  Matrix out(static_cast<Index>(centres.size()), x.cols());
  Index taken = 0;
  for (Index k = 0; k < x.rows();) {
    const RowsRoom room = decimator.room();
    const Index count = std::min({most, room.rows, x.rows() - k});
    for (Index c = 0; c < x.cols(); ++c) {
      std::copy_n(x.col(c).data() + k, count, room.target.data + c * room.target.ld);
    }
    decimator.commit(count);
    k += count;
    const Index finished = decimator.finished();
    decimator.take(finished, {out.data() + taken, out.rows()});
    taken += finished;
  }
  EXPECT_EQ(taken, out.rows());
  return out;
}

TEST(WindowDecimator, IsTheWindowedSumAroundEachCentreWhateverTheBlocks) {
  const Matrix x = test::random_matrix(1500, 3, 5);
  const std::vector<Index> centres = {19, 25, 300, 320, 340, 1100, 1480};
  const Vector h = decimation_window(20);
  for (const Index most : {1, 7, 256, 2000}) {
    const Matrix rows = decimated(x, 20, centres, most);
    for (std::size_t k = 0; k < centres.size(); ++k) {
      const Eigen::RowVectorXd expected = h.transpose() * x.middleRows(centres[k] - 19, 39);
      EXPECT_LT((rows.row(static_cast<Index>(k)) - expected).norm(), 1e-15 * x.norm());
    }
  }
}

TEST(WindowDecimator, LeavesConstantsAndSlopesAlone) {
  for (const Index n_d : {1, 2, 20}) {
    const Vector h = decimation_window(n_d);
    EXPECT_NEAR(h.sum(), 1.0, 1e-14);
    const auto reach = static_cast<double>(n_d - 1);
    EXPECT_NEAR(h.dot(Vector::LinSpaced(h.size(), 0.0, 2.0 * reach)), reach, 1e-13);
  }
}

TEST(WindowDecimator, TouchesNothingAStrideAway) {
  Matrix x = test::random_matrix(200, 1, 6);
  const double before = decimated(x, 10, {100}, 256)(0, 0);
  x(90, 0) = x(110, 0) = 1e6;
  EXPECT_EQ(decimated(x, 10, {100}, 256)(0, 0), before);
}

}  // namespace
}  // namespace rivid
