#include <Eigen/Geometry>

#include "dense.hpp"
#include "identify/infer/infer.hpp"
#include "identify/infer/noise_bias.hpp"
#include "rivid/regressor/load.hpp"

namespace rivid::detail {

namespace {

// The robot whose link j stands elsewhere in the frame before it, by one of the three coordinates of its
// origin or of the turns about its own axes.
Robot moved(Robot robot, std::size_t j, int coordinate, const GeometryTolerance& by) {
  Chain::Link& link = robot.chain.links[j];
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(coordinate % 3);
  if (coordinate < 3) {
    link.p += by.length * axis;
  } else {
    link.R = link.R * Eigen::AngleAxisd(by.angle, axis).toRotationMatrix();
  }
  return robot;
}

// Another geometry regroups parameters otherwise, so that all standard parameters count: these are those of
// the description, but for what the estimate says of them.
struct StandardModel {
  StandardModel(const Robot& robot, const BaseParameters& base, const Vector& chi) : columns(base) {
    const Vector a_priori = robot.chi_st();
    chi_st = a_priori + base.to_standard(chi - base.from_standard(a_priori));
    columns.parameters.clear();
    for (const StandardParameter& p : base.standard) {
      columns.parameters.push_back({p, p.name(), p.name(), ""});
    }
    columns.load = {chi_st, std::nullopt};
  }

  // Torques of a robot, weighted, joint by joint in a column of all.
  [[nodiscard]] Vector torques(const Robot& robot, const Motion& motion,
                               const std::vector<double>& weights) const {
    const Observation W = observation(robot, columns, motion);
    Vector out(motion.samples() * robot.size());
    for (std::size_t j = 0; j < W.joints.size(); ++j) {
      const JointRows& rows = W.joints[j];
      out.segment(static_cast<Index>(j) * motion.samples(), motion.samples()) =
          weights[j] * (rows.W * chi_st(rows.columns));
    }
    return out;
  }

  BaseParameters columns;
  Vector chi_st;
};

}  // namespace

Matrix geometry_covariance(const EstimationProblem& problem, const Estimate& estimate) {
  const GeometryTolerance& by = problem.robot.tolerance;
  const Index b = problem.base.size();
  if ((by.length == 0.0 && by.angle == 0.0) || problem.logs.empty() || estimate.rank < b) {
    return {};
  }
  constexpr int coordinates = 6;  // of a frame: three lengths and three angles
  const Index n = problem.joints();
  const BaseParameters base = at_load(problem.base, estimate.chi);
  const StandardModel model(problem.robot, base, estimate.chi);
  Matrix W(0, b);
  Matrix moves(0, coordinates * std::ssize(problem.robot.chain.links));
  for (std::size_t l = 0; l < problem.logs.size(); ++l) {
    const Motion motion = some_motion(problem.logs[l], estimate.signals[l]);
    const Index first = W.rows();
    const Index count = motion.samples() * n;
    W.conservativeResizeLike(Matrix::Zero(first + count, b));
    moves.conservativeResize(first + count, moves.cols());
    const Observation rows = observation(problem.robot, base, motion);
    for (std::size_t j = 0; j < rows.joints.size(); ++j) {
      W.middleRows(first + static_cast<Index>(j) * motion.samples(), motion.samples())(
          Eigen::all, rows.joints[j].columns) = estimate.weights[j] * rows.joints[j].W;
    }
    const Vector here = model.torques(problem.robot, motion, estimate.weights);
    for (Index g = 0; g < moves.cols(); ++g) {
      const Robot other = moved(problem.robot, static_cast<std::size_t>(g / coordinates),
                                static_cast<int>(g % coordinates), by);
      moves.col(g).segment(first, count) = model.torques(other, motion, estimate.weights) - here;
    }
  }
  if (W.rows() <= b) {
    return {};
  }
  const Vector scale = W.colwise().norm().unaryExpr([](double x) { return x > 0.0 ? 1.0 / x : 0.0; });
  const Matrix steps = scale.asDiagonal() * least_squares_solution(W * scale.asDiagonal(), moves);
  return steps.allFinite() ? Matrix(steps * steps.transpose()) : Matrix();
}

}  // namespace rivid::detail
