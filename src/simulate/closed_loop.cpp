#include "rivid/simulate/closed_loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "dense.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics_batch.hpp"
#include "rivid/text.hpp"
#include "simulate/integrator.hpp"
#include "simulate/loop.hpp"

namespace rivid {

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

// One simulation from its beginning to its end.
class Run {
 public:
  Run(const Robot& robot, const DynamicModel& model, const ControlLaw& law, const Reference& reference,
      const SimulationOptions& options)
      : robot_(robot),
        reference_(reference),
        options_(options),
        n_(model.size()),
        ode_(robot, model, law, reference, options),
        batch_(model),
        controller_(law, reference, options.sampling, n_),
        sampled_(options.sampling.period > 0),
        held_inputs_(options.added_control.rows() > 0 || options.disturbance.rows() > 0),
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

  Simulation result() && {
    const auto clock = std::chrono::steady_clock::now();
    began_ = clock;
    integrate();
    accelerate_waiting();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - clock;
    out_.effort.seconds = took.count();
    finish();
    return std::move(out_);
  }

 private:
  void reserve() {
    out_.t = Vector(samples_);
    for (Matrix* m : {&out_.motion.q, &out_.motion.qd, &out_.motion.qdd, &out_.v_tau, &out_.tau, &out_.q_r,
                      &out_.qd_r, &out_.q_measured}) {
      *m = Matrix(samples_, n_);
    }
  }

  void note_clamped(const DynamicModel& model) {
    if (!model.clamped().empty()) {
      out_.warnings.push_back(Finding{
          "driving_friction", {}, "friction that would drive counts as zero: " + listed(model.clamped())});
    }
  }

  void make_integrator() {
    const detail::IntegratorOptions options{options_.rtol, options_.atol, options_.max_step,
                                            samples_between_looks / options_.f_m};
    switch (options_.integrator) {
      case Integrator::automatic:
        integrator_ = sampled_ || held_inputs_ ? detail::bogacki_shampine_integrator(ode_, options)
                                               : detail::cvode_integrator(ode_, options, false);
        break;
      case Integrator::adams:
      case Integrator::bdf:
        integrator_ = detail::cvode_integrator(ode_, options, options_.integrator == Integrator::bdf);
        break;
      case Integrator::bogacki_shampine:
        integrator_ = detail::bogacki_shampine_integrator(ode_, options);
        break;
      case Integrator::dormand_prince:
        integrator_ = detail::dormand_prince_integrator(ode_, options);
        break;
      case Integrator::rk4:
        integrator_ = detail::rk4_integrator(ode_);
        break;
    }
  }

  void start() {
    Vector q_r(n_);
    Vector qd_r(n_);
    Vector qdd_r(n_);
    reference_.at(begin_, q_r, qd_r, qdd_r);
    y_.head(n_) = options_.q_0.size() > 0 ? options_.q_0 : q_r;
    y_.segment(n_, n_) = options_.qd_0.size() > 0 ? options_.qd_0 : qd_r;
    ode_.reset_modes(y_.data());
  }

  // Time, state and torques up to the end, or to what ends it early.
  void integrate() {
    const double end = begin_ + static_cast<double>(samples_ - 1) / options_.f_m;
    const bool in_periods = sampled_ || held_inputs_ || options_.integrator == Integrator::rk4;
    t_ = begin_;
    for (Index period = 0; !over_; ++period) {
      if (!begin_period(period)) {
        return;
      }
      if (next_ >= samples_) {
        return;
      }
      const double stop = in_periods ? begin_ + static_cast<double>(period + 1) * period_ : end;
      // An event may lie so close to the end of a period that no step fits between.
      while (stop - t_ > no_time / options_.f_m && !over_) {
        advance(stop);
      }
      if (!over_) {
        t_ = stop;
      }
      if (next_ >= samples_) {
        return;
      }
      if (!in_periods) {
        // The last sample, should rounding have left it.
        record(end, y_);
        return;
      }
    }
  }

  // What changes at a control instant: control signal, inputs from outside, with them the modes.
  bool begin_period(Index period) {
    if (sampled_) {
      ode_.hold_control(controller_.tick(t_, y_.head(n_), y_.segment(n_, n_)));
    }
    hold(options_.added_control, period, [&] { ode_.hold_added(row_); });
    hold(options_.disturbance, period, [&] { ode_.hold_disturbance(row_); });
    if (options_.friction == DryFrictionScheme::held) {
      ode_.hold_friction(y_.data());
    }
    if (!settle(-1)) {
      return false;
    }
    restart();
    while (next_ < samples_ && instant(next_) <= t_ + same_instant / options_.f_m) {
      if (!record(t_, y_)) {
        return false;
      }
    }
    return true;
  }

  template <typename Set>
  void hold(const Matrix& input, Index period, Set&& set) {
    if (input.rows() > 0) {
      row_.setZero();
      if (period < input.rows()) {
        row_ = input.row(period).transpose();
      }
      set();
    }
  }

  void restart() {
    integrator_->restart(t_, y_.data());
    ++out_.effort.restarts;
  }

  // One step of the integrator, the samples in it, and the event at its end.
  void advance(double stop) {
    using Halt = detail::LoopIntegrator::Halt;
    const detail::LoopIntegrator::Step step = integrator_->step(stop);
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

  bool settle(Index ended) {
    if (!ode_.settle(t_, y_.data(), ended)) {
      end_indefinite();
      return false;
    }
    return true;
  }

  [[nodiscard]] double instant(Index sample) const {
    return begin_ + static_cast<double>(sample) / options_.f_m;
  }

  // The row of sample next_.
  bool record(double t, const Vector& y) {
    if (!accelerate_waiting()) {
      return false;
    }
    const Index before = ode_.evaluations();
    if (!ode_.rate(t, y.data(), yd_.data())) {
      end_indefinite();
      return false;
    }
    recording_ += ode_.evaluations() - before;
    out_.motion.qdd.row(next_) = yd_.segment(n_, n_);
    note(t, y);
    waiting_ = next_;
    return true;
  }

  // The same where nothing sticks: in place of the acceleration it leaves the torques until there are several samples.
  bool record_sliding(double t, const Vector& y) {
    ode_.driving_torques(t, y.data(), yd_.data());
    out_.motion.qdd.row(next_) = yd_.head(n_);
    note(t, y);
    return next_ - waiting_ < samples_together || accelerate_waiting();
  }

  // The accelerations that samples from waiting_ on still lack, by a batch, in a fraction of the time of single ones.
  bool accelerate_waiting() {
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
  void note(double t, const Vector& y) {
    const Index k = next_++;
    out_.t[k] = instant(k);
    out_.motion.q.row(k) = y.head(n_);
    out_.motion.qd.row(k) = y.segment(n_, n_);
    out_.v_tau.row(k) = ode_.v_tau();
    out_.tau.row(k) = ode_.tau();
    out_.q_measured.row(k) = sampled_ && t == t_ ? controller_.q_measured() : y.head(n_);
  }

  void end_early(Outcome outcome, const std::string& why) {
    out_.outcome = outcome;
    out_.reason = "at t = " + number(t_) + " s: " + why;
    over_ = true;
  }

  void end_indefinite() {
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
      const double eigenvalue = detail::symmetric_eigenvalues(M)[0];
      why += ", its smallest eigenvalue is " + number(eigenvalue, 4) + "; joint \"" +
             robot_.joints[static_cast<std::size_t>(joint)].name + "\" has no positive inertia left";
    }
    end_early(Outcome::not_positive_definite, why);
  }

  void end_diverged() {
    Index joint = 0;
    y_.segment(n_, n_).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&joint);
    end_early(Outcome::diverged, "joint \"" + robot_.joints[static_cast<std::size_t>(joint)].name +
                                     "\" runs at " + number(y_[n_ + joint], 4) + ", beyond " +
                                     number(options_.max_velocity));
  }

  void finish() {
    out_.t.conservativeResize(next_);
    for (Matrix* m : {&out_.motion.q, &out_.motion.qd, &out_.motion.qdd, &out_.v_tau, &out_.tau, &out_.q_r,
                      &out_.qd_r, &out_.q_measured}) {
      m->conservativeResize(next_, Eigen::NoChange);
    }
    out_.effort.right_hand_sides = ode_.evaluations() - recording_;
    for (Index e = 0; e < ode_.events(); ++e) {
      out_.element_names.push_back(ode_.stick_slip().name(e));
      out_.element_changes.push_back(ode_.stick_slip().changes(e));
      out_.effort.mode_changes += ode_.stick_slip().changes(e);
    }
    add_reference();
  }

  void add_reference() {
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

  const Robot& robot_;
  const Reference& reference_;
  const SimulationOptions& options_;
  Index n_;
  detail::LoopOde ode_;
  DynamicsBatch batch_;
  detail::SampledController controller_;
  std::unique_ptr<detail::LoopIntegrator> integrator_;
  bool sampled_;
  bool held_inputs_;
  double period_;
  double begin_;
  Vector y_, at_, yd_, row_;
  double t_ = 0.0;
  Index samples_ = 0;
  Index next_ = 0;       // sample to be recorded
  Index waiting_ = 0;    // first sample without its acceleration
  Index recording_ = 0;  // evaluations for samples
  bool over_ = false;
  std::chrono::steady_clock::time_point began_;
  Simulation out_;
};

}  // namespace

Simulation simulate(const Robot& robot, const DynamicModel& model, const ControlLaw& law,
                    const Reference& reference, const SimulationOptions& options) {
  const Index n = robot.size();
  if (const auto fault = options.complaint(n)) {
    throw InputError("simulate: " + *fault);
  }
  if (model.size() != n || reference.joints() != n) {
    throw InputError("simulate: the robot has " + counted(n, "joint") + ", its model " +
                     std::to_string(model.size()) + ", the reference " + std::to_string(reference.joints()));
  }
  return Run(robot, model, law, reference, options).result();
}

Simulation simulate(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi,
                    const Control& control, const Eigen::Ref<const Vector>& J, const Reference& reference,
                    const SimulationOptions& options) {
  const DynamicModel model(robot, base, chi);
  const std::unique_ptr<ControlLaw> law = control({robot, model, J});
  return simulate(robot, model, *law, reference, options);
}

}  // namespace rivid
