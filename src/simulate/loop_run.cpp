#include "simulate/loop_run.hpp"

#include <algorithm>
#include <cmath>

#include "dense.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Instants that agree to this part of a sample are one.
constexpr double same_instant = 1e-6;
// Part of a sample that nothing happens in.
constexpr double no_time = 1e-9;
// While a joint sticks, the torques that hold it are looked at after so many samples at the latest.
constexpr double samples_between_looks = 10.0;
// Samples whose accelerations are found together at most: many packs of the widest registers.
constexpr Index samples_together = 64;
// Steps between two looks at the clock, and two reports of progress.
constexpr Index steps_between_clocks = 256;

}  // namespace

LoopRun::LoopRun(const Robot& robot, const DynamicModel& model, const ControlLaw& law,
                 const Reference& reference, const SimulationOptions& options)
    : robot_(robot),
      reference_(reference),
      options_(options),
      n_(model.size()),
      ode_(robot, model, law, reference, options),
      batch_(model),
      controller_(law, reference, options.sampling, n_, options.q_0.size() > 0),
      sampled_(options.sampling.period > 0),
      held_inputs_(options.added_control.rows() > 0 || options.disturbance.rows() > 0),
      in_periods_(sampled_ || held_inputs_ || options.integrator == Integrator::rk4),
      period_(sampled_ ? options.sampling.period : 1.0 / options.f_m),
      begin_(reference.begin()),
      y_(Vector::Zero(ode_.size())),
      at_(ode_.size()),
      yd_(ode_.size()),
      row_(n_) {
  samples_ = options.samples > 0
                 ? options.samples
                 : static_cast<Index>(std::floor(reference.duration() * options.f_m + same_instant)) + 1;
  reserve();
  note_clamped(model);
  make_integrator();
  start();
}

void LoopRun::carry_out() {
  start_clock();
  while (!over()) {
    begin_period();
    finish_period();
  }
}

void LoopRun::start_clock() { began_ = std::chrono::steady_clock::now(); }

Simulation LoopRun::result() && {
  finish();
  add_reference();
  return std::move(out_);
}

Simulation LoopRun::motion() && {
  finish();
  return std::move(out_);
}

void LoopRun::reserve() {
  out_.t = Vector(samples_);
  for (Matrix* m :
       {&out_.motion.q, &out_.motion.qd, &out_.motion.qdd, &out_.v_tau, &out_.tau, &out_.q_measured}) {
    *m = Matrix(samples_, n_);
  }
}

void LoopRun::note_clamped(const DynamicModel& model) {
  if (!model.clamped().empty()) {
    out_.warnings.push_back(Finding{
        "driving_friction", {}, "friction that would drive counts as zero: " + listed(model.clamped())});
  }
}

void LoopRun::make_integrator() {
  const IntegratorOptions options{options_.rtol, options_.atol, options_.max_step,
                                  samples_between_looks / options_.f_m};
  switch (options_.integrator) {
    case Integrator::automatic:
      integrator_ = sampled_ || held_inputs_ ? bogacki_shampine_integrator(ode_, options)
                                             : cvode_integrator(ode_, options, false);
      break;
    case Integrator::adams:
    case Integrator::bdf:
      integrator_ = cvode_integrator(ode_, options, options_.integrator == Integrator::bdf);
      break;
    case Integrator::bogacki_shampine:
      integrator_ = bogacki_shampine_integrator(ode_, options);
      break;
    case Integrator::dormand_prince:
      integrator_ = dormand_prince_integrator(ode_, options);
      break;
    case Integrator::rk4:
      integrator_ = rk4_integrator(ode_);
      break;
  }
}

void LoopRun::start() {
  Vector q_r(n_);
  Vector qd_r(n_);
  Vector qdd_r(n_);
  reference_.at(begin_, q_r, qd_r, qdd_r);
  y_.head(n_) = options_.q_0.size() > 0 ? options_.q_0 : q_r;
  y_.segment(n_, n_) = options_.qd_0.size() > 0 ? options_.qd_0 : qd_r;
  ode_.reset_modes(y_.data());
  t_ = begin_;
}

// What changes at a control instant: control signal and inputs from outside.
void LoopRun::begin_period() {
  period_ended_ = false;
  moves_ = false;
  stop_ = begin_ + (in_periods_ ? static_cast<double>(periods_ + 1) * period_
                                : static_cast<double>(samples_ - 1) / options_.f_m);
  if (late_) {
    ode_.hold_control(controller_.later());
    if (end_at_no_number()) {
      return;
    }
  } else if (sampled_) {
    if (controller_.switches_at() > 0.0) {
      stop_ = begin_ + (static_cast<double>(periods_) + controller_.switches_at()) * period_;
    }
    ode_.hold_control(controller_.tick(t_, y_.head(n_), y_.segment(n_, n_)));
    if (end_at_no_number()) {
      return;
    }
  }
  if (!late_) {
    hold(options_.added_control, [&] { ode_.hold_added(row_); });
    hold(options_.disturbance, [&] { ode_.hold_disturbance(row_); });
  }
  if (options_.friction == DryFrictionScheme::held) {
    ode_.hold_friction(y_.data());
  }
}

// The modes under the new torques, and the samples at the beginning.
void LoopRun::begin_motion() {
  moves_ = true;
  if (!settle(-1)) {
    return;
  }
  restart();
  while (next_ < samples_ && due(next_)) {
    if (!record(t_, y_)) {
      return;
    }
  }
}

// What is left of the period.
void LoopRun::finish_period() {
  if (over()) {
    return;
  }
  if (in_pack_) {
    ode_.return_to(y_.data());
  }
  in_pack_ = false;
  attempts_ = 0;
  if (moves_) {
    integrator_->restart(t_, y_.data());
  } else {
    begin_motion();
  }
  if (over()) {
    return;
  }
  // An event may lie so close to the end of a period that no step fits between.
  while (stop_ - t_ > no_time / options_.f_m && !over_) {
    advance();
  }
  if (over_) {
    return;
  }
  end_period();
  if (!in_periods_ && next_ < samples_) {
    // The last sample, should rounding have left it.
    record(t_, y_);
    over_ = true;
  }
}

void LoopRun::end_period() {
  t_ = stop_;
  late_ = !late_ && controller_.switches_at() > 0.0;
  periods_ += late_ ? 0 : 1;
  period_ended_ = true;
}

LoopPackStep LoopRun::step_for_pack() {
  if (!ode_.simple() || waiting_ != next_) {
    return {};
  }
  const Index after = due(next_) ? next_ + 1 : next_;
  if (after >= samples_ || instant(after) < stop_ - same_instant / options_.f_m) {
    return {};
  }
  return {.ode = &ode_,
          .y = y_.data(),
          .follows = in_pack_ && attempts_ == 0,
          .h = integrator_->proposal(stop_ - t_),
          .rtol = options_.rtol,
          .atol = options_.atol,
          .max_velocity = options_.max_velocity};
}

void LoopRun::take(const LoopPack& pack, std::size_t lane) {
  const double left = stop_ - t_;
  const double h = integrator_->proposal(left);
  ++attempts_;
  if (!integrator_->judge(left, pack.error(lane))) {
    return;
  }
  if (!moves_) {
    ++out_.effort.restarts;
  }
  if (due(next_)) {
    for (Index j = 0; j < n_; ++j) {
      out_.motion.qdd(next_, j) = pack.acceleration(lane, j);
    }
    note(t_, y_);
    waiting_ = next_;
  } else if (!in_pack_ && !ode_.is_at(y_.data())) {
    ode_.count_evaluations(1);
  }
  at_ = y_;
  pack.state(lane, y_);
  // Where nothing moves M and N stay what they are.
  ode_.count_evaluations(y_ == at_ ? 0 : attempts_ * (BogackiShampine::stages - 1));
  t_ += h;
  moves_ = true;
  in_pack_ = true;
  attempts_ = 0;
  ++out_.effort.steps;
  check_budgets();
  if (!(stop_ - t_ > no_time / options_.f_m)) {
    end_period();
  }
}

template <typename Set>
void LoopRun::hold(const Matrix& input, Set&& set) {
  if (input.rows() > 0) {
    row_.setZero();
    if (periods_ < input.rows()) {
      row_ = input.row(periods_).transpose();
    }
    set();
  }
}

void LoopRun::restart() {
  integrator_->restart(t_, y_.data());
  ++out_.effort.restarts;
}

// One step of the integrator, the samples in it, and the event at its end.
void LoopRun::advance() {
  using Halt = LoopIntegrator::Halt;
  const LoopIntegrator::Step step = integrator_->step(stop_);
  ++out_.effort.steps;
  if (step.halt == Halt::not_positive_definite) {
    return end_indefinite();
  }
  if (step.halt == Halt::failed) {
    return end_early(Outcome::integrator_failed, "the step became too short for the tolerances");
  }
  while (next_ < samples_ && instant(next_) < step.t - same_instant / options_.f_m) {
    integrator_->state(instant(next_), at_.data());
    if (!(ode_.slides() ? record_sliding(instant(next_), at_) : record(instant(next_), at_))) {
      return;
    }
  }
  integrator_->state(step.t, y_.data());
  t_ = step.t;
  if (!(y_.segment(n_, n_).cwiseAbs().maxCoeff() <= options_.max_velocity) || !y_.allFinite()) {
    return end_diverged();
  }
  if (step.halt == Halt::event) {
    if (!settle(step.event)) {
      return;
    }
    restart();
  }
  check_budgets();
}

void LoopRun::check_budgets() {
  if (out_.effort.steps >= options_.max_steps) {
    return end_early(Outcome::too_slow,
                     "the budget of " + counted(options_.max_steps, "step") + " is used up");
  }
  if (out_.effort.steps % steps_between_clocks == 0) {
    if (options_.progress) {
      options_.progress(static_cast<double>(next_) / static_cast<double>(samples_));
    }
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - began_;
    if (taken.count() > options_.max_seconds) {
      end_early(Outcome::too_slow, "the budget of " + number(options_.max_seconds) + " s is used up");
    }
  }
}

bool LoopRun::settle(Index ended) {
  if (!ode_.settle(t_, y_.data(), ended)) {
    end_indefinite();
    return false;
  }
  return true;
}

double LoopRun::instant(Index sample) const { return begin_ + static_cast<double>(sample) / options_.f_m; }

bool LoopRun::due(Index sample) const { return instant(sample) <= t_ + same_instant / options_.f_m; }

// The row of sample next_.
bool LoopRun::record(double t, const Vector& y) {
  if (!accelerate_waiting()) {
    return false;
  }
  const Index before = ode_.evaluations();
  if (!ode_.rate(t, y.data(), yd_.data())) {
    end_indefinite();
    return false;
  }
  // Where all joints stick it would show nowhere else.
  if (end_at_no_number()) {
    return false;
  }
  recording_ += ode_.evaluations() - before;
  out_.motion.qdd.row(next_) = yd_.segment(n_, n_);
  note(t, y);
  waiting_ = next_;
  return true;
}

// The same where nothing sticks: in place of the acceleration it leaves the torques until there are several
// samples.
bool LoopRun::record_sliding(double t, const Vector& y) {
  ode_.driving_torques(t, y.data(), yd_.data());
  if (end_at_no_number()) {
    return false;
  }
  out_.motion.qdd.row(next_) = yd_.head(n_);
  note(t, y);
  return next_ - waiting_ < samples_together || accelerate_waiting();
}

// The accelerations that samples from waiting_ on still lack, by a batch, in a fraction of the time of single
// ones.
bool LoopRun::accelerate_waiting() {
  const Index count = next_ - waiting_;
  const auto waiting = [&](Matrix& m) { return m.middleRows(waiting_, count); };
  auto qdd = waiting(out_.motion.qdd);
  const auto fault = batch_.accelerations(waiting(out_.motion.q), waiting(out_.motion.qd), qdd, qdd);
  if (fault) {
    next_ = waiting_ + fault->sample;
    waiting_ = next_;
    t_ = out_.t[next_];
    y_.head(n_) = out_.motion.q.row(next_);
    y_.segment(n_, n_) = out_.motion.qd.row(next_);
    // For the words about it.
    [[maybe_unused]] const bool definite = ode_.rate(t_, y_.data(), yd_.data());
    end_indefinite();
    return false;
  }
  waiting_ = next_;
  return true;
}

// What is known of sample next_ without its acceleration.
void LoopRun::note(double t, const Vector& y) {
  const Index k = next_++;
  out_.t[k] = instant(k);
  out_.motion.q.row(k) = y.head(n_);
  out_.motion.qd.row(k) = y.segment(n_, n_);
  out_.v_tau.row(k) = ode_.v_tau();
  out_.tau.row(k) = ode_.tau();
  out_.q_measured.row(k) = sampled_ && t == t_ && !late_ ? controller_.q_measured() : y.head(n_);
}

void LoopRun::end_early(Outcome outcome, const std::string& why) {
  out_.outcome = outcome;
  out_.reason = "at t = " + number(t_) + " s: " + why;
  over_ = true;
}

bool LoopRun::end_at_no_number() {
  for (Index j = 0; j < n_; ++j) {
    const double q_r = sampled_ ? controller_.q_r()[j] : ode_.q_r()[j];
    const double v_tau = ode_.v_tau()[j];
    if (!std::isfinite(q_r) || !std::isfinite(v_tau)) {
      const bool asked = !std::isfinite(q_r);
      end_early(Outcome::diverged, std::string("the ") + (asked ? "reference" : "control signal") +
                                       " of joint \"" + robot_.joints[static_cast<std::size_t>(j)].name +
                                       "\" is " + number(asked ? q_r : v_tau) + ", must be finite");
      return true;
    }
  }
  return false;
}

void LoopRun::end_indefinite() {
  if (end_at_no_number()) {
    return;
  }
  const Dynamics<double>& dynamics = ode_.dynamics();
  const Index joint = dynamics.failed_joint();
  Matrix M(n_, n_);
  for (Index i = 0; i < n_; ++i) {
    for (Index j = 0; j < n_; ++j) {
      M(i, j) = dynamics.M(i, j);
    }
  }
  std::string why = "M(q) is not positive definite";
  if (M.allFinite() && joint >= 0) {
    const double eigenvalue = symmetric_eigenvalues(M)[0];
    why += ", its smallest eigenvalue is " + number(eigenvalue, 4) + "; joint \"" +
           robot_.joints[static_cast<std::size_t>(joint)].name + "\" has no positive inertia left";
  }
  end_early(Outcome::not_positive_definite, why);
}

void LoopRun::end_diverged() {
  if (end_at_no_number()) {
    return;
  }
  Index joint = 0;
  y_.segment(n_, n_).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&joint);
  end_early(Outcome::diverged, "joint \"" + robot_.joints[static_cast<std::size_t>(joint)].name +
                                   "\" runs at " + number(y_[n_ + joint], 4) + ", beyond " +
                                   number(options_.max_velocity));
}

void LoopRun::finish() {
  accelerate_waiting();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began_;
  out_.effort.seconds = took.count();
  out_.t.conservativeResize(next_);
  for (Matrix* m :
       {&out_.motion.q, &out_.motion.qd, &out_.motion.qdd, &out_.v_tau, &out_.tau, &out_.q_measured}) {
    m->conservativeResize(next_, Eigen::NoChange);
  }
  out_.effort.right_hand_sides = ode_.evaluations() - recording_;
  for (Index e = 0; e < ode_.events(); ++e) {
    out_.element_names.push_back(ode_.stick_slip().name(e));
    out_.element_changes.push_back(ode_.stick_slip().changes(e));
    out_.effort.mode_changes += ode_.stick_slip().changes(e);
  }
}

void LoopRun::add_reference() {
  out_.q_r.resize(next_, n_);
  out_.qd_r.resize(next_, n_);
  Vector q_r(n_);
  Vector qd_r(n_);
  Vector qdd_r(n_);
  for (Index k = 0; k < next_; ++k) {
    reference_.at(out_.t[k], q_r, qd_r, qdd_r);
    out_.q_r.row(k) = q_r;
    out_.qd_r.row(k) = qd_r;
  }
  out_.max_tracking_error = Vector::Zero(n_);
  if (next_ == 0) {
    return;
  }
  out_.max_tracking_error = (out_.q_r - out_.motion.q).cwiseAbs().colwise().maxCoeff();
  for (Index j = 0; j < n_; ++j) {
    const Joint& joint = robot_.joints[static_cast<std::size_t>(j)];
    const double least = out_.q_r.col(j).minCoeff();
    const double most = out_.q_r.col(j).maxCoeff();
    if (least < joint.lower || most > joint.upper) {
      const bool below = least < joint.lower;
      out_.warnings.push_back(Finding{"reference_limits",
                                      {},
                                      "the reference of joint \"" + joint.name + "\" reaches " +
                                          number(below ? least : most) + ", beyond its limit " +
                                          number(below ? joint.lower : joint.upper)});
    }
  }
}

}  // namespace rivid::detail
