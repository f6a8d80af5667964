#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "dense.hpp"
#include "rivid/error.hpp"
#include "rivid/model/dependent.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Pieces along each of one, two or three joints: so many coefficients are a matrix of a second at most.
constexpr std::array<int, JointSpline::most_joints> most_pieces = {60, 16, 6};
// What makes the spline smooth where no point is, of the diagonal of the normal equations.
constexpr double smoothing = 1e-13;
// of the range of the points, rms; a choice: tables with few digits are nearer
constexpr double far_off = 0.01;

// The value is a sum of coefficients times products of B-splines; `add` gets their places and the products.
template <typename Add>
void for_each_product(const JointSpline& spline, const std::vector<JointSpline::Basis<double>>& of_joint,
                      const Add& add) {
  const std::size_t corners = std::size_t{1} << (2 * of_joint.size());
  for (std::size_t corner = 0; corner < corners; ++corner) {
    Index place = 0;
    double product = 1.0;
    for (std::size_t a = 0, rest = corner; a < of_joint.size(); ++a, rest /= 4) {
      place = place * (spline.pieces[a] + 3) + static_cast<Index>(of_joint[a].first + rest % 4);
      product *= of_joint[a].values[0][rest % 4];
    }
    add(place, product);
  }
}

// Squares of second differences of the coefficients along each joint.
void smooth(const JointSpline& spline, Matrix& A) {
  const double size = smoothing * A.diagonal().maxCoeff();
  Index stride = 1;
  for (std::size_t a = spline.pieces.size(); a-- > 0;) {
    const Index count = spline.pieces[a] + 3;
    for (Index k = 0; k < A.rows(); ++k) {
      if (const Index at = k / stride % count; at > 0 && at + 1 < count) {
        const std::array<std::pair<Index, double>, 3> terms = {
            {{k - stride, 1.0}, {k, -2.0}, {k + stride, 1.0}}};
        for (const auto& [i, x] : terms) {
          for (const auto& [j, y] : terms) {
            A(i, j) += size * x * y;
          }
        }
      }
    }
    stride *= count;
  }
}

}  // namespace

JointSpline spline_through(const Eigen::Ref<const Matrix>& q, const Eigen::Ref<const Vector>& of) {
  const auto d = static_cast<std::size_t>(q.cols());
  if (d < 1 || d > JointSpline::most_joints || of.size() != q.rows() || !q.allFinite() || !of.allFinite()) {
    throw InputError("a table must have finite positions of one to " +
                     std::to_string(JointSpline::most_joints) +
                     " joints that are followed, and of the joint");
  }
  JointSpline out;
  Index count = 1;
  for (Index a = 0; a < q.cols(); ++a) {
    Vector sorted = q.col(a);
    std::ranges::sort(sorted);
    // Values that differ by rounding are one.
    const double step = 1e-9 * (sorted[sorted.size() - 1] - sorted[0]);
    int distinct = 1;
    for (Index k = 1; k < sorted.size(); ++k) {
      distinct += sorted[k] - sorted[k - 1] > step ? 1 : 0;
    }
    if (distinct < 4) {
      throw InputError("a table has " + counted(distinct, "position") +
                       " of a joint that is followed, must have four at least");
    }
    out.least.push_back(sorted[0]);
    out.most.push_back(sorted[sorted.size() - 1]);
    // Three positions for two coefficients: interpolation is ill-conditioned at the ends.
    out.pieces.push_back(std::clamp(2 * distinct / 3 - 3, 1, most_pieces[d - 1]));
    count *= out.pieces.back() + 3;
  }
  Matrix A = Matrix::Zero(count, count);
  Vector b = Vector::Zero(count);
  std::vector<JointSpline::Basis<double>> of_joint(d);
  const auto place_at = [&](Index k) {
    for (std::size_t a = 0; a < d; ++a) {
      of_joint[a] = out.basis(a, q(k, static_cast<Index>(a)));
    }
  };
  for (Index k = 0; k < q.rows(); ++k) {
    place_at(k);
    for_each_product(out, of_joint, [&](Index i, double x) {
      b[i] += x * of[k];
      for_each_product(out, of_joint, [&](Index j, double y) { A(i, j) += x * y; });
    });
  }
  const Matrix exact = A;
  smooth(out, A);
  Vector c = detail::solve(A, b);
  c += detail::solve(A, b - exact * c);  // what the smoothing took
  out.coefficients.assign(c.begin(), c.end());
  double squares = 0.0;
  for (Index k = 0; k < q.rows(); ++k) {
    double value = 0.0;
    place_at(k);
    for_each_product(out, of_joint, [&](Index i, double x) { value += x * c[i]; });
    squares += std::pow(of[k] - value, 2);
  }
  const double off = std::sqrt(squares / static_cast<double>(q.rows()));
  const double range = of.maxCoeff() - of.minCoeff();
  if (!(off <= far_off * range)) {
    throw InputError("the points lie " + number(off, 3) + " off a smooth curve, of a range of " +
                     number(range, 3) + ": the joint does not follow those alone, or columns are mixed up");
  }
  return out;
}

}  // namespace rivid
