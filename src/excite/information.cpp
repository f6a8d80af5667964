#include "excite/information.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "dense.hpp"
#include "excite/products_kernel.hpp"

namespace rivid::detail {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Eigenvalues below this part of the largest, of M with unit diagonal, are rounding.
constexpr double negligible = 1e-13;

// M with unit diagonal, which makes it as well conditioned as units allow: M = D⁻¹ S D⁻¹.
struct Scaled {
  explicit Scaled(const Matrix& M)
      : d(M.diagonal().cwiseSqrt().cwiseInverse()), S(d.asDiagonal() * M * d.asDiagonal()) {}
  Vector d;
  Matrix S;
};

double log_det_of(const Eigen::LLT<Matrix>& factor, const Vector& d) {
  return 2.0 * (factor.matrixLLT().diagonal().array().log().sum() - d.array().log().sum());
}

const ProductsKernel& products() { return kernel_for<ProductsKernel>(); }

TallMatrix tall(const Matrix& W) { return {W.data(), W.outerStride(), W.rows(), W.cols()}; }

// Aᵀ A, both triangles.
Matrix gram_of(const Matrix& A) {
  Matrix out(A.cols(), A.cols());
  products().gram(tall(A), out.data());
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
  return out;
}

// M⁻¹ from L of D M D = L Lᵀ.
Matrix inverse_of(const Eigen::LLT<Matrix>& factor, const Vector& d) {
  const Matrix inverse = factor.matrixL().solve(Matrix::Identity(d.size(), d.size()));
  return gram_of(inverse * d.asDiagonal());
}

ObjectiveValue score_of(const Matrix& C, double log_det, const Objective& objective) {
  if (const auto* const torque = std::get_if<TorqueError>(&objective)) {
    const double trace = (C * torque->B).trace();
    return {std::log(trace), C * torque->B * C / trace};
  }
  if (const auto* const chosen = std::get_if<Deviations>(&objective)) {
    ObjectiveValue out{0.0, Matrix::Zero(C.rows(), C.cols())};
    for (const Index i : chosen->parameters) {
      out.value += std::log(C(i, i));
      out.K += C.col(i) * C.col(i).transpose() / C(i, i);
    }
    return out;
  }
  return {-log_det, C};
}

ObjectiveValue condition_of(const Matrix& M) {
  const SymmetricEigen eigen = symmetric_eigen(M);
  const Index last = M.rows() - 1;
  const double least = eigen.values[0];
  const double most = eigen.values[last];
  return {0.5 * std::log(most / least),
          0.5 * (eigen.vectors.col(0) * eigen.vectors.col(0).transpose() / least -
                 eigen.vectors.col(last) * eigen.vectors.col(last).transpose() / most)};
}

}  // namespace

void add_information(const SampledRegressor& regressor, std::span<const Matrix> W, const Vector& weights,
                     Matrix& M) {
  for (std::size_t i = 0; i < W.size(); ++i) {
    const std::vector<Index>& columns = regressor.columns(i);
    M(columns, columns) += weights[static_cast<Index>(i)] * gram_of(W[i]);
  }
}

Matrix times_symmetric(const Matrix& W, const Matrix& K) {
  Matrix out(W.rows(), W.cols());
  products().product(tall(W), K.data(), out.data(), out.outerStride());
  return out;
}

std::optional<ObjectiveValue> score(const Matrix& M, const Objective& objective, bool slope) {
  const Scaled scaled(M);
  if (!scaled.d.allFinite()) {
    return std::nullopt;
  }
  const Eigen::LLT<Matrix> factor(scaled.S);
  if (factor.info() != Eigen::Success) {
    return std::nullopt;
  }
  const double log_det = log_det_of(factor, scaled.d);
  ObjectiveValue out;
  if (std::holds_alternative<Condition>(objective)) {
    out = condition_of(M);
  } else if (std::holds_alternative<Information>(objective) && !slope) {
    out.value = -log_det;
  } else {
    out = score_of(inverse_of(factor, scaled.d), log_det, objective);
  }
  return std::isfinite(out.value) ? std::optional(std::move(out)) : std::nullopt;
}

double log_determinant(const Matrix& M) {
  const Scaled scaled(M);
  if (!scaled.d.allFinite()) {
    return -infinity;
  }
  const Eigen::LLT<Matrix> factor(scaled.S);
  return factor.info() == Eigen::Success ? log_det_of(factor, scaled.d) : -infinity;
}

Spread spread(const Matrix& M) {
  const Index b = M.rows();
  Spread out;
  out.sigma = Vector::Constant(b, infinity);
  out.log_det = log_determinant(M);
  // Parameters that nothing is seen of are left out, so that they spoil no other.
  std::vector<Index> seen;
  for (Index i = 0; i < b; ++i) {
    if (M(i, i) > 0.0) {
      seen.push_back(i);
    }
  }
  if (seen.empty()) {
    out.condition = infinity;
    return out;
  }
  const Scaled scaled(M(seen, seen));
  const SymmetricEigen eigen = symmetric_eigen(scaled.S);
  const double least = negligible * eigen.values.maxCoeff();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto k = static_cast<Index>(i);
    double variance = 0.0;
    for (Index e = 0; e < eigen.values.size(); ++e) {
      const double part = eigen.vectors(k, e) * eigen.vectors(k, e);
      if (eigen.values[e] > least) {
        variance += part / eigen.values[e];
      } else if (part > negligible) {
        variance = infinity;
      }
    }
    out.sigma[seen[i]] = scaled.d[k] * std::sqrt(variance);
  }
  const Vector values = symmetric_eigenvalues(M);
  out.condition = values.minCoeff() > 0.0 ? std::sqrt(values.maxCoeff() / values.minCoeff()) : infinity;
  return out;
}

}  // namespace rivid::detail
