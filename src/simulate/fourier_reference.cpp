#include <cmath>
#include <numbers>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/text.hpp"
#include "simulate/reference_time.hpp"

namespace rivid {

std::optional<std::string> FourierSeries::complaint() const {
  const auto size = [](const Matrix& x) {
    return "(" + std::to_string(x.rows()) + " x " + std::to_string(x.cols()) + ")";
  };
  if (!(omega_f > 0.0) || !std::isfinite(omega_f)) {
    return "omega_f is " + number(omega_f) + " rad/s, must be positive and finite";
  }
  if (A.size() == 0 || A.rows() != B.rows() || A.cols() != B.cols()) {
    return "A is " + size(A) + " and B is " + size(B) +
           "; both must be (n x L): one row a joint, one column a harmonic";
  }
  if (q0.size() != 0 && q0.size() != A.rows()) {
    return "q0 has " + std::to_string(q0.size()) + " entries for " + std::to_string(A.rows()) + " joints";
  }
  for (Index j = 0; j < A.rows(); ++j) {
    if (!A.row(j).allFinite() || !B.row(j).allFinite() || (q0.size() > 0 && !std::isfinite(q0[j]))) {
      return "the coefficients of joint " + std::to_string(j + 1) + " must be finite";
    }
  }
  if (!(duration >= 0.0) || !std::isfinite(duration)) {
    return "duration is " + number(duration) + " s, must be positive and finite, or 0 for one period";
  }
  return std::nullopt;
}

FourierReference::FourierReference(FourierSeries series) : series_(std::move(series)) {
  if (const auto complaint = series_.complaint()) {
    throw InputError("FourierReference: " + *complaint);
  }
  if (series_.q0.size() == 0) {
    series_.q0 = Vector::Zero(joints());
  }
  if (series_.duration == 0.0) {
    series_.duration = 2.0 * std::numbers::pi / series_.omega_f;
  }
}

void FourierReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                          Eigen::Ref<Vector> qdd_r) const {
  const detail::ReferenceTime time(*this, t);
  q_r = series_.q0;
  qd_r.setZero();
  qdd_r.setZero();
  // The sines of one harmonic follow from those of the last, to some l roundings: a call of sin and cos for each would
  // take most of the time.
  const double s_1 = std::sin(series_.omega_f * time.t);
  const double c_1 = std::cos(series_.omega_f * time.t);
  const double moves = time.rests ? 0.0 : 1.0;
  double s = s_1;
  double c = c_1;
  for (Index l = 0; l < series_.A.cols(); ++l) {
    const double omega = static_cast<double>(l + 1) * series_.omega_f;
    const double length = 1.0 / omega;
    for (Index j = 0; j < series_.A.rows(); ++j) {
      const double along = s * series_.A(j, l) - c * series_.B(j, l);
      q_r[j] += length * along;
      qd_r[j] += moves * (c * series_.A(j, l) + s * series_.B(j, l));
      qdd_r[j] -= moves * omega * along;
    }
    const double last = s;
    s = last * c_1 + c * s_1;
    c = c * c_1 - last * s_1;
  }
}

}  // namespace rivid
