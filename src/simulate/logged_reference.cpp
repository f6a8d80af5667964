#include <cmath>
#include <string>

#include "rivid/error.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/text.hpp"
#include "simulate/reference_time.hpp"

namespace rivid {

namespace {

using Samples = Eigen::Ref<const Matrix>;

// The samples, once it is known that a motion leads through them.
Samples checked(const std::string& who, const Eigen::Ref<const Vector>& t, const Samples& q_r) {
  if (t.size() != q_r.rows()) {
    throw InputError(who + ": t has " + std::to_string(t.size()) + " instants, q_r has " +
                     std::to_string(q_r.rows()) + " rows; they must be as many");
  }
  if (t.size() < 2 || q_r.cols() < 1) {
    throw InputError(who + ": q_r is (" + std::to_string(q_r.rows()) + " x " + std::to_string(q_r.cols()) +
                     "), must have two samples and one joint at least");
  }
  for (Index k = 0; k < t.size(); ++k) {
    if (!std::isfinite(t[k])) {
      throw InputError(who + ": t is " + number(t[k]) + " at index " + std::to_string(k) +
                       ", must be finite");
    }
    if (k > 0 && !(t[k] > t[k - 1])) {
      throw InputError(who + ": t must increase, but goes from " + number(t[k - 1]) + " to " + number(t[k]) +
                       " s at index " + std::to_string(k));
    }
  }
  for (Index j = 0; j < q_r.cols(); ++j) {
    for (Index k = 0; k < q_r.rows(); ++k) {
      if (!std::isfinite(q_r(k, j))) {
        throw InputError(who + ": the reference of joint " + std::to_string(j + 1) + " is " +
                         number(q_r(k, j)) + " at index " + std::to_string(k) + ", must be finite");
      }
    }
  }
  return q_r;
}

}  // namespace

LoggedReference::LoggedReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r)
    : spline_(t, checked("LoggedReference", t, q_r)) {}

void LoggedReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                         Eigen::Ref<Vector> qdd_r) const {
  const detail::ReferenceTime time(*this, t);
  spline_.at(time.t, q_r, qd_r, qdd_r);
  if (time.rests) {
    qd_r.setZero();
    qdd_r.setZero();
  }
}

LinearReference::LinearReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r)
    : t_(t), q_r_(checked("LinearReference", t, q_r)) {}

void LinearReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                         Eigen::Ref<Vector> qdd_r) const {
  const detail::ReferenceTime time(*this, t);
  const Index i = detail::interval(t_, time.t);
  const double h = t_[i + 1] - t_[i];
  const double part = (time.t - t_[i]) / h;
  for (Index j = 0; j < q_r_.cols(); ++j) {
    q_r[j] = (1.0 - part) * q_r_(i, j) + part * q_r_(i + 1, j);
    qd_r[j] = time.rests ? 0.0 : (q_r_(i + 1, j) - q_r_(i, j)) / h;
  }
  qdd_r.setZero();
}

}  // namespace rivid
