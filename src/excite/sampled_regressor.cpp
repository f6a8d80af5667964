#include "excite/sampled_regressor.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <numbers>
#include <unsupported/Eigen/AutoDiff>

namespace rivid::detail {

namespace {

// Samples whose rows stay in the first caches.
constexpr Index block_samples = 64;

using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 1, 1>>;

// A step of a difference and what its rows are weighted with.
struct Step {
  double shift;
  double weight;
};

// Exact where rows are a₀ + a₁ cos q + b₁ sin q + a₂ cos 2q + b₂ sin 2q.
constexpr double quarter = std::numbers::pi / 4.0;
constexpr double of_second = 0.5 * (1.0 - std::numbers::sqrt2);
constexpr std::array<Step, 4> trigonometric = {
    {{quarter, 1.0}, {-quarter, -1.0}, {2.0 * quarter, of_second}, {-2.0 * quarter, -of_second}}};
// Exact where they are quadratic.
constexpr std::array<Step, 2> quadratic = {{{1.0, 0.5}, {-1.0, -0.5}}};

// The motor that several joints turn whose parameter this is.
const Coupling* motor_of(const Robot& robot, const StandardParameter& p) {
  const auto is_its = [&](const Coupling& coupling) {
    const bool tied = p.kind == ParameterKind::Ia && coupling.inertia == Coupling::Inertia::tied;
    return coupling.motor == p.joint && (about(p.kind).coupled || tied);
  };
  const auto found = std::ranges::find_if(robot.couplings, is_its);
  return found == robot.couplings.end() ? nullptr : &*found;
}

bool is_of_links(const Robot& robot, const StandardParameter& p) {
  return role(p.kind) == Role::inertial || (role(p.kind) == Role::rotor && motor_of(robot, p) == nullptr);
}

// Those of links first, first + 1 … that the kernels make.
std::vector<StandardParameter> parameters_from(const Robot& robot, std::span<const StandardParameter> all,
                                               Index first) {
  std::vector<StandardParameter> out;
  std::ranges::copy_if(all, std::back_inserter(out),
                       [&](const StandardParameter& p) { return p.joint >= first && is_of_links(robot, p); });
  return out;
}

Robot without_gravity(Robot robot) {
  robot.chain.gravity.setZero();
  return robot;
}

}  // namespace

void Slopes::set_zero(Index samples, Index joints) {
  q.setZero(samples, joints);
  qd.setZero(samples, joints);
  qdd.setZero(samples, joints);
}

SampledRegressor::SampledRegressor(const Robot& robot, const BaseParameters& base)
    : size_(base.size()),
      columns_(robot.joints.size()),
      block_rows_(robot.joints.size()),
      block_targets_(robot.joints.size()) {
  const std::vector<StandardParameter> all = base.columns();
  std::vector<Index> of_links;
  for (Index c = 0; c < size_; ++c) {
    if (is_of_links(robot, all[static_cast<std::size_t>(c)])) {
      of_links.push_back(c);
    }
  }
  const Robot weightless = without_gravity(robot);
  for (Index k = 0; k < robot.size(); ++k) {
    const std::vector<StandardParameter> parameters = parameters_from(robot, all, k);
    const RegressorBatch batch(robot, parameters);
    const RegressorBatch no_gravity(weightless, parameters);
    branches_.push_back({batch,
                         no_gravity,
                         BatchWorkspace(batch),
                         BatchWorkspace(no_gravity),
                         {},
                         {},
                         robot.chain.links[static_cast<std::size_t>(k)].type == JointType::revolute});
  }
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    for (const Index c : branches_.front().batch.of_joint(i)) {
      columns_[i].push_back(of_links[static_cast<std::size_t>(c)]);
    }
    link_columns_.push_back(std::ssize(columns_[i]));
    for (Branch& branch : branches_) {
      branch.widths.push_back(std::ssize(branch.batch.of_joint(i)));
      branch.skipped.push_back(link_columns_[i] - branch.widths.back());
    }
    block_rows_[i].resize(block_samples, link_columns_[i]);
    block_targets_[i] = {block_rows_[i].data(), block_samples};
  }
  for (Index c = 0; c < size_; ++c) {
    if (!is_of_links(robot, all[static_cast<std::size_t>(c)])) {
      add_direct(robot, all[static_cast<std::size_t>(c)], c);
    }
  }
}

void SampledRegressor::add_direct(const Robot& robot, const StandardParameter& parameter, Index column) {
  const auto add = [&](std::size_t joint, std::optional<CoupledEntry> coupled) {
    const double sign_speed = robot.joints[static_cast<std::size_t>(parameter.joint)].sign_speed;
    direct_.push_back({joint, std::ssize(columns_[joint]), parameter, sign_speed, std::move(coupled)});
    columns_[joint].push_back(column);
  };
  const Coupling* const coupling = motor_of(robot, parameter);
  if (coupling == nullptr) {
    add(static_cast<std::size_t>(parameter.joint), std::nullopt);
    return;
  }
  for (CoupledEntry& entry : coupled_entries(*coupling, parameter.kind, robot.size())) {
    entry.sign_speed = robot.joints[static_cast<std::size_t>(parameter.joint)].sign_speed;
    for (CoupledEntry::Term& term : entry.terms) {
      term.sign_speed = robot.joints[term.joint].sign_speed;
    }
    const std::size_t joint = entry.joint;
    add(joint, std::move(entry));
  }
}

void SampledRegressor::rows(const Motion& motion, std::vector<Matrix>& W) {
  const Index N = motion.samples();
  std::vector<RowsTarget> targets;
  W.resize(columns_.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    W[i].resize(N, std::ssize(columns_[i]));
    targets.push_back({W[i].data(), N});
  }
  branches_.front().batch.fill(motion, 0, N, targets, 0, branches_.front().workspace);
  std::vector<double> none(columns_.size(), 0.0);
  std::vector<double> qd(columns_.size());
  std::vector<double> qdd(columns_.size());
  for (const DirectEntry& e : direct_) {
    for (Index k = 0; k < N; ++k) {
      double& value = W[e.joint](k, e.column);
      if (!e.coupled) {
        value = friction_entry(e.parameter.kind, motion.qd(k, static_cast<Index>(e.joint)), e.sign_speed);
        continue;
      }
      for (std::size_t j = 0; j < columns_.size(); ++j) {
        qd[j] = motion.qd(k, static_cast<Index>(j));
        qdd[j] = motion.qdd(k, static_cast<Index>(j));
      }
      value = RegressorColumns::coupled_value<double>(*e.coupled, {none, qd, qdd});
    }
  }
}

void SampledRegressor::pieces(const Motion& motion,
                              const std::function<void(Index first, std::span<const Matrix> W)>& take) {
  constexpr Index piece = 256;
  std::vector<Matrix> W;
  for (Index first = 0; first < motion.samples(); first += piece) {
    const Index count = std::min(piece, motion.samples() - first);
    rows({.q = motion.q.middleRows(first, count),
          .qd = motion.qd.middleRows(first, count),
          .qdd = motion.qdd.middleRows(first, count)},
         W);
    take(first, W);
  }
}

struct SampledRegressor::Sums {
  std::span<const Matrix> G;
  Index first;              // sample of G and of the sums that the block begins at
  std::vector<Vector> chi;  // by joint, of its columns; empty: not wanted
  double* of_sum = nullptr;
  std::vector<double*> of_torque;
};

void SampledRegressor::sweep(const RegressorBatch& batch, const Branch& branch, BatchWorkspace& workspace,
                             const Motion& motion, Index count, double weight, const Sums& sums) {
  batch.fill(motion, 0, count, block_targets_, 0, workspace);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const bool torques = !sums.chi.empty();
    std::array<double, block_samples> torque{};
    std::array<double, block_samples> sum{};
    for (Index c = 0; c < branch.widths[i]; ++c) {
      const Index column = branch.skipped[i] + c;
      const double* const W = block_rows_[i].data() + c * block_samples;
      const double* const G = sums.G[i].data() + column * sums.G[i].rows() + sums.first;
      const double chi = torques ? sums.chi[i][column] : 0.0;
      for (std::size_t s = 0; s < static_cast<std::size_t>(count); ++s) {
        sum[s] += G[s] * W[s];
        torque[s] += chi * W[s];
      }
    }
    for (std::size_t s = 0; s < static_cast<std::size_t>(count); ++s) {
      sums.of_sum[s] += weight * sum[s];
      if (torques) {
        sums.of_torque[i][s] += weight * torque[s];
      }
    }
  }
}

void SampledRegressor::slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi,
                              Slopes& of_sum, std::vector<Slopes>& of_torque) {
  const Index N = motion.samples();
  const Index n = joints();
  of_sum.set_zero(N, n);
  Sums sums{.G = G, .first = 0, .chi = {}, .of_torque = std::vector<double*>(columns_.size(), nullptr)};
  if (chi.size() > 0) {
    of_torque.resize(columns_.size());
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      of_torque[i].set_zero(N, n);
      sums.chi.emplace_back(chi(columns_[i]));
    }
  }
  const auto into = [&](Matrix Slopes::* member, Index k) {
    sums.of_sum = (of_sum.*member).data() + k * N + sums.first;
    for (std::size_t i = 0; !sums.chi.empty() && i < columns_.size(); ++i) {
      sums.of_torque[i] = (of_torque[i].*member).data() + k * N + sums.first;
    }
  };
  Motion block;
  for (sums.first = 0; sums.first < N; sums.first += block_samples) {
    const Index count = std::min(block_samples, N - sums.first);
    block.q = motion.q.middleRows(sums.first, count);
    block.qd = motion.qd.middleRows(sums.first, count);
    block.qdd = motion.qdd.middleRows(sums.first, count);
    Motion at_rest{.q = block.q, .qd = Matrix::Zero(count, n), .qdd = Matrix::Zero(count, n)};
    for (Index k = 0; k < n; ++k) {
      Branch& branch = branches_[static_cast<std::size_t>(k)];
      const auto differ = [&](Matrix& moved, std::span<const Step> steps) {
        for (const Step& step : steps) {
          const Vector kept = moved.col(k);
          moved.col(k).array() += step.shift;
          sweep(branch.batch, branch, branch.workspace, block, count, step.weight, sums);
          moved.col(k) = kept;
        }
      };
      into(&Slopes::q, k);
      differ(block.q,
             branch.revolute ? std::span<const Step>(trigonometric) : std::span<const Step>(quadratic));
      into(&Slopes::qd, k);
      differ(block.qd, quadratic);
      into(&Slopes::qdd, k);
      at_rest.qdd.col(k).setOnes();
      sweep(branch.weightless, branch, branch.weightless_workspace, at_rest, count, 1.0, sums);
      at_rest.qdd.col(k).setZero();
    }
  }
  direct_slopes(motion, G, chi, of_sum, of_torque);
}

void SampledRegressor::direct_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi,
                                     Slopes& of_sum, std::vector<Slopes>& of_torque) const {
  const std::size_t n = columns_.size();
  const Dual::DerType one = Dual::DerType::Ones();
  std::vector<Dual> none(n, Dual(0.0));
  std::vector<Dual> qd(n);
  std::vector<Dual> qdd(n);
  for (const DirectEntry& e : direct_) {
    const double value = chi.size() > 0 ? chi[columns_[e.joint][static_cast<std::size_t>(e.column)]] : 0.0;
    const auto add = [&](Matrix Slopes::* member, Index sample, std::size_t joint, double slope) {
      const auto k = static_cast<Index>(joint);
      (of_sum.*member)(sample, k) += G[e.joint](sample, e.column) * slope;
      if (chi.size() > 0) {
        (of_torque[e.joint].*member)(sample, k) += value * slope;
      }
    };
    for (Index k = 0; k < motion.samples(); ++k) {
      if (!e.coupled) {
        const Dual speed(motion.qd(k, static_cast<Index>(e.joint)), one);
        const Dual entry = friction_entry(e.parameter.kind, speed, e.sign_speed);
        add(&Slopes::qd, k, e.joint, entry.derivatives()[0]);
        continue;
      }
      for (std::size_t j = 0; j < n; ++j) {
        qd[j] = Dual(motion.qd(k, static_cast<Index>(j)));
        qdd[j] = Dual(motion.qdd(k, static_cast<Index>(j)));
      }
      const bool by_acceleration = e.coupled->quantity == CoupledEntry::Quantity::acceleration;
      std::vector<Dual>& moved = by_acceleration ? qdd : qd;
      for (const CoupledEntry::Term& term : e.coupled->terms) {
        moved[term.joint].derivatives() = one;
        const Dual entry = RegressorColumns::coupled_value<Dual>(*e.coupled, {none, qd, qdd});
        add(by_acceleration ? &Slopes::qdd : &Slopes::qd, k, term.joint, entry.derivatives()[0]);
        moved[term.joint].derivatives().setZero();
      }
    }
  }
}

}  // namespace rivid::detail
