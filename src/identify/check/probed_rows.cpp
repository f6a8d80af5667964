#include "identify/check/probed_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rivid/regressor/batch.hpp"
#include "rivid/solve/streaming_qr.hpp"

namespace rivid::detail {

namespace {

// Blocks of motion that errors are independent between; more where a joint moves in some of them alone, so
// that it has a few.
constexpr Index wanted_blocks = 20;
constexpr Index most_blocks = 120;
// Instants of all logs that are compared.
constexpr Index most_instants = 400;
constexpr Index rows_of_a_column = 3;
// Of the norm of a column: what the rows tell less of stays with the result.
constexpr double hardly_determined = 1e-6;

}  // namespace

void ProbedRows::pick_instants(const TorqueProbe& probe, std::span<const Index> wanted) {
  Index instants = 0;
  for (const ProbedLog& log : probe.logs()) {
    instants += log.size();
  }
  const Index every = std::max<Index>(1, instants / most_instants);
  std::vector<std::vector<bool>> picked;
  for (const ProbedLog& log : probe.logs()) {
    std::vector<bool>& of_log = picked.emplace_back(static_cast<std::size_t>(log.size()), false);
    for (std::size_t i = 0; i < of_log.size(); i += static_cast<std::size_t>(every)) {
      of_log[i] = true;
    }
  }
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    std::vector<std::pair<std::size_t, std::size_t>> others;  // at which the joint moves
    Index have = 0;
    for (std::size_t l = 0; l < picked.size(); ++l) {
      for (std::size_t i = 0; i < picked[l].size(); ++i) {
        if (!probe.logs()[l].moves(static_cast<Index>(i), static_cast<Index>(j))) {
          continue;
        }
        if (picked[l][i]) {
          ++have;
        } else {
          others.emplace_back(l, i);
        }
      }
    }
    const Index missing = std::min(wanted[j] - have, static_cast<Index>(others.size()));
    for (Index k = 0; k < missing; ++k) {
      const auto [l, i] = others[static_cast<std::size_t>(k * std::ssize(others) / missing)];
      picked[l][i] = true;
    }
  }
  for (std::size_t l = 0; l < picked.size(); ++l) {
    const ProbedLog& log = probe.logs()[l];
    PickedLog out;
    out.log = &log;
    for (std::size_t i = 0; i < picked[l].size(); ++i) {
      if (picked[l][i]) {
        out.instants.push_back(static_cast<Index>(i));
      }
    }
    out.motion = {log.motion.q(out.instants, Eigen::all), log.motion.qd(out.instants, Eigen::all),
                  log.motion.qdd(out.instants, Eigen::all)};
    logs.push_back(std::move(out));
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
    }
  }
}

void ProbedRows::divide() {
  std::vector<Index> before;  // instants of earlier logs
  Index instants = 0;
  for (const PickedLog& log : logs) {
    before.push_back(instants);
    instants += static_cast<Index>(log.instants.size());
  }
  Index fewest = instants;
  for (const Piece& piece : pieces) {
    if (const Index rows = rows_of(piece.joint); rows > 0) {
      fewest = std::min(fewest, rows);
    }
  }
  blocks = std::min({std::max(wanted_blocks, wanted_blocks * instants / (2 * std::max<Index>(fewest, 1))),
                     most_blocks, instants});
  block_of.clear();
  for (const Piece& piece : pieces) {
    for (const Index i : piece.instants) {
      block_of.push_back((before[piece.log] + i) * blocks / instants);
    }
  }
}

std::optional<ProbedRows> ProbedRows::of(const TorqueProbe& probe, const Robot& robot,
                                         const Identification& result, std::vector<UntestedJoint>* untested) {
  const Index n = robot.size();
  const RegressorBatch batch(robot, result.base.columns());
  std::vector<Index> wanted;
  for (std::size_t j = 0; j < batch.joints(); ++j) {
    wanted.push_back(rows_of_a_column * static_cast<Index>(batch.of_joint(j).size()));
  }
  ProbedRows out;
  out.weights = Eigen::Map<const Vector>(result.weights.data(), n);
  out.of_result_ = result.chi.unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
  out.pick_instants(probe, wanted);
  out.cut_pieces(n);
  for (Index j = 0; j < n; ++j) {
    const Index needed = wanted[static_cast<std::size_t>(j)];
    const Index found = out.rows_of(j);
    if (found < needed || !std::isfinite(out.weights[j])) {
      std::erase_if(out.pieces, [&](const Piece& piece) { return piece.joint == j; });
      if (untested != nullptr) {
        untested->push_back({j, found, needed});
      }
    }
  }
  if (out.pieces.empty()) {
    return std::nullopt;
  }
  Index row = 0;
  for (Piece& piece : out.pieces) {
    piece.first = row;
    row += piece.size();
  }
  std::vector<Observation> of_logs;
  for (const PickedLog& log : out.logs) {
    of_logs.push_back(probe.averaged_observation(*log.log, log.instants));
  }
  out.stack(of_logs, result.base.size());
  out.divide();
  out.fit(true);
  return out.residual.squaredNorm() > 0.0 ? std::optional(std::move(out)) : std::nullopt;
}

void ProbedRows::fit(bool with_chi) {
  const Index b = of_result_.size();
  const Vector told = Y - W.leftCols(b) * of_result_;
  const Vector norms = W.colwise().norm();
  StreamingQr qr(W.cols(), 1);
  qr.add(W, told);
  const Matrix ridge =
      (hardly_determined * norms.cwiseMax(hardly_determined * norms.maxCoeff())).asDiagonal();
  qr.add(ridge, Vector::Zero(W.cols()));
  R = qr.R();
  const Vector solution = R.triangularView<Eigen::Upper>().solve(qr.qty());
  residual = told - W * solution;
  beside = of_result_ + solution.head(b);
  if (with_chi) {
    chi = beside;
  }
}

void ProbedRows::take(const Matrix& columns) {
  const Index before = W.cols();
  W.conservativeResize(Eigen::NoChange, before + columns.cols());
  W.rightCols(columns.cols()) = columns * (W.leftCols(before).norm() / columns.norm());
  fit(false);
}

ProbedRows ProbedRows::of_blocks(Index first, Index count, std::vector<Index>& kept) const {
  ProbedRows out;
  out.weights = weights;
  out.of_result_ = of_result_;
  out.logs = logs;
  out.blocks = count;
  kept.clear();
  for (const Piece& piece : pieces) {
    Piece part{piece.joint, piece.log, {}, std::ssize(kept)};
    for (Index i = 0; i < piece.size(); ++i) {
      const Index block = block_of[static_cast<std::size_t>(piece.first + i)] - first;
      if (block >= 0 && block < count) {
        part.instants.push_back(piece.instants[static_cast<std::size_t>(i)]);
        out.block_of.push_back(block);
        kept.push_back(piece.first + i);
      }
    }
    out.pieces.push_back(std::move(part));
  }
  out.W = W(kept, Eigen::all);
  out.Y = Y(kept);
  out.chi = chi;
  out.fit(false);
  return out;
}

}  // namespace rivid::detail
