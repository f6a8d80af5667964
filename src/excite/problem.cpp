#include "excite/problem.hpp"

#include <algorithm>
#include <limits>

#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::vector<Index> nonzero(const Vector& x) {
  std::vector<Index> out;
  for (Index k = 0; k < x.size(); ++k) {
    if (x[k] != 0.0) {
      out.push_back(k);
    }
  }
  return out;
}

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

std::string limit_in_words(const Task& task, Index limit) {
  const std::vector<SideLimit> sides = side_limits(task.bounds);
  if (limit >= std::ssize(sides)) {
    const Clearances& clearances = *task.clearances;
    const Index pair = limit - std::ssize(sides);
    return clearances.first(pair) + ": distance to " + clearances.second(pair);
  }
  const SideLimit& side = sides[static_cast<std::size_t>(limit)];
  return task.robot.joints[static_cast<std::size_t>(side.joint)].name + ": " +
         std::string(about(side.quantity).name);
}

std::string excess_in_words(const Task& task, Index limit, double value) {
  const std::vector<SideLimit> sides = side_limits(task.bounds);
  if (limit >= std::ssize(sides)) {
    const double distance = task.space.clearance + clearance_reserve - value * clearance_scale;
    return limit_in_words(task, limit) + " is " + number(distance, 3) + " m where it must be at least " +
           number(task.space.clearance, 3) +
           " m; see to [excitation.space]: metres in the base frame, clearance, capsules of the links";
  }
  const SideLimit& side = sides[static_cast<std::size_t>(limit)];
  return limit_in_words(task, limit) + " is " + number(side.side * (side.edge + value * side.scale), 4) +
         " where it may be " + number(side.side * side.edge, 4);
}

Matrix predicted_torques(SampledRegressor& regressor, const Motion& motion, const Vector& chi) {
  Matrix out(motion.samples(), motion.joints());
  regressor.pieces(motion, [&](Index first, std::span<const Matrix> W) {
    for (std::size_t i = 0; i < W.size(); ++i) {
      out.col(static_cast<Index>(i)).segment(first, W[i].rows()) = W[i] * chi(regressor.columns(i));
    }
  });
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

Problem::Problem(const Task& task, const Curve& curve, Index samples, double rho)
    : task_(task),
      curve_(curve),
      regressor_(smoothed(task.robot, smoothing_speed), task.base),
      clearances_(*task.clearances),
      rho_(rho),
      tables_(curve.tables(middles(curve.duration(), samples))),
      weights_(task.weights * (curve.duration() / static_cast<double>(samples))),
      limits_(side_limits(task.bounds)),
      shifts_(Vector::Zero(limits())) {}

Problem::Value Problem::operator()(const Vector& z, Vector* gradient, Matrix* jacobian) {
  const Matrix coefficients = curve_.coefficients(z);
  Sampled at{.motion = curve_.motion(tables_, coefficients),
             .jerk = Curve::jerk(tables_, coefficients),
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
  if (jacobian != nullptr) {
    jacobian->setZero(variables(), limits());
  }
  keep_clear(at.motion, out, jacobian);
  Matrix M = task_.known;
  add_information(regressor_, W_, weights_, M);
  const std::optional<ObjectiveValue> scored = score(M, task_.objective, gradient != nullptr);
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
    G[i] = times_symmetric(W_[i], -2.0 * weights_[static_cast<Index>(i)] * scored->K(columns, columns));
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
  jacobian->leftCols(std::ssize(limits_)) = limit_slopes(at, shares, of_torque);
  return out;
}

// The distances as limits, behind those of the joints.
void Problem::keep_clear(const Motion& motion, Value& out, Matrix* jacobian) {
  const Index pairs = clearances_.size();
  if (pairs == 0) {
    return;
  }
  // Beyond this a sample has no share of a soft maximum.
  const double beyond = -negligible_exponent / rho_ * clearance_scale;
  std::vector<Matrix> slopes;
  const Matrix distances = clearances_.along(motion.q, beyond, jacobian != nullptr ? &slopes : nullptr);
  const Index m = curve_.per_joint();
  Vector share;
  for (Index p = 0; p < pairs; ++p) {
    const Index limit = std::ssize(limits_) + p;
    const Vector g = (task_.space.clearance - distances.col(p).array()) / clearance_scale;
    out.limits[limit] = soft_maximum(g, rho_, share) + shifts_[limit];
    if (jacobian != nullptr) {
      const Matrix by_coefficients =
          -1.0 / clearance_scale *
          (tables_.position.transpose() * share.asDiagonal() * slopes[static_cast<std::size_t>(p)]);
      for (Index j = 0; j < motion.joints(); ++j) {
        jacobian->col(limit).segment(j * m, m) = curve_.pulled_back(j, by_coefficients.col(j));
      }
    }
  }
}

Matrix Problem::limit_slopes(const Sampled& at, std::span<const Vector> shares,
                             std::span<const Slopes> of_torque) const {
  Matrix out = Matrix::Zero(variables(), std::ssize(limits_));
  const Index m = curve_.per_joint();
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    const SideLimit& limit = limits_[l];
    const Vector weight = limit.side / limit.scale * shares[l];
    const auto add = [&](Index joint, const Vector& slope) {
      out.col(static_cast<Index>(l)).segment(joint * m, m) += curve_.pulled_back(joint, slope);
    };
    if (const auto table = about(limit.quantity).table) {
      add(limit.joint, (tables_.*table).transpose() * weight);
      continue;
    }
    const Slopes& slopes = of_torque[static_cast<std::size_t>(limit.joint)];
    const std::vector<Index> near = nonzero(weight);
    const Vector own = weight(near);
    const auto part = [&](const Matrix& table, const Matrix& by) -> Matrix {
      return table(near, Eigen::all).transpose() * (own.asDiagonal() * by(near, Eigen::all));
    };
    const Matrix slope = part(tables_.position, slopes.q) + part(tables_.velocity, slopes.qd) +
                         part(tables_.acceleration, slopes.qdd);
    for (Index k = 0; k < at.motion.joints(); ++k) {
      add(k, slope.col(k));
    }
  }
  return out;
}

void Problem::shift(const Vector& z, const Vector& found) {
  const Vector soft = (*this)(z).limits;
  shifts_ += found - soft;
}

DenseCheck::DenseCheck(const Task& task, const Curve& curve, Index samples)
    : task_(task),
      curve_(curve),
      regressor_(task.robot, task.base),
      clearances_(*task.clearances),
      tables_(curve.tables(Vector::LinSpaced(samples, 0.0, curve.duration()))),
      limits_(side_limits(task.bounds)) {}

namespace {

// States at the reversals between samples, one before and one after each: dry friction steps there.
Motion reversals(const Motion& motion) {
  // [rad/s | m/s] any small value: dry friction has its sign, viscous friction nothing
  constexpr double nearly_at_rest = 1e-12;
  std::vector<std::pair<Index, Index>> found;
  for (Index j = 0; j < motion.joints(); ++j) {
    for (Index k = 0; k + 1 < motion.samples(); ++k) {
      if (motion.qd(k, j) * motion.qd(k + 1, j) < 0.0) {
        found.emplace_back(k, j);
      }
    }
  }
  const Index n = motion.joints();
  const Index rows = 2 * std::ssize(found);
  Motion out{.q = Matrix(rows, n), .qd = Matrix(rows, n), .qdd = Matrix(rows, n)};
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto [k, j] = found[i];
    const double part = motion.qd(k, j) / (motion.qd(k, j) - motion.qd(k + 1, j));
    for (const Index side : {0, 1}) {
      const Index row = 2 * static_cast<Index>(i) + side;
      out.q.row(row) = motion.q.row(k) + part * (motion.q.row(k + 1) - motion.q.row(k));
      out.qd.row(row) = motion.qd.row(k) + part * (motion.qd.row(k + 1) - motion.qd.row(k));
      out.qdd.row(row) = motion.qdd.row(k) + part * (motion.qdd.row(k + 1) - motion.qdd.row(k));
      out.qd(row, j) = side == 0 ? nearly_at_rest : -nearly_at_rest;
    }
  }
  return out;
}

Matrix stacked(const Matrix& a, const Matrix& b) {
  Matrix out(a.rows() + b.rows(), a.cols());
  out << a, b;
  return out;
}

}  // namespace

Vector DenseCheck::operator()(const Vector& z) {
  const Matrix coefficients = curve_.coefficients(z);
  const Matrix jerk = Curve::jerk(tables_, coefficients);
  Motion motion = curve_.motion(tables_, coefficients);
  const Motion turning = reversals(motion);
  motion = {.q = stacked(motion.q, turning.q),
            .qd = stacked(motion.qd, turning.qd),
            .qdd = stacked(motion.qdd, turning.qdd)};
  const Matrix torque = task_.chi.size() > 0 ? predicted_torques(regressor_, motion, task_.chi) : Matrix();
  const LimitedMotion limited{motion, jerk, torque};
  Vector out(std::ssize(limits_) + clearances_.size());
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    out[static_cast<Index>(l)] = peak(limits_[l], limited).value;
  }
  if (clearances_.size() > 0) {
    const Vector nearest = clearances_.along(motion.q, 0.0).colwise().minCoeff().transpose();
    out.tail(nearest.size()) =
        (task_.space.clearance + clearance_reserve - nearest.array()) / clearance_scale;
  }
  return out;
}

}  // namespace rivid::detail
