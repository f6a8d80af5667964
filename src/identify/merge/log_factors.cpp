#include "rivid/identify/log_factors.hpp"

#include <algorithm>
#include <utility>

#include "accept.hpp"
#include "identify/choose/row_choice.hpp"
#include "identify/describe/describe.hpp"
#include "identify/estimate/fitting_factors.hpp"
#include "identify/merge/unknown_to_factors.hpp"
#include "identify/rows/factors.hpp"
#include "identify/rows/time_blocks.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Takes the rows of a joint into the factors of their blocks of time.
class BlockedRows final : public detail::BufferedSink {
 public:
  // joint    whose rows come
  // samples  of the log
  BlockedRows(std::vector<std::vector<RowGroup>>& blocks, std::size_t joint, Index samples)
      : BufferedSink(std::ssize(blocks.front()[joint].columns) + 1),
        blocks_(blocks),
        joint_(joint),
        time_({{samples, 1.0}}, std::ssize(blocks)) {}

  void commit(std::span<const Index> samples) override {
    time_.divide(0, samples, [&](Index block, Index first, Index count) {
      StreamingQr& qr = blocks_[static_cast<std::size_t>(block)][joint_].qr;
      qr.add(rows_.middleRows(first, count).leftCols(qr.columns()),
             rows_.middleRows(first, count).rightCols(1));
    });
  }

 private:
  std::vector<std::vector<RowGroup>>& blocks_;
  std::size_t joint_;
  detail::TimeBlocks time_;
};

std::vector<std::vector<RowGroup>> blocks_of_log(const Robot& robot, const BaseParameters& base,
                                                 const Log& log, const SignalOptions& signal,
                                                 std::span<const RowGroup> like, int blocks, int threads) {
  std::vector<std::vector<RowGroup>> out;
  for (int g = 0; g < blocks; ++g) {
    out.push_back(detail::empty_groups(like));
  }
  detail::ThreadTeam team(threads);
  detail::RowSource source(robot, base, log, signal, team);
  const detail::JointSinks<BlockedRows> sinks(
      source.joints(), [&](std::size_t j) { return BlockedRows(out, j, log.samples()); });
  source.send(sinks.sinks());
  return out;
}

}  // namespace

std::optional<std::string> detail::unknown_to_factors(const Robot& robot, const Estimation& estimation) {
  const std::string instead = "; identify from the logs themselves";
  if (estimation.robust) {
    return "robust estimation weights single rows" + instead;
  }
  if (estimation.essential) {
    return "the search for essential parameters needs the positions" + instead;
  }
  if (estimation.covariance.kind == CovarianceKind::hac) {
    return "covariance \"hac\" needs all residuals; \"blocks\" and \"classical\" do not";
  }
  if (has_load(robot)) {
    return "friction that follows the load makes rows that depend on the parameters" + instead;
  }
  return std::nullopt;
}

SignalOptions chosen_signal(const Robot& robot, std::span<const Log> logs, const Estimation& estimation) {
  Estimation chosen = estimation;
  detail::accept("chosen_signal", estimation.complaint(robot));
  if (!chosen.signal.automatic()) {
    return chosen.signal;
  }
  if (logs.empty()) {
    throw InputError("chosen_signal: no log is given that the rows could be chosen by");
  }
  for (const Log& log : logs) {
    detail::require_joints("position", log.q, robot, log);
  }
  static_cast<void>(detail::choose_rows(without_load(robot), logs, chosen));
  return chosen.signal;
}

LogFactors log_factors(const Robot& robot, const Log& log, const SignalOptions& signal, int blocks,
                       int threads) {
  if (blocks < 1 || blocks > LogFactors::most_blocks) {
    throw InputError("log_factors: blocks is " + std::to_string(blocks) + ", must lie between 1 and " +
                     std::to_string(LogFactors::most_blocks));
  }
  if (signal.automatic()) {
    throw InputError(
        "log_factors: the rows of each log would be chosen by its own noise; chosen_signal() chooses for "
        "all");
  }
  detail::accept("log_factors", detail::unknown_to_factors(robot, {.method = Wls{}}));
  const BaseParameters base = base_parameters(robot);
  LogFactors out;
  out.rows = factors(robot, base, log, signal, threads);
  out.blocks = blocks_of_log(robot, base, log, signal, out.rows.groups, blocks, threads);
  out.velocities = detail::squared_velocities(std::span(&log, 1), robot.size());
  out.logs = 1;
  return out;
}

void merge(LogFactors& into, const LogFactors& other) {
  const std::vector<std::vector<Index>> columns = detail::columns_of(into.rows.groups);
  if (!detail::fit(into, columns) || !detail::fit(other, columns) ||
      into.rows.undecimated.size() != other.rows.undecimated.size()) {
    throw InputError("merge: the factors are of different robots or options");
  }
  detail::add_factors(into.rows, other.rows);
  into.blocks.insert(into.blocks.end(), other.blocks.begin(), other.blocks.end());
  into.blocks = detail::fewer_blocks(std::move(into.blocks), LogFactors::most_blocks);
  into.velocities.sums += other.velocities.sums;
  into.velocities.count += other.velocities.count;
  into.logs += other.logs;
}

Identification identify(const Robot& robot, const LogFactors& factors, const Estimation& asked) {
  Estimation estimation = asked;
  std::optional<MethodChoice> choice;
  if (std::holds_alternative<Auto>(asked.method)) {
    estimation.method = Wls{};
    choice = {.reason = "weighted least squares: factors of logs serve no other method", .least_squares = {}};
  }
  if (std::holds_alternative<Iv>(estimation.method)) {
    throw InputError(
        "identify: instrumental variables simulate every log; identify from the logs themselves, by "
        "rivid.distributed of the Python package, or by method \"wls\"");
  }
  detail::accept("identify", detail::unknown_to_factors(robot, estimation));
  detail::Answer answer(std::make_unique<detail::EstimationProblem>(robot, factors, estimation));
  answer.method = std::move(choice);
  return described(answer, {}, detail::Widened::whole);
}

}  // namespace rivid
