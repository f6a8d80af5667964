#include "rivid/regressor/observation.hpp"

#include <algorithm>
#include <thread>

namespace rivid {

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

}  // namespace rivid
