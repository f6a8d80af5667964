#include "rivid/solve/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "dense.hpp"
#include "gram.hpp"
#include "rivid/error.hpp"
#include "rivid/solve/instrumental.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// The columns of a factor brought to norm 1, so that units do not decide about rank.
struct ColumnScaled {
  Matrix R;
  Vector norms;  // 1 where a column is zero
};

ColumnScaled column_scaled(const Eigen::Ref<const Matrix>& R) {
  Vector norms = R.colwise().norm();
  norms = (norms.array() > 0.0).select(norms, 1.0);
  return {R * norms.cwiseInverse().asDiagonal(), norms};
}

// A pivot is noise when it lies below the rounding errors that the factorisation of all rows leaves.
double rank_tolerance(Index rows, Index columns) {
  return 16.0 * std::numeric_limits<double>::epsilon() *
         std::sqrt(static_cast<double>(std::max<Index>(rows, 1) * std::max<Index>(columns, 1)));
}

// Sets of columns that a null space ties together, as a null vector with several entries says.
std::vector<std::vector<Index>> tied_columns(const Matrix& null_space) {
  // of a projector's entries, at most 1: above their rounding, below those of a dependency
  constexpr double noise = 1e-6;
  const Index b = null_space.rows();
  // Projector onto the null space: its entry (i, k) is not zero when columns i and k take part in one
  // dependency.
  const Matrix P = null_space * null_space.transpose();
  std::vector<std::vector<Index>> sets;
  std::vector<bool> seen(static_cast<std::size_t>(b), false);
  for (Index start = 0; start < b; ++start) {
    if (seen[static_cast<std::size_t>(start)] || P(start, start) < noise) {
      continue;
    }
    std::vector<Index> set = {start};
    seen[static_cast<std::size_t>(start)] = true;
    for (std::size_t head = 0; head < set.size(); ++head) {
      for (Index k = 0; k < b; ++k) {
        if (!seen[static_cast<std::size_t>(k)] && std::abs(P(set[head], k)) > noise) {
          seen[static_cast<std::size_t>(k)] = true;
          set.push_back(k);
        }
      }
    }
    std::ranges::sort(set);
    sets.push_back(std::move(set));
  }
  return sets;
}

// Ratio of the extreme singular values, infinite where the least is zero.
double condition_number(const Matrix& R) {
  const Vector singular = detail::singular_values(R);
  const double least = singular[singular.size() - 1];
  return least > 0.0 ? singular[0] / least : std::numeric_limits<double>::infinity();
}

// R⁻¹ by halves: what is zero in it is left out.
void invert_upper(const Eigen::Ref<const Matrix>& R, Eigen::Ref<Matrix> inverse) {
  constexpr Index small = 12;  // order up to which it is solved at once; a choice of speed
  const Index n = R.rows();
  if (n <= small) {
    inverse.setIdentity();
    R.triangularView<Eigen::Upper>().solveInPlace(inverse);
    return;
  }
  const Index half = n / 2;
  auto corner = inverse.topRightCorner(half, n - half);
  invert_upper(R.topLeftCorner(half, half), inverse.topLeftCorner(half, half));
  invert_upper(R.bottomRightCorner(n - half, n - half), inverse.bottomRightCorner(n - half, n - half));
  inverse.bottomLeftCorner(n - half, half).setZero();
  const Matrix behind = R.topRightCorner(half, n - half) * inverse.bottomRightCorner(n - half, n - half);
  corner.noalias() = -inverse.topLeftCorner(half, half) * behind;
}

Matrix upper_inverse(const Matrix& R) {
  Matrix out(R.rows(), R.cols());
  invert_upper(R, out);
  return out;
}

// Lower bound of the singular values of the scaled factor, and so of its pivots; zero, or nan, where there is
// none.
double least_pivot(const ColumnScaled& scaled, const Matrix& inverse) {
  return 1.0 / (scaled.norms.asDiagonal() * inverse).norm();
}

// Whether such a bound settles that no pivot is noise, for all that roundings do to the inverse; mostly it
// does, in a fraction of the time of pivoting.
bool surely_full(double least_pivot, double tolerance) {
  // for the rounding of the inverse; a choice: what fails it is only looked at by pivoting
  constexpr double margin = 10.0;
  return least_pivot > margin * tolerance;
}

// A symmetric tridiagonal matrix without zeros beside its diagonal that grows by rows, for its largest
// eigenvalue.
class Tridiagonal {
 public:
  void add(double diagonal, double before) {
    diagonal_.push_back(diagonal);
    before_.push_back(before);
  }
  [[nodiscard]] std::size_t size() const { return diagonal_.size(); }

  // By bisection.
  [[nodiscard]] double largest_eigenvalue() const {
    double low = *std::ranges::max_element(diagonal_);
    double high = low;
    for (std::size_t i = 0; i < size(); ++i) {
      high = std::max(high, diagonal_[i] + before_[i] + (i + 1 < size() ? before_[i + 1] : 0.0));
    }
    for (;;) {
      const double middle = 0.5 * (low + high);
      if (!(low < middle && middle < high)) {  // nan is between nothing
        return high;
      }
      (above_all(middle) ? high : low) = middle;
    }
  }

  // Magnitude of the last entry of the unit eigenvector of the largest eigenvalue. From the last row on the
  // entries grow, so roundings do not.
  [[nodiscard]] double last_entry(double largest) const {
    double entry = 1.0;
    double squares = 1.0;
    double pivot = largest - diagonal_.back();
    for (std::size_t i = size() - 1; i > 0; --i) {
      entry *= pivot / before_[i];
      squares += entry * entry;
      pivot = largest - diagonal_[i - 1] - before_[i] * before_[i] / pivot;
    }
    return 1.0 / std::sqrt(squares);
  }

 private:
  // Whether x I − T is positive definite.
  [[nodiscard]] bool above_all(double x) const {
    double pivot = x - diagonal_.back();
    for (std::size_t i = size() - 1; i > 0 && pivot > 0.0; --i) {
      pivot = x - diagonal_[i - 1] - before_[i] * before_[i] / pivot;
    }
    return pivot > 0.0;
  }

  std::vector<double> diagonal_;
  std::vector<double> before_;  // entry on the left of the diagonal
};

// Largest eigenvalue of A Aᵀ by Lanczos' method, to eight digits at least: some twenty products in place of a
// factorisation. Vectors that lose their orthogonality on the way only repeat eigenvalues.
double largest_eigenvalue(const Matrix& A) {
  // bound of the eigenvalue's error, relative, that ends it: the eight digits said above
  constexpr double digits = 1e-8;
  // a choice: a look, by bisection, costs about as much as some products
  constexpr std::size_t steps_between_looks = 4;
  const auto n = static_cast<std::size_t>(A.rows());
  std::mt19937_64 random(2021);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  // Any vector that has a share of the one looked for.
  Vector v = Vector::NullaryExpr(A.rows(), [&] { return uniform(random); }).normalized();
  Vector last = Vector::Zero(A.rows());
  Tridiagonal T;
  for (double before = 0.0;;) {
    const Vector inner = A.transpose() * v;
    Vector next = A * inner - before * last;
    const double diagonal = inner.squaredNorm();
    T.add(diagonal, before);
    next -= diagonal * v;
    before = next.norm();
    if (T.size() % steps_between_looks == 0 || T.size() <= 2 || T.size() == n || !(before > 0.0)) {
      const double largest = T.largest_eigenvalue();
      const bool open = before * T.last_entry(largest) > digits * largest;  // not where it is nan
      if (!open) {
        return largest;
      }
    }
    last.swap(v);
    v = next / before;
  }
}

Index total_rows(std::span<const RowGroup> groups) {
  return std::accumulate(groups.begin(), groups.end(), Index{0},
                         [](Index sum, const RowGroup& g) { return sum + g.qr.rows(); });
}

// Norm of each parameter's column over the rows of all groups.
Vector column_norms(std::span<const RowGroup> groups) {
  Index count = 0;
  for (const RowGroup& group : groups) {
    count = std::max(count, group.columns.empty() ? Index{0} : std::ranges::max(group.columns) + 1);
  }
  Vector squares = Vector::Zero(count);
  for (const RowGroup& group : groups) {
    squares(group.columns) += group.qr.R().colwise().squaredNorm().transpose();
  }
  return squares.cwiseSqrt();
}

}  // namespace

namespace {

// Whether the columns of groups are those of their factors, among so many, and there is a weight for each.
template <typename Group>
void require_groups(const char* who, std::span<const Group> groups, Index columns, std::size_t weights) {
  if (weights < groups.size()) {
    throw InputError(std::string(who) + ": weights has " + counted(static_cast<Index>(weights), "value") +
                     ", must have one for each of " + counted(std::ssize(groups), "group"));
  }
  for (const Group& group : groups) {
    if (std::ssize(group.columns) != group.qr.columns()) {
      throw InputError(std::string(who) + ": a group names " + counted(std::ssize(group.columns), "column") +
                       ", its factor has " + std::to_string(group.qr.columns()));
    }
    for (const Index c : group.columns) {
      if (c < 0 || c >= columns) {
        throw InputError(std::string(who) + ": a group has column " + std::to_string(c) +
                         ", must be one of 0 to " + std::to_string(columns - 1));
      }
    }
  }
}

// The same, for a solution.
template <typename Group>
void require_system(const char* who, std::span<const Group> groups, Index columns, std::size_t weights) {
  if (groups.empty() || columns < 1) {
    throw InputError(std::string(who) + ": there are " + counted(std::ssize(groups), "group") + " and " +
                     counted(columns, "column") + ", must be one of each at least");
  }
  require_groups(who, groups, columns, weights);
}

}  // namespace

StreamingQr combined(std::span<const RowGroup> groups, Index columns, std::span<const double> weights) {
  require_groups("combined", groups, columns, weights.size());
  StreamingQr out(columns);
  Matrix rows;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const StreamingQr& qr = groups[g].qr;
    rows.setZero(qr.columns(), columns + 1);
    for (Index c = 0; c < qr.columns(); ++c) {
      rows.col(groups[g].columns[static_cast<std::size_t>(c)]).head(c + 1) =
          weights[g] * qr.R().col(c).head(c + 1);
    }
    rows.col(columns) = weights[g] * qr.qty();
    out.add(rows.leftCols(columns), rows.rightCols(1));
  }
  return out;
}

LeastSquares least_squares(std::span<const RowGroup> groups, Index columns, std::span<const double> weights) {
  require_system("least_squares", groups, columns, weights.size());
  const StreamingQr all = combined(groups, columns, weights);
  LeastSquares out;
  out.R = all.R();
  const Vector qty = all.qty();
  const ColumnScaled scaled = column_scaled(out.R);
  const double tolerance = rank_tolerance(total_rows(groups), columns);
  const Matrix inverse = upper_inverse(out.R);
  out.smallest_pivot = least_pivot(scaled, inverse);
  if (surely_full(out.smallest_pivot, tolerance)) {
    out.rank = columns;
  } else {
    const detail::PivotedQr pivoted(scaled.R, tolerance);
    out.rank = pivoted.rank();
    out.smallest_pivot = pivoted.last_pivot();
  }
  if (out.rank == columns) {
    out.chi = out.R.triangularView<Eigen::Upper>().solve(qty);
    out.unit_covariance = Matrix::Zero(columns, columns);
    detail::add_gram(out.unit_covariance, inverse.transpose());
    out.unit_covariance.triangularView<Eigen::StrictlyUpper>() = out.unit_covariance.transpose();
    // Both extremes as largest values, which keep their digits when squared.
    out.condition = std::sqrt(largest_eigenvalue(out.R) * largest_eigenvalue(inverse));
    return out;
  }
  out.condition = condition_number(out.R);
  // What lies in the null space is not determined; the other entries are unique all the same.
  const detail::Svd svd = detail::svd(scaled.R, Eigen::ComputeThinU | Eigen::ComputeFullV);
  const Matrix V = svd.V.leftCols(out.rank);
  const Vector s = svd.values.head(out.rank);
  const Matrix pseudo = scaled.norms.cwiseInverse().asDiagonal() * V * s.cwiseInverse().asDiagonal();
  out.chi = pseudo * (svd.U.leftCols(out.rank).transpose() * qty);
  out.unit_covariance = pseudo * pseudo.transpose();
  out.undetermined = tied_columns(svd.V.rightCols(columns - out.rank));
  for (const std::vector<Index>& set : out.undetermined) {
    for (const Index c : set) {
      out.unit_covariance(c, c) = std::numeric_limits<double>::infinity();
    }
  }
  return out;
}

namespace {

// A group with fewer rows for each of its columns fits itself in part, or altogether: its deviation is told
// by the fit to all groups, which leaves it the degrees of freedom that the others do not determine for it.
// So is that of rows without Y, which parameters of zero fit.
bool fits_itself(const RowGroup& group) {
  // rows for each column; a choice: with fewer the fit hides more than a fifth of the squares
  constexpr Index enough = 5;
  return group.qr.rows() > 0 && (group.qr.rows() < enough * group.qr.columns() || group.qr.y_norm() == 0.0);
}

double rms(const RowGroup& group) {
  return group.qr.y_norm() / std::sqrt(static_cast<double>(group.qr.rows()));
}

// The covariance on what is determined, zero elsewhere.
Matrix determined(Matrix covariance) {
  for (Index i = 0; i < covariance.rows(); ++i) {
    if (!std::isfinite(covariance(i, i))) {
      covariance.row(i).setZero();
      covariance.col(i).setZero();
    }
  }
  return covariance;
}

// Deviations of groups that fit themselves, and the fit to all groups that these make, in turn.
void refit_by_all(std::span<const RowGroup> groups, Index columns, std::vector<double>& sigmas) {
  constexpr double first = 0.05;         // of the rms of Y
  constexpr double least = 1e-3;         // the same, that a group which nothing else determines ends at
  constexpr double least_freedom = 0.1;  // of the rows
  constexpr int most_rounds = 8;         // a choice that ends what does not settle
  // largest relative change of a deviation; a choice: weights need no more digits
  constexpr double settled = 0.01;
  double largest = 0.0;
  for (const RowGroup& group : groups) {
    largest = std::max(largest, group.qr.rows() > 0 ? rms(group) : 0.0);
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const double own = fits_itself(groups[g]) ? rms(groups[g]) : 0.0;
    sigmas[g] = fits_itself(groups[g]) ? std::max(first * (own > 0.0 ? own : largest), sigmas[g]) : sigmas[g];
  }
  double step = 1.0;
  for (int round = 0; round < most_rounds && step > settled; ++round) {
    std::vector<double> weights = sigmas;
    std::ranges::transform(weights, weights.begin(), [](double sigma) { return 1.0 / sigma; });
    const LeastSquares all = least_squares(groups, columns, weights);
    const Matrix C = determined(all.unit_covariance);
    step = 0.0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!fits_itself(groups[g])) {
        continue;
      }
      const RowGroup& group = groups[g];
      const Matrix R = weights[g] * group.qr.R();
      const double leverage = (R * C(group.columns, group.columns)).cwiseProduct(R).sum();
      const auto rows = static_cast<double>(group.qr.rows());
      const double freedom = std::max({rows - leverage, least_freedom * rows, 1.0});
      const double sigma = std::max(group.qr.residual_norm(all.chi(group.columns)) / std::sqrt(freedom),
                                    least * rms(group) + std::numeric_limits<double>::min());
      step = std::max(step, std::abs(std::log(sigma / sigmas[g])));
      sigmas[g] = sigma;
    }
  }
}

}  // namespace

std::vector<double> group_sigmas(std::span<const RowGroup> groups) {
  require_groups("group_sigmas", groups, std::numeric_limits<Index>::max(), groups.size());
  const Vector norms = column_norms(groups);
  std::vector<double> out;
  for (const RowGroup& group : groups) {
    const Index rows = group.qr.rows();
    if (rows == 0) {
      out.push_back(1.0);
      continue;
    }
    Matrix R = group.qr.R();
    for (Index c = 0; c < R.cols(); ++c) {
      // What is rounding errors beside the same parameter's column in other groups, such as gravity about an
      // axis that points up, would else be brought to norm 1 and count.
      constexpr double nothing = 1e-12;
      if (R.col(c).norm() <= nothing * norms[group.columns[static_cast<std::size_t>(c)]]) {
        R.col(c).setZero();
      }
    }
    const ColumnScaled scaled = column_scaled(R);
    const double tolerance = rank_tolerance(rows, group.qr.columns());
    Index rank = group.qr.columns();
    double norm = group.qr.unreachable_norm();
    if (!surely_full(least_pivot(scaled, upper_inverse(R)), tolerance)) {
      const detail::PivotedQr pivoted(scaled.R, tolerance);
      rank = pivoted.rank();
      // What the dependent columns' pivots, mere rounding errors, would take of Y belongs to the residual.
      const Vector qty = pivoted.rotated(group.qr.qty());
      norm = std::hypot(qty.tail(qty.size() - rank).norm(), norm);
    }
    const auto freedom = static_cast<double>(std::max<Index>(rows - rank, 1));
    const double rounding =
        std::numeric_limits<double>::epsilon() * group.qr.y_norm() + std::numeric_limits<double>::min();
    out.push_back(std::max(norm, rounding) / std::sqrt(freedom));
  }
  if (std::ranges::any_of(groups, fits_itself)) {
    refit_by_all(groups, norms.size(), out);
  }
  return out;
}

Residual residual(std::span<const RowGroup> groups, const Eigen::Ref<const Vector>& chi,
                  std::span<const double> weights) {
  require_groups("residual", groups, chi.size(), weights.size());
  Residual out;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const RowGroup& group = groups[g];
    const Vector own = chi(group.columns);
    out.norm = std::hypot(out.norm, weights[g] * group.qr.residual_norm(own));
    out.y_norm = std::hypot(out.y_norm, weights[g] * group.qr.y_norm());
    out.sum += weights[g] * group.qr.residual_sum(own);
    out.rows += group.qr.rows();
  }
  return out;
}

InstrumentalVariables instrumental_variables(std::span<const InstrumentalGroup> groups, Index columns,
                                             std::span<const double> weights) {
  require_system("instrumental_variables", groups, columns, weights.size());
  for (const InstrumentalGroup& group : groups) {
    if (group.qr.carried() != group.qr.columns() + 1) {
      throw InputError("instrumental_variables: a factor of " + counted(group.qr.columns(), "column") +
                       " carries " + std::to_string(group.qr.carried()) +
                       ", must carry those of W and Y: " + std::to_string(group.qr.columns() + 1));
    }
  }
  // Below its triangle V is zero, so what W and Y have there takes no part in Vᵀ W and Vᵀ Y.
  StreamingQr all(columns, columns + 1);
  Matrix V;
  Matrix WY;
  Index rows = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const StreamingQr& qr = groups[g].qr;
    const Index m = qr.columns();
    V.setZero(m, columns);
    WY.setZero(m, columns + 1);
    for (Index c = 0; c < m; ++c) {
      const Index to = groups[g].columns[static_cast<std::size_t>(c)];
      V.col(to).head(c + 1) = weights[g] * qr.R().col(c).head(c + 1);
      WY.col(to) = weights[g] * qr.qt_carried().col(c);
    }
    WY.col(columns) = weights[g] * qr.qty();
    all.add(V, WY);
    rows += qr.rows();
  }

  InstrumentalVariables out;
  out.R_VV = all.R();
  out.R_VW = all.qt_carried().leftCols(columns);
  out.condition_V = condition_number(out.R_VV);
  out.condition_VW = condition_number(out.R_VW);
  const ColumnScaled scaled = column_scaled(out.R_VW);
  const detail::PivotedQr pivoted(scaled.R, rank_tolerance(rows, columns));
  out.rank = pivoted.rank();
  out.smallest_pivot = pivoted.last_pivot();
  if (out.rank == columns) {
    out.chi = scaled.norms.cwiseInverse().asDiagonal() * pivoted.solve(all.qty());
    const Matrix inverse =
        scaled.norms.cwiseInverse().asDiagonal() * pivoted.solve(Matrix::Identity(columns, columns));
    out.unit_covariance = inverse * inverse.transpose();
    return out;
  }
  out.chi = Vector::Constant(columns, std::numeric_limits<double>::quiet_NaN());
  out.unit_covariance = Matrix::Constant(columns, columns, std::numeric_limits<double>::infinity());
  // A joint that never moves, a direction that never turns shows in V itself.
  const ColumnScaled V_scaled = column_scaled(out.R_VV);
  const detail::Svd of_V = detail::svd(V_scaled.R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector& singular = of_V.values;
  const double noise = rank_tolerance(rows, columns) * singular[0];
  const Index missing = (singular.array() <= noise).count();
  if (missing > 0) {
    out.undetermined = tied_columns(of_V.V.rightCols(missing));
    return out;
  }
  const detail::Svd of_VW = detail::svd(scaled.R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  out.undetermined = tied_columns(of_VW.V.rightCols(columns - out.rank));
  return out;
}

}  // namespace rivid
