#include "report/analysis.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "dense.hpp"

namespace rivid::detail {

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

Vector concatenated(const std::vector<const Vector*>& parts) {
  Index size = 0;
  for (const Vector* const part : parts) {
    size += part->size();
  }
  Vector out(size);
  Index at = 0;
  for (const Vector* const part : parts) {
    out.segment(at, part->size()) = *part;
    at += part->size();
  }
  return out;
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

// Orientation and origin of each link's frame in that of the base.
std::vector<Eigen::Isometry3d> link_frames(const Chain& chain, const Vector& q) {
  std::vector<Eigen::Isometry3d> out;
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  for (std::size_t j = 0; j < chain.links.size(); ++j) {
    const Chain::Link& link = chain.links[j];
    Eigen::Isometry3d fixed = Eigen::Isometry3d::Identity();
    fixed.linear() = link.R;
    fixed.translation() = link.p;
    frame = frame * fixed;
    const double at = q[static_cast<Index>(j)];
    if (link.type == JointType::revolute) {
      frame.rotate(Eigen::AngleAxisd(at, Eigen::Vector3d::UnitZ()));
    } else {
      frame.translate(Eigen::Vector3d(0.0, 0.0, at));
    }
    out.push_back(frame);
  }
  return out;
}

}  // namespace

TorqueShares torque_shares(std::span<const Prediction> predictions, std::size_t joint) {
  TorqueShares sums;
  for (const Prediction& log : predictions) {
    if (!log.validation) {
      const FittedRows& rows = log.joints[joint].fitted;
      sums.gravity += rows.gravity.lpNorm<1>();
      sums.inertia += rows.inertia.lpNorm<1>();
      sums.coriolis += rows.coriolis.lpNorm<1>();
      sums.friction += rows.friction.lpNorm<1>();
    }
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
  std::array<std::vector<const Vector*>, 6> parts;
  Index rows = 0;
  for (const Prediction& log : logs) {
    const JointPrediction& from = log.joints[joint];
    out.logs.push_back(&log);
    parts[0].push_back(&from.fitted.position);
    parts[1].push_back(&from.fitted.velocity);
    parts[2].push_back(&from.fitted.measured);
    parts[3].push_back(&from.fitted.a_priori);
    parts[4].push_back(&from.residual);
    parts[5].push_back(&from.fitted.friction);
    rows += from.residual.size();
  }
  out.position = concatenated(parts[0]);
  out.velocity = concatenated(parts[1]);
  out.measured = concatenated(parts[2]);
  out.a_priori = concatenated(parts[3]);
  out.residual = concatenated(parts[4]);
  out.friction = concatenated(parts[5]) + out.residual;
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

Spectrum amplitude_spectrum(const Vector& x, const Vector& values, double most, Index count) {
  Spectrum out;
  const Index rows = x.size();
  if (rows < 8 || count < 1 || !(most > 0.0)) {
    return out;
  }
  const double step = most / static_cast<double>(count);
  out.frequency = Vector::LinSpaced(count, step, most);
  // A stretch resolves frequencies that are one over its length apart: stretches as long as the grid is fine.
  const double length = x.maxCoeff() - x.minCoeff();
  const auto stretches = std::clamp<Index>(static_cast<Index>(length * step), 1, rows / 8);
  const Vector centred = values.array() - values.mean();
  Vector squares = Vector::Zero(count);
  for (Index s = 0; s < stretches; ++s) {
    const Index first = rows * s / stretches;
    const Index size = rows * (s + 1) / stretches - first;
    const Eigen::ArrayXd angle = 2.0 * std::numbers::pi * step * x.segment(first, size).array();
    const Eigen::ArrayXd r = centred.segment(first, size).array();
    // cos and sin of k ω t from those of (k − 1) ω t: no more than one function a row.
    const Eigen::ArrayXd c1 = angle.cos();
    const Eigen::ArrayXd s1 = angle.sin();
    Eigen::ArrayXd c = Eigen::ArrayXd::Ones(size);
    Eigen::ArrayXd d = Eigen::ArrayXd::Zero(size);
    for (Index k = 0; k < count; ++k) {
      const Eigen::ArrayXd next = c * c1 - d * s1;
      d = c * s1 + d * c1;
      c = next;
      // The best a and b of r ≈ a cos + b sin.
      Eigen::Matrix2d normal;
      normal << c.square().sum(), (c * d).sum(), (c * d).sum(), d.square().sum();
      const Eigen::Vector2d right((r * c).sum(), (r * d).sum());
      const double determinant = normal.determinant();
      if (determinant > 1e-6 * normal.trace() * normal.trace()) {
        squares[k] += (normal.inverse() * right).squaredNorm();
      }
    }
  }
  out.amplitude = (squares / static_cast<double>(stretches)).cwiseSqrt();
  // Of white noise N (a² + b²) / (2 σ²) is χ² with 2 degrees of freedom a stretch; 2.326 is the 99 % quantile of the normal
  // distribution in the cube-root approximation of χ² by Wilson and Hilferty.
  const double freedom = 2.0 * static_cast<double>(stretches);
  const double cube = 1.0 - 2.0 / (9.0 * freedom) + 2.326 * std::sqrt(2.0 / (9.0 * freedom));
  const double chi_squared = freedom * cube * cube * cube;
  const double rows_of_stretch = static_cast<double>(rows) / static_cast<double>(stretches);
  const double variance = centred.squaredNorm() / static_cast<double>(rows);
  out.noise = std::sqrt(chi_squared * 2.0 * variance / (rows_of_stretch * static_cast<double>(stretches)));
  return out;
}

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
    for (const Prediction& log : predictions) {
      if (!log.validation) {
        const auto count = log.joints[j].residual.size();
        squares += static_cast<double>(count) * log.joints[j].fitted.column_rms.cwiseAbs2();
        rows += count;
      }
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

Skeleton skeleton_of(const Robot& robot, const Vector& q) {
  Skeleton out;
  out.joints.emplace_back(Eigen::Vector3d::Zero());
  for (const Eigen::Isometry3d& frame : link_frames(robot.chain, q)) {
    out.joints.emplace_back(frame.translation());
  }
  return out;
}

void add_ellipsoids(const Robot& robot, const Vector& q, const std::vector<Inertial>& inertials,
                    const std::string& style, Skeleton& out) {
  const std::vector<Eigen::Isometry3d> frames = link_frames(robot.chain, q);
  for (std::size_t j = 0; j < frames.size() && j < inertials.size(); ++j) {
    const Eigen::Matrix4d P = pseudo_inertia(inertials[j]);
    const double mass = P(3, 3);
    if (!(mass > 0.0)) {
      continue;
    }
    const Eigen::Vector3d centre = P.topRightCorner<3, 1>() / mass;
    const Eigen::Matrix3d moments = P.topLeftCorner<3, 3>() - mass * centre * centre.transpose();
    const SymmetricEigen principal = symmetric_eigen(moments);
    if (principal.values.minCoeff() < -1e-9 * principal.values.cwiseAbs().maxCoeff()) {
      continue;
    }
    // ∫ x² dm of an ellipsoid with semi-axis a is m a² / 5.
    const Eigen::Vector3d moments_of_axes = principal.values;
    const Eigen::Matrix3d directions = principal.vectors;
    const Eigen::Vector3d axes = (5.0 / mass * moments_of_axes.cwiseMax(0.0)).cwiseSqrt();
    const Eigen::Matrix3d to_base = frames[j].linear() * link_axes(robot.chain.links[j]).transpose();
    out.ellipsoids.push_back({robot.joints[j].link, style, mass, frames[j].translation() + to_base * centre,
                              to_base * directions * axes.asDiagonal()});
  }
}

}  // namespace rivid::detail
