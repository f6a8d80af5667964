#include "identify/check/alternative_tests.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dense.hpp"
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
  Index columns = 0;
  for (const Alternative& one : alternatives) {
    columns += one.effect.cols();
  }
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
      std::vector<Index> columns;
      for (Index c = 0; c < x.cols(); ++c) {
        if ((x.col(c)(some).array() != 0.0).any()) {
          columns.push_back(c);
        }
      }
      return columns;
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

// What of an alternative no parameter reaches, beside the residual, added up by blocks.
struct BlockScores {
  std::vector<Matrix> A;  // squares, (k × k)
  Matrix s;               // scores, (k × blocks)
  Matrix whole;           // sum of A
  Vector score;           // of s
  Index counting = 0;     // blocks that hold some of it

  // X  columns, (rows × k)
  BlockScores(const ProbedRows& rows, const Matrix& X)
      : A(static_cast<std::size_t>(rows.blocks), Matrix::Zero(X.cols(), X.cols())),
        s(Matrix::Zero(X.cols(), rows.blocks)),
        whole(Matrix::Zero(X.cols(), X.cols())) {
    // A block with less than this part of the mean has no say.
    constexpr double least_part = 0.1;
    for (const Segment& segment : segments_of(rows.block_of)) {
      const auto some = X.middleRows(segment.first, segment.count);
      A[static_cast<std::size_t>(segment.block)].noalias() += some.transpose() * some;
      s.col(segment.block).noalias() +=
          some.transpose() * rows.residual.segment(segment.first, segment.count);
    }
    for (const Matrix& one : A) {
      whole += one;
    }
    score = s.rowwise().sum();
    const double mean = whole.trace() / static_cast<double>(rows.blocks);
    counting = std::ranges::count_if(A, [&](const Matrix& one) { return one.trace() > least_part * mean; });
  }

  // Of A⁻¹ of the whole times the score, by the scatter of the blocks.
  [[nodiscard]] Matrix covariance(const Matrix& inverted, const Vector& delta) const {
    Matrix scatter = Matrix::Zero(delta.size(), delta.size());
    for (std::size_t g = 0; g < A.size(); ++g) {
      const Vector rest = s.col(static_cast<Index>(g)) - A[g] * delta;
      scatter.noalias() += rest * rest.transpose();
    }
    const auto G = static_cast<double>(counting);
    return inverted * (G / (G - 1.0) * scatter) * inverted;
  }

  // Part of the sum of squares that goes with what the other blocks say, added up.
  [[nodiscard]] double held_out() const {
    double out = 0.0;
    for (std::size_t g = 0; g < A.size(); ++g) {
      const Vector own = s.col(static_cast<Index>(g));
      const Vector without = solve(whole - A[g], score - own).col(0);
      out += 2.0 * without.dot(own) - without.dot(Vector(A[g] * without));
    }
    return out;
  }

  // Fewer than these say nothing of a covariance.
  [[nodiscard]] bool enough() const { return counting > whole.rows() + 2; }
};

// What one half of the motion says of an alternative, with parameters of its own.
struct Half {
  Matrix A;
  Vector score;
  Vector delta;
  Matrix V;  // of delta; empty where there are too few blocks
  double squares = 0.0;

  // E  columns of the alternative, (rows × k)
  Half(const ProbedRows& rows, const Matrix& E) : squares(rows.residual.squaredNorm()) {
    const auto R = rows.R.triangularView<Eigen::Upper>();
    const Matrix absorbed = R.solve(R.transpose().solve(rows.W.transpose() * E));
    const BlockScores blocks(rows, E - rows.W * absorbed);
    A = blocks.whole;
    score = blocks.score;
    const SymmetricEigen own = symmetric_eigen(A);
    const Index k = (own.values.array() > told_apart * std::max(E.squaredNorm(), 1e-300)).count();
    const Matrix directions = own.vectors.rightCols(k);
    const Matrix inverted =
        directions * own.values.tail(k).cwiseInverse().asDiagonal() * directions.transpose();
    delta = inverted * score;
    if (blocks.enough()) {
      V = blocks.covariance(inverted, delta);
    }
  }

  // Of the sum of squares, what goes with a value.
  [[nodiscard]] double gone_with(const Vector& value) const {
    return 2.0 * value.dot(score) - value.dot(Vector(A * value));
  }
};

}  // namespace

bool replicates(const ProbedRows& rows, const Alternative& alternative) {
  // Part of what a half explains by itself that the value of the other half must explain as well, part of its
  // sum of squares that it must be, and difference of both: in deviations, or in part of the effect.
  constexpr double as_well = 0.5;
  constexpr double notable = 0.2;
  constexpr double deviations = 3.0;
  constexpr double small_difference = 0.1;
  const UnitColumns unit = unit_columns(rows, std::span(&alternative, 1));
  const auto R = rows.R.triangularView<Eigen::Upper>();
  const Matrix X = unit.E - rows.W * R.solve(R.transpose().solve(products(rows, unit.E)));
  const Matrix T = told_directions(X.transpose() * X);
  if (T.cols() == 0) {
    return false;
  }
  // Halves of what tells of it, not of the time: a joint may have its turn at the end.
  const BlockScores blocks(rows, X * T);
  Index middle = 0;
  for (double sum = 0.0; middle < rows.blocks && sum < 0.5 * blocks.whole.trace(); ++middle) {
    sum += blocks.A[static_cast<std::size_t>(middle)].trace();
  }
  if (middle < 2 || rows.blocks - middle < 2) {
    return false;
  }
  std::vector<Half> halves;
  for (const auto& [first, count] : {std::pair(Index{0}, middle), std::pair(middle, rows.blocks - middle)}) {
    std::vector<Index> kept;
    const ProbedRows part = rows.of_blocks(first, count, kept);
    halves.emplace_back(part, Matrix(unit.E(kept, Eigen::all) * T));
  }
  for (std::size_t h = 0; h < 2; ++h) {
    const double own = halves[h].gone_with(halves[h].delta);
    if (own < notable * halves[h].squares || halves[h].gone_with(halves[1 - h].delta) < as_well * own) {
      return false;
    }
  }
  const Vector difference = halves[0].delta - halves[1].delta;
  const Vector mean = 0.5 * (halves[0].delta + halves[1].delta);
  if (difference.dot(Vector(blocks.whole * difference)) <
      small_difference * mean.dot(Vector(blocks.whole * mean))) {
    return true;
  }
  if (halves[0].V.size() == 0 || halves[1].V.size() == 0) {
    return false;
  }
  const Vector whitened = solve(halves[0].V + halves[1].V, difference).col(0);
  return difference.dot(whitened) < deviations * deviations * static_cast<double>(T.cols());
}

std::vector<AlternativeTest> tests(const ProbedRows& rows, std::span<const Alternative> alternatives,
                                   std::vector<std::size_t>* untested) {
  const auto R = rows.R.triangularView<Eigen::Upper>();
  const double squares = rows.residual.squaredNorm();
  const UnitColumns unit = unit_columns(rows, alternatives);
  // Qᵀ E, what of the columns base parameters reach, (b × columns).
  const Matrix reached = R.transpose().solve(products(rows, unit.E));
  const Vector scores = unit.E.transpose() * rows.residual;
  std::vector<AlternativeTest> out;
  for (std::size_t a = 0, first = 0; a < alternatives.size(); ++a) {
    const Index columns = alternatives[a].effect.cols();
    const auto at = Eigen::seqN(static_cast<Index>(first), columns);
    first += static_cast<std::size_t>(columns);
    const Matrix E = unit.E(Eigen::all, at);
    const Matrix gram = E.transpose() * E - reached(Eigen::all, at).transpose() * reached(Eigen::all, at);
    const Matrix T = told_directions(gram);
    const Index k = T.cols();
    if (k == 0) {
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
    const BlockScores blocks(rows, (E - rows.W * absorbed) * T);
    // So many parameters as those of all bodies have no covariance by blocks: left-out blocks judge them.
    const bool by_blocks = alternatives[a].code != "logs_differ";
    if (by_blocks && !blocks.enough()) {
      if (untested != nullptr) {
        untested->push_back(a);
      }
      continue;
    }
    const Matrix inverted = inverse(blocks.whole);
    const Vector delta = inverted * blocks.score;
    const auto freedom = static_cast<double>(k);
    const auto rest = static_cast<double>(rows.Y.size() - rows.W.cols() - k);
    const auto G = by_blocks ? static_cast<double>(blocks.counting) : rest + freedom;
    const Matrix V = by_blocks ? blocks.covariance(inverted, delta)
                               : Matrix(inverted * ((1.0 - fit) * squares / std::max(rest, 1.0)));
    const auto per_unit = unit.per_unit(at);
    AlternativeTest found;
    found.of = a;
    found.freedom = freedom;
    found.estimate = per_unit.cwiseProduct(T * delta);
    found.sigma = per_unit.cwiseProduct((T * V * T.transpose()).diagonal().cwiseSqrt());
    found.statistic = delta.dot(solve(V, delta).col(0)) * (G - freedom) / (freedom * (G - 1.0));
    found.p = f_tail(found.statistic, freedom, G - freedom);
    found.held_out = blocks.held_out() / squares;
    found.shift = (-absorbed * (T * delta)).head(rows.chi.size());
    found.columns = E * T;
    out.push_back(std::move(found));
  }
  return out;
}

}  // namespace rivid::detail
