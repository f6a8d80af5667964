#include "identify/check/probed_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/rows/time_blocks.hpp"
#include "rivid/solve/streaming_qr.hpp"

namespace rivid::detail {

namespace {

// Blocks of time that errors are independent between.
constexpr Index wanted_blocks = 20;
// Instants of all logs that are compared.
constexpr Index most_instants = 400;
constexpr Index rows_of_a_column = 3;

}  // namespace

void ProbedRows::pick_instants(const TorqueProbe& probe) {
  Index instants = 0;
  for (const ProbedLog& log : probe.logs()) {
    instants += log.size();
  }
  const Index every = std::max<Index>(1, instants / most_instants);
  for (const ProbedLog& log : probe.logs()) {
    PickedLog picked;
    picked.log = &log;
    for (Index i = 0; i < log.size(); i += every) {
      picked.instants.push_back(i);
    }
    picked.motion = {log.motion.q(picked.instants, Eigen::all), log.motion.qd(picked.instants, Eigen::all),
                     log.motion.qdd(picked.instants, Eigen::all)};
    logs.push_back(std::move(picked));
  }
}

void ProbedRows::cut_pieces(Index joints) {
  Index row = 0;
  for (Index j = 0; j < joints; ++j) {
    for (std::size_t l = 0; l < logs.size(); ++l) {
      Piece piece{j, l, {}, row};
      for (std::size_t i = 0; i < logs[l].instants.size(); ++i) {
        if (logs[l].log->moves(logs[l].instants[i], j)) {
          piece.instants.push_back(static_cast<Index>(i));
        }
      }
      row += piece.size();
      pieces.push_back(std::move(piece));
    }
  }
}

Index ProbedRows::rows_of(Index joint) const {
  Index out = 0;
  for (const Piece& piece : pieces) {
    out += piece.joint == joint ? piece.size() : 0;
  }
  return out;
}

void ProbedRows::stack(const std::vector<Observation>& of_logs, Index parameters) {
  std::vector<Duration> lasting;
  for (const PickedLog& log : logs) {
    lasting.push_back({log.log->log->samples(), log.log->log->f_m});
  }
  const TimeBlocks time_blocks(std::move(lasting), wanted_blocks);
  blocks = time_blocks.count();
  const Index rows = pieces.back().first + pieces.back().size();
  W = Matrix::Zero(rows, parameters);
  Y = Vector(rows);
  for (const Piece& piece : pieces) {
    const PickedLog& log = logs[piece.log];
    const JointRows& of_joint = of_logs[piece.log].joints[static_cast<std::size_t>(piece.joint)];
    const double weight = weights[piece.joint];
    for (std::size_t c = 0; c < of_joint.columns.size(); ++c) {
      W.col(of_joint.columns[c]).segment(piece.first, piece.size()) =
          weight * of_joint.W.col(static_cast<Index>(c))(piece.instants);
    }
    for (Index i = 0; i < piece.size(); ++i) {
      const Index instant =
          log.instants[static_cast<std::size_t>(piece.instants[static_cast<std::size_t>(i)])];
      Y[piece.first + i] = weight * log.log->tau(instant, piece.joint);
      block_of.push_back(time_blocks.of(piece.log, log.log->samples[static_cast<std::size_t>(instant)]));
    }
  }
}

std::optional<ProbedRows> ProbedRows::of(const TorqueProbe& probe, const Robot& robot,
                                         const Identification& result) {
  const Index n = robot.size();
  ProbedRows out;
  out.weights = Eigen::Map<const Vector>(result.weights.data(), n);
  out.pick_instants(probe);
  out.cut_pieces(n);
  std::vector<Observation> of_logs;
  for (const PickedLog& log : out.logs) {
    of_logs.push_back(probe.averaged_observation(*log.log, log.instants));
  }
  for (Index j = 0; j < n; ++j) {
    if (out.rows_of(j) < rows_of_a_column * of_logs.front().joints[static_cast<std::size_t>(j)].W.cols()) {
      return std::nullopt;
    }
  }
  out.stack(of_logs, result.base.size());
  if (!out.fit(true) || !(out.residual.squaredNorm() > 0.0)) {
    return std::nullopt;
  }
  return out;
}

bool ProbedRows::fit(bool with_chi) {
  constexpr double independent = 1e-12;
  StreamingQr qr(W.cols(), 1);
  qr.add(W, Y);
  R = qr.R();
  const Vector diagonal = R.diagonal().cwiseAbs();
  if (!(diagonal.minCoeff() > independent * diagonal.maxCoeff())) {
    return false;
  }
  const Vector solution = R.triangularView<Eigen::Upper>().solve(qr.qty());
  residual = Y - W * solution;
  if (with_chi) {
    chi = solution;
  }
  return true;
}

bool ProbedRows::take(const Matrix& columns) {
  const Index before = W.cols();
  W.conservativeResize(Eigen::NoChange, before + columns.cols());
  W.rightCols(columns.cols()) = columns * (W.leftCols(before).norm() / columns.norm());
  return fit(false);
}

}  // namespace rivid::detail
