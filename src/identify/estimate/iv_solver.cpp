#include "identify/estimate/iv_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "dense.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Halvings of a step whose end can not be simulated.
constexpr int most_halvings = 5;
// Part of the parameter tolerance that counts as standing still.
constexpr double still = 0.2;
// A step counts as one of a cycle where it leads back to within this part of itself.
constexpr double cycle_return = 0.1;
// halvings of the step; a choice: an eighth that still goes to and fro does not settle
constexpr int most_dampings = 3;
// Parameters are moved by this part of their deviation for differences.
constexpr double difference_part = 0.1;

// Takes rows [V V'] of a joint, V' of a loop with other parameters; Σ Vᵀ (V' χ' − V χ).
class TorqueChangeSink final : public BufferedSink {
 public:
  TorqueChangeSink(Vector chi, Vector changed)
      : BufferedSink(2 * chi.size()),
        chi_(std::move(chi)),
        changed_(std::move(changed)),
        sum_(Vector::Zero(chi_.size())) {}

  void commit(std::span<const Index> samples) override {
    const Index own = chi_.size();
    const auto rows = rows_.topRows(static_cast<Index>(samples.size()));
    const auto V = rows.leftCols(own);
    sum_.noalias() += V.transpose() * (rows.rightCols(own) * changed_ - V * chi_);
  }
  [[nodiscard]] const Vector& sum() const { return sum_; }

 private:
  Vector chi_;
  Vector changed_;
  Vector sum_;
};

}  // namespace

IvSolver::IvSolver(const EstimationProblem& problem, Estimated& out, Iv::Compares compares)
    : problem_(problem),
      method_(problem.iv()),
      out_(out),
      compares_(compares),
      loops_(problem),
      instruments_(problem),
      weights_(problem.data.groups.size(), 1.0) {
  if (method_.weights == Iv::Weights::by_joint) {
    weights_ = joint_weights(problem);
  }
}

Vector IvSolver::start() const {
  if (base().load.chi.size() > 0) {
    return base().load.chi;
  }
  if (method_.chi_0.size() > 0) {
    return method_.chi_0;
  }
  switch (method_.start) {
    case Iv::Start::a_priori:
      return base().from_standard(problem_.robot.chi_st());
    case Iv::Start::least_squares:
      return least_squares(problem_.data.groups, base().size(), weights_).chi;
    case Iv::Start::regular:
      break;
  }
  return regular_start(problem_.robot, base());
}

bool IvSolver::iterate(Vector chi) {
  int dampings = 0;
  double part = 1.0;  // of a step that is taken
  for (int k = 0;; ++k) {
    std::string remark;
    const Vector wanted = chi;
    SimulatedLoops loops = loops_of(chi, remark);
    if (!loops.failure.empty()) {
      const std::string what = history_.empty() ? "the start" : "iterate " + std::to_string(history_.size());
      out_.status = loops.gave_up ? Status::gave_up : Status::not_simulable;
      out_.reasons.push_back(what + " can not be simulated: " + loops.failure +
                             (loops.gave_up ? "; simulation in [method] has the budgets" : ""));
      return false;
    }
    const std::vector<InstrumentalGroup> groups = solve_or_halve(loops, chi, remark);
    history_.push_back(told(chi, loops, groups));
    history_.back().safeguard = std::move(remark);
    if (!solution_.full_rank()) {
      explain_rank(base(), solution_.rank, solution_.undetermined,
                   "the instruments of iteration " + std::to_string(history_.size()), out_);
      std::ranges::move(locked_joints(problem_, loops, loops_.sums(loops)), std::back_inserter(out_.reasons));
      return false;
    }
    last_ = std::move(loops);
    if (!find_bread(chi)) {
      return false;
    }
    if (history_.size() > 1) {
      const IvIteration& before = history_[history_.size() - 2];
      history_.back().largest_step = step_in_sigmas(chi - before.chi);
      keep(chi);
      // An iterate that was moved has not come to rest by itself.
      if (chi == wanted && settled(before, part)) {
        return true;
      }
    }
    if (k == method_.max_iterations) {
      out_.status = Status::not_converged;
      out_.reasons.push_back("not converged after " + counted(method_.max_iterations, "iteration") +
                             ": parameters still move by " +
                             number_that_says(history_.back().largest_step, 3) + " standard deviations");
      return false;
    }
    Vector next = compares_ == Iv::Compares::torques ? newton_step(chi) : solution_.chi;
    if (part < 1.0) {
      next = chi + part * (next - chi);
    }
    if (cycles(next)) {
      if (step_in_sigmas(next - chi) <= part * method_.parameter_tolerance) {
        return true;  // there and back again, far within the deviations: signs that flip
      }
      if (++dampings > most_dampings) {
        out_.status = Status::cycling;
        out_.reasons.push_back("the iteration goes back and forth between two estimates, " +
                               number_that_says(history_.back().largest_step, 3) +
                               " standard deviations apart, and damping does not help");
        return false;
      }
      // Whole steps from there would lead it back to where it went to and fro.
      part *= 0.5;
      next = 0.5 * (next + chi);
      history_.back().safeguard += history_.back().safeguard.empty() ? "" : "; ";
      history_.back().safeguard += "steps are halved from here on, for the iteration went back and forth";
    }
    reweight(next);
    chi = std::move(next);
  }
}

bool IvSolver::iterate_again(const std::string& what) {
  solve(last_, &history_.back().chi);
  if (!solution_.full_rank()) {
    explain_rank(base(), solution_.rank, solution_.undetermined, what, out_);
    return false;
  }
  Vector chi = solution_.chi;
  reweight(chi);
  return iterate(std::move(chi));
}

double IvSolver::step_in_sigmas(const Vector& step) const {
  const double sigma = deviation_of(solution_.chi);
  return (step.array() / (sigma * solution_.unit_covariance.diagonal().array().sqrt())).abs().maxCoeff();
}

bool IvSolver::stands_still(const Vector& step) const {
  return step_in_sigmas(step) <= still * method_.parameter_tolerance;
}

// The loop of the start knows nothing of friction yet, and its signs are little use.
bool IvSolver::simulated_signs() const {
  if (history_.empty() && method_.signs == Iv::Signs::automatic) {
    return false;
  }
  return method_.signs == Iv::Signs::simulated ||
         (method_.signs == Iv::Signs::automatic && problem_.estimation.signal.cutoff_hz == 0.0 &&
          !problem_.estimation.signal.exact_rows());
}

FromV IvSolver::from_V() const {
  if (compares_ == Iv::Compares::torques) {
    return FromV::all;
  }
  return simulated_signs() ? FromV::signs : FromV::none;
}

std::vector<InstrumentalGroup> IvSolver::factors(const SimulatedLoops& loops) {
  return instruments_.factors(loops_, loops, from_V());
}

SimulatedLoops IvSolver::simulated(const Vector& chi) const {
  return problem_.ask == nullptr ? loops_.simulated(chi, history_)
                                 : loops_.asked(chi, history_, from_V() == FromV::signs);
}

// The loops of an iterate, or of what takes its place.
SimulatedLoops IvSolver::loops_of(Vector& chi, std::string& remark) {
  SimulatedLoops loops = simulated(chi);
  const bool took_measured_signs =
      history_.size() == 1 && method_.signs == Iv::Signs::automatic && from_V() == FromV::signs;
  if (!loops.failure.empty() && !loops.gave_up && took_measured_signs) {
    // The signs of raw velocities may be noise alone: once more with those of the first loop.
    const InstrumentalVariables again = instrumental_variables(factors(last_), base().size(), weights_);
    if (again.full_rank()) {
      chi = again.chi;
      reweight(chi);
      loops = simulated(chi);
      remark = "with the signs of the first loop";
    }
  }
  const bool done = loops.failure.empty() || loops.gave_up;
  return done ? std::move(loops) : safeguarded(std::move(loops), chi, remark);
}

// In place of loops that could not be simulated: those with the nearest physical parameters, or on the way
// back to the last ones.
SimulatedLoops IvSolver::safeguarded(SimulatedLoops loops, Vector& chi, std::string& remark) {
  const std::string first_failure = loops.failure;
  loops = simulated(nearest_physical(chi));
  if (loops.failure.empty()) {
    remark = first_failure + "; simulated with the nearest physical parameters";
    return loops;
  }
  if (!history_.empty() && !loops.gave_up) {
    Vector step = chi - history_.back().chi;
    for (int halving = 1; halving <= most_halvings; ++halving) {
      step *= 0.5;
      chi = history_.back().chi + step;
      loops = simulated(chi);
      if (loops.failure.empty()) {
        remark = first_failure + "; the step was halved " + counted(halving, "time");
        return loops;
      }
      if (loops.gave_up) {
        return loops;
      }
    }
  }
  if (!loops.gave_up) {
    loops.failure = first_failure;
  }
  return loops;
}

// The physically consistent parameters that give the torques nearest to those of an iterate, along the
// measured motion.
Vector IvSolver::nearest_physical(const Vector& chi) const {
  const Matrix root = combined(instruments_.used(), base().size(), weights_).R();
  // The motion only has to be near the actual one: a body twice as heavy or half as heavy as described may
  // cost some per cent of the residual. Without that pull a link may end with next to no inertia, and gains
  // that follow it.
  constexpr double share_of_rows = 0.01;
  Physical options = problem_.estimation.physical.value_or(Physical{});
  options.weight = std::max(options.weight, share_of_rows * static_cast<double>(instruments_.rows()));
  return physical(problem_.robot, base(), chi, root, options).chi;
}

// Solves for the next iterate with the instruments of these loops. Rows that are weighted by their residuals
// are weighted and solved in turn, for these instruments.
//
// weighted_by  parameters whose residual gives the weights by joint; nullptr keeps these as they are
std::vector<InstrumentalGroup> IvSolver::solve(const SimulatedLoops& loops, const Vector* weighted_by) {
  std::vector<InstrumentalGroup> groups;
  const auto make_rows = [&] { groups = factors(loops); };
  Reweighting* const reweighting = instruments_.reweighting();
  if (reweighting == nullptr) {
    make_rows();
    if (weighted_by != nullptr) {
      reweight(*weighted_by);
    }
    solution_ = instrumental_variables(groups, base().size(), weights_);
    return groups;
  }
  reweighting->settle(make_rows, [&] {
    if (method_.weights == Iv::Weights::by_joint) {
      weights_ = reweighting->weights();
    }
    solution_ = instrumental_variables(groups, base().size(), weights_);
    const double sigma = robust_deviation(reweighting->sums(), reweighting->loss(), weights_);
    return Reweighting::Solution{solution_.chi, sigma * solution_.unit_covariance.diagonal().cwiseSqrt()};
  });
  return groups;
}

// The same, with instruments of loops on the way back to the last iterate where these lack rank.
std::vector<InstrumentalGroup> IvSolver::solve_or_halve(SimulatedLoops& loops, Vector& chi,
                                                        std::string& remark) {
  std::vector<InstrumentalGroup> groups = solve(loops);
  // A step too far may hold a joint by its friction, where a shorter one does not.
  for (int halving = 1; !history_.empty() && !solution_.full_rank() && halving <= most_halvings; ++halving) {
    const Vector shorter = history_.back().chi + 0.5 * (chi - history_.back().chi);
    SimulatedLoops trial = simulated(shorter);
    if (!trial.failure.empty()) {
      break;
    }
    chi = shorter;
    loops = std::move(trial);
    groups = solve(loops);
    remark = "the step was halved " + counted(halving, "time") + ", for its instruments lacked rank";
  }
  return groups;
}

IvIteration IvSolver::told(const Vector& chi, const SimulatedLoops& loops,
                           std::span<const InstrumentalGroup> groups) const {
  IvIteration out;
  out.chi = chi;
  const Index n = problem_.joints();
  out.joint_error_norm = Vector(n);
  for (Index j = 0; j < n; ++j) {
    const InstrumentalGroup& group = groups[static_cast<std::size_t>(j)];
    out.joint_error_norm[j] = group.qr.residual_norm(chi(group.columns));
  }
  out.error_norm = out.joint_error_norm.norm();
  out.relative_error = out.error_norm / instruments_.y_norm();
  const LoopSums sums = loops_.sums(loops);
  out.to_measured = motion_error(sums.off_measured, sums.measured);
  out.to_reference = motion_error(sums.off_reference, sums.reference);
  out.J = loops.J;
  out.gains = loops.laws.front()->description().gains;
  out.condition_V = solution_.condition_V;
  out.condition_VW = solution_.condition_VW;
  out.effort = loops.effort;
  return out;
}

// Whether the last iterate, to which a part of a step led, is where the one before it was.
bool IvSolver::settled(const IvIteration& before, double part) const {
  const IvIteration& now = history_.back();
  const double change = std::abs(now.error_norm - before.error_norm);
  // Signs that flip keep ‖ε‖ from settling at all; steps far below the deviations are the end all the same.
  return (change <= method_.tolerance * before.error_norm &&
          now.largest_step <= part * method_.parameter_tolerance) ||
         now.largest_step <= part * still * method_.parameter_tolerance;
}

// Whether the step from χ̂_k to `next` takes back the step before.
bool IvSolver::cycles(const Vector& next) const {
  if (history_.size() < 3) {
    return false;
  }
  const Vector& now = history_.back().chi;
  const Vector& before = history_[history_.size() - 2].chi;
  return step_in_sigmas(next - before) < cycle_return * step_in_sigmas(next - now);
}

// The weights of the next iteration: from what this estimate leaves of each joint's rows.
void IvSolver::reweight(const Vector& chi) {
  // Weights that come with those of the rows are there already.
  if (method_.weights == Iv::Weights::none || instruments_.reweighting() != nullptr) {
    return;
  }
  for (std::size_t j = 0; j < weights_.size(); ++j) {
    weights_[j] = residual_weight(instruments_.used()[j], chi).value_or(weights_[j]);
  }
}

// This iterate is the estimate, unless a later one comes.
void IvSolver::keep(const Vector& chi) {
  const double sigma = deviation_of(chi);
  estimate_ = {.chi = chi,
               .weights = weights_,
               .rows = instruments_.rows(),
               .rank = base().size(),
               .condition = solution_.condition_VW,
               .sigma = sigma,
               .sigma_rho = sigma,
               .root = solution_.R_VW,
               .unit_covariance = unit_covariance(),
               .bread = bread_,
               .signals = instruments_.signals(),
               .loss = {},
               .instruments = EstimateInstruments{.motions = instruments_.motions(last_.motions),
                                                  .blocks = {},
                                                  .from_V = instruments_.from_V(),
                                                  .whitening = instruments_.whitening(),
                                                  .used = instruments_.used(),
                                                  .first_stage_F = first_stage_F()},
               .scores = {}};
  if (last_.found) {
    estimate_->instruments->blocks = last_.found->blocks;
  }
}

// Of errors that are independent, per unit of their variance.
Matrix IvSolver::unit_covariance() const {
  if (compares_ == Iv::Compares::instruments) {
    return solution_.unit_covariance;
  }
  const Matrix half = solution_.R_VV * bread_.transpose();
  return half.transpose() * half;
}

double IvSolver::deviation_of(const Vector& chi) const {
  return deviation(residual(instruments_.used(), chi, weights_), instruments_.freedom(),
                   problem_.estimation.signal.convention);
}

// bread_ of the iterate whose loops were simulated last; false where there is none.
bool IvSolver::find_bread(const Vector& chi) {
  bread_ = bread_of(solution_);
  if (compares_ != Iv::Compares::torques) {
    return true;
  }
  const Index b = base().size();
  const std::vector<Motion> V = instruments_.motions(last_.motions);
  const Vector steps = difference_part * deviation_of(chi) * solution_.unit_covariance.diagonal().cwiseSqrt();
  Matrix A = Matrix::Zero(b, b);  // Vᵀ Ω⁻¹ ∂(V χ)/∂χ
  for (Index first = 0; first < b; first += loops_.worthwhile()) {
    const std::vector<Vector> changed =
        changed_one_by_one(chi, steps, first, std::min(loops_.worthwhile(), b - first));
    const std::vector<SimulatedLoops> loops = loops_.simulated(changed, history_);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      if (!loops[i].failure.empty()) {
        out_.status = loops[i].gave_up ? Status::gave_up : Status::not_simulable;
        out_.reasons.push_back("parameters near iterate " + std::to_string(history_.size() - 1) +
                               " can not be simulated: " + loops[i].failure);
        return false;
      }
      const Index at = first + static_cast<Index>(i);
      A.col(at) = torque_slope(V, chi, instruments_.motions(loops[i].motions), changed[i], steps[at]);
    }
  }
  bread_ = detail::solve(A, Matrix::Identity(b, b));
  return true;
}

// Vᵀ Ω⁻¹ (V' χ' − V χ) / step.
Vector IvSolver::torque_slope(std::span<const Motion> V, const Vector& chi, std::span<const Motion> V_changed,
                              const Vector& changed, double step) const {
  Vector out = Vector::Zero(base().size());
  for (std::size_t k = 0; k < problem_.logs.size(); ++k) {
    RowSource source(problem_.robot, base(), problem_.logs[k], instruments_.signals()[k], *problem_.team);
    const JointSinks<TorqueChangeSink> sinks(source.joints(), [&](std::size_t j) {
      return TorqueChangeSink(chi(source.columns(j)), changed(source.columns(j)));
    });
    source.send_others(sinks.sinks(), std::array{V[k], V_changed[k]});
    for (std::size_t j = 0; j < source.joints(); ++j) {
      out(source.columns(j)) += weights_[j] * weights_[j] / step * sinks[j].sum();
    }
  }
  return out;
}

// Where Vᵀ Ω⁻¹ (Y − V χ) is zero as far as the derivative of V χ tells.
Vector IvSolver::newton_step(const Vector& chi) const {
  const Matrix& R = solution_.R_VV;
  return chi + bread_ * (R.transpose() * (R * (solution_.chi - chi)));
}

// R_VW⁻¹ R_VV⁻ᵀ.
Matrix bread_of(const InstrumentalVariables& solution) {
  const Index b = solution.R_VV.rows();
  return solve(solution.R_VW,
               solution.R_VV.transpose().triangularView<Eigen::Lower>().solve(Matrix::Identity(b, b)));
}

// Strength of the instruments, parameter by parameter: R² of Shea (1997), the variance that least squares
// would have on the same rows over that of the instrumental variables, as the F statistic of a first stage.
// Empty where W is V itself.
Vector IvSolver::first_stage_F() const {
  if (from_V() == FromV::all) {
    return {};
  }
  const LeastSquares ls = least_squares(instruments_.used(), base().size(), weights_);
  Vector F(base().size());
  for (Index i = 0; i < F.size(); ++i) {
    const double R2 = std::min(ls.unit_covariance(i, i) / solution_.unit_covariance(i, i), 1.0);
    F[i] = instruments_.freedom() * R2 / std::max(1.0 - R2, std::numeric_limits<double>::epsilon());
  }
  return F;
}

}  // namespace rivid::detail
