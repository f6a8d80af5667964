#include "rivid/regressor/batch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <thread>

#include "accept.hpp"
#include "dense.hpp"
#include "regressor/batch_kernel.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"
#include "threads.hpp"

namespace rivid {

namespace {

constexpr std::size_t alignment = 64;  // [bytes] of a cache line, and of a register of AVX-512

Simd usable(const BatchOptions& options) {
  detail::accept("RegressorBatch", options.complaint());
  return detail::resolved(options.simd);
}

}  // namespace

bool supported(Simd simd) { return detail::available(simd); }

void detail::require_finite(std::string_view who, const Motion& motion) {
  for (const auto& [name, x] :
       {std::pair("q", &motion.q), std::pair("qd", &motion.qd), std::pair("qdd", &motion.qdd)}) {
    if (x->allFinite()) {
      continue;
    }
    for (Index j = 0; j < x->cols(); ++j) {
      for (Index k = 0; k < x->rows(); ++k) {
        if (!std::isfinite((*x)(k, j))) {
          throw InputError(std::string(who) + ": " + name + " of joint " + std::to_string(j + 1) +
                           " at sample " + std::to_string(k) + " is " + number((*x)(k, j)) +
                           ", must be finite");
        }
      }
    }
  }
}

Simd detail::resolved(Simd simd) { return simd == Simd::best ? fastest<Simd>() : simd; }

std::optional<std::string> BatchOptions::complaint() const {
  if (threads < 1) {
    return "threads is " + std::to_string(threads) + ", must be at least 1";
  }
  if (!supported(simd)) {
    return "simd is " + std::string(name(simd)) + ", which this machine has not; take Simd::best";
  }
  return std::nullopt;
}

RegressorBatch::RegressorBatch(const Robot& robot, std::span<const StandardParameter> parameters,
                               const BatchOptions& options)
    : columns_(robot, parameters),
      simd_(usable(options)),
      kernel_(&detail::kernel_for<detail::BatchKernel>(simd_)) {}

void RegressorBatch::require(std::string_view who, const Motion& motion, Index first, Index count) const {
  const auto n = static_cast<Index>(joints());
  const auto fits = [&](const Matrix& x) { return x.rows() == motion.q.rows() && x.cols() == n; };
  if (!fits(motion.q) || !fits(motion.qd) || !fits(motion.qdd)) {
    const auto shape = [](const Matrix& x) {
      return "(" + std::to_string(x.rows()) + " x " + std::to_string(x.cols()) + ")";
    };
    throw InputError(std::string(who) + ": q is " + shape(motion.q) + ", qd " + shape(motion.qd) + ", qdd " +
                     shape(motion.qdd) + "; each must have one column for each of the robot's " +
                     std::to_string(n) + " joints and the same number of rows");
  }
  if (first < 0 || count < 0 || count > motion.samples() - first) {
    throw InputError(std::string(who) + ": samples " + std::to_string(first) + " to " +
                     std::to_string(first + count) + " are asked for, the motion has " +
                     std::to_string(motion.samples()));
  }
}

void RegressorBatch::fill(const Motion& motion, Index first, Index count, RegressorBlock& block) const {
  if (count > block.capacity() || block.targets_.size() != joints()) {
    throw InputError("RegressorBatch::fill: " + std::to_string(count) + " samples of " +
                     std::to_string(joints()) + " joints do not fit a block for " +
                     std::to_string(block.capacity()) + " samples of " +
                     std::to_string(block.targets_.size()) + " joints");
  }
  fill(motion, first, count, block.targets_, 0, block.workspace_);
  block.rows_ = count;
}

void RegressorBatch::fill(const Motion& motion, Index first, Index count, std::span<const RowsTarget> targets,
                          Index row, BatchWorkspace& workspace) const {
  require("RegressorBatch::fill", motion, first, count);
  if (targets.size() != joints() || workspace.columns_.size() != columns_.entries().size()) {
    throw InputError("RegressorBatch::fill: targets or workspace are those of another robot");
  }
  const detail::RegressorInput<double> input = {motion.q.data() + first,   motion.qd.data() + first,
                                                motion.qdd.data() + first, motion.q.outerStride(),
                                                motion.qd.outerStride(),   motion.qdd.outerStride()};
  if (!columns_.dependence().empty()) {
    fill_folded(input, count, targets, row, workspace);
  } else {
    const auto entries = columns_.entries();
    for (std::size_t e = 0; e < entries.size(); ++e) {
      const RowsTarget& target = targets[entries[e].joint];
      workspace.columns_[e] = target.data + entries[e].column * target.ld + row;
    }
    fill_entries(input, count, workspace);
  }
  fill_coupled(motion, first, count, targets, row, workspace);
}

void RegressorBatch::fill_entries(const detail::RegressorInput<double>& input, Index count,
                                  BatchWorkspace& workspace) const {
  const Index lanes = kernel_->lanes;
  const Index packs = count / lanes;
  kernel_->fill(plan(), input, static_cast<std::size_t>(packs), workspace.columns_.data(),
                workspace.scratch_.get());
  const Index rest = count - packs * lanes;
  if (rest > 0) {
    fill_rest(input, rest, packs * lanes, workspace);
  }
}

// Samples that fill no pack go through one of their own, by the same arithmetic: a row never depends on where
// a batch ends.
void RegressorBatch::fill_rest(const detail::RegressorInput<double>& input, Index rest, Index row,
                               BatchWorkspace& workspace) const {
  const Index lanes = kernel_->lanes;
  const auto n = static_cast<Index>(plan().joints);
  double* const q = workspace.tail_.get();
  double* const qd = q + n * lanes;
  double* const qdd = qd + n * lanes;
  for (Index j = 0; j < n; ++j) {
    for (Index lane = 0; lane < lanes; ++lane) {
      const Index k = row + std::min(lane, rest - 1);
      q[j * lanes + lane] = input.q[j * input.q_stride + k];
      qd[j * lanes + lane] = input.qd[j * input.qd_stride + k];
      qdd[j * lanes + lane] = input.qdd[j * input.qdd_stride + k];
    }
  }
  kernel_->fill(plan(), {q, qd, qdd, lanes, lanes, lanes}, 1, workspace.tail_columns_.data(),
                workspace.scratch_.get());
  for (std::size_t e = 0; e < workspace.columns_.size(); ++e) {
    std::copy_n(workspace.tail_columns_[e], rest, workspace.columns_[e] + row);
  }
}

namespace {

// Samples whose rows of all links' joints are made before they are folded; whole packs of any kernel.
constexpr Index fold_samples = 64;

}  // namespace

void RegressorBatch::fill_folded(const detail::RegressorInput<double>& input, Index count,
                                 std::span<const RowsTarget> targets, Index row,
                                 BatchWorkspace& workspace) const {
  double* const motion = workspace.folded_.data();
  double* const values = motion + columns_.dependence().memory(fold_samples);
  for (std::size_t e = 0; e < workspace.columns_.size(); ++e) {
    workspace.columns_[e] = values + static_cast<Index>(e) * fold_samples;
  }
  for (Index first = 0; first < count; first += fold_samples) {
    const Index some = std::min(fold_samples, count - first);
    fill_entries(columns_.expanded(input, first, some, motion), some, workspace);
    for (const RegressorColumns::FoldedEntry& folded : columns_.folded()) {
      const RowsTarget& target = targets[folded.to.joint];
      double* const out = target.data + folded.to.column * target.ld + row + first;
      std::fill_n(out, some, 0.0);
      for (const auto& [e, term] : folded.terms) {
        for (Index k = 0; k < some; ++k) {
          out[k] += columns_.dependence().slope(term, some, k, motion) * workspace.columns_[e][k];
        }
      }
    }
  }
}

// Few robots have coupled motors, and those have few columns of them: no work for the kernels.
void RegressorBatch::fill_coupled(const Motion& motion, Index first, Index count,
                                  std::span<const RowsTarget> targets, Index row,
                                  BatchWorkspace& workspace) const {
  const std::size_t n = joints();
  double* const q = workspace.tail_.get();
  const std::span<double> qd(q + n, n);
  const std::span<double> qdd(q + 2 * n, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (const RegressorColumns::MotorEntry& e : columns_.of_motors(i)) {
      for (Index k = 0; k < count; ++k) {
        for (const CoupledEntry::Term& term : e.entry.terms) {
          const auto joint = static_cast<Index>(term.joint);
          qd[term.joint] = motion.qd(first + k, joint);
          qdd[term.joint] = motion.qdd(first + k, joint);
        }
        targets[i].data[row + k + e.column * targets[i].ld] =
            RegressorColumns::coupled_value(e.entry, State<double>{{}, qd, qdd});
      }
    }
  }
}

void detail::AlignedDelete::operator()(double* p) const {
  ::operator delete[](p, std::align_val_t(alignment));
}

detail::AlignedDoubles detail::aligned_doubles(std::size_t count) {
  return AlignedDoubles(
      static_cast<double*>(::operator new[](count * sizeof(double), std::align_val_t(alignment))));
}

BatchWorkspace::BatchWorkspace(const RegressorBatch& batch)
    : scratch_(detail::aligned_doubles(detail::kernel_scratch(static_cast<std::size_t>(batch.kernel_->lanes),
                                                              batch.plan().joints, batch.plan().forks))),
      columns_(batch.columns_.entries().size()),
      tail_columns_(columns_.size()) {
  const auto lanes = static_cast<std::size_t>(batch.kernel_->lanes);
  const std::size_t input = 3 * batch.plan().joints * lanes;
  tail_ = detail::aligned_doubles(input + tail_columns_.size() * lanes);
  if (!batch.columns_.dependence().empty()) {
    folded_.resize(batch.columns_.dependence().memory(fold_samples) + columns_.size() * fold_samples);
  }
  for (std::size_t e = 0; e < tail_columns_.size(); ++e) {
    tail_columns_[e] = tail_.get() + input + e * lanes;
  }
}

namespace {

Index rows_for_the_cache(const RegressorBatch& batch) {
  // [bytes] of the second-level cache that rows may fill; a choice
  constexpr Index cache = Index{512} * 1024;
  Index width = 1;
  for (std::size_t i = 0; i < batch.joints(); ++i) {
    width += static_cast<Index>(batch.of_joint(i).size());
  }
  return std::clamp<Index>(cache / (8 * width) / 8 * 8, 16, 256);
}

}  // namespace

RegressorBlock::RegressorBlock(const RegressorBatch& batch)
    : RegressorBlock(batch, rows_for_the_cache(batch)) {}

RegressorBlock::RegressorBlock(const RegressorBatch& batch, Index capacity)
    : capacity_(capacity), workspace_(batch) {
  if (capacity < 1) {
    throw InputError("RegressorBlock: capacity is " + std::to_string(capacity) + ", must be at least 1");
  }
  // Columns an odd number of cache lines apart: at a power of two they would all fall into the same few sets.
  constexpr Index line = 8;
  const Index ld = (((capacity + line - 1) / line) | 1) * line;
  std::size_t size = 0;
  for (std::size_t i = 0; i < batch.joints(); ++i) {
    widths_.push_back(static_cast<Index>(batch.of_joint(i).size()));
    size += static_cast<std::size_t>(ld * widths_.back());
  }
  memory_ = detail::aligned_doubles(size);
  double* next = memory_.get();
  for (const Index width : widths_) {
    targets_.push_back({next, ld});
    next += ld * width;
  }
}

RegressorBlock::Rows RegressorBlock::W(std::size_t i) const {
  const RowsTarget& target = targets_[i];
  return {target.data, rows_, widths_[i], Eigen::OuterStride<>(target.ld)};
}

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
  detail::accept("observation", base.complaint(robot));
  const RegressorBatch batch(robot, base.columns(), options);
  batch.require("observation", motion, 0, motion.samples());
  const LoadColumns load("observation", robot, base, batch);
  Observation out;
  out.columns = batch.size();
  std::vector<RowsTarget> targets;
  for (std::size_t i = 0; i < batch.joints(); ++i) {
    const std::vector<Index>& own = batch.of_joint(i);
    out.joints.push_back({own, Matrix(motion.samples(), static_cast<Index>(own.size()))});
    targets.push_back({out.joints.back().W.data(), motion.samples()});
  }

  // Each thread takes one stretch. A row depends on its own sample alone, so nothing changes with their
  // number.
  constexpr Index granule = 64;
  const Index granules = (motion.samples() + granule - 1) / granule;
  const Index threads = std::clamp<Index>(granules, 1, detail::useful_threads(options.threads));
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
  Index own = threads;
  while (own > 1 && detail::started(others, stretch, own - 1)) {
    --own;
  }
  for (Index t = 0; t < own; ++t) {
    stretch(t);
  }
  others.clear();
  for (std::size_t i = 0; i < batch.joints(); ++i) {
    load.complete(i, targets[i], motion.samples(), nullptr);
  }
  return out;
}

namespace {

// Triangular factor of IDM_st along a motion, (N_s × N_s), a block of samples at a time.
Matrix triangle(const Robot& robot, std::span<const StandardParameter> standard, const Motion& motion) {
  // The observation matrix of all standard parameters is that of a base without regrouping.
  BaseParameters all;
  all.standard.assign(standard.begin(), standard.end());
  for (const StandardParameter& p : standard) {
    all.parameters.push_back({p, p.name(), p.name(), ""});
  }
  const Index columns = all.size();
  // Friction that follows the load is independent of all else whatever the robot's parameters are: any will
  // do.
  all.load.chi = Vector::Ones(columns);
  constexpr Index block = 256;  // samples at a time; a choice that bounds the memory
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

BaseParameters base_parameters(const Robot& robot, const Motion& motion, double tolerance) {
  detail::accept("base_parameters", robot.complaint());
  if (std::isnan(tolerance) || tolerance <= 0.0 || tolerance >= 1.0) {
    throw InputError("base_parameters: tolerance is " + number(tolerance) + ", must lie between 0 and 1");
  }
  const auto fits = [&](const Matrix& x) { return x.rows() == motion.samples() && x.cols() == robot.size(); };
  if (motion.samples() == 0 || !fits(motion.q) || !fits(motion.qd) || !fits(motion.qdd)) {
    throw InputError("base_parameters: q, qd and qdd of the motion must have one column for each of the " +
                     std::to_string(robot.size()) + " joints and the same number of rows, at least one");
  }
  detail::require_finite("base_parameters", motion);
  // A small coefficient is noise here.
  const Matrix R = triangle(robot, robot.standard_parameters(), motion);
  if (!R.allFinite()) {
    throw InputError("base_parameters: q, qd or qdd of the motion is so large that the torques overflow");
  }
  BaseParameters base = detail::base_of(robot, R, tolerance, detail::SmallCoefficients::dropped);
  if (base.size() == 0) {
    throw InputError("base_parameters: the motion of robot \"" + robot.name +
                     "\" shows no parameter in its torques; no joint moves and none is loaded");
  }
  return base;
}

}  // namespace rivid
