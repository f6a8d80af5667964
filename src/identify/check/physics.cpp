// What a result leaves unexplained, and values that physics forbids.

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "identify/check/checks.hpp"
#include "identify/check/torque_probe.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Part of a joint's torque from which on a model is none; of a torque that is clipped; and of the torques of
// all joints.
constexpr double poor = 0.3;
constexpr double poor_where_clipped = 0.1;
constexpr double useless = 1.0;
// A joint whose torque is below this part of the largest one of its type carries none that counts.
constexpr double counting = 0.01;
// A value of many parameters, or the worst of many poses, is beyond doubt from so many σ on.
constexpr double sure = 4.5;
// And of one drive likely.
constexpr double likely = 3.0;
constexpr Index most_poses = 100;  // of each log, up to twice as many; a choice of time

// A of Σ c_k π_k = ∫ [r; 1]ᵀ A [r; 1] dm, with coefficients c of the inertial parameters π of a body.
Eigen::Matrix4d moment_matrix(const Inertial& c) {
  Eigen::Matrix4d A;
  for (Index i = 0; i < 4; ++i) {
    for (Index j = 0; j < 4; ++j) {
      Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
      P(i, j) += 0.5;
      P(j, i) += 0.5;
      A(i, j) = c.dot(inertial_from_pseudo_inertia(P));
    }
  }
  return A;
}

// Whether a base parameter is positive in every robot: what is regrouped into it are moments of each link
// with A ⪰ 0, as masses and inertias about any axis are, and rotor inertias and friction with positive
// coefficients.
bool always_positive(const BaseParameters& base, Index i) {
  constexpr double rounding = 1e-9;  // relative; any value between rounding and a coefficient that counts
  std::map<int, Inertial> moments;
  const auto add = [&](Index standard, double coefficient) {
    const StandardParameter& p = base.standard[static_cast<std::size_t>(standard)];
    if (role(p.kind) != Role::inertial) {
      return std::abs(coefficient) < rounding || (about(p.kind).bound == Bound::zero && coefficient > 0.0);
    }
    moments.try_emplace(p.joint, Inertial::Zero()).first->second[static_cast<Index>(p.kind)] += coefficient;
    return true;
  };
  bool out = add(base.leading[static_cast<std::size_t>(i)], 1.0);
  for (std::size_t d = 0; d < base.dependent.size(); ++d) {
    out = add(base.dependent[d], base.K(i, static_cast<Index>(d))) && out;
  }
  return out && std::ranges::all_of(moments, [](const auto& of_link) {
           const Eigen::Matrix4d A = moment_matrix(of_link.second);
           const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> of_A(A, Eigen::EigenvaluesOnly);
           return of_A.eigenvalues()[0] >= -rounding * A.norm();
         });
}

// Torques beside a result.
struct Explained {
  Reading told;
  const std::vector<JointFactor>& factors;
  Vector residual;     // rms, (n) [N·m | N]
  Vector torque;       // rms without the mean, (n) [N·m | N]
  double error = 0.0;  // ‖Y − Wχ‖ / ‖Y‖ over all joints

  Explained(const TorqueProbe& probe, const Vector& chi)
      : told(probe.as_told()), factors(probe.told_factors()) {
    residual = torque = Vector::Zero(static_cast<Index>(factors.size()));
    Vector with_mean = residual;
    for (std::size_t j = 0; j < factors.size(); ++j) {
      const JointFactor& f = factors[j];
      const auto at = static_cast<Index>(j);
      const Index column = told.torque[j];
      const auto rows = static_cast<double>(std::max<Index>(f.rows, 1));
      torque[at] = std::sqrt(f.centred[column] / rows);
      with_mean[at] = std::sqrt((f.Z.col(column).squaredNorm() + f.rest[column]) / rows);
      residual[at] =
          std::sqrt(((f.Z.col(column) - f.R * chi(f.columns)).squaredNorm() + f.rest[column]) / rows);
    }
    error = residual.norm() / with_mean.norm();
  }

  // Whether the torque of a joint counts and so large a part of it is left.
  [[nodiscard]] bool is_poor(const Robot& robot, Index j, double part) const {
    double largest = 0.0;
    for (Index k = 0; k < torque.size(); ++k) {
      const bool like =
          robot.joints[static_cast<std::size_t>(k)].type == robot.joints[static_cast<std::size_t>(j)].type;
      largest = like ? std::max(largest, torque[k]) : largest;
    }
    return torque[j] > counting * largest && residual[j] > part * torque[j];
  }
};

std::string in_percent(double part) { return number_that_says(100.0 * part, 3) + " %"; }

void add_poor(const Robot& robot, const Explained& explained, Index j, double part, const std::string& where,
              Findings& out) {
  if (explained.is_poor(robot, j, part)) {
    out.add("poor_fit", robot.joints[static_cast<std::size_t>(j)].name,
            where + "the model leaves " + in_percent(explained.residual[j] / explained.torque[j]) +
                " of its torque (mean taken off), of windows that average noise away; should be below " +
                in_percent(part));
  }
}

// Not the error of the rows, which has the noise of unfiltered accelerations beside what the model leaves.
void add_useless(const Explained& explained, const std::string& where, Findings& out) {
  if (explained.error > useless) {
    out.add("poor_fit", "all joints",
            where + "the error is " + in_percent(explained.error) +
                " of the torques, of windows that average noise away: as large as without a model");
  }
}

// Whether friction as a whole takes power from a joint, as where it falls with speed: its columns, which have
// the sign of the velocity, against each other.
bool brakes(const Identification& result, const Explained& explained, int joint) {
  const JointFactor& f = explained.factors[static_cast<std::size_t>(joint)];
  Vector dry = Vector::Zero(f.R.rows());
  Vector all = dry;
  for (std::size_t c = 0; c < f.columns.size(); ++c) {
    const StandardParameter& p = result.base.parameters[static_cast<std::size_t>(f.columns[c])].leading;
    if (p.joint != joint || !is_friction(p.kind) || about(p.kind).coupled) {
      continue;
    }
    all += f.R.col(static_cast<Index>(c)) * result.chi[f.columns[c]];
    if (role(p.kind) == Role::dry) {
      dry += f.R.col(static_cast<Index>(c));
    }
  }
  return dry.dot(all) > 0.0;
}

// Values below zero that more of the torques depends on than the model leaves unexplained: what is smaller
// may be an error of the model.
void check_parameters(const Identification& result, const Explained& explained, Findings& out) {
  for (Index i = 0; i < result.base.size(); ++i) {
    const ParameterEstimate& p = result.parameters[static_cast<std::size_t>(i)];
    const StandardParameter& leading = result.base.parameters[static_cast<std::size_t>(i)].leading;
    if (!(p.value < -sure * p.sigma) || !always_positive(result.base, i) ||
        (is_friction(leading.kind) && brakes(result, explained, leading.joint))) {
      continue;
    }
    for (std::size_t j = 0; j < explained.factors.size(); ++j) {
      const JointFactor& f = explained.factors[j];
      const auto at = std::ranges::find(f.columns, i);
      if (at != f.columns.end() &&
          std::abs(p.value) * f.R.col(at - f.columns.begin()).norm() >
              explained.residual[static_cast<Index>(j)] * std::sqrt(static_cast<double>(f.rows))) {
        out.add("not_physical", p.name,
                p.regrouped + " = " + number(p.value, 3) + " ± " + number(p.sigma, 2) + " " + p.unit +
                    ", is positive in every robot");
        break;
      }
    }
  }
}

// Signs of drives that are hardly in doubt, however little of the torques depends on them.
void check_signs(const Robot& robot, const Identification& result, const Explained& explained,
                 Findings& out) {
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const StandardParameter& leading = result.base.parameters[i].leading;
    if (role(leading.kind) == Role::inertial || about(leading.kind).coupled ||
        !(p.value < -likely * p.sigma) || out.has("not_physical", p.name)) {
      continue;
    }
    const std::string& joint = robot.joints[static_cast<std::size_t>(leading.joint)].name;
    const std::string value = p.name + " = " + number(p.value, 3) + " ± " + number(p.sigma, 2) + " " + p.unit;
    const Role of = role(leading.kind);
    if ((of == Role::viscous || of == Role::dry) && !brakes(result, explained, leading.joint)) {
      out.add("friction_drives", joint, value + ", friction brakes");
    } else if (of == Role::rotor) {
      out.add("negative_rotor", joint, value + ", inertias are positive");
    }
  }
}

// The mass matrix along the logs, in the direction of accelerations where it is least, as far as that is
// beyond doubt.
void check_mass_matrix(const TorqueProbe& probe, const Robot& robot, const Identification& result,
                       const Explained& explained, Findings& out) {
  Robot weightless = robot;
  weightless.chain.gravity.setZero();
  const RegressorBatch batch(weightless, result.base.columns());
  const Index n = robot.size();
  const auto joints = static_cast<std::size_t>(n);
  RegressorBlock block(batch, n);
  double least = -sure;
  std::string text;
  std::string subject;
  for (const ProbedLog& log : probe.logs()) {
    const Index every = std::max<Index>(log.size() / most_poses, 1);
    for (Index s = 0; s < log.size(); s += every) {
      batch.fill({log.motion.q.row(s).replicate(n, 1), Matrix::Zero(n, n), Matrix::Identity(n, n)}, 0, n,
                 block);
      // Of each joint's row what its accelerations make, parameters of friction left out.
      std::vector<Matrix> W;
      Matrix M(n, n);
      for (std::size_t j = 0; j < joints; ++j) {
        const std::vector<Index>& columns = batch.of_joint(j);
        Matrix& of_joint = W.emplace_back(Matrix::Zero(n, result.base.size()));
        for (std::size_t c = 0; c < columns.size(); ++c) {
          const StandardParameter& leading =
              result.base.parameters[static_cast<std::size_t>(columns[c])].leading;
          if (!is_friction(leading.kind)) {
            of_joint.col(columns[c]) = block.W(j).col(static_cast<Index>(c)).head(n);
          }
        }
        M.row(static_cast<Index>(j)) = of_joint * result.chi;
      }
      const Vector scale = M.diagonal().cwiseAbs().cwiseMax(1e-12 * M.norm()).cwiseSqrt().cwiseInverse();
      const Eigen::SelfAdjointEigenSolver<Matrix> of_M(scale.asDiagonal() * M * scale.asDiagonal());
      if (!(of_M.eigenvalues()[0] < 0.0)) {
        continue;
      }
      Index k = 0;
      of_M.eigenvectors().col(0).cwiseAbs().maxCoeff(&k);
      Vector v = scale.cwiseProduct(of_M.eigenvectors().col(0));
      v /= v[k];
      Vector gradient = Vector::Zero(result.base.size());  // of vᵀ M v, by the parameters
      for (std::size_t j = 0; j < joints; ++j) {
        gradient += v[static_cast<Index>(j)] * (W[j].transpose() * v);
      }
      const double inertia = gradient.dot(result.chi);
      const double sigma = std::sqrt(gradient.dot(result.C_chi * gradient));
      const double accelerates = log.motion.qdd.col(k).norm() / std::sqrt(static_cast<double>(log.size()));
      if (inertia < least * sigma && -inertia * accelerates > explained.residual[k]) {
        least = inertia / sigma;
        const Joint& joint = robot.joints[static_cast<std::size_t>(k)];
        subject = joint.name;
        text = "the mass matrix is not positive definite at " +
               number(log.log->t[log.samples[static_cast<std::size_t>(s)]], 4) + " s of " + log.log->source +
               ": vᵀ M v = " + number(inertia, 3) + " ± " + number(sigma, 2) +
               (joint.type == JointType::revolute ? " kg·m²" : " kg") + " in the direction of this joint";
      }
    }
  }
  if (!text.empty()) {
    out.add("not_physical", std::move(subject), std::move(text));
  }
}

}  // namespace

void check_physics(const TorqueProbe& probe, const Robot& robot, std::span<const Log> logs,
                   const Identification& result, Findings& out) {
  const Explained explained(probe, result.chi);
  check_parameters(result, explained, out);
  check_signs(robot, result, explained, out);
  if (!out.has("not_physical")) {
    check_mass_matrix(probe, robot, result, explained, out);
  }
  add_useless(explained, "", out);
  // What has a name explains a poor fit.
  if (out.any(Severity::error)) {
    return;
  }
  for (Index j = 0; j < robot.size(); ++j) {
    const bool clipped = std::ranges::any_of(
        logs, [&](const Log& log) { return out.has("torque_saturated", place(robot, logs, log, j)); });
    add_poor(robot, explained, j, clipped ? poor_where_clipped : poor, "", out);
  }
}

void check_poor_validation(const TorqueProbe& probe, const Robot& robot, const Validation& found,
                           const Identification& result, Findings& out) {
  const std::string where = found.file + ": ";
  const Explained explained(probe, result.answer());
  add_useless(explained, where, out);
  for (Index j = 0; j < robot.size(); ++j) {
    add_poor(robot, explained, j, poor, where, out);
  }
}

bool looks_poor(const Fit& fit) {
  return fit.relative_error > useless ||
         std::ranges::any_of(fit.joints, [](const JointFit& joint) { return joint.relative_error > poor; });
}

}  // namespace rivid::detail
