#include "identify/estimate/closed_loops.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "dense.hpp"
#include "identify/estimate/fitting_factors.hpp"
#include "identify/rows/factors.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/text.hpp"
#include "simulate/simulation_group.hpp"

namespace rivid::detail {

namespace {

// Stretch of the log from which its first position and velocity are estimated [s], and the samples it takes
// at least.
constexpr double start_stretch = 0.05;
constexpr Index fewest_samples = 7;

// Position and velocity at the first sample: parabolas through the first positions, which noise moves little.
void measured_start(const Log& log, Vector& q, Vector& qd) {
  const auto wanted = std::max(fewest_samples, static_cast<Index>(start_stretch * log.f_m));
  const Index m = std::min(wanted, log.samples());
  Matrix powers(m, 3);
  for (Index k = 0; k < m; ++k) {
    const double t = static_cast<double>(k) / log.f_m;
    powers.row(k) << 1.0, t, t * t;
  }
  const Matrix coefficients = least_squares_solution(powers, log.q.topRows(m));
  q = coefficients.row(0);
  qd = coefficients.row(1);
}

Matrix filtered(const Log& log, double cutoff_hz, const SignalOptions& signal) {
  return cutoff_hz > 0.0 ? zero_phase(log.q, log.f_m, cutoff_hz, signal.order, signal.convention) : log.q;
}

// Time of the simulation: from zero, at the sampling rate of the log, whose own time stamps may begin at an
// epoch.
Vector instants(const Log& log) {
  return Vector::NullaryExpr(log.samples(), [&](Index k) { return static_cast<double>(k) / log.f_m; });
}

std::unique_ptr<Reference> reference_of(const Log& log, const SignalOptions& signal, const Iv& method) {
  if (method.follows == Iv::Follows::measured) {
    const double cutoff_hz = method.reference_cutoff_hz > 0.0 ? method.reference_cutoff_hz : signal.cutoff_hz;
    return std::make_unique<LoggedReference>(instants(log), filtered(log, cutoff_hz, signal));
  }
  if (log.q_r.size() == 0) {
    throw InputError(
        log.source +
        ": no reference columns, which the simulated loop must follow; name them, or let the filtered "
        "measured positions stand in for them");
  }
  return std::make_unique<LoggedReference>(instants(log), log.q_r);
}

// Steps that the integrator may take with one iterate: so many times the most that an earlier one took, and
// so many a sample. Near a mass matrix that is not positive definite there is no end to them.
constexpr Index most_times_the_steps = 20;
constexpr Index most_steps_a_sample = 10;

Index step_budget(Index samples, Index steps_before) {
  return steps_before > 0 ? most_times_the_steps * steps_before + most_steps_a_sample * samples
                          : std::numeric_limits<Index>::max();
}

Index most_steps_of(std::span<const IvIteration> earlier) {
  Index most = 0;
  for (const IvIteration& iteration : earlier) {
    most = std::max(most, iteration.effort.steps);
  }
  return most;
}

// Position error [rad | m] from which a law's stiffness is computed: too small to saturate it.
constexpr double dead_band_probe = 1e-6;
// Of an unknown gain: it keeps its sign.
constexpr double least_factor = 1e-3;
// A joint that moves in a smaller part of the samples counts as locked.
constexpr double locked_part = 0.05;

// How far a joint's position must be off before a proportional law overcomes its friction: Fc / (ω_n² J) for
// PD (40).
std::string dead_band(const Robot& robot, const SimulatedLoops& loops, Index j) {
  const Index n = robot.size();
  const Vector none = Vector::Zero(n);
  const ControlLaw& law = *loops.laws.front();
  const Vector x = Vector::Zero(law.states());
  Vector xd = x;
  Vector v(n);
  Vector v_0(n);
  law.control({0.0, none, none, none, none, none}, x, v_0, xd);
  law.control({0.0, none, none, Vector::Unit(n, j) * dead_band_probe, none, none}, x, v, xd);
  const double stiffness = (robot.drive_matrix() * (v - v_0))[j] / dead_band_probe;
  const double Fc = sum_of(loops.model->dry_friction(), [&](const DryFriction& element) {
    return element.direction[j] != 0.0 ? 0.5 * (element.Fc_plus + element.Fc_minus) : 0.0;
  });
  if (!(stiffness > 0.0) || Fc == 0.0) {
    return "";
  }
  return ", which holds it within " + number(Fc / stiffness, 3) + " of its reference";
}

Direction opposite(Direction direction) {
  switch (direction) {
    case Direction::positive:
      return Direction::negative;
    case Direction::negative:
      return Direction::positive;
    case Direction::both:
      break;
  }
  return Direction::both;
}

// Standard parameters whose friction brakes: where Fv or Fc of a joint is negative it becomes zero, and the
// other one takes over its torque as well as it can along a motion, by least squares over Fv |q̇| + Fc.
// (Early iterates trade one for the other; the simulation could only leave the negative one out, and the
// positive one alone may hold the joint fast.)
//
// chi_st      (N_s) values of base.standard
// mean_speed  mean |q̇| of each joint along the motion, (n)
// mean_square mean q̇², (n)
void make_dissipative(const BaseParameters& base, const Vector& mean_speed, const Vector& mean_square,
                      Vector& chi_st) {
  const auto find = [&](Basis basis, Direction direction, int joint) {
    const auto at = std::ranges::find_if(base.standard, [&](const StandardParameter& p) {
      const KindRow& row = about(p.kind);
      return p.joint == joint && row.basis == basis && row.direction == direction && !row.coupled;
    });
    return at == base.standard.end() ? nullptr : &chi_st[at - base.standard.begin()];
  };
  for (int joint = 0; joint < static_cast<int>(mean_speed.size()); ++joint) {
    for (const Direction direction : {Direction::both, Direction::positive, Direction::negative}) {
      double* const v = find(Basis::speed, direction, joint);
      double* const c = find(Basis::sign, direction, joint);
      if (v == nullptr || c == nullptr) {
        continue;
      }
      if (*v < 0.0) {
        *c += *v * mean_speed[joint];
        *v = 0.0;
      }
      // Asymmetric friction may be shifted by an offset: its mean decides whether it dissipates.
      const double* const other = find(Basis::sign, opposite(direction), joint);
      if (*c < 0.0 && (other == nullptr || *c + *other < 0.0)) {
        *v += mean_square[joint] > 0.0 ? *c * mean_speed[joint] / mean_square[joint] : 0.0;
        *c = 0.0;
      }
      *v = std::max(*v, 0.0);
    }
  }
}

Vector squares(const Matrix& x) { return x.colwise().squaredNorm().transpose(); }

// Sums of squares of a motion, or of its difference from another one, (n × 3).
void add_squares(Matrix& to, const Motion& motion, const Motion* other) {
  const std::array parts = {&Motion::q, &Motion::qd, &Motion::qdd};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Matrix& x = motion.*parts[i];
    to.col(static_cast<Index>(i)) += other == nullptr ? squares(x) : squares(x - other->*parts[i]);
  }
}

LoopSums no_sums(Index n) {
  const Matrix squares_of_motion = Matrix::Zero(n, 3);
  const Vector none = Vector::Zero(n);
  return {.off_measured = squares_of_motion,
          .measured = squares_of_motion,
          .off_reference = squares_of_motion,
          .reference = squares_of_motion,
          .tracking = none,
          .missed = none,
          .control = none,
          .moving = none};
}

}  // namespace

AuxiliaryLoop::AuxiliaryLoop(const Robot& robot, const Log& log, const SignalOptions& signal,
                             const Iv& method)
    : robot_(robot), log_(log), reference_(reference_of(log, signal, method)), options_(method.simulation) {
  const Index n = robot.size();
  options_.f_m = log.f_m;
  options_.samples = log.samples();
  options_.sampling = method.sampling;
  if (options_.integrator == Integrator::automatic && options_.sampling.period == 0.0) {
    // Every sample and every reversal of six joints makes a multistep method look back or begin anew.
    options_.integrator = Integrator::dormand_prince;
  }
  options_.q_0.resize(0);
  options_.qd_0.resize(0);
  if (!method.start_on_reference) {
    measured_start(log, options_.q_0, options_.qd_0);
  }
  measured_ = differentiate(filtered(log, signal.cutoff_hz, signal), log.f_m);
  Vector q(n);
  Vector qd(n);
  Vector qdd(n);
  for (Matrix* m : {&reference_motion_.q, &reference_motion_.qd, &reference_motion_.qdd}) {
    m->resize(log.samples(), n);
  }
  for (Index k = 0; k < log.samples(); ++k) {
    reference_->at(static_cast<double>(k) / log.f_m, q, qd, qdd);
    reference_motion_.q.row(k) = q;
    reference_motion_.qd.row(k) = qd;
    reference_motion_.qdd.row(k) = qdd;
  }
}

LoopTask AuxiliaryLoop::task(const DynamicModel& model, const ControlLaw& law, std::optional<double> delay,
                             Index most_steps, double most_seconds) const {
  LoopTask out{robot_, model, law, *reference_, options_};
  out.options.sampling.delay = delay.value_or(options_.sampling.delay);
  out.options.max_steps = std::min(options_.max_steps, most_steps);
  out.options.max_seconds = std::min(options_.max_seconds, most_seconds);
  return out;
}

Matrix AuxiliaryLoop::rebuilt_control(const ControlLaw& law) const {
  const Index n = robot_.size();
  Matrix out(log_.samples(), n);
  const bool every_sample = std::abs(options_.sampling.period * log_.f_m - 1.0) < 1e-6 &&
                            !options_.sampling.velocity_filter.empty();
  if (every_sample) {
    Sampling sampling = options_.sampling;
    sampling.position_noise.resize(0, 0);
    sampling.quantum.resize(0);
    sampling.delay = std::floor(sampling.delay);
    SampledController controller(law, *reference_, sampling, n);
    for (Index k = 0; k < log_.samples(); ++k) {
      out.row(k) = controller.tick(static_cast<double>(k) / log_.f_m, log_.q.row(k).transpose(),
                                   measured_.qd.row(k).transpose());
    }
    return out;
  }
  Vector x = Vector::Zero(law.states());
  Vector xd = Vector::Zero(law.states());
  Vector v(n);
  for (Index k = 0; k < log_.samples(); ++k) {
    const Vector q = measured_.q.row(k);
    const Vector qd = measured_.qd.row(k);
    const Vector q_r = reference_motion_.q.row(k);
    const Vector qd_r = reference_motion_.qd.row(k);
    const Vector qdd_r = reference_motion_.qdd.row(k);
    law.control({static_cast<double>(k) / log_.f_m, q, qd, q_r, qd_r, qdd_r}, x, v, xd);
    x += xd / log_.f_m;
    out.row(k) = v;
  }
  return out;
}

namespace {

// What a pass over logs that are elsewhere comes to.
//
// throws InputError where that is not of this problem
LoopFactors answer(const EstimationProblem& problem, const LoopRequest& request) {
  LoopFactors out = (*problem.ask)(request);
  const Index n = problem.joints();
  const LoopSums& sums = out.sums;
  const auto answered = [&] {
    switch (request.pass) {
      case LoopPass::speeds:
        return out.mean_speeds.size() == n && out.mean_squares.size() == n;
      case LoopPass::inertias:
        return out.J.size() == n;
      case LoopPass::rows:
        break;
    }
    return !out.groups.empty() && out.simulated_signs == request.simulated_signs &&
           out.used.empty() != request.simulated_signs &&
           std::ranges::all_of(
               std::array{sums.off_measured.rows(), sums.measured.rows(), sums.off_reference.rows(),
                          sums.reference.rows(), sums.tracking.rows(), sums.missed.rows(),
                          sums.control.rows(), sums.moving.rows()},
               [n](Index rows) { return rows == n; });
  };
  if (out.logs < 1 || !fit(out, columns_of(problem.data.groups)) || (out.failure.empty() && !answered())) {
    throw InputError("identify: what is returned by ask is not what the pass over robot \"" +
                     problem.robot.name + "\" was to come to, see loop_factors()");
  }
  return out;
}

}  // namespace

ClosedLoops::ClosedLoops(const EstimationProblem& problem)
    : problem_(problem),
      mean_speed_(Vector::Zero(problem.joints())),
      mean_square_(Vector::Zero(problem.joints())) {
  if (problem.ask != nullptr) {
    const LoopFactors speeds = answer(problem, {});
    mean_speed_ = speeds.mean_speeds / static_cast<double>(speeds.logs);
    mean_square_ = speeds.mean_squares / static_cast<double>(speeds.logs);
  }
  for (const Log& log : problem.logs) {
    loops_.push_back(
        std::make_unique<AuxiliaryLoop>(problem.robot, log, problem.estimation.signal, problem.iv()));
  }
  for (const auto& loop : loops_) {
    const auto share = 1.0 / static_cast<double>(loops_.size());
    mean_speed_ += share * loop->measured().qd.cwiseAbs().colwise().mean().transpose();
    mean_square_ += share * loop->measured().qd.cwiseAbs2().colwise().mean().transpose();
  }
}

double ClosedLoops::most_seconds() const {
  return problem_.iv().simulation.max_seconds * static_cast<double>(loops_.size());
}

double ClosedLoops::seconds_left() const {
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun_;
  return std::max(most_seconds() - taken.count(), 0.0);
}

SimulatedLoops ClosedLoops::simulated(const Vector& chi, std::span<const IvIteration> earlier,
                                      const SimulatedLoops* gains_of) const {
  return std::move(simulated(std::span(&chi, 1), earlier, gains_of).front());
}

std::vector<SimulatedLoops> ClosedLoops::simulated(std::span<const Vector> chis,
                                                   std::span<const IvIteration> earlier,
                                                   const SimulatedLoops* gains_of) const {
  std::vector<SimulatedLoops> out = made_of(chis, [&](const Vector& chi) { return prepared(chi, gains_of); });
  try {
    simulate(out, most_steps_of(earlier));
  } catch (const NumericsError& error) {
    if (chis.size() == 1) {
      out.front().failure = error.what();
      return out;
    }
    out.clear();
    return made_of(chis, [&](const Vector& chi) { return simulated(chi, earlier, gains_of); });
  }
  const auto& progress = problem_.estimation.progress;
  if (progress && out.front().failure.empty()) {
    progress("iteration " + std::to_string(earlier.size()), 1.0);
  }
  return out;
}

// Simulates those that have not failed before, beside each other.
void ClosedLoops::simulate(std::span<SimulatedLoops> all, Index steps_before) const {
  std::vector<LoopTask> tasks;
  const double left = seconds_left();
  for (SimulatedLoops& loops : all) {
    if (!loops.failure.empty()) {
      continue;
    }
    if (left <= 0.0) {
      run_out_of_time(0, loops);
      continue;
    }
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      tasks.push_back(loops_[k]->task(*loops.model, *loops.laws[k], loops.delay,
                                      step_budget(problem_.logs[k].samples(), steps_before), left));
    }
  }
  std::vector<Simulation> simulations = simulated_motions(tasks);
  std::size_t next = 0;
  for (SimulatedLoops& loops : all) {
    if (loops.failure.empty()) {
      take(std::span(simulations).subspan(next, loops_.size()), loops);
      next += loops_.size();
    }
  }
}

SimulatedLoops ClosedLoops::simulated(const LoopRequest& request) const {
  SimulatedLoops out;
  try {
    out.model = std::make_unique<DynamicModel>(problem_.robot, request.chi_st);
    out.J = request.J;
    out.laws.push_back(law_of(problem_.iv().control, {problem_.robot, *out.model, out.J}));
    simulate(std::span(&out, 1), request.steps_before);
  } catch (const NumericsError& error) {
    out.failure = error.what();
  }
  return out;
}

SimulatedLoops ClosedLoops::asked(const Vector& chi, std::span<const IvIteration> earlier,
                                  bool simulated_signs) const {
  SimulatedLoops out;
  const auto take_failure = [&](const LoopFactors& of) {
    out.failure = of.failure;
    out.gave_up = of.gave_up;
    return !of.failure.empty();
  };
  try {
    out.chi_st = braking(chi);
    out.model = std::make_unique<DynamicModel>(problem_.robot, out.chi_st);
    const LoopFactors inertias = answer(problem_, {.pass = LoopPass::inertias, .chi_st = out.chi_st});
    if (take_failure(inertias)) {
      return out;
    }
    out.J = inertias.J;
    out.laws.push_back(law_of(problem_.iv().control, {problem_.robot, *out.model, out.J}));
    out.found =
        std::make_shared<const LoopFactors>(answer(problem_, {.pass = LoopPass::rows,
                                                              .chi_st = out.chi_st,
                                                              .J = out.J,
                                                              .simulated_signs = simulated_signs,
                                                              .steps_before = most_steps_of(earlier)}));
    out.effort = out.found->effort;
    take_failure(*out.found);
  } catch (const NumericsError& error) {
    out.failure = error.what();
  }
  return out;
}

LoopFactors ClosedLoops::asked_again(const SimulatedLoops& loops, bool simulated_signs) const {
  return answer(
      problem_,
      {.pass = LoopPass::rows, .chi_st = loops.chi_st, .J = loops.J, .simulated_signs = simulated_signs});
}

// Standard parameters whose friction brakes.
Vector ClosedLoops::braking(const Vector& chi) const {
  Vector chi_st = problem_.base.to_standard(chi.head(problem_.base.size()));
  make_dissipative(problem_.base, mean_speed_, mean_square_, chi_st);
  return chi_st;
}

// Model and control laws of the loops with some parameters.
SimulatedLoops ClosedLoops::prepared(const Vector& chi, const SimulatedLoops* gains_of) const {
  SimulatedLoops out;
  try {
    out.chi_st = braking(chi);
    out.model = std::make_unique<DynamicModel>(problem_.robot, out.chi_st);
    if (gains_of != nullptr) {
      out.J = gains_of->J;
    } else {
      for (const auto& loop : loops_) {
        const Vector J = design_inertia(*out.model, loop->measured().q);
        out.J = out.J.size() == 0 ? J : out.J.cwiseMax(J);
      }
    }
    Plant plant{problem_.robot, gains_of != nullptr ? *gains_of->model : *out.model, out.J};
    if (!unknowns_.empty()) {
      const auto kinds = std::ssize(law_of(problem_.iv().control, plant)->description().gains);
      plant.gain_factors = Matrix::Ones(problem_.joints(), kinds);
    }
    for (std::size_t i = 0; i < unknowns_.size(); ++i) {
      const LoopUnknown& unknown = unknowns_[i];
      const double value = chi[problem_.base.size() + static_cast<Index>(i)];
      if (unknown.gain < 0) {
        out.delay = value;
      } else {
        plant.gain_factors(unknown.joint, unknown.gain) = value;
      }
    }
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      out.laws.push_back(law_of(problem_.iv().control, plant));
    }
  } catch (const NumericsError& error) {
    out.failure = error.what();
  }
  return out;
}

void ClosedLoops::run_out_of_time(std::size_t log, SimulatedLoops& out) const {
  out.gave_up = true;
  out.failure = problem_.logs[log].source + ": the budget of " + number(most_seconds()) +
                " s for all simulations is used up";
}

// What the simulations of all logs came to, up to the first one that failed.
void ClosedLoops::take(std::span<Simulation> simulations, SimulatedLoops& out) const {
  for (std::size_t k = 0; k < simulations.size(); ++k) {
    Simulation& simulation = simulations[k];
    add(out.effort, simulation.effort);
    if (simulation.outcome == Outcome::too_slow && seconds_left() <= 0.0) {
      return run_out_of_time(k, out);
    }
    if (simulation.outcome != Outcome::completed) {
      out.failure = problem_.logs[k].source + ": " + simulation.reason;
      out.gave_up = simulation.outcome == Outcome::too_slow &&
                    simulation.effort.steps >= problem_.iv().simulation.max_steps;
      return;
    }
    out.motions.push_back(std::move(simulation.motion));
  }
}

Index ClosedLoops::worthwhile() const {
  const Index logs = std::ssize(loops_);
  return (SimulationGroup::worthwhile() + logs - 1) / logs;
}

LoopSums ClosedLoops::sums(const SimulatedLoops& loops) const {
  if (loops.found) {
    return loops.found->sums;
  }
  const Index n = problem_.joints();
  LoopSums out = no_sums(n);
  for (std::size_t k = 0; k < loops_.size(); ++k) {
    const AuxiliaryLoop& loop = *loops_[k];
    const Motion& motion = loops.motions[k];
    add_squares(out.off_measured, motion, &loop.measured());
    add_squares(out.measured, loop.measured(), nullptr);
    add_squares(out.off_reference, motion, &loop.reference());
    add_squares(out.reference, loop.reference(), nullptr);
    out.tracking += squares(loop.reference().q - loop.measured().q);
    for (Index j = 0; j < n; ++j) {
      out.moving[j] += static_cast<double>((motion.qd.col(j).array() != 0.0).count());
    }
    out.samples += static_cast<double>(motion.samples());
  }
  return out;
}

LoopSums ClosedLoops::sums_with_control(const SimulatedLoops& loops) const {
  LoopSums out = sums(loops);
  for (std::size_t k = 0; k < loops_.size(); ++k) {
    const Log& log = problem_.logs[k];
    // A law that follows the measured motion has no error to work on, and rebuilds nothing.
    if (log.v_tau.size() > 0 && problem_.iv().follows == Iv::Follows::reference) {
      out.missed += squares(loops_[k]->rebuilt_control(*loops.laws[k]) - log.v_tau);
      out.control += squares(log.v_tau);
    }
  }
  return out;
}

Vector ClosedLoops::feasible(const Vector& chi) const {
  Vector out = chi;
  out.head(problem_.base.size()) = problem_.base.from_standard(braking(chi));
  for (std::size_t i = 0; i < unknowns_.size(); ++i) {
    double& value = out[problem_.base.size() + static_cast<Index>(i)];
    value = std::max(value, unknowns_[i].gain < 0 ? 0.0 : least_factor);
  }
  return out;
}

std::vector<LoopUnknown> loop_unknowns(const Iv& method, const ControlLaw& law) {
  const std::vector<Gain> gains = law.description().gains;
  std::vector<LoopUnknown> out;
  for (const auto& [name, sigma] : method.gain_sigma) {
    const auto at = std::ranges::find(gains, name, &Gain::name);
    if (at == gains.end()) {
      std::vector<std::string> names;
      std::ranges::transform(gains, std::back_inserter(names), &Gain::name);
      throw InputError("gain_sigma names \"" + name + "\"; the gains of this law are " + listed(names));
    }
    for (Index j = 0; j < at->values.size(); ++j) {
      if (sigma > 0.0 && std::isfinite(at->values[j]) && at->values[j] != 0.0) {
        out.push_back({.gain = at - gains.begin(),
                       .joint = j,
                       .prior = 1.0,
                       .sigma = sigma,
                       .in_signals = name.front() == 'K' || name == "k_v"});
      }
    }
  }
  if (method.delay_sigma > 0.0) {
    out.push_back({.gain = -1, .joint = 0, .prior = method.sampling.delay, .sigma = method.delay_sigma});
  }
  return out;
}

std::vector<Vector> changed_one_by_one(const Vector& chi, const Vector& steps, Index first, Index count) {
  std::vector<Vector> out(static_cast<std::size_t>(count), chi);
  for (Index i = 0; i < count; ++i) {
    out[static_cast<std::size_t>(i)][first + i] += steps[first + i];
  }
  return out;
}

void add(SimulationEffort& to, const SimulationEffort& effort) {
  to.steps += effort.steps;
  to.right_hand_sides += effort.right_hand_sides;
  to.restarts += effort.restarts;
  to.mode_changes += effort.mode_changes;
  to.seconds += effort.seconds;
}

MotionError motion_error(const Matrix& difference, const Matrix& whole) {
  const Matrix ratio =
      (whole.array() > 0.0)
          .select((difference.array() / whole.array()).sqrt(), std::numeric_limits<double>::quiet_NaN());
  return {ratio.col(0), ratio.col(1), ratio.col(2)};
}

std::vector<std::string> locked_joints(const EstimationProblem& problem, const SimulatedLoops& loops,
                                       const LoopSums& sums) {
  std::vector<std::string> out;
  for (Index j = 0; j < problem.joints(); ++j) {
    if (sums.moving[j] < locked_part * sums.samples) {
      out.push_back("joint \"" + problem.robot.joints[static_cast<std::size_t>(j)].name +
                    "\" stands still in " + number(100.0 * (1.0 - sums.moving[j] / sums.samples), 3) +
                    " % of the simulation: the assumed controller does not overcome its friction" +
                    dead_band(problem.robot, loops, j) + "; a wider bandwidth or a larger motion is needed");
    }
  }
  return out;
}

LoopDiagnosis diagnosed_loop(const EstimationProblem& problem, const LoopSums& sums) {
  LoopDiagnosis diagnosis;
  if (sums.control.maxCoeff() > 0.0) {
    diagnosis.control_error = (sums.missed.array() / sums.control.array()).sqrt();
  }
  if (problem.iv().follows == Iv::Follows::reference) {
    diagnosis.tracking_ratio = (sums.off_measured.col(0).array() / sums.tracking.array()).sqrt();
  }
  return diagnosis;
}

}  // namespace rivid::detail
