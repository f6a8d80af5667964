#include "rivid/regressor/observation.hpp"

#include "rivid/error.hpp"

namespace rivid {

namespace {

void require_same_shape(const Robot& robot, const Motion& motion) {
  const auto fits = [&](const Matrix& x) { return x.rows() == motion.q.rows() && x.cols() == robot.size(); };
  if (!fits(motion.q) || !fits(motion.qd) || !fits(motion.qdd)) {
    const auto shape = [](const Matrix& x) {
      return "(" + std::to_string(x.rows()) + " x " + std::to_string(x.cols()) + ")";
    };
    throw InputError("observation: q is " + shape(motion.q) + ", qd " + shape(motion.qd) + ", qdd " +
                     shape(motion.qdd) + "; each must have one column for each of the robot's " +
                     std::to_string(robot.size()) + " joints and the same number of rows");
  }
}

}  // namespace

Matrix Observation::dense() const {
  Index rows = 0;
  for (const JointRows& joint : joints) {
    rows += joint.W.rows();
  }
  Matrix out = Matrix::Zero(rows, columns);
  Index first = 0;
  for (const JointRows& joint : joints) {
    for (std::size_t c = 0; c < joint.columns.size(); ++c) {
      out.col(joint.columns[c]).segment(first, joint.W.rows()) = joint.W.col(static_cast<Index>(c));
    }
    first += joint.W.rows();
  }
  return out;
}

Observation observation(const Robot& robot, const BaseParameters& base, const Motion& motion) {
  require_same_shape(robot, motion);
  const RegressorColumns columns(robot, base.columns());
  const auto n = static_cast<std::size_t>(robot.size());
  Observation out;
  out.columns = columns.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<Index>& own = columns.of_joint(i);
    out.joints.push_back({own, Matrix(motion.samples(), static_cast<Index>(own.size()))});
  }
  RegressorWorkspace<double> workspace(robot.chain);
  std::vector<double> q(n);
  std::vector<double> qd(n);
  std::vector<double> qdd(n);
  for (Index k = 0; k < motion.samples(); ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const auto column = static_cast<Index>(j);
      q[j] = motion.q(k, column);
      qd[j] = motion.qd(k, column);
      qdd[j] = motion.qdd(k, column);
    }
    columns.rows(robot.chain, State<double>{q, qd, qdd}, workspace,
                 [&](std::size_t i, Index column, double value) { out.joints[i].W(k, column) = value; });
  }
  return out;
}

}  // namespace rivid
