#include "identify/figures/joint_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "accept.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

// Whether the series of a joint have the sizes that predict() gives them.
bool fits(const JointPrediction& joint, Index samples, Index b) {
  const FittedRows& fitted = joint.fitted;
  const auto is_a_row_each = [&](const Vector* x) { return x->size() == std::ssize(joint.rows); };
  const auto may_lack = [&](Index size) { return size == samples || size == 0; };
  return joint.measured.size() == samples && may_lack(joint.predicted.size()) &&
         may_lack(std::ssize(joint.kept)) && fitted.column_rms.size() == b &&
         std::ranges::all_of(std::array{&joint.residual, &fitted.position, &fitted.velocity, &fitted.measured,
                                        &fitted.a_priori, &fitted.gravity, &fitted.inertia, &fitted.coriolis,
                                        &fitted.friction},
                             is_a_row_each);
}

// Instants of the rows of one log, and the rows that do not follow their predecessor.
void add_times(const Prediction& log, const JointPrediction& joint, double offset, Index first_row,
               StackedRows& out) {
  for (std::size_t k = 0; k < joint.rows.size(); ++k) {
    const auto row = first_row + static_cast<Index>(k);
    out.time[row] = offset + static_cast<double>(joint.rows[k]) / log.f_m;
    if (k == 0 || joint.rows[k] - joint.rows[k - 1] > log.row_stride) {
      out.begins.push_back(row);
    }
  }
}

}  // namespace

void require_fitting(std::string_view who, const Robot& robot, const Identification& result,
                     std::span<const Prediction> predictions) {
  const auto require = [&](bool fits, const std::string& words) {
    if (!fits) {
      throw InputError(std::string(who) + ": " + words);
    }
  };
  const Index joints = std::ssize(result.fit.joints);
  require(joints == 0 || joints == robot.size(), "the result is of " + counted(joints, "joint") +
                                                     ", robot \"" + robot.name + "\" has " +
                                                     std::to_string(robot.size()));
  if (!result.base.standard.empty()) {
    accept(who, result.base.complaint(robot));
  }
  for (const Prediction& log : predictions) {
    require(std::ssize(log.joints) == robot.size(),
            "the prediction of \"" + log.source + "\" is of " + counted(std::ssize(log.joints), "joint") +
                ", robot \"" + robot.name + "\" has " + std::to_string(robot.size()));
    for (std::size_t j = 0; j < log.joints.size(); ++j) {
      require(fits(log.joints[j], log.samples(), result.base.size()),
              "the prediction of \"" + log.source + "\" for joint \"" + robot.joints[j].name +
                  "\" has series of different lengths; give what predict() returned");
    }
  }
}

std::span<const Prediction> fitted_logs(std::span<const Prediction> logs) {
  return {logs.begin(), std::ranges::find(logs, true, &Prediction::validation)};
}

TorqueShares torque_shares(std::span<const Prediction> predictions, std::size_t joint) {
  TorqueShares sums;
  for (const Prediction& log : fitted_logs(predictions)) {
    const FittedRows& rows = log.joints[joint].fitted;
    sums.gravity += rows.gravity.lpNorm<1>();
    sums.inertia += rows.inertia.lpNorm<1>();
    sums.coriolis += rows.coriolis.lpNorm<1>();
    sums.friction += rows.friction.lpNorm<1>();
  }
  const double all = sums.gravity + sums.inertia + sums.coriolis + sums.friction;
  const double share = all > 0.0 ? 1.0 / all : undefined;
  return {sums.gravity * share, sums.inertia * share, sums.coriolis * share, sums.friction * share};
}

double a_priori_error(const Prediction& log, std::size_t joint) {
  const FittedRows& rows = log.joints[joint].fitted;
  return (rows.measured - rows.a_priori).norm() / rows.measured.norm();
}

StackedRows stacked_rows(std::span<const Prediction> logs, std::size_t joint) {
  StackedRows out;
  Index rows = 0;
  for (const Prediction& log : logs) {
    out.logs.push_back(&log);
    rows += log.joints[joint].residual.size();
  }
  const auto stacked = [&](const auto& of) {
    Vector all(rows);
    Index at = 0;
    for (const Prediction& log : logs) {
      const Vector& part = of(log.joints[joint]);
      all.segment(at, part.size()) = part;
      at += part.size();
    }
    return all;
  };
  const auto fitted = [&](Vector FittedRows::* series) {
    return stacked([=](const JointPrediction& of) -> const Vector& { return of.fitted.*series; });
  };
  out.position = fitted(&FittedRows::position);
  out.velocity = fitted(&FittedRows::velocity);
  out.measured = fitted(&FittedRows::measured);
  out.a_priori = fitted(&FittedRows::a_priori);
  out.residual = stacked([](const JointPrediction& of) -> const Vector& { return of.residual; });
  out.friction = fitted(&FittedRows::friction) + out.residual;
  out.predicted = out.measured - out.residual;
  out.time.resize(rows);
  Index first_row = 0;
  double offset = logs.empty() ? 0.0 : logs.front().start;
  for (const Prediction& log : logs) {
    add_times(log, log.joints[joint], offset, first_row, out);
    first_row += log.joints[joint].residual.size();
    offset += static_cast<double>(log.samples()) / log.f_m;
  }
  return out;
}

double relative_error(const StackedRows& rows) { return rows.residual.norm() / rows.measured.norm(); }

std::vector<Index> every_few(Index rows, Index most) {
  const Index step = rows > most ? (rows + most - 1) / most : 1;
  std::vector<Index> out;
  for (Index k = 0; k < rows; k += step) {
    out.push_back(k);
  }
  return out;
}

Matrix correlation(const Matrix& covariance) {
  Vector deviation = covariance.diagonal().cwiseSqrt();
  for (double& sigma : deviation) {
    sigma = std::isfinite(sigma) && sigma > 0.0 ? sigma : undefined;
  }
  return covariance.cwiseQuotient(deviation * deviation.transpose());
}

Vector excitation(const Identification& result, std::span<const Prediction> predictions) {
  Vector out = Vector::Zero(result.base.size());
  for (std::size_t j = 0; j < result.fit.joints.size(); ++j) {
    Vector squares = Vector::Zero(out.size());
    Index rows = 0;
    for (const Prediction& log : fitted_logs(predictions)) {
      const auto count = log.joints[j].residual.size();
      squares += static_cast<double>(count) * log.joints[j].fitted.column_rms.cwiseAbs2();
      rows += count;
    }
    const double sigma = result.fit.joints[j].sigma_rho;
    if (rows > 0 && sigma > 0.0) {
      const Vector rms =
          (squares / static_cast<double>(rows)).cwiseSqrt().cwiseProduct(result.chi.cwiseAbs());
      out = out.cwiseMax(rms / sigma);
    }
  }
  return out;
}

}  // namespace rivid::detail
