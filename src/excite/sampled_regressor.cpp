#include "excite/sampled_regressor.hpp"

#include <algorithm>
#include <array>
#include <unsupported/Eigen/AutoDiff>

namespace rivid::detail {

namespace {

using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 1, 1>>;

SlopeTarget target_of(Slopes& slopes) {
  return {slopes.q.data(), slopes.qd.data(), slopes.qdd.data(), slopes.q.rows()};
}

// The first samples, and the last one again where these are not enough.
Matrix stretched(const Matrix& x, Index samples) {
  Matrix out(samples, x.cols());
  out.topRows(x.rows()) = x;
  out.bottomRows(samples - x.rows()).rowwise() = x.row(x.rows() - 1);
  return out;
}

void cut(Slopes& slopes, Index samples) {
  for (Matrix* const x : {&slopes.q, &slopes.qd, &slopes.qdd}) {
    x->conservativeResize(samples, Eigen::NoChange);
  }
}

}  // namespace

void Slopes::resize(Index samples, Index joints) {
  for (Matrix* const x : {&q, &qd, &qdd}) {
    x->resize(samples, joints);
  }
}

SampledRegressor::SampledRegressor(const Robot& robot, const BaseParameters& base)
    : batch_(robot, base.columns()),
      workspace_(batch_),
      columns_(robot, base.columns()),
      places_(columns_.entries().begin(), columns_.entries().end()),
      link_entries_(places_.size() - columns_.plan().own_count),
      kernel_(&kernel_for<SlopesKernel>()),
      scratch_(aligned_doubles(kernel_->scratch(columns_.plan().joints, columns_.plan().forks))) {
  for (const RegressorColumns::FoldedEntry& folded : columns_.folded()) {
    for (const auto& [e, factor] : folded.terms) {
      places_[e] = folded.to;
    }
  }
}

void SampledRegressor::rows(const Motion& motion, std::vector<Matrix>& W) {
  const Index N = motion.samples();
  std::vector<RowsTarget> targets;
  W.resize(batch_.joints());
  for (std::size_t i = 0; i < W.size(); ++i) {
    W[i].resize(N, std::ssize(columns(i)));
    targets.push_back({W[i].data(), N});
  }
  batch_.fill(motion, 0, N, targets, 0, workspace_);
}

void SampledRegressor::pieces(const Motion& motion,
                              const std::function<void(Index first, std::span<const Matrix> W)>& take) {
  constexpr Index piece = 256;  // samples; a choice that bounds the memory
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

void SampledRegressor::slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi,
                              Slopes& of_sum, std::vector<Slopes>& of_torque) {
  of_torque.resize(chi.size() > 0 ? batch_.joints() : 0);
  if (columns_.dependence().bends()) {
    bent_slopes(motion, G, chi, of_sum, of_torque);
    return;
  }
  const Index N = motion.samples();
  const Index lanes = kernel_->lanes;
  const Index whole = (N + lanes - 1) / lanes * lanes;
  if (whole == N) {
    link_slopes(motion, G, chi, of_sum, of_torque);
  } else {
    std::vector<Matrix> longer;
    std::ranges::transform(G, std::back_inserter(longer),
                           [&](const Matrix& x) { return stretched(x, whole); });
    link_slopes({.q = stretched(motion.q, whole),
                 .qd = stretched(motion.qd, whole),
                 .qdd = stretched(motion.qdd, whole)},
                longer, chi, of_sum, of_torque);
    cut(of_sum, N);
    std::ranges::for_each(of_torque, [&](Slopes& slopes) { cut(slopes, N); });
  }
  add_own_slopes(motion, G, chi, of_sum, of_torque);
  add_motor_slopes(motion, G, chi, of_sum, of_torque);
}

// Where G of the dependence follows the motion, too: by dual numbers, one for each quantity of each joint.
void SampledRegressor::bent_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi,
                                   Slopes& of_sum, std::vector<Slopes>& of_torque) const {
  const auto clear = [&](Slopes& slopes) {
    slopes.q = slopes.qd = slopes.qdd = Matrix::Zero(motion.samples(), joints());
  };
  clear(of_sum);
  std::ranges::for_each(of_torque, clear);
  RegressorWorkspace<Dual> workspace(columns_);
  std::array<std::vector<Dual>, 3> state;
  state.fill(std::vector<Dual>(batch_.joints()));
  const std::array<const Matrix*, 3> values = {&motion.q, &motion.qd, &motion.qdd};
  const std::array<Matrix Slopes::*, 3> parts = {&Slopes::q, &Slopes::qd, &Slopes::qdd};
  for (Index k = 0; k < motion.samples(); ++k) {
    for (std::size_t part = 0; part < parts.size(); ++part) {
      for (Index j = 0; j < joints(); ++j) {
        state[part][static_cast<std::size_t>(j)] = Dual((*values[part])(k, j), Dual::DerType::Zero());
      }
    }
    for (std::size_t part = 0; part < parts.size(); ++part) {
      for (Index j = 0; j < joints(); ++j) {
        Dual& moved = state[part][static_cast<std::size_t>(j)];
        moved.derivatives().setOnes();
        columns_.rows(State<Dual>{state[0], state[1], state[2]}, workspace,
                      [&](std::size_t i, Index column, const Dual& value) {
                        const double slope = value.derivatives()[0];
                        (of_sum.*parts[part])(k, j) += G[i](k, column) * slope;
                        if (!of_torque.empty()) {
                          (of_torque[i].*parts[part])(k, j) +=
                              chi[columns(i)[static_cast<std::size_t>(column)]] * slope;
                        }
                      });
        moved.derivatives().setZero();
      }
    }
  }
}

// Values of the parameters that the links' entries belong to; those that are in no row are zero.
std::vector<double> SampledRegressor::by_link(const Vector& chi) const {
  const RegressorPlan plan = columns_.plan();
  std::vector<double> out(10 * plan.joints, 0.0);
  std::size_t e = 0;
  for (std::size_t j = 0; j < plan.joints; ++j) {
    // The rows of all joints on the way to it have the same parameters of the link.
    const std::size_t first = e;
    for (std::size_t k = 0; k < 10; ++k) {
      if ((plan.links[j].mask >> k & 1U) != 0U) {
        const RegressorColumns::Entry& entry = places_[e++];
        out[10 * j + k] = chi[columns(entry.joint)[static_cast<std::size_t>(entry.column)]];
      }
    }
    e = first + (e - first) * static_cast<std::size_t>(plan.links[j].depth + 1);
  }
  return out;
}

// Of whole packs of samples.
void SampledRegressor::link_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi,
                                   Slopes& of_sum, std::vector<Slopes>& of_torque) {
  const Index N = motion.samples();
  const auto links = static_cast<Index>(columns_.plan().joints);
  RegressorInput<double> input = {motion.q.data(),        motion.qd.data(),        motion.qdd.data(),
                                  motion.q.outerStride(), motion.qd.outerStride(), motion.qdd.outerStride()};
  std::vector<const double*> entries;
  for (const RegressorColumns::Entry& entry : std::span(places_).first(link_entries_)) {
    entries.push_back(G[entry.joint].col(entry.column).data());
  }
  // Where joints depend on others, all of it is of the links' joints at first.
  std::vector<double> moved;
  Matrix weights;
  Slopes sum_of_links;
  std::vector<Slopes> torques_of_links;
  const bool dependent = !columns_.dependence().empty();
  if (dependent) {
    moved.resize(columns_.dependence().memory(static_cast<std::size_t>(N)));
    input = columns_.expanded(input, 0, N, moved.data());
    weights = Matrix::Zero(N, static_cast<Index>(places_.size()));
    for (const RegressorColumns::FoldedEntry& folded : columns_.folded()) {
      for (const auto& [e, term] : folded.terms) {
        weights.col(static_cast<Index>(e)) +=
            columns_.dependence().terms[term].factor * G[folded.to.joint].col(folded.to.column);
      }
    }
    for (std::size_t e = 0; e < entries.size(); ++e) {
      entries[e] = weights.col(static_cast<Index>(e)).data();
    }
    torques_of_links.resize(of_torque.empty() ? 0 : columns_.plan().joints);
  }
  Slopes& sum = dependent ? sum_of_links : of_sum;
  std::vector<Slopes>& torques = dependent ? torques_of_links : of_torque;
  std::vector<SlopeTarget> targets;
  for (Slopes& slopes : torques) {
    slopes.resize(N, links);
    targets.push_back(target_of(slopes));
  }
  sum.resize(N, links);
  const std::vector<double> values = of_torque.empty() ? std::vector<double>() : by_link(chi);
  const SlopesTask task{.plan = columns_.plan(),
                        .input = input,
                        .G = entries.data(),
                        .of_sum = target_of(sum),
                        .chi = values.empty() ? nullptr : values.data(),
                        .of_torque = targets.data()};
  kernel_->fill(task, static_cast<std::size_t>(N / kernel_->lanes), scratch_.get());
  if (dependent) {
    fold(sum_of_links, torques_of_links, of_sum, of_torque);
  }
}

// Derivatives by the motion of the robot's joints from those by the motion of all links', of the torques Gᵀ
// τ.
void SampledRegressor::fold(const Slopes& sum, std::span<const Slopes> torques, Slopes& of_sum,
                            std::vector<Slopes>& of_torque) const {
  const Index N = sum.q.rows();
  const auto add = [&](const Slopes& from, double factor, Slopes& to) {
    for (const Dependence::Term& term : columns_.dependence().terms) {
      for (Matrix Slopes::* const part : {&Slopes::q, &Slopes::qd, &Slopes::qdd}) {
        (to.*part).col(term.joint) += factor * term.factor * (from.*part).col(term.link);
      }
    }
  };
  const auto clear = [&](Slopes& slopes) { slopes.q = slopes.qd = slopes.qdd = Matrix::Zero(N, joints()); };
  clear(of_sum);
  add(sum, 1.0, of_sum);
  std::ranges::for_each(of_torque, clear);
  for (const Dependence::Term& term : columns_.dependence().terms) {
    if (!of_torque.empty()) {
      add(torques[static_cast<std::size_t>(term.link)], term.factor,
          of_torque[static_cast<std::size_t>(term.joint)]);
    }
  }
}

void SampledRegressor::add_own_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi,
                                      Slopes& of_sum, std::vector<Slopes>& of_torque) const {
  const RegressorPlan plan = columns_.plan();
  for (std::size_t e = 0; e < plan.own_count; ++e) {
    const OwnEntry& own = plan.own[e];
    const RegressorColumns::Entry& entry = places_[link_entries_ + e];
    const auto joint = static_cast<Index>(entry.joint);
    const bool by_acceleration = own.basis == Basis::acceleration;
    if (own.basis == Basis::one) {
      continue;
    }
    Vector slope = Vector::Ones(motion.samples());
    for (Index k = 0; !by_acceleration && k < slope.size(); ++k) {
      const Dual speed(motion.qd(k, joint), Dual::DerType::Ones());
      slope[k] = friction_entry(own.basis, own.direction, speed, own.sign_speed).derivatives()[0];
    }
    Matrix Slopes::* const member = by_acceleration ? &Slopes::qdd : &Slopes::qd;
    (of_sum.*member).col(joint) += G[entry.joint].col(entry.column).cwiseProduct(slope);
    if (!of_torque.empty()) {
      (of_torque[entry.joint].*member).col(joint) +=
          chi[columns(entry.joint)[static_cast<std::size_t>(entry.column)]] * slope;
    }
  }
}

void SampledRegressor::add_motor_slopes(const Motion& motion, std::span<const Matrix> G, const Vector& chi,
                                        Slopes& of_sum, std::vector<Slopes>& of_torque) const {
  const std::size_t n = batch_.joints();
  const std::vector<Dual> none(n, Dual(0.0));
  std::vector<Dual> qd(n);
  std::vector<Dual> qdd(n);
  const auto add_entry = [&](std::size_t i, const RegressorColumns::MotorEntry& motor, Index k) {
    const bool by_acceleration = motor.entry.quantity == CoupledEntry::Quantity::acceleration;
    Matrix Slopes::* const member = by_acceleration ? &Slopes::qdd : &Slopes::qd;
    std::vector<Dual>& moved = by_acceleration ? qdd : qd;
    for (const CoupledEntry::Term& term : motor.entry.terms) {
      const auto joint = static_cast<Index>(term.joint);
      moved[term.joint].derivatives().setOnes();
      const double slope =
          RegressorColumns::coupled_value<Dual>(motor.entry, {none, qd, qdd}).derivatives()[0];
      moved[term.joint].derivatives().setZero();
      (of_sum.*member)(k, joint) += G[i](k, motor.column) * slope;
      if (!of_torque.empty()) {
        (of_torque[i].*member)(k, joint) += chi[columns(i)[static_cast<std::size_t>(motor.column)]] * slope;
      }
    }
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::span<const RegressorColumns::MotorEntry> motors = columns_.of_motors(i);
    for (Index k = 0; !motors.empty() && k < motion.samples(); ++k) {
      for (std::size_t j = 0; j < n; ++j) {
        qd[j] = Dual(motion.qd(k, static_cast<Index>(j)), Dual::DerType::Zero());
        qdd[j] = Dual(motion.qdd(k, static_cast<Index>(j)), Dual::DerType::Zero());
      }
      for (const RegressorColumns::MotorEntry& motor : motors) {
        add_entry(i, motor, k);
      }
    }
  }
}

}  // namespace rivid::detail
