#include "rivid/regressor/observation.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "dense.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Triangular factor of IDM_st along a motion, (N_s × N_s), a block of samples at a time.
Matrix triangle(const Robot& robot, std::span<const StandardParameter> standard, const Motion& motion) {
  // The observation matrix of all standard parameters is that of a base without regrouping.
  BaseParameters all;
  for (const StandardParameter& p : standard) {
    all.parameters.push_back({p, p.name(), p.name(), ""});
  }
  const Index columns = all.size();
  constexpr Index block = 256;
  Matrix R = Matrix::Zero(columns, columns);
  Index first = 0;
  do {
    const Index count = std::min(block, motion.samples() - first);
    const auto cut = [&](const Matrix& x) { return Matrix(x.middleRows(first, count)); };
    const Matrix W = observation(robot, all, Motion{cut(motion.q), cut(motion.qd), cut(motion.qdd)}).dense();
    Matrix stacked(columns + W.rows(), columns);
    stacked << R, W;
    R = detail::triangular_factor(stacked);
    first += count;
  } while (first < motion.samples());
  return R;
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

Observation observation(const Robot& robot, const BaseParameters& base, const Motion& motion,
                        const BatchOptions& options) {
  const RegressorBatch batch(robot, base.columns(), options);
  batch.require("observation", motion, 0, motion.samples());
  Observation out;
  out.columns = batch.size();
  std::vector<RowsTarget> targets;
  for (std::size_t i = 0; i < batch.joints(); ++i) {
    const std::vector<Index>& own = batch.of_joint(i);
    out.joints.push_back({own, Matrix(motion.samples(), static_cast<Index>(own.size()))});
    targets.push_back({out.joints.back().W.data(), motion.samples()});
  }

  // Each thread takes one stretch. A row depends on its own sample alone, so nothing changes with their number.
  constexpr Index granule = 64;
  const Index granules = (motion.samples() + granule - 1) / granule;
  const Index threads = std::clamp<Index>(granules, 1, options.threads);
  std::vector<BatchWorkspace> workspaces;
  workspaces.reserve(static_cast<std::size_t>(threads));
  for (Index t = 0; t < threads; ++t) {
    workspaces.emplace_back(batch);
  }
  const auto stretch = [&](Index t) {
    const Index first = granules * t / threads * granule;
    const Index last = std::min(granules * (t + 1) / threads * granule, motion.samples());
    batch.fill(motion, first, last - first, targets, first, workspaces[static_cast<std::size_t>(t)]);
  };
  std::vector<std::jthread> others;
  for (Index t = 1; t < threads; ++t) {
    others.emplace_back(stretch, t);
  }
  stretch(0);
  return out;
}

BaseParameters base_parameters(const Robot& robot, const Motion& motion, double tolerance) {
  if (const auto complaint = robot.complaint()) {
    throw InputError("base_parameters: " + *complaint);
  }
  if (std::isnan(tolerance) || tolerance <= 0.0 || tolerance >= 1.0) {
    throw InputError("base_parameters: tolerance is " + number(tolerance) + ", must lie between 0 and 1");
  }
  const auto fits = [&](const Matrix& x) { return x.rows() == motion.samples() && x.cols() == robot.size(); };
  if (motion.samples() == 0 || !fits(motion.q) || !fits(motion.qd) || !fits(motion.qdd)) {
    throw InputError("base_parameters: q, qd and qdd of the motion must have one column for each of the " +
                     std::to_string(robot.size()) + " joints and the same number of rows, at least one");
  }
  // A small coefficient is noise here.
  BaseParameters base = detail::base_of(robot, triangle(robot, robot.standard_parameters(), motion),
                                        tolerance, detail::SmallCoefficients::dropped);
  if (base.size() == 0) {
    throw InputError("base_parameters: the motion of robot \"" + robot.name +
                     "\" shows no parameter in its torques; no joint moves and none is loaded");
  }
  return base;
}

}  // namespace rivid
