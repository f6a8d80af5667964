#include <cmath>

#include "dense.hpp"
#include "identify/check/alternatives.hpp"
#include "ranges.hpp"
#include "rivid/solve/inference.hpp"

namespace rivid::detail {

namespace {

// Directions of which so little is left beside the parameters are no alternative (squared).
constexpr double told_apart = 1e-4;
// Part of the sum of squares below which an alternative is not looked at any further.
constexpr double least_fit = 0.01;

// Rows of one block that lie together.
struct Segment {
  Index first = 0;
  Index count = 0;
  Index block = 0;
};

std::vector<Segment> segments_of(const std::vector<Index>& block_of) {
  std::vector<Segment> out;
  for (std::size_t r = 0; r < block_of.size(); ++r) {
    if (out.empty() || out.back().block != block_of[r]) {
      out.push_back({static_cast<Index>(r), 0, block_of[r]});
    }
    ++out.back().count;
  }
  return out;
}

// The columns of all alternatives side by side, of unit length.
struct UnitColumns {
  Matrix E;
  Vector per_unit;  // what a column was multiplied by; 0 where it is none
};

UnitColumns unit_columns(const ProbedRows& rows, std::span<const Alternative> alternatives) {
  const Index columns = sum_of(alternatives, [&](const Alternative& one) { return one.effect.cols(); });
  UnitColumns out{Matrix(rows.Y.size(), columns), Vector(columns)};
  Index at = 0;
  for (const Alternative& one : alternatives) {
    for (Index c = 0; c < one.effect.cols(); ++c, ++at) {
      const double norm = one.effect.col(c).norm();
      out.per_unit[at] = norm > 0.0 && std::isfinite(norm) ? 1.0 / norm : 0.0;
      out.E.col(at) =
          out.per_unit[at] > 0.0 ? Vector(one.effect.col(c) * out.per_unit[at]) : Vector::Zero(rows.Y.size());
    }
  }
  return out;
}

// Wᵀ E, (b × columns), leaving out what is zero: columns of links nearer to the base than a joint, and
// alternatives that have no rows of it.
Matrix products(const ProbedRows& rows, const Matrix& E) {
  Matrix out = Matrix::Zero(rows.W.cols(), E.cols());
  for (const ProbedRows::Piece& piece : rows.pieces) {
    const auto some = Eigen::seqN(piece.first, piece.size());
    const auto nonzero = [&](const Matrix& x) {
      return places_where(x.cols(), [&](Index c) { return (x.col(c)(some).array() != 0.0).any(); });
    };
    const std::vector<Index> of_W = nonzero(rows.W);
    const std::vector<Index> of_E = nonzero(E);
    const Matrix W = rows.W(some, of_W);
    const Matrix own = E(some, of_E);
    out(of_W, of_E) += W.transpose() * own;
  }
  return out;
}

// The directions of some columns that are distinguishable from the parameters and from each other;
// orthonormal combinations of the columns, (columns × k).
//
// gram  of what of the columns no parameter reaches
Matrix told_directions(const Matrix& gram) {
  const SymmetricEigen directions = symmetric_eigen(gram);
  const Index k = (directions.values.array() > told_apart).count();
  return directions.vectors.rightCols(k);
}

}  // namespace

std::vector<AlternativeTest> tests(const ProbedRows& rows, std::span<const Alternative> alternatives) {
  const auto R = rows.R.triangularView<Eigen::Upper>();
  const double squares = rows.residual.squaredNorm();
  const std::vector<Segment> segments = segments_of(rows.block_of);
  const UnitColumns unit = unit_columns(rows, alternatives);
  // Qᵀ E, what of the columns base parameters reach, (b × columns).
  const Matrix reached = R.transpose().solve(products(rows, unit.E));
  const Vector scores = unit.E.transpose() * rows.residual;
  const auto G = static_cast<double>(rows.blocks);
  Vector of_blocks = Vector::Zero(rows.blocks);  // squares of the residual
  for (const Segment& segment : segments) {
    of_blocks[segment.block] += rows.residual.segment(segment.first, segment.count).squaredNorm();
  }
  std::vector<AlternativeTest> out;
  for (std::size_t a = 0, first = 0; a < alternatives.size(); ++a) {
    const Index columns = alternatives[a].effect.cols();
    const auto at = Eigen::seqN(static_cast<Index>(first), columns);
    first += static_cast<std::size_t>(columns);
    const Matrix E = unit.E(Eigen::all, at);
    const Matrix gram = E.transpose() * E - reached(Eigen::all, at).transpose() * reached(Eigen::all, at);
    const Matrix T = told_directions(gram);
    const Index k = T.cols();
    const bool many = rows.blocks <= k + 2;  // for a covariance of their scores
    if (k == 0 || (many && !alternatives[a].by_blocks)) {
      continue;
    }
    // Most alternatives explain next to nothing: what of them no parameter reaches is made for the others
    // alone.
    const Vector towards = T.transpose() * scores(at);
    const double fit = towards.dot(solve(T.transpose() * gram * T, towards).col(0)) / squares;
    if (fit < least_fit) {
      continue;
    }
    const Matrix absorbed = R.solve(reached(Eigen::all, at));
    const Matrix X = (E - rows.W * absorbed) * T;
    std::vector<Matrix> A(static_cast<std::size_t>(rows.blocks), Matrix::Zero(k, k));
    Matrix s = Matrix::Zero(k, rows.blocks);
    for (const Segment& segment : segments) {
      const auto some = X.middleRows(segment.first, segment.count);
      A[static_cast<std::size_t>(segment.block)].noalias() += some.transpose() * some;
      s.col(segment.block).noalias() +=
          some.transpose() * rows.residual.segment(segment.first, segment.count);
    }
    Matrix whole = Matrix::Zero(k, k);
    for (const Matrix& one : A) {
      whole += one;
    }
    const Vector score = s.rowwise().sum();
    const Matrix inverted = inverse(whole);
    const Vector delta = inverted * score;
    Matrix scatter = Matrix::Zero(k, k);
    Vector gains(rows.blocks);  // squares of each block that go by the others
    for (Index g = 0; g < rows.blocks; ++g) {
      const Matrix& of_block = A[static_cast<std::size_t>(g)];
      const Vector rest = s.col(g) - of_block * delta;
      scatter.noalias() += rest * rest.transpose();
      const Vector without = solve(whole - of_block, score - s.col(g)).col(0);
      gains[g] = 2.0 * without.dot(s.col(g)) - without.dot(Vector(of_block * without));
    }
    const Matrix V = inverted * (G / (G - 1.0) * scatter) * inverted;
    const auto freedom = static_cast<double>(k);
    const auto per_unit = unit.per_unit(at);
    AlternativeTest found;
    found.of = a;
    found.freedom = freedom;
    found.estimate = per_unit.cwiseProduct(T * delta);
    found.sigma = per_unit.cwiseProduct((T * V * T.transpose()).diagonal().cwiseSqrt());
    if (many) {
      // By parts, which are more alike than what blocks have; of a quiet one little is asked.
      const Vector parts = gains.cwiseQuotient(of_blocks.cwiseMax(of_blocks.mean()));
      const double scatter_of_parts = (parts.array() - parts.mean()).matrix().squaredNorm() / (G - 1.0);
      found.statistic = G * parts.mean() * std::abs(parts.mean()) / scatter_of_parts;
      found.p = f_tail(std::max(found.statistic, 0.0), 1.0, G - 1.0);
    } else {
      found.statistic = delta.dot(solve(V, delta).col(0)) * (G - freedom) / (freedom * (G - 1.0));
      found.p = f_tail(found.statistic, freedom, G - freedom);
    }
    found.held_out = gains.sum() / squares;
    found.shift = (-absorbed * (T * delta)).head(rows.chi.size());
    found.directions = per_unit.asDiagonal() * T;
    out.push_back(std::move(found));
  }
  return out;
}

}  // namespace rivid::detail
