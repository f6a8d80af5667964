#include "rivid/identify/row_table.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "csv_columns.hpp"
#include "dense.hpp"
#include "identify/figures/numpy_archive.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/instruments.hpp"
#include "rivid/identify/robust.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Diagonal of A (AᵀA)⁻¹ Aᵀ.
Vector hat_diagonal(const Matrix& A) {
  Matrix factored = A;
  const Matrix R = detail::triangular_factor(factored);
  const Vector diagonal = R.diagonal().cwiseAbs();
  if (A.rows() < A.cols() ||
      diagonal.minCoeff() <= std::numeric_limits<double>::epsilon() * diagonal.maxCoeff()) {
    return Vector::Constant(A.rows(), std::numeric_limits<double>::quiet_NaN());
  }
  const Matrix Q = R.topRows(A.cols()).triangularView<Eigen::Upper>().solve<Eigen::OnTheRight>(A);
  return Q.rowwise().squaredNorm();
}

Vector robust_weights(const Identification& result, const RowTable& rows) {
  Vector out = Vector::Ones(rows.Y.size());
  if (result.robust) {
    const RobustLoss loss = result.robust->options.loss();
    for (Index i = 0; i < out.size(); ++i) {
      const RobustJoint& joint = result.robust->joints[static_cast<std::size_t>(rows.joint[i])];
      out[i] = loss.weight(rows.residual[i] / joint.scale);
    }
  }
  return out;
}

// Times, torques, W and V of one joint's rows in one log, from this row of the table on.
void copy_rows(const Rows& from, const Log& log, const Observation* instruments, std::size_t joint, Index row,
               RowTable& to) {
  const Index size = from.Y[joint].size();
  to.Y.segment(row, size) = from.Y[joint];
  for (Index i = 0; i < size; ++i) {
    to.t[row + i] = log.t[from.samples[joint][static_cast<std::size_t>(i)]];
  }
  const JointRows& W = from.W.joints[joint];
  for (std::size_t k = 0; k < W.columns.size(); ++k) {
    const auto at = static_cast<Index>(k);
    to.W.col(W.columns[k]).segment(row, size) = W.W.col(at);
    if (instruments != nullptr) {
      to.V.col(W.columns[k]).segment(row, size) = instruments->joints[joint].W.col(at);
    }
  }
}

}  // namespace

RowTable row_table(const Robot& robot, const Identification& result, std::span<const Log> logs) {
  if (logs.empty()) {
    throw InputError("row_table: no log is given");
  }
  if (result.chi.size() != result.base.size()) {
    throw InputError("row_table: the result has " + counted(result.chi.size(), "value") + " for " +
                     counted(result.base.size(), "base parameter") + "; give what identify() returned");
  }
  if (result.robust && std::ssize(result.robust->joints) != robot.size()) {
    throw InputError("row_table: the robust estimate is of " +
                     counted(std::ssize(result.robust->joints), "joint") + ", robot \"" + robot.name +
                     "\" has " + std::to_string(robot.size()));
  }
  if (!result.weights.empty() && std::ssize(result.weights) != robot.size()) {
    throw InputError("row_table: the result has " + counted(std::ssize(result.weights), "weight") +
                     ", must have one for each of the " + counted(robot.size(), "joint"));
  }
  RowTable out;
  out.parameters = detail::made_of(result.base.parameters, &BaseParameter::name);
  out.joints = detail::made_of(robot.joints, &Joint::name);
  std::vector<Rows> all;
  Index count = 0;
  for (const Log& log : logs) {
    out.logs.push_back(log.source);
    all.push_back(rows(robot, result.base, log, result.estimation.signal));
    for (const Vector& Y : all.back().Y) {
      count += Y.size();
    }
  }
  const Index b = result.base.size();
  const std::vector<Observation> V = instrument_rows(robot, result, logs);
  out.W = Matrix::Zero(count, b);
  out.V = Matrix::Zero(V.empty() ? 0 : count, b);
  for (Vector* const each : {&out.t, &out.log, &out.joint, &out.Y, &out.weight}) {
    each->resize(count);
  }
  Index row = 0;
  for (std::size_t l = 0; l < all.size(); ++l) {
    for (std::size_t j = 0; j < all[l].Y.size(); ++j) {
      const Index size = all[l].Y[j].size();
      out.log.segment(row, size).setConstant(static_cast<double>(l));
      out.joint.segment(row, size).setConstant(static_cast<double>(j));
      out.weight.segment(row, size).setConstant(result.weights.empty() ? 1.0 : result.weights[j]);
      copy_rows(all[l], logs[l], V.empty() ? nullptr : &V[l], j, row, out);
      row += size;
    }
  }
  out.chi = result.chi;
  out.covariance = result.C_chi;
  out.prediction = out.W * out.chi;
  out.residual = out.Y - out.prediction;
  out.robust_weight = robust_weights(result, out);
  out.leverage = hat_diagonal(out.weight.cwiseProduct(out.robust_weight.cwiseSqrt()).asDiagonal() * out.W);
  return out;
}

std::string to_npz(const RowTable& rows) {
  detail::NumpyArchive out;
  const auto vector = [&](const char* name, const Vector& values) { out.add(name, values); };
  vector("t", rows.t);
  vector("log", rows.log);
  vector("joint", rows.joint);
  vector("Y", rows.Y);
  out.add("W", rows.W);
  if (rows.V.rows() > 0) {
    out.add("V", rows.V);
  }
  vector("weight", rows.weight);
  vector("robust_weight", rows.robust_weight);
  vector("prediction", rows.prediction);
  vector("residual", rows.residual);
  vector("leverage", rows.leverage);
  vector("chi", rows.chi);
  out.add("covariance", rows.covariance);
  out.add("parameters", rows.parameters);
  out.add("joints", rows.joints);
  out.add("logs", rows.logs);
  return out.finished();
}

std::string to_csv(const RowTable& rows) {
  detail::CsvColumns out(rows.Y.size());
  const std::array<std::pair<const char*, const Vector*>, 9> series = {
      {{"t", &rows.t},
       {"log", &rows.log},
       {"joint", &rows.joint},
       {"Y", &rows.Y},
       {"prediction", &rows.prediction},
       {"residual", &rows.residual},
       {"weight", &rows.weight},
       {"robust_weight", &rows.robust_weight},
       {"leverage", &rows.leverage}}};
  for (const auto& [name, values] : series) {
    out.add(name, values->data());
  }
  const auto add_each = [&](const std::string& prefix, const Matrix& values) {
    for (Index c = 0; c < values.cols() && values.rows() > 0; ++c) {
      out.add(prefix + rows.parameters[static_cast<std::size_t>(c)], values.col(c).data());
    }
  };
  add_each("W:", rows.W);
  add_each("V:", rows.V);
  return out.text();
}

}  // namespace rivid
