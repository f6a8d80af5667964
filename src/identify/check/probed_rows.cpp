#include "identify/check/probed_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/rows/time_blocks.hpp"
#include "ranges.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/solve/streaming_qr.hpp"

namespace rivid::detail {

namespace {

// Blocks of time that errors are independent between.
constexpr Index wanted_blocks = 20;
// Instants of all logs that are compared.
constexpr Index most_instants = 400;
// that each joint should have; a choice: with fewer, columns fit what they are to explain
constexpr Index rows_of_a_column = 3;

}  // namespace

void ProbedRows::pick_instants(const TorqueProbe& probe) {
  const Index instants = sum_of(probe.logs(), &ProbedLog::size);
  const Index every = std::max<Index>(1, instants / most_instants);
  for (const ProbedLog& log : probe.logs()) {
    PickedLog& picked = logs.emplace_back();
    picked.log = &log;
    std::vector<bool> taken(static_cast<std::size_t>(log.size()));
    for (Index i = 0; i < log.size(); i += every) {
      taken[static_cast<std::size_t>(i)] = true;
    }
    const auto is_taken = [&](Index i) -> bool { return taken[static_cast<std::size_t>(i)]; };
    for (Index j = 0; j < log.moves.cols(); ++j) {
      const std::vector<Index> moving = rows_that(log.moves.col(j));
      const Index least = wanted[static_cast<std::size_t>(j)] * log.size() / std::max<Index>(instants, 1) + 1;
      if (std::ranges::count_if(moving, is_taken) < least) {
        for (const Index i : spread(moving, least)) {
          taken[static_cast<std::size_t>(i)] = true;
        }
      }
    }
    picked.instants = places_where(log.size(), is_taken);
    picked.motion = {log.motion.q(picked.instants, Eigen::all), log.motion.qd(picked.instants, Eigen::all),
                     log.motion.qdd(picked.instants, Eigen::all)};
  }
}

void ProbedRows::cut_pieces(Index joints) {
  Index row = 0;
  for (Index j = 0; j < joints; ++j) {
    for (std::size_t l = 0; l < logs.size(); ++l) {
      Piece piece{j, l, {}, row};
      piece.instants = places_where(std::ssize(logs[l].instants), [&](Index i) {
        return logs[l].log->moves(logs[l].instants[static_cast<std::size_t>(i)], j);
      });
      row += piece.size();
      pieces.push_back(std::move(piece));
    }
  }
}

Index ProbedRows::rows_of(Index joint) const {
  return sum_of(pieces, [&](const Piece& piece) { return piece.joint == joint ? piece.size() : 0; });
}

void ProbedRows::stack(const std::vector<Observation>& of_logs, Index parameters) {
  std::vector<Duration> lasting = made_of(
      logs, [&](const PickedLog& log) { return Duration{log.log->log->samples(), log.log->log->f_m}; });
  const TimeBlocks time_blocks(std::move(lasting), wanted_blocks);
  blocks = time_blocks.count();
  const Index rows = pieces.back().first + pieces.back().size();
  W = Matrix::Zero(rows, parameters);
  Y = Vector(rows);
  for (const Piece& piece : pieces) {
    const PickedLog& log = logs[piece.log];
    const JointRows& of_joint = of_logs[piece.log].joints[static_cast<std::size_t>(piece.joint)];
    const double weight = weights[piece.joint];
    W(Eigen::seqN(piece.first, piece.size()), of_joint.columns) =
        weight * of_joint.W(piece.instants, Eigen::all);
    for (Index i = 0; i < piece.size(); ++i) {
      const Index instant =
          log.instants[static_cast<std::size_t>(piece.instants[static_cast<std::size_t>(i)])];
      Y[piece.first + i] = weight * log.log->tau(instant, piece.joint);
      block_of.push_back(time_blocks.of(piece.log, log.log->samples[static_cast<std::size_t>(instant)]));
    }
  }
}

ProbedRows::ProbedRows(const TorqueProbe& probe, const Robot& robot, const Identification& result)
    : weights(Eigen::Map<const Vector>(result.weights.data(), robot.size())) {
  const RegressorBatch batch(robot, result.base.columns());
  wanted = made_of(batch.joints(),
                   [&](std::size_t j) -> Index { return rows_of_a_column * std::ssize(batch.of_joint(j)); });
  pick_instants(probe);
  cut_pieces(robot.size());
  const std::vector<Observation> of_logs =
      made_of(logs, [&](const PickedLog& log) { return probe.averaged_observation(*log.log, log.instants); });
  stack(of_logs, result.base.size());
}

std::optional<ProbedRows> ProbedRows::fitted(const TorqueProbe& probe, const Robot& robot,
                                             const Identification& result) {
  ProbedRows out(probe, robot, result);
  if (out.Y.size() < result.base.size() || !out.fit() || !(out.residual.squaredNorm() > 0.0)) {
    return std::nullopt;
  }
  out.chi = out.solution;
  return out;
}

bool ProbedRows::fit() {
  // least over largest pivot, 4500 ε: columns below are dependent but for rounding
  constexpr double independent = 1e-12;
  StreamingQr qr(W.cols(), 1);
  qr.add(W, Y);
  R = qr.R();
  const Vector diagonal = R.diagonal().cwiseAbs();
  if (!(diagonal.minCoeff() > independent * diagonal.maxCoeff())) {
    return false;
  }
  solution = R.triangularView<Eigen::Upper>().solve(qr.qty());
  residual = Y - W * solution;
  return true;
}

void ProbedRows::take(const Matrix& columns) {
  W.conservativeResize(Eigen::NoChange, W.cols() + columns.cols());
  W.rightCols(columns.cols()) = columns;
}

}  // namespace rivid::detail
