#include "identify/estimate/instruments.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/estimate/closed_loops.hpp"
#include "identify/rows/exact_rows.hpp"
#include "identify/rows/factors.hpp"
#include "identify/rows/row_source.hpp"
#include "identify/rows/time_blocks.hpp"
#include "identify/rows/whitened_rows.hpp"
#include "ranges.hpp"
#include "rivid/identify/instruments.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/signal/filter.hpp"

namespace rivid::detail {

namespace {

// Takes rows [V W Y] of a joint into the factor of the instruments.
class InstrumentSink final : public RowSink {
 public:
  // from_V: columns of W, within the joint's own, that are taken from V instead.
  // used:   factor of [W Y] with these columns, or nullptr.
  // blocks: of a log of so many samples, of which this is the joint; or nullptr.
  InstrumentSink(StreamingQr& qr, std::vector<Index> from_V, StreamingQr* used,
                 std::vector<std::vector<InstrumentalGroup>>* blocks, std::size_t joint, Index samples_of_log)
      : qr_(qr),
        from_V_(std::move(from_V)),
        used_(used),
        blocks_(blocks),
        joint_(joint),
        time_({{samples_of_log, 1.0}}, blocks != nullptr ? std::ssize(*blocks) : 1) {}

  RowsRoom room(Index wanted) override { return room_ = qr_.room(wanted); }
  void commit(std::span<const Index> samples) override {
    const auto count = static_cast<Index>(samples.size());
    const RowsTarget& target = room_.target;
    for (const Index c : from_V_) {
      std::copy_n(target.data + c * target.ld, count, target.data + (qr_.columns() + c) * target.ld);
    }
    const Index m = qr_.columns();
    using Rows = Eigen::Map<const Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;
    const Rows V(target.data, count, m, Eigen::OuterStride<>(target.ld));
    const Rows WY(target.data + m * target.ld, count, m + 1, Eigen::OuterStride<>(target.ld));
    if (used_ != nullptr) {
      used_->add(WY.leftCols(m), WY.rightCols(1));
    }
    if (blocks_ != nullptr) {
      time_.divide(0, samples, [&](Index block, Index first, Index rows) {
        (*blocks_)[static_cast<std::size_t>(block)][joint_].qr.add(V.middleRows(first, rows),
                                                                   WY.middleRows(first, rows));
      });
    }
    qr_.commit(count);
  }

 private:
  StreamingQr& qr_;
  std::vector<Index> from_V_;
  StreamingQr* used_;
  std::vector<std::vector<InstrumentalGroup>>* blocks_;
  std::size_t joint_;
  TimeBlocks time_;
  RowsRoom room_{};
};

Motion instrument_motion(const Motion& simulated, double f_m, const SignalOptions& signal) {
  if (!signal.exact_rows()) {
    return simulated;
  }
  return averaged_motion(signal.cutoff_hz > 0.0
                             ? zero_phase(simulated.q, f_m, signal.cutoff_hz, signal.order, signal.convention)
                             : simulated.q,
                         f_m);
}

}  // namespace

Instruments::Instruments(const EstimationProblem& problem) : problem_(problem), signals_(problem.signals) {
  count_rows();
}

std::vector<InstrumentalGroup> Instruments::no_rows() const {
  std::vector<InstrumentalGroup> out;
  for (const RowGroup& joint : problem_.data.groups) {
    const auto own = static_cast<Index>(joint.columns.size());
    out.push_back({joint.columns, StreamingQr(own, own + 1)});
  }
  return out;
}

std::vector<InstrumentalGroup> Instruments::factors(const ClosedLoops& loops_of, const SimulatedLoops& loops,
                                                    FromV which) {
  from_V_ = columns_from(which);
  used_.clear();
  if (!loops.found) {
    return made(loops.motions, which);
  }
  const bool signs = which == FromV::signs;
  LoopFactors found =
      loops.found->simulated_signs == signs ? *loops.found : loops_of.asked_again(loops, signs);
  used_ = std::move(found.used);
  count_rows();
  return std::move(found.groups);
}

std::vector<InstrumentalGroup> Instruments::made(std::span<const Motion> simulated, FromV which) {
  const std::vector<RowGroup>& joints = problem_.data.groups;
  std::vector<InstrumentalGroup> groups = no_rows();
  if (which != FromV::none || !whitening_.empty() || reweighting_ != nullptr) {
    used_ = empty_groups(joints);
  }
  for (std::size_t k = 0; k < problem_.logs.size(); ++k) {
    const JointSinks<InstrumentSink> sinks(groups.size(), [&](std::size_t j) {
      return InstrumentSink(groups[j].qr, from_V_[j], used_.empty() ? nullptr : &used_[j].qr, blocks_, j,
                            problem_.logs[k].samples());
    });
    const std::vector<Index> widths =
        made_of(groups, [](const InstrumentalGroup& group) { return 2 * group.qr.columns() + 1; });
    const ReweightedSinks reweighted(sinks.sinks(), reweighting_, joints, from_V_);
    const WhitenedSinks whitened(reweighted.sinks(), whitening_, widths);
    const Motion V = instrument_motion(simulated[k], problem_.logs[k].f_m, problem_.estimation.signal);
    problem_.send_rows(k, signals_[k], whitened.sinks(), std::span(&V, 1));
  }
  count_rows();
  return groups;
}

std::vector<Motion> Instruments::motions(std::span<const Motion> simulated) const {
  return made_of(simulated.size(), [&](std::size_t k) {
    return instrument_motion(simulated[k], problem_.logs[k].f_m, problem_.estimation.signal);
  });
}

void Instruments::keep_every_row() {
  for (SignalOptions& signal : signals_) {
    signal.decimation.clear();
  }
}

std::vector<std::vector<Index>> Instruments::columns_from(FromV which) const {
  const std::vector<StandardParameter> columns = problem_.base.columns();
  const auto taken = [&](Index column) {
    // What follows the load has more of the motion than the sign.
    const ParameterKind kind = columns[static_cast<std::size_t>(column)].kind;
    return which == FromV::all ||
           (which == FromV::signs && role(kind) == Role::dry && about(kind).basis != Basis::load);
  };
  return made_of(problem_.data.groups, [&](const RowGroup& joint) {
    return places_where(std::ssize(joint.columns),
                        [&](Index c) { return taken(joint.columns[static_cast<std::size_t>(c)]); });
  });
}

void Instruments::count_rows() {
  rows_ = rows_of(used());
  y_norm_ = 0.0;
  for (const RowGroup& group : used()) {
    y_norm_ = std::hypot(y_norm_, group.qr.y_norm());
  }
}

}  // namespace rivid::detail

namespace rivid {

std::vector<Observation> instrument_rows(const Robot& robot, const Identification& result,
                                         std::span<const Log> logs) {
  const Iv* const iv = std::get_if<Iv>(&result.estimation.method);
  if (iv == nullptr || result.prefilter || has_load(robot) || !result.chi.allFinite()) {
    return {};
  }
  const detail::EstimationProblem problem(robot, logs, result.estimation);
  const detail::SimulatedLoops loops = detail::ClosedLoops(problem).simulated(result.chi, {});
  if (!loops.failure.empty()) {
    return {};
  }
  const std::vector<Motion> V = detail::Instruments(problem).motions(loops.motions);
  std::vector<Observation> out;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    // The samples of rows(), which knows of no transient.
    detail::RowSource source(robot, problem.base, logs[k], result.estimation.signal, *problem.team);
    const detail::JointSinks<detail::HeldRows> held(source.joints(), [&](std::size_t j) {
      return detail::HeldRows(source.rows(), 2 * std::ssize(source.columns(j)) + 1);
    });
    source.send(held.sinks(), std::span(&V[k], 1));
    Observation& rows = out.emplace_back();
    rows.columns = problem.base.size();
    for (std::size_t j = 0; j < source.joints(); ++j) {
      const auto own = static_cast<Index>(source.columns(j).size());
      rows.joints.push_back({source.columns(j), held[j].rows().leftCols(own)});
    }
  }
  return out;
}

}  // namespace rivid
