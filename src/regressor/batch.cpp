#include "rivid/regressor/batch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>

#include "regressor/batch_kernel.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/turn_and_angle.hpp"

namespace rivid {

namespace {

constexpr std::size_t alignment = 64;

}  // namespace

Simd detail::resolved(Simd simd) {
  if (simd != Simd::best) {
    return simd;
  }
  return supported(Simd::avx512) ? Simd::avx512 : supported(Simd::avx2) ? Simd::avx2 : Simd::baseline;
}

namespace {

const detail::BatchKernel& kernel_of(Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::avx512) {
    return detail::avx512_kernel();
  }
  if (simd == Simd::avx2) {
    return detail::avx2_kernel();
  }
#else
  static_cast<void>(simd);
#endif
  return detail::baseline_kernel();
}

void copy(const Eigen::Vector3d& from, double* to) { Eigen::Vector3d::Map(to) = from; }

detail::LinkPlan link_plan(const Chain& chain, std::size_t j, InertialMask mask) {
  const Chain::Link& link = chain.links[j];
  detail::LinkPlan out{};
  out.revolute = link.type == JointType::revolute;
  const detail::TurnAndAngle turn = detail::turn_and_angle(link.R);
  const Eigen::Matrix3d turned = turn.R.transpose();
  Eigen::Matrix3d::Map(out.R) = turned;  // column-major, so its transpose row by row
  out.cos_theta = turn.cos_theta;
  out.sin_theta = turn.sin_theta;
  out.shifted_angle = turn.sin_theta != 0.0 || turn.cos_theta != 1.0;
  copy(link.p, out.p);
  copy(turned * -chain.gravity, out.accel);
  if (j > 0) {
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    const bool revolute = chain.links[j - 1].type == JointType::revolute;
    copy(revolute ? Eigen::Vector3d(turned * z) : Eigen::Vector3d::Zero(), out.parent_w);
    copy(turned * (revolute ? Eigen::Vector3d(z.cross(link.p)) : z), out.parent_v);
  }
  out.mask = mask;
  std::ranges::fill(out.sign, 1.0);
  bool plain = mask == detail::usual_mask;
  for (int k = 0; k < inertial_count; ++k) {
    const InertialColumn column = inertial_column(link, static_cast<ParameterKind>(k));
    out.sign[column.index] = column.sign;
    plain = plain && column.sign > 0;
  }
  unsigned offsets = 0;
  for (int k = 0; k < 3; ++k) {
    offsets |= link.p[k] != 0.0 ? 1U << k : 0U;
  }
  out.step = detail::step_number(turn.turn, offsets, out.revolute, plain);
  return out;
}

}  // namespace

std::string_view name(Simd simd) {
  constexpr std::array<std::string_view, 4> names = {"best", "baseline", "avx2", "avx512"};
  return names[static_cast<std::size_t>(simd)];
}

bool supported(Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::avx512) {
    return __builtin_cpu_supports("avx512f") != 0 && supported(Simd::avx2);
  }
  if (simd == Simd::avx2) {
    return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  }
#endif
  return simd == Simd::best || simd == Simd::baseline;
}

std::optional<std::string> BatchOptions::complaint() const {
  if (threads < 1) {
    return "threads is " + std::to_string(threads) + ", must be at least 1";
  }
  if (!supported(simd)) {
    return "simd is " + std::string(name(simd)) + ", which this machine has not; take Simd::best";
  }
  return std::nullopt;
}

struct RegressorBatch::Plan {
  // Column of joint i's rows that an entry goes to, in the order of the kernel.
  struct Entry {
    std::size_t joint;
    Index column;
  };

  std::vector<detail::LinkPlan> links;
  std::vector<detail::OwnEntry> own;
  std::vector<Entry> entries;
  Simd simd = Simd::baseline;
  const detail::BatchKernel* kernel = nullptr;

  [[nodiscard]] detail::BatchPlan view() const {
    return {links.data(), links.size(), own.data(), own.size()};
  }
  [[nodiscard]] std::size_t lanes() const { return static_cast<std::size_t>(kernel->lanes); }
};

RegressorBatch::RegressorBatch(const Robot& robot, std::span<const StandardParameter> parameters,
                               const BatchOptions& options)
    : columns_(robot, parameters), plan_(std::make_unique<Plan>()) {
  if (const auto complaint = options.complaint()) {
    throw InputError("RegressorBatch: " + *complaint);
  }
  Plan& plan = *plan_;
  plan.simd = detail::resolved(options.simd);
  plan.kernel = &kernel_of(plan.simd);
  const std::size_t n = joints();
  for (std::size_t j = 0; j < n; ++j) {
    plan.links.push_back(link_plan(robot.chain, j, columns_.wanted()[j]));
    for (std::size_t i = 0; i <= j; ++i) {
      const auto block = columns_.of_link(i, j);
      std::vector<RegressorColumns::InertialEntry> sorted(block.begin(), block.end());
      std::ranges::sort(sorted, {}, &RegressorColumns::InertialEntry::index);
      for (std::size_t e = 0; e < sorted.size(); ++e) {
        if (e > 0 && sorted[e].index == sorted[e - 1].index) {
          throw InputError("RegressorBatch: a parameter of joint " + std::to_string(j + 1) +
                           " occurs twice, must occur once");
        }
        plan.entries.push_back({i, sorted[e].column});
      }
    }
  }
  for (std::size_t j = 0; j < n; ++j) {
    for (const RegressorColumns::JointEntry& e : columns_.of_own(j)) {
      plan.own.push_back({static_cast<int>(j), e.basis, e.direction, e.sign_speed});
      plan.entries.push_back({j, e.column});
    }
  }
}

RegressorBatch::~RegressorBatch() = default;
RegressorBatch::RegressorBatch(RegressorBatch&&) noexcept = default;
RegressorBatch& RegressorBatch::operator=(RegressorBatch&&) noexcept = default;

Simd RegressorBatch::simd() const { return plan_->simd; }

detail::BatchPlan RegressorBatch::plan() const { return plan_->view(); }

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
  if (targets.size() != joints() || workspace.columns_.size() != plan_->entries.size()) {
    throw InputError("RegressorBatch::fill: targets or workspace are those of another robot");
  }
  const Plan& plan = *plan_;
  const auto lanes = static_cast<Index>(plan.lanes());
  const detail::BatchPlan view = plan.view();
  for (std::size_t e = 0; e < plan.entries.size(); ++e) {
    const RowsTarget& target = targets[plan.entries[e].joint];
    workspace.columns_[e] = target.data + plan.entries[e].column * target.ld + row;
  }
  const Index packs = count / lanes;
  const auto input = [&](Index sample) {
    return detail::BatchInput{motion.q.data() + sample, motion.qd.data() + sample, motion.qdd.data() + sample,
                              motion.q.outerStride(),   motion.qd.outerStride(),   motion.qdd.outerStride()};
  };
  plan.kernel->fill(view, input(first), static_cast<std::size_t>(packs), workspace.columns_.data(),
                    workspace.scratch_.get());

  const Index rest = count - packs * lanes;
  if (rest > 0) {
    fill_rest(motion, first + packs * lanes, rest, packs * lanes, workspace);
  }
  fill_coupled(motion, first, count, targets, row, workspace);
}

// Samples that fill no pack go through one of their own, by the same arithmetic: a row never depends on where a batch
// ends.
void RegressorBatch::fill_rest(const Motion& motion, Index sample, Index rest, Index row,
                               BatchWorkspace& workspace) const {
  const Plan& plan = *plan_;
  const auto lanes = static_cast<Index>(plan.lanes());
  const auto n = static_cast<Index>(joints());
  double* const q = workspace.tail_.get();
  double* const qd = q + n * lanes;
  double* const qdd = qd + n * lanes;
  for (Index j = 0; j < n; ++j) {
    for (Index lane = 0; lane < lanes; ++lane) {
      const Index k = sample + std::min(lane, rest - 1);
      q[j * lanes + lane] = motion.q(k, j);
      qd[j * lanes + lane] = motion.qd(k, j);
      qdd[j * lanes + lane] = motion.qdd(k, j);
    }
  }
  plan.kernel->fill(plan.view(), {q, qd, qdd, lanes, lanes, lanes}, 1, workspace.tail_columns_.data(),
                    workspace.scratch_.get());
  for (std::size_t e = 0; e < plan.entries.size(); ++e) {
    std::copy_n(workspace.tail_columns_[e], rest, workspace.columns_[e] + row);
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
    : scratch_(detail::aligned_doubles(detail::kernel_scratch(batch.plan_->lanes(), batch.joints()))),
      columns_(batch.plan_->entries.size()),
      tail_columns_(batch.plan_->entries.size()) {
  const std::size_t lanes = batch.plan_->lanes();
  const std::size_t input = 3 * batch.joints() * lanes;
  tail_ = detail::aligned_doubles(input + tail_columns_.size() * lanes);
  for (std::size_t e = 0; e < tail_columns_.size(); ++e) {
    tail_columns_[e] = tail_.get() + input + e * lanes;
  }
}

namespace {

Index rows_for_the_cache(const RegressorBatch& batch) {
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

}  // namespace rivid
