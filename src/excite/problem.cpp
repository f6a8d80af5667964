#include "excite/problem.hpp"

#include <algorithm>

namespace rivid::detail {

namespace {

constexpr Index chunk = 256;

Vector middles(double duration, Index samples) {
  const double step = duration / static_cast<double>(samples);
  return Vector::LinSpaced(samples, 0.5 * step, duration - 0.5 * step);
}

}  // namespace

Robot smoothed(Robot robot, double sign_speed) {
  for (Joint& joint : robot.joints) {
    joint.sign_speed = std::max(joint.sign_speed, sign_speed);
  }
  return robot;
}

Matrix foretold_torques(SampledRegressor& regressor, const Motion& motion, const Vector& chi) {
  Matrix out(motion.samples(), motion.joints());
  std::vector<Matrix> W;
  for (Index first = 0; first < motion.samples(); first += chunk) {
    const Index count = std::min(chunk, motion.samples() - first);
    regressor.rows({.q = motion.q.middleRows(first, count),
                    .qd = motion.qd.middleRows(first, count),
                    .qdd = motion.qdd.middleRows(first, count)},
                   W);
    for (std::size_t i = 0; i < W.size(); ++i) {
      out.col(static_cast<Index>(i)).segment(first, count) = W[i] * chi(regressor.columns(i));
    }
  }
  return out;
}

// A motion at the instants of a problem.
struct Problem::Sampled {
  Motion motion;
  Matrix jerk;
  Matrix torque;
};

// Reversals are smooth over speeds that make a few samples of a grid.
constexpr double smoothing_speed = 0.05;

Problem::Problem(const Task& task, const FourierCurve& curve, Index samples, double rho)
    : task_(task),
      curve_(curve),
      regressor_(smoothed(task.robot, smoothing_speed), task.base),
      rho_(rho),
      tables_(curve.tables(middles(curve.duration(), samples))),
      weights_(task.weights * (curve.duration() / static_cast<double>(samples))),
      limits_(side_limits(task.bounds)),
      shifts_(Vector::Zero(std::ssize(limits_))) {}

Problem::Value Problem::operator()(const Vector& z, Vector* gradient, Matrix* jacobian) {
  const Matrix coefficients = curve_.coefficients(z);
  Sampled at{.motion = curve_.motion(tables_, coefficients),
             .jerk = FourierCurve::jerk(tables_, coefficients),
             .torque = {}};
  const bool torques = task_.chi.size() > 0;
  regressor_.rows(at.motion, W_);
  at.torque.resize(at.motion.samples(), torques ? at.motion.joints() : 0);
  for (std::size_t i = 0; torques && i < W_.size(); ++i) {
    at.torque.col(static_cast<Index>(i)) = W_[i] * task_.chi(regressor_.columns(i));
  }
  const LimitedMotion limited{at.motion, at.jerk, at.torque};
  Value out;
  out.limits.resize(limits());
  std::vector<Vector> shares(limits_.size());
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    const SideLimit& limit = limits_[l];
    const Vector g = (limit.side * limited.of(limit).array() - limit.edge) / limit.scale;
    out.limits[static_cast<Index>(l)] = soft_maximum(g, rho_, shares[l]) + shifts_[static_cast<Index>(l)];
  }
  Matrix M = task_.known;
  add_information(regressor_, W_, weights_, M);
  const std::optional<ObjectiveValue> scored = score(M, task_.objective);
  out.defined = scored.has_value();
  if (!scored) {
    return out;
  }
  out.objective = scored->value;
  if (gradient == nullptr) {
    return out;
  }
  std::vector<Matrix> G(W_.size());
  for (std::size_t i = 0; i < W_.size(); ++i) {
    const std::vector<Index>& columns = regressor_.columns(i);
    G[i].noalias() = W_[i] * (-2.0 * weights_[static_cast<Index>(i)] * scored->K(columns, columns));
  }
  Slopes of_objective;
  std::vector<Slopes> of_torque;
  regressor_.slopes(at.motion, G, torques ? task_.chi : Vector(), of_objective, of_torque);
  gradient->resize(variables());
  const Index m = curve_.per_joint();
  const Matrix slope = tables_.position.transpose() * of_objective.q +
                       tables_.velocity.transpose() * of_objective.qd +
                       tables_.acceleration.transpose() * of_objective.qdd;
  for (Index j = 0; j < curve_.joints(); ++j) {
    gradient->segment(j * m, m) = curve_.pulled_back(j, slope.col(j));
  }
  *jacobian = limit_slopes(at, shares, of_torque);
  return out;
}

Matrix Problem::limit_slopes(const Sampled& at, std::span<const Vector> shares,
                             std::span<const Slopes> of_torque) const {
  Matrix out = Matrix::Zero(variables(), limits());
  const Index m = curve_.per_joint();
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    const SideLimit& limit = limits_[l];
    const Vector weight = limit.side / limit.scale * shares[l];
    const auto add = [&](Index joint, const Vector& slope) {
      out.col(static_cast<Index>(l)).segment(joint * m, m) += curve_.pulled_back(joint, slope);
    };
    switch (limit.quantity) {
      case Limited::position:
        add(limit.joint, tables_.position.transpose() * weight);
        break;
      case Limited::velocity:
        add(limit.joint, tables_.velocity.transpose() * weight);
        break;
      case Limited::acceleration:
        add(limit.joint, tables_.acceleration.transpose() * weight);
        break;
      case Limited::jerk:
        add(limit.joint, tables_.jerk.transpose() * weight);
        break;
      case Limited::torque: {
        const Slopes& slopes = of_torque[static_cast<std::size_t>(limit.joint)];
        const Matrix slope = tables_.position.transpose() * (weight.asDiagonal() * slopes.q) +
                             tables_.velocity.transpose() * (weight.asDiagonal() * slopes.qd) +
                             tables_.acceleration.transpose() * (weight.asDiagonal() * slopes.qdd);
        for (Index k = 0; k < at.motion.joints(); ++k) {
          add(k, slope.col(k));
        }
        break;
      }
    }
  }
  return out;
}

void Problem::shift(const Vector& z, const Vector& found) {
  const Vector soft = (*this)(z).limits;
  shifts_ += found - soft;
}

DenseCheck::DenseCheck(const Task& task, const FourierCurve& curve, Index samples)
    : task_(task),
      curve_(curve),
      regressor_(task.robot, task.base),
      tables_(curve.tables(Vector::LinSpaced(samples, 0.0, curve.duration()))),
      limits_(side_limits(task.bounds)) {}

Vector DenseCheck::operator()(const Vector& z) {
  const Matrix coefficients = curve_.coefficients(z);
  const Motion motion = curve_.motion(tables_, coefficients);
  const Matrix jerk = FourierCurve::jerk(tables_, coefficients);
  const Matrix torque = task_.chi.size() > 0 ? foretold_torques(regressor_, motion, task_.chi) : Matrix();
  const LimitedMotion limited{motion, jerk, torque};
  Vector out(std::ssize(limits_));
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    out[static_cast<Index>(l)] = peak(limits_[l], limited).value;
  }
  return out;
}

}  // namespace rivid::detail
