#include "rivid/simulate/dynamics_batch.hpp"

#include <algorithm>
#include <string>

#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "simulate/dynamics_batch_kernel.hpp"

namespace rivid {

namespace {

Simd usable(Simd simd) {
  if (!supported(simd)) {
    throw InputError("DynamicsBatch: simd is " + std::string(name(simd)) +
                     ", which this machine has not; take Simd::best");
  }
  return detail::resolved(simd);
}

}  // namespace

DynamicsBatch::DynamicsBatch(const ModelData& model, Simd simd)
    : simd_(usable(simd)),
      kernel_(&detail::kernel_for<detail::DynamicsBatchKernel>(simd_)),
      tables_(model),
      one_(model) {
  const auto n = static_cast<std::size_t>(joints());
  const auto lanes = static_cast<std::size_t>(kernel_->lanes);
  const std::size_t scratch = detail::dynamics_scratch(lanes, n, tables_.forks);
  scratch_ = detail::aligned_doubles(scratch);
  std::fill_n(scratch_.get(), scratch, 0.0);
  tail_ = detail::aligned_doubles(4 * n * lanes);
  state_.resize(3 * n);
}

std::optional<IndefiniteMass> DynamicsBatch::accelerations(const Eigen::Ref<const Matrix>& q,
                                                           const Eigen::Ref<const Matrix>& qd,
                                                           const Eigen::Ref<const Matrix>& tau,
                                                           Eigen::Ref<Matrix> qdd) {
  const Index n = joints();
  const Index samples = q.rows();
  const auto require = [&](const char* what, Index rows, Index columns) {
    if (rows != samples || columns != n) {
      throw InputError("DynamicsBatch::accelerations: " + std::string(what) + " is (" + std::to_string(rows) +
                       " x " + std::to_string(columns) + "), must be (" + std::to_string(samples) + " x " +
                       std::to_string(n) + ")");
    }
  };
  require("q", q.rows(), q.cols());
  require("qd", qd.rows(), qd.cols());
  require("tau", tau.rows(), tau.cols());
  require("qdd", qdd.rows(), qdd.cols());

  const auto lanes = static_cast<Index>(kernel_->lanes);
  const detail::DynamicsPlan plan = tables_.plan();
  const auto one_by_one = [&](Index first, Index count) -> std::optional<IndefiniteMass> {
    const auto size = static_cast<std::size_t>(n);
    const std::span<double> position(state_.data(), size);
    const std::span<double> velocity(state_.data() + size, size);
    const std::span<double> torque(state_.data() + 2 * size, size);
    for (Index k = first; k < first + count; ++k) {
      Vector::Map(position.data(), n) = q.row(k);
      Vector::Map(velocity.data(), n) = qd.row(k);
      if (!one_.set_state(position, velocity)) {
        return IndefiniteMass{k, one_.failed_joint()};
      }
      Vector::Map(torque.data(), n) = tau.row(k).transpose() - Vector::Map(one_.N().data(), n);
      one_.solve(torque);
      qdd.row(k) = Vector::Map(torque.data(), n);
    }
    return std::nullopt;
  };
  if (!tables_.dependence.empty()) {
    return one_by_one(0, samples);
  }

  for (Index done = 0; done < samples;) {
    const Index packs = (samples - done) / lanes;
    if (packs > 0) {
      const detail::DynamicsBatchInput in = {q.data() + done,   qd.data() + done, tau.data() + done,
                                             qdd.data() + done, q.outerStride(),  qd.outerStride(),
                                             tau.outerStride(), qdd.outerStride()};
      const auto good =
          static_cast<Index>(kernel_->run(plan, in, static_cast<std::size_t>(packs), scratch_.get()));
      done += good * lanes;
      if (good < packs) {
        // The fault is in one of these lanes; where rounding alone made it one, the work goes on behind them.
        if (const auto fault = one_by_one(done, lanes)) {
          return fault;
        }
        done += lanes;
      }
      continue;
    }
    // Samples that fill no pack go through one of their own, by the same arithmetic: a row never depends on
    // where a batch ends.
    const Index rest = samples - done;
    double* const memory = tail_.get();
    for (Index j = 0; j < n; ++j) {
      for (Index lane = 0; lane < lanes; ++lane) {
        const Index k = done + std::min(lane, rest - 1);
        memory[j * lanes + lane] = q(k, j);
        memory[(n + j) * lanes + lane] = qd(k, j);
        memory[(2 * n + j) * lanes + lane] = tau(k, j);
      }
    }
    double* const out = memory + 3 * n * lanes;
    const detail::DynamicsBatchInput in = {
        memory, memory + n * lanes, memory + 2 * n * lanes, out, lanes, lanes, lanes, lanes};
    if (kernel_->run(plan, in, 1, scratch_.get()) == 0) {
      return one_by_one(done, rest);
    }
    for (Index j = 0; j < n; ++j) {
      std::copy_n(out + j * lanes, rest, &qdd(done, j));
    }
    done = samples;
  }
  return std::nullopt;
}

}  // namespace rivid
