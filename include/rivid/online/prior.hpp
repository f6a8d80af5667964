#pragma once

#include <cmath>
#include <string>

#include "rivid/error.hpp"
#include "rivid/online/information_triangle.hpp"
#include "rivid/online/model.hpp"
#include "rivid/online/row_stream.hpp"
#include "rivid/online/saved_state.hpp"

// What estimators make of their model when they are constructed.
namespace rivid::detail {

// Lower triangle L of A = L Lᵀ; throws where A is not positive definite. (Eigen's costs users of rivid::headers seconds.)
inline Matrix cholesky_of(const Matrix& A, const char* who) {
  const Index n = A.rows();
  Matrix L = Matrix::Zero(n, n);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) {
      double sum = A(i, j);
      for (Index k = 0; k < j; ++k) {
        sum -= L(i, k) * L(j, k);
      }
      if (i == j) {
        if (!(sum > 0.0)) {
          throw InputError(std::string(who) + ": the covariance of the parameters is not positive definite");
        }
        L(j, j) = std::sqrt(sum);
      } else {
        L(i, j) = sum / L(j, j);
      }
    }
  }
  return L;
}

// L⁻¹ of a lower triangle: its rows are whitened rows of information, L⁻¹ χ = L⁻¹ χ̂ + e, for C = L Lᵀ.
inline Matrix inverse_of_lower(const Matrix& L) {
  const Index n = L.rows();
  Matrix out = Matrix::Zero(n, n);
  for (Index c = 0; c < n; ++c) {
    out(c, c) = 1.0 / L(c, c);
    for (Index i = c + 1; i < n; ++i) {
      double sum = 0.0;
      for (Index k = c; k < i; ++k) {
        sum += L(i, k) * out(k, c);
      }
      out(i, c) = -sum / L(i, i);
    }
  }
  return out;
}

// What is known of parameters beforehand as rows: factor (χ − χ̂) has unit variance.
inline Matrix whitening_of(const Matrix& C, const char* who) {
  // Scaled to deviations of one: entries of C may differ by many decades.
  const Vector scale = C.diagonal().cwiseSqrt().cwiseInverse();
  Matrix scaled(C.rows(), C.cols());
  for (Index i = 0; i < C.rows(); ++i) {
    for (Index j = 0; j < C.cols(); ++j) {
      scaled(i, j) = C(i, j) * scale[i] * scale[j];
    }
  }
  Matrix out = inverse_of_lower(cholesky_of(scaled, who));
  for (Index j = 0; j < C.cols(); ++j) {
    out.col(j) *= scale[j];
  }
  return out;
}

// The same, row by row into a triangle.
//
// place  unknown of the triangle that a parameter is
template <typename Scalar, typename Place>
void add_prior(InformationTriangle<Scalar>& to, const Matrix& C, const Vector& chi, const Place& place,
               const char* who) {
  const Matrix whitening = whitening_of(C, who);
  for (Index i = 0; i < chi.size(); ++i) {
    Scalar* const w = to.room();
    double y = 0.0;
    for (Index c = 0; c <= i; ++c) {
      w[place(c)] = static_cast<Scalar>(whitening(i, c));
      y += whitening(i, c) * chi[c];
    }
    w[to.size()] = static_cast<Scalar>(y);
    to.commit(-1);
    to.finish([](const auto& /*outcome*/) {});
  }
}

// The model, once it is known that an estimator can be made of it: before anything reads it.
template <typename Options>
[[nodiscard]] const OnlineModel& usable(const char* who, const OnlineModel& model, const Options& options) {
  if (const auto fault = model.complaint()) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  if (const auto fault = options.complaint(model.robot.size())) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  return model;
}

// Options of the rows, with the model's thresholds where they have none.
template <typename Options>
[[nodiscard]] RowStreamOptions row_options(const OnlineModel& model, const Options& options) {
  const RowStreamOptions& rows = options.rows;
  return {.f_m = rows.f_m,
          .stride = rows.stride,
          .torque_held = rows.torque_held,
          .velocity_threshold =
              rows.velocity_threshold.size() == 0 ? model.velocity_threshold : rows.velocity_threshold,
          .velocity_span = rows.velocity_span};
}

// Whose state an estimator has that is made of a model.
//
// others  options beside the rows' and the flange's
template <typename Scalar, typename... Others>
[[nodiscard]] StateOwner owner_of(const char* who, const OnlineModel& model, const RowStreamOptions& rows,
                                  const Others&... others) {
  const auto& [robot, base, chi, C_chi, sigma_rho, velocity_threshold] = model;
  std::uint64_t laws = 0;
  for (const Joint& joint : robot.joints) {
    laws = Fingerprint::of(laws, joint.sign_speed);
  }
  for (const BaseParameter& parameter : base.parameters) {
    laws = Fingerprint::of(laws, parameter.leading.kind, parameter.leading.joint);
  }
  for (const Coupling& coupling : robot.couplings) {
    laws = Fingerprint::of(laws, coupling.row(robot.size()), coupling.coulomb, coupling.terms);
  }
  const auto& [f_m, stride, torque_held, threshold, span] = rows;
  return {.kind = kind_of<Scalar>(who),
          .arm = Fingerprint::of(robot.chain, laws, chi, C_chi, sigma_rho, velocity_threshold),
          .rate = Fingerprint::of(f_m),
          .options = Fingerprint::of(stride, torque_held, threshold, span, others...)};
}

}  // namespace rivid::detail
