#include "rivid/identify/iv.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "identify/covariance.hpp"
#include "identify/dissipative.hpp"
#include "identify/essential_model.hpp"
#include "identify/exact_rows.hpp"
#include "identify/fit.hpp"
#include "identify/loop.hpp"
#include "identify/physical_model.hpp"
#include "identify/prefilter.hpp"
#include "identify/row_source.hpp"
#include "identify/thread_team.hpp"
#include "identify/verdict.hpp"
#include "rivid/error.hpp"
#include "rivid/signal/zero_phase.hpp"
#include "rivid/simulate/inertia.hpp"
#include "rivid/solve/instrumental.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::AuxiliaryLoop;

// Halvings of a step whose end can not be simulated.
constexpr int most_halvings = 5;
// Steps that the integrator may take with one iterate: so many times the most that an earlier one took, and so many a
// sample. Near a mass matrix that is not positive definite there is no end to them.
constexpr Index most_times_the_steps = 20;
constexpr Index most_steps_a_sample = 10;
// Part of the parameter tolerance that counts as standing still.
constexpr double still = 0.2;
// A step counts as one of a cycle where it leads back to within this part of itself.
constexpr double cycle_return = 0.1;
constexpr int most_dampings = 3;
// First-stage F statistic below which instruments count as weak, after Staiger & Stock (1997).
constexpr double least_F = 10.0;
// Position error [rad | m] that a law's stiffness is told from: too small to saturate it.
constexpr double dead_band_probe = 1e-6;
// The assumed loop is in doubt where the law rebuilds the control signal worse than this, or the simulated motion lies
// farther from the measured one than this part of the tracking error.
constexpr double doubtful_control = 0.2;
constexpr double doubtful_tracking = 0.5;
// The bandwidth shows in the residual with V alone: doubtful where that is so much of Y, and so many times the one with W.
constexpr double doubtful_residual = 0.2;
constexpr double doubtful_ratio = 4.0;

bool is_sign(ParameterKind kind) {
  using enum ParameterKind;
  return kind == Fc || kind == Fc_plus || kind == Fc_minus || kind == Fcm;
}

// Takes rows [V W Y] of a joint into the factor of the instruments.
class InstrumentSink final : public detail::RowSink {
 public:
  // signs: columns of W, within the joint's own, that are taken from V instead.
  // used:  factor of [W Y] with these columns, or nullptr.
  InstrumentSink(StreamingQr& qr, std::vector<Index> signs, StreamingQr* used)
      : qr_(qr), signs_(std::move(signs)), used_(used) {}

  RowsRoom room(Index wanted) override { return room_ = qr_.room(wanted); }
  void commit(std::span<const Index> samples) override {
    const auto count = static_cast<Index>(samples.size());
    const RowsTarget& target = room_.target;
    for (const Index c : signs_) {
      std::copy_n(target.data + c * target.ld, count, target.data + (qr_.columns() + c) * target.ld);
    }
    if (used_ != nullptr) {
      const Index m = qr_.columns();
      using Rows = Eigen::Map<const Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;
      const Rows WY(target.data + m * target.ld, count, m + 1, Eigen::OuterStride<>(target.ld));
      used_->add(WY.leftCols(m), WY.rightCols(1));
    }
    qr_.commit(count);
  }

 private:
  StreamingQr& qr_;
  std::vector<Index> signs_;
  StreamingQr* used_;
  RowsRoom room_{};
};

// Distances of a motion from another over several logs, sums of squares first.
class MotionDistance {
 public:
  explicit MotionDistance(Index n) : difference_(Matrix::Zero(n, 3)), whole_(Matrix::Zero(n, 3)) {}
  void add(const Motion& a, const Motion& b) {
    const std::array<std::pair<const Matrix*, const Matrix*>, 3> parts = {
        {{&a.q, &b.q}, {&a.qd, &b.qd}, {&a.qdd, &b.qdd}}};
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto c = static_cast<Index>(i);
      difference_.col(c) += (*parts[i].first - *parts[i].second).colwise().squaredNorm().transpose();
      whole_.col(c) += parts[i].second->colwise().squaredNorm().transpose();
    }
  }
  [[nodiscard]] MotionError error() const {
    // Not a number where there was no motion.
    const Matrix ratio =
        (whole_.array() > 0.0)
            .select((difference_.array() / whole_.array()).sqrt(), std::numeric_limits<double>::quiet_NaN());
    return {ratio.col(0), ratio.col(1), ratio.col(2)};
  }

 private:
  Matrix difference_;
  Matrix whole_;
};

// The last iterate that the instruments of its own loop have been solved for, with all that belongs to it.
struct Estimate {
  Vector chi;
  std::vector<double> weights;
  double sigma = 0.0;  // standard deviation of the weighted residual
  Matrix unit_covariance;
  Matrix R_VW;
  double condition_VW = 0.0;
  Vector first_stage_F;
  Matrix bread;                           // (Vᵀ Ω⁻¹ W)⁻¹
  std::vector<Motion> motions;            // that V is built from, one a log
  std::vector<RowGroup> used;             // [W Y]
  std::vector<std::vector<Index>> signs;  // columns of W that were taken from V
};

// One identification: what stays the same over its iterations, and the iterations.
class Run {
 public:
  Run(const Robot& robot, std::span<const Log> logs, const Iv& method)
      : robot_(robot), method_(method), logs_(logs), n_(robot.size()), team_(std::max(method.threads, 1)) {
    out_.method = "iv";
    out_.title = "IDIM-IV";
    if (logs.empty()) {
      throw InputError("identify(IDIM-IV): no log is given");
    }
    if (const auto fault = method.complaint(robot)) {
      throw InputError("identify(IDIM-IV): " + *fault);
    }
    out_.signal = method.signal;
    out_.base = base_parameters(robot);
    out_.columns = base().size();
    if (method.chi_0.size() > 0 && (method.chi_0.size() != base().size() || !method.chi_0.allFinite())) {
      throw InputError("identify(IDIM-IV): chi_0 has " + counted(method.chi_0.size(), "value") +
                       ", must have one, finite, for each of " + counted(base().size(), "base parameter"));
    }
    if (auto doubt = base().doubt()) {
      out_.warnings.push_back(std::move(*doubt));
    }
    signals_.reserve(logs.size());
    for (const Log& log : logs) {
      if (const auto fault = log.complaint()) {
        throw InputError(*fault);
      }
      signals_.push_back(without_transient(log));
      detail::add_factors(data_, factors(robot, base(), log, signals_.back(), method.threads));
      loops_.push_back(std::make_unique<AuxiliaryLoop>(robot, log, method));
    }
    mean_speed_ = Vector::Zero(n_);
    mean_square_ = Vector::Zero(n_);
    for (const auto& loop : loops_) {
      const auto share = 1.0 / static_cast<double>(loops_.size());
      mean_speed_ += share * loop->measured().qd.cwiseAbs().colwise().mean().transpose();
      mean_square_ += share * loop->measured().qd.cwiseAbs2().colwise().mean().transpose();
    }
    count_rows();
    if (rows_ <= base().size()) {
      throw InputError("identify(IDIM-IV): " + std::to_string(rows_) + " rows for " +
                       std::to_string(base().size()) +
                       " base parameters; more rows than parameters are needed");
    }
    weights_.assign(data_.groups.size(), 1.0);
    if (method.weights == Iv::Weights::by_joint) {
      weights_ = detail::joint_weights("identify(IDIM-IV)", robot, data_);
    }
  }

  Identification result() && {
    if (iterate(start()) && method_.prefilter) {
      prefilter();
    }
    conclude();
    out_.iv = std::move(history_);
    return std::move(out_);
  }

 private:
  // The loops of all logs, simulated with some parameters.
  struct Loop {
    std::string failure;  // empty where all were simulated
    std::vector<Motion> motions;
    std::unique_ptr<DynamicModel> model;  // that the law may look into
    std::unique_ptr<ControlLaw> law;
    Vector J;
    SimulationEffort effort;
  };

  [[nodiscard]] const BaseParameters& base() const { return out_.base; }
  [[nodiscard]] std::vector<IvIteration>& history() { return history_.iterations; }
  [[nodiscard]] const std::vector<IvIteration>& history() const { return history_.iterations; }

  [[nodiscard]] SignalOptions without_transient(const Log& log) const {
    SignalOptions signal = method_.signal;
    if (method_.transient > 0.0) {
      auto window = signal.window.value_or(std::array{log.t[0], log.t[log.samples() - 1]});
      window[0] = std::max(window[0], log.t[0] + method_.transient);
      signal.window = window;
    }
    return signal;
  }

  [[nodiscard]] Vector start() const {
    if (method_.chi_0.size() > 0) {
      return method_.chi_0;
    }
    switch (method_.start) {
      case Iv::Start::a_priori:
        return base().from_standard(robot_.chi_st());
      case Iv::Start::least_squares:
        return least_squares(data_.groups, base().size(), weights_).chi;
      case Iv::Start::regular:
        break;
    }
    return regular_start(robot_, base());
  }

  void tell(double fraction) const {
    if (method_.progress) {
      method_.progress("iteration " + std::to_string(history().size()), fraction);
    }
  }

  [[nodiscard]] Loop simulated(const Vector& chi) const {
    Loop loop;
    try {
      Vector chi_st = base().to_standard(chi);
      detail::make_dissipative(base(), mean_speed_, mean_square_, chi_st);
      loop.model = std::make_unique<DynamicModel>(robot_, chi_st);
      for (const auto& auxiliary : loops_) {
        const Vector J = design_inertia(*loop.model, auxiliary->measured().q);
        loop.J = loop.J.size() == 0 ? J : loop.J.cwiseMax(J);
      }
      for (std::size_t k = 0; k < loops_.size(); ++k) {
        // A law is made anew for each simulation: it may keep scratch.
        loop.law = method_.control({robot_, *loop.model, loop.J});
        Simulation simulation = loops_[k]->simulate(*loop.model, *loop.law, step_budget(logs_[k].samples()));
        loop.effort.steps += simulation.effort.steps;
        loop.effort.right_hand_sides += simulation.effort.right_hand_sides;
        loop.effort.restarts += simulation.effort.restarts;
        loop.effort.mode_changes += simulation.effort.mode_changes;
        loop.effort.seconds += simulation.effort.seconds;
        if (simulation.outcome != Outcome::completed) {
          loop.failure = logs_[k].source + ": " + simulation.reason;
          return loop;
        }
        loop.motions.push_back(std::move(simulation.motion));
        tell(static_cast<double>(k + 1) / static_cast<double>(loops_.size()));
      }
    } catch (const NumericsError& error) {
      loop.failure = error.what();
    }
    return loop;
  }

  // The physically consistent parameters that give the torques nearest to those of an iterate, along the measured motion.
  [[nodiscard]] Vector nearest_physical(const Vector& chi) const {
    const Matrix root = combined(used(), base().size(), weights_).R();
    // The motion only has to be near the actual one: a body twice as heavy or half as heavy as described may cost some
    // per cent of the residual. Without that pull a link may end with next to no inertia, and gains that follow it.
    constexpr double share_of_rows = 0.01;
    Physical options = method_.physical.value_or(Physical{});
    options.weight = std::max(options.weight, share_of_rows * static_cast<double>(rows_));
    return physical(robot_, base(), chi, root, options).chi;
  }

  [[nodiscard]] Index step_budget(Index samples) const {
    Index most = 0;
    for (const IvIteration& iteration : history()) {
      most = std::max(most, iteration.effort.steps);
    }
    return most > 0 ? most_times_the_steps * most + most_steps_a_sample * samples
                    : std::numeric_limits<Index>::max();
  }

  // In place of a loop that could not be simulated: one with the nearest physical parameters, or on the way back to the
  // last ones.
  [[nodiscard]] Loop safeguarded(Loop loop, Vector& chi, std::string& safeguard) {
    const std::string first_failure = loop.failure;
    loop = simulated(nearest_physical(chi));
    if (loop.failure.empty()) {
      safeguard = first_failure + "; simulated with the nearest physical parameters";
      return loop;
    }
    if (!history().empty()) {
      Vector step = chi - history().back().chi;
      for (int halving = 1; halving <= most_halvings; ++halving) {
        step *= 0.5;
        chi = history().back().chi + step;
        loop = simulated(chi);
        if (loop.failure.empty()) {
          safeguard = first_failure + "; the step was halved " + counted(halving, "time");
          return loop;
        }
      }
    }
    loop.failure = first_failure;
    return loop;
  }

  // What V is built from. Exact rows ask for the same differences as those of W.
  [[nodiscard]] Motion instrument_motion(const Motion& simulated, double f_m) const {
    const SignalOptions& signal = method_.signal;
    if (!signal.exact_rows()) {
      return simulated;
    }
    return detail::averaged_motion(signal.cutoff_hz > 0.0 ? zero_phase(simulated.q, f_m, signal.cutoff_hz,
                                                                       signal.order, signal.convention)
                                                          : simulated.q,
                                   f_m);
  }

  // Columns of W, within each joint's own, that are taken from V.
  [[nodiscard]] std::vector<std::vector<Index>> sign_columns() const {
    const std::vector<StandardParameter> columns = base().columns();
    std::vector<std::vector<Index>> out;
    for (const RowGroup& group : data_.groups) {
      std::vector<Index>& signs = out.emplace_back();
      for (std::size_t c = 0; simulated_signs() && c < group.columns.size(); ++c) {
        if (is_sign(columns[static_cast<std::size_t>(group.columns[c])].kind)) {
          signs.push_back(static_cast<Index>(c));
        }
      }
    }
    return out;
  }

  // Factors of [V | W Y] of all logs.
  [[nodiscard]] std::vector<InstrumentalGroup> instruments(const Loop& loop) {
    std::vector<InstrumentalGroup> groups;
    for (const RowGroup& group : data_.groups) {
      const auto own = static_cast<Index>(group.columns.size());
      groups.push_back({group.columns, StreamingQr(own, own + 1)});
    }
    signs_ = sign_columns();
    used_.clear();
    if (simulated_signs() || !whitening_.empty()) {
      for (const RowGroup& group : data_.groups) {
        used_.push_back({group.columns, StreamingQr(static_cast<Index>(group.columns.size()))});
      }
    }
    for (std::size_t k = 0; k < logs_.size(); ++k) {
      detail::RowSource source(robot_, base(), logs_[k], signals_[k], team_);
      std::vector<InstrumentSink> own_sinks;
      own_sinks.reserve(groups.size());
      std::vector<detail::RowSink*> sinks;
      sinks.reserve(groups.size());
      std::vector<Index> widths;
      for (std::size_t j = 0; j < groups.size(); ++j) {
        sinks.push_back(
            &own_sinks.emplace_back(groups[j].qr, signs_[j], used_.empty() ? nullptr : &used_[j].qr));
        widths.push_back(2 * groups[j].qr.columns() + 1);
      }
      const Motion V = instrument_motion(loop.motions[k], logs_[k].f_m);
      const detail::WhitenedSinks whitened(sinks, whitening_, widths);
      source.send(whitened.sinks(), std::span(&V, 1));
    }
    count_rows();
    return groups;
  }

  [[nodiscard]] IvIteration told(const Vector& chi, const Loop& loop,
                                 const std::vector<InstrumentalGroup>& groups,
                                 const InstrumentalVariables& solution) const {
    IvIteration out;
    out.chi = chi;
    out.joint_error_norm = Vector(n_);
    for (Index j = 0; j < n_; ++j) {
      const InstrumentalGroup& group = groups[static_cast<std::size_t>(j)];
      out.joint_error_norm[j] = group.qr.residual_norm(chi(group.columns));
    }
    out.error_norm = out.joint_error_norm.norm();
    out.relative_error = out.error_norm / y_norm_;
    MotionDistance to_measured(n_);
    MotionDistance to_reference(n_);
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      to_measured.add(loop.motions[k], loops_[k]->measured());
      to_reference.add(loop.motions[k], loops_[k]->reference());
    }
    out.to_measured = to_measured.error();
    out.to_reference = to_reference.error();
    out.J = loop.J;
    out.gains = loop.law->description().gains;
    out.condition_V = solution.condition_V;
    out.condition_VW = solution.condition_VW;
    out.effort = loop.effort;
    return out;
  }

  // [W Y] as the last instruments were solved with.
  [[nodiscard]] const std::vector<RowGroup>& used() const { return used_.empty() ? data_.groups : used_; }

  void count_rows() {
    rows_ = 0;
    y_norm_ = 0.0;
    for (const RowGroup& group : used()) {
      rows_ += group.qr.rows();
      y_norm_ = std::hypot(y_norm_, group.qr.y_norm());
    }
  }

  [[nodiscard]] double deviation_of(const Vector& chi) const {
    return detail::deviation(residual(used(), chi, weights_), freedom(), out_.signal.convention);
  }

  // Largest change of a parameter in its standard deviations.
  [[nodiscard]] double step_in_sigmas(const Vector& step, const InstrumentalVariables& solution) const {
    const double sigma = deviation_of(solution.chi);
    return (step.array() / (sigma * solution.unit_covariance.diagonal().array().sqrt())).abs().maxCoeff();
  }

  // The loop of the start knows nothing of friction yet, and its signs are little use.
  [[nodiscard]] bool simulated_signs() const {
    if (history().empty() && method_.signs == Iv::Signs::automatic) {
      return false;
    }
    return method_.signs == Iv::Signs::simulated ||
           (method_.signs == Iv::Signs::automatic && method_.signal.cutoff_hz == 0.0 &&
            !method_.signal.exact_rows());
  }

  [[nodiscard]] double freedom() const { return static_cast<double>(rows_ - base().size()); }

  // The weights of the next iteration: from what this estimate leaves of each joint's rows.
  void reweight(const Vector& chi) {
    if (method_.weights == Iv::Weights::none) {
      return;
    }
    for (std::size_t j = 0; j < weights_.size(); ++j) {
      const RowGroup& group = used()[j];
      const double norm = group.qr.residual_norm(chi(group.columns));
      if (norm > 0.0) {
        const Index freedom = std::max<Index>(group.qr.rows() - group.qr.columns(), 1);
        weights_[j] = std::sqrt(static_cast<double>(freedom)) / norm;
      }
    }
  }

  // The loop of an iterate, or of what takes its place.
  [[nodiscard]] Loop loop_of(Vector& chi, std::string& remark) {
    Loop loop = simulated(chi);
    const bool took_measured_signs =
        history().size() == 1 && method_.signs == Iv::Signs::automatic && simulated_signs();
    if (!loop.failure.empty() && took_measured_signs) {
      // The signs of raw velocities may be noise alone: once more with those of the first loop.
      const InstrumentalVariables again = instrumental_variables(instruments(last_), base().size(), weights_);
      if (again.full_rank()) {
        chi = again.chi;
        reweight(chi);
        loop = simulated(chi);
        remark = "with the signs of the first loop";
      }
    }
    return loop.failure.empty() ? std::move(loop) : safeguarded(std::move(loop), chi, remark);
  }

  // Iterates from `chi` on; whether it settled, for status and reasons tell why not.
  bool iterate(Vector chi) {
    int dampings = 0;
    for (int k = 0;; ++k) {
      std::string remark;
      const Vector wanted = chi;
      Loop loop = loop_of(chi, remark);
      if (!loop.failure.empty()) {
        out_.status = Status::not_simulable;
        out_.reasons.push_back(
            (history().empty() ? "the start" : "iterate " + std::to_string(history().size())) +
            " can not be simulated: " + loop.failure);
        return false;
      }
      std::vector<InstrumentalGroup> groups = instruments(loop);
      solution_ = instrumental_variables(groups, base().size(), weights_);
      // A step too far may hold a joint by its friction, where a shorter one does not.
      for (int halving = 1; !history().empty() && !solution_.full_rank() && halving <= most_halvings;
           ++halving) {
        const Vector shorter = history().back().chi + 0.5 * (chi - history().back().chi);
        Loop trial = simulated(shorter);
        if (!trial.failure.empty()) {
          break;
        }
        chi = shorter;
        loop = std::move(trial);
        groups = instruments(loop);
        solution_ = instrumental_variables(groups, base().size(), weights_);
        remark = "the step was halved " + counted(halving, "time") + ", for its instruments lacked rank";
      }
      IvIteration iteration = told(chi, loop, groups, solution_);
      iteration.safeguard = std::move(remark);
      if (!solution_.full_rank()) {
        history().push_back(std::move(iteration));
        detail::explain_rank(solution_.rank, solution_.undetermined,
                             "the instruments of iteration " + std::to_string(history().size()), out_);
        explain_locked(loop);
        return false;
      }
      last_ = std::move(loop);
      if (!history().empty()) {
        iteration.largest_step = step_in_sigmas(chi - history().back().chi, solution_);
        const double before = history().back().error_norm;
        const double change = std::abs(iteration.error_norm - before);
        // Signs that flip keep ‖ε‖ from settling at all; steps far below the deviations are the end all the same.
        // An iterate that was moved has not come to rest by itself.
        const bool settled = chi == wanted && ((change <= method_.tolerance * before &&
                                                iteration.largest_step <= method_.parameter_tolerance) ||
                                               iteration.largest_step <= still * method_.parameter_tolerance);
        history().push_back(std::move(iteration));
        keep(chi);
        if (settled) {
          return true;
        }
      } else {
        history().push_back(std::move(iteration));
      }
      if (k == method_.max_iterations) {
        out_.status = Status::not_converged;
        out_.reasons.push_back("not converged after " + counted(method_.max_iterations, "iteration") +
                               ": parameters still move by " + number(history().back().largest_step, 3) +
                               " standard deviations");
        return false;
      }
      Vector next = solution_.chi;
      if (cycles(next)) {
        if (step_in_sigmas(next - chi, solution_) <= method_.parameter_tolerance) {
          return true;  // there and back again, far within the deviations: signs that flip
        }
        if (++dampings > most_dampings) {
          out_.status = Status::cycling;
          out_.reasons.push_back("the iteration goes back and forth between two estimates, " +
                                 number(history().back().largest_step, 3) +
                                 " standard deviations apart, and damping does not help");
          return false;
        }
        next = 0.5 * (next + chi);
        history().back().safeguard += history().back().safeguard.empty() ? "" : "; ";
        history().back().safeguard += "the next step was halved, for the iteration went back and forth";
      }
      reweight(next);
      chi = std::move(next);
    }
  }

  // The noise models that the residual of `chi` tells, one a joint.
  [[nodiscard]] std::vector<NoiseModel> noise_models(const Vector& chi) {
    const Index order = method_.prefilter_order;
    std::vector<StreamingQr> lagged(data_.groups.size(),
                                    StreamingQr(order > 0 ? order : Iv::most_prefilter_order));
    for (std::size_t k = 0; k < logs_.size(); ++k) {
      detail::RowSource source(robot_, base(), logs_[k], signals_[k], team_);
      std::vector<detail::LaggedResidualSink> own_sinks;
      own_sinks.reserve(lagged.size());
      std::vector<detail::RowSink*> sinks;
      for (std::size_t j = 0; j < lagged.size(); ++j) {
        sinks.push_back(&own_sinks.emplace_back(lagged[j], chi(data_.groups[j].columns), signs_[j]));
      }
      const Motion V = instrument_motion(last_.motions[k], logs_[k].f_m);
      source.send(sinks, std::span(&V, 1));
    }
    std::vector<NoiseModel> out;
    out.reserve(lagged.size());
    for (std::size_t j = 0; j < lagged.size(); ++j) {
      detail::Autoregression model = detail::autoregression(lagged[j], order);
      out.push_back({robot_.joints[j].name, std::move(model.ar), model.innovation});
    }
    return out;
  }

  // Noise models from the estimate and estimates from whitened rows in turn.
  void prefilter() {
    constexpr int most_rounds = 10;
    if (!estimate_) {
      return;
    }
    PrefilterReport& report = out_.prefilter.emplace();
    unfiltered_error_ = history().back().relative_error;
    tell_uncertainty(*estimate_);
    report.chi = history().back().chi;
    report.sigma = out_.C_chi.diagonal().cwiseSqrt();
    report.covariance = out_.covariance;
    for (SignalOptions& signal : signals_) {
      signal.decimation.clear();
    }
    while (report.rounds < most_rounds) {
      ++report.rounds;
      const Vector before = history().back().chi;
      report.noise = noise_models(before);
      whitening_.clear();
      for (const NoiseModel& model : report.noise) {
        whitening_.push_back(model.ar);
      }
      const std::vector<InstrumentalGroup> groups = instruments(last_);
      report.rows = rows_;
      reweight(before);
      solution_ = instrumental_variables(groups, base().size(), weights_);
      if (!solution_.full_rank()) {
        detail::explain_rank(solution_.rank, solution_.undetermined, "the whitened instruments", out_);
        return;
      }
      const Vector next = solution_.chi;
      reweight(next);
      if (!iterate(next)) {
        return;
      }
      if (step_in_sigmas(history().back().chi - before, solution_) <= still * method_.parameter_tolerance) {
        return;
      }
    }
    out_.status = Status::not_converged;
    out_.reasons.push_back("noise models and parameters do not settle on each other in " +
                           counted(most_rounds, "round") + " of the prefilter");
  }

  // Whitening changes no parameter by much where the model is right.
  void judge_prefilter() {
    if (!out_.prefilter) {
      return;
    }
    const PrefilterReport& report = *out_.prefilter;
    std::string moved;
    for (Index i = 0; i < base().size(); ++i) {
      const ParameterEstimate& p = out_.parameters[static_cast<std::size_t>(i)];
      const double half_width =
          std::max(report.covariance.quantile_975 * report.sigma[i], out_.covariance.quantile_975 * p.sigma);
      if (std::abs(p.value - report.chi[i]) > half_width) {
        moved += (moved.empty() ? "" : ", ") + p.name + " (" + number(report.chi[i], 4) + " to " +
                 number(p.value, 4) + ")";
      }
    }
    if (!moved.empty()) {
      out_.warnings.push_back("the prefilter moves " + moved +
                              " by more than the 95 % intervals: the model of the robot is not right at the "
                              "frequencies that whitening amplifies; prefer the estimate without prefilter");
    }
  }

  // Whether the step from χ̂_k to `next` takes back the step before.
  [[nodiscard]] bool cycles(const Vector& next) {
    if (history().size() < 3) {
      return false;
    }
    const Vector& now = history().back().chi;
    const Vector& before = history()[history().size() - 2].chi;
    return step_in_sigmas(next - before, solution_) < cycle_return * step_in_sigmas(next - now, solution_);
  }

  // A joint that its friction holds throughout gives no instruments.
  void explain_locked(const Loop& loop) {
    for (Index j = 0; j < n_; ++j) {
      double moving = 0.0;
      double all = 0.0;
      for (std::size_t k = 0; k < loops_.size(); ++k) {
        moving += static_cast<double>((loop.motions[k].qd.col(j).array() != 0.0).count());
        all += static_cast<double>(loop.motions[k].samples());
      }
      if (moving < 0.05 * all) {
        out_.reasons.push_back("joint \"" + robot_.joints[static_cast<std::size_t>(j)].name +
                               "\" stands still in " + number(100.0 * (1.0 - moving / all), 3) +
                               " % of the simulation: the assumed controller does not overcome its friction" +
                               dead_band(loop, j) + "; a wider bandwidth or a larger motion is needed");
      }
    }
  }

  // How far a joint's position must be off before a proportional law overcomes its friction: Fc / (ω_n² J) for PD (40).
  [[nodiscard]] std::string dead_band(const Loop& loop, Index j) const {
    const Vector none = Vector::Zero(n_);
    const Vector x = Vector::Zero(loop.law->states());
    Vector xd = x;
    Vector v(n_);
    Vector v_0(n_);
    loop.law->control({0.0, none, none, none, none, none}, x, v_0, xd);
    loop.law->control({0.0, none, none, Vector::Unit(n_, j) * dead_band_probe, none, none}, x, v, xd);
    const double stiffness = (robot_.drive_matrix() * (v - v_0))[j] / dead_band_probe;
    double Fc = 0.0;
    for (const DryFriction& law : loop.model->dry_friction()) {
      Fc += law.direction[j] != 0.0 ? 0.5 * (law.Fc_plus + law.Fc_minus) : 0.0;
    }
    if (!(stiffness > 0.0) || Fc == 0.0) {
      return "";
    }
    return ", which holds it within " + number(Fc / stiffness, 3) + " of its reference";
  }

  // This iterate is the estimate, unless a later one comes.
  void keep(const Vector& chi) {
    estimate_ = Estimate{.chi = chi,
                         .weights = weights_,
                         .sigma = deviation_of(chi),
                         .unit_covariance = solution_.unit_covariance,
                         .R_VW = solution_.R_VW,
                         .condition_VW = solution_.condition_VW,
                         .first_stage_F = first_stage_F(),
                         .bread = bread(),
                         .motions = instrument_motions(),
                         .used = used(),
                         .signs = signs_};
  }

  // (Vᵀ Ω⁻¹ W)⁻¹ = R_VW⁻¹ R_VV⁻ᵀ.
  [[nodiscard]] Matrix bread() const {
    const Index b = base().size();
    return solution_.R_VW.partialPivLu().solve(
        Matrix(solution_.R_VV.transpose().triangularView<Eigen::Lower>().solve(Matrix::Identity(b, b))));
  }

  [[nodiscard]] std::vector<Motion> instrument_motions() const {
    std::vector<Motion> out;
    for (std::size_t k = 0; k < logs_.size(); ++k) {
      out.push_back(instrument_motion(last_.motions[k], logs_[k].f_m));
    }
    return out;
  }

  // Strength of the instruments, parameter by parameter: R² of Shea (1997), the variance that least squares would have on
  // the same rows over that of the instrumental variables, as the F statistic of a first stage.
  [[nodiscard]] Vector first_stage_F() const {
    const LeastSquares ls = least_squares(used(), base().size(), weights_);
    Vector F(base().size());
    for (Index i = 0; i < F.size(); ++i) {
      const double R2 = std::min(ls.unit_covariance(i, i) / solution_.unit_covariance(i, i), 1.0);
      F[i] = freedom() * R2 / std::max(1.0 - R2, std::numeric_limits<double>::epsilon());
    }
    return F;
  }

  void conclude() {
    const Index b = base().size();
    const std::vector<double> ones(data_.groups.size(), 1.0);
    out_.R_diagonal = combined(data_.groups, b, ones).R().diagonal().cwiseAbs();
    if (!estimate_) {
      out_.weights = weights_;
      out_.condition = std::numeric_limits<double>::infinity();
      out_.chi = Vector::Constant(b, std::numeric_limits<double>::quiet_NaN());
      out_.C_chi = Matrix::Constant(b, b, std::numeric_limits<double>::infinity());
      out_.fit = detail::judged(robot_, data_, Vector::Zero(b), b, out_.signal.convention);
      forget_errors();
      detail::describe_parameters(robot_, out_);
      detail::judge_parameters(robot_, logs_, out_);
      return;
    }
    const Estimate& estimate = *estimate_;
    out_.weights = estimate.weights;
    out_.condition = estimate.condition_VW;
    out_.chi = estimate.chi;
    tell_uncertainty(estimate);
    out_.fit = detail::judged(robot_, data_, estimate.chi, b, out_.signal.convention);
    out_.fit.sigma_rho = estimate.sigma;
    detail::describe_parameters(robot_, out_);
    detail::add_physical(robot_, method_.physical, data_, estimate.R_VW / estimate.sigma, out_);
    detail::judge_parameters(robot_, logs_, out_);
    detail::add_essential(robot_, method_.essential, logs_, data_,
                          detail::decimation_factor(signals_.front()) / estimate.sigma * estimate.R_VW,
                          freedom(), out_);
    judge_instruments(estimate.first_stage_F);
    judge_prefilter();
    diagnose_loop();
    diagnose_bandwidth();
  }

  // out_.C_chi and what comes with a second look at the rows: those that the estimate's own instruments were made for, as
  // long as no later iterate took their place.
  void tell_uncertainty(const Estimate& estimate) {
    detail::Uncertainty found =
        detail::classical_covariance(signals_.front(), estimate.sigma, estimate.unit_covariance, freedom());
    if (detail::resolved(method_.covariance.kind, out_.signal.convention) == CovarianceKind::hac &&
        !estimate.motions.empty()) {
      const LeastSquares ls = least_squares(estimate.used, base().size(), estimate.weights);
      const bool corrected = detail::leverage_counts(rows_, base().size());
      const auto bread = [&](const Matrix& inverse) { return corrected ? inverse : Matrix(); };
      const std::array<detail::Estimator, 2> estimators = {
          {{estimate.chi, true, bread(estimate.bread)}, {ls.chi, false, bread(ls.unit_covariance)}}};
      std::vector<detail::ScoredLog> scored;
      for (std::size_t k = 0; k < logs_.size(); ++k) {
        scored.push_back({&logs_[k], &signals_[k], &estimate.motions[k]});
      }
      const detail::Scores scores = detail::scores(robot_, base(), scored, estimators, estimate.weights,
                                                   estimate.signs, team_, whitening_);
      found = detail::hac_covariance(scores.series[0], scores.interval, estimate.bread, method_.covariance,
                                     freedom());
      out_.diagnostics = Diagnostics{.residuals = detail::residual_tests(robot_, scores), .hausman = {}};
      if (ls.full_rank()) {
        out_.diagnostics->hausman = detail::hausman_test(
            base(), estimate.chi - ls.chi, scores.series[0], estimate.bread, scores.series[1],
            ls.unit_covariance, scores.interval, method_.covariance, found.C.diagonal().cwiseSqrt());
      }
    }
    out_.C_chi = std::move(found.C);
    out_.covariance = found.report;
  }

  // Rows without an estimate have no errors.
  void forget_errors() {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    Fit& fit = out_.fit;
    fit.relative_error = fit.centred_relative_error = fit.error_norm = fit.sigma_rho = none;
    for (JointFit& joint : fit.joints) {
      joint.relative_error = joint.centred_relative_error = joint.sigma_rho = none;
    }
  }

  void judge_instruments(const Vector& F) {
    history_.first_stage_F = F;
    std::string weak;
    for (Index i = 0; i < base().size(); ++i) {
      if (!(F[i] > least_F)) {
        weak += (weak.empty() ? "" : ", ") + base().parameters[static_cast<std::size_t>(i)].name +
                " (F = " + number(F[i], 3) + ")";
      }
    }
    // A later iterate that lacks instruments altogether has told why already.
    if (weak.empty() || out_.status == Status::rank_deficient) {
      return;
    }
    if (out_.status == Status::identified) {
      out_.status = Status::weak_instruments;
    }
    out_.reasons.push_back(
        "the simulated motion says too little about " + weak + ", which need F above " + number(least_F) +
        "; the assumed loop moves otherwise than the actual one, so try a wider bandwidth, the "
        "actual gains, or a larger motion");
  }

  // How well the assumed controller explains the logs.
  void diagnose_loop() {
    Vector missed = Vector::Zero(n_);
    Vector control = Vector::Zero(n_);
    Vector apart = Vector::Zero(n_);
    Vector tracking = Vector::Zero(n_);
    const auto add = [](Vector& to, const Matrix& x) { to += x.colwise().squaredNorm().transpose(); };
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      const Log& log = logs_[k];
      // A law that follows the measured motion has no error to work on, and rebuilds nothing.
      if (log.v_tau.size() > 0 && method_.follows == Iv::Follows::reference) {
        add(missed, loops_[k]->rebuilt_control(*last_.law) - log.v_tau);
        add(control, log.v_tau);
      }
      add(apart, last_.motions[k].q - loops_[k]->measured().q);
      add(tracking, loops_[k]->reference().q - loops_[k]->measured().q);
    }
    LoopDiagnosis& loop = history_.loop;
    if (control.maxCoeff() > 0.0) {
      loop.control_error = (missed.array() / control.array()).sqrt();
    }
    if (method_.follows == Iv::Follows::reference) {
      loop.tracking_ratio = (apart.array() / tracking.array()).sqrt();
    }
    const auto warn = [&](const Vector& error, double limit, std::string_view what) {
      for (Index j = 0; j < error.size(); ++j) {
        if (error[j] > limit) {
          out_.warnings.push_back(
              "joint \"" + robot_.joints[static_cast<std::size_t>(j)].name + "\": " + std::string(what) +
              " by " + number(100.0 * error[j], 3) +
              " %; the assumed controller may not be the actual one, which makes the instruments "
              "weaker");
        }
      }
    };
    warn(loop.control_error, doubtful_control, "the control law misses the recorded control signal");
    warn(loop.tracking_ratio, doubtful_tracking,
         "the simulated motion misses the measured one, in units of the tracking error,");
  }

  void diagnose_bandwidth() {
    const double with_V = unfiltered_error_.value_or(history().back().relative_error);
    const double with_W = out_.fit.relative_error;
    if (with_V > doubtful_residual && with_V > doubtful_ratio * with_W) {
      out_.warnings.push_back("the simulated motion misses " + number(100.0 * with_V, 3) +
                              " % of the torques, the measured one " + number(100.0 * with_W, 3) +
                              " %: the bandwidth of the assumed controller may be far from the actual one");
    }
  }

  const Robot& robot_;
  const Iv& method_;
  std::span<const Log> logs_;
  Index n_;
  detail::ThreadTeam team_;
  std::vector<SignalOptions> signals_;  // one a log
  std::vector<std::unique_ptr<AuxiliaryLoop>> loops_;
  Vector mean_speed_;  // |q̇| of the measured motions
  Vector mean_square_;
  RowFactors data_;  // of [W Y]
  Index rows_ = 0;
  double y_norm_ = 0.0;
  std::vector<double> weights_;
  InstrumentalVariables solution_;         // of the instruments that were simulated last
  std::vector<RowGroup> used_;             // [W Y] with the signs that they took, or whitened; empty: data_
  std::vector<std::vector<Index>> signs_;  // columns of these signs
  std::optional<Estimate> estimate_;
  std::vector<Vector> whitening_;           // coefficients of each joint's prefilter; empty without
  std::optional<double> unfiltered_error_;  // ‖ε‖ / ‖Y‖ before prefiltering
  Loop last_;
  IvHistory history_;
  Identification out_;
};

}  // namespace

std::optional<std::string> Iv::complaint(const Robot& robot) const {
  if (!control) {
    return "control is not set; the loop that makes the instruments needs a control law, PdControl say";
  }
  if (auto fault = signal.complaint(robot.size())) {
    return fault;
  }
  if (follows == Follows::measured && reference_cutoff_hz == 0.0 && signal.cutoff_hz == 0.0) {
    return "reference_cutoff_hz is 0: a loop that followed the raw positions would carry their noise into "
           "the "
           "instruments; it must be positive where follows is measured";
  }
  if (auto fault = sampling.complaint(robot.size())) {
    return fault;
  }
  if (auto fault = covariance.complaint()) {
    return fault;
  }
  if (auto fault = physical ? physical->complaint(robot) : std::nullopt) {
    return "physical: " + *fault;
  }
  if (auto fault = essential ? essential->complaint() : std::nullopt) {
    return "essential: " + *fault;
  }
  if (prefilter && !signal.exact_rows()) {
    return "prefilter works on exact rows: rows must be \"exact\"";
  }
  if (prefilter_order < 0 || prefilter_order > most_prefilter_order) {
    return "prefilter_order is " + std::to_string(prefilter_order) + ", must lie between 0 and " +
           std::to_string(most_prefilter_order);
  }
  const auto positive = [](double x) { return std::isfinite(x) && x > 0.0; };
  for (const auto& [key, value] :
       {std::pair("tolerance", tolerance), std::pair("parameter_tolerance", parameter_tolerance)}) {
    if (!positive(value)) {
      return std::string(key) + " is " + number(value) + ", must be positive";
    }
  }
  for (const auto& [key, value] :
       {std::pair("transient", transient), std::pair("reference_cutoff_hz", reference_cutoff_hz)}) {
    if (!std::isfinite(value) || value < 0.0) {
      return std::string(key) + " is " + number(value) + ", must not be negative";
    }
  }
  for (const auto& [key, value] :
       {std::pair("max_iterations", max_iterations), std::pair("threads", threads)}) {
    if (value < 1) {
      return std::string(key) + " is " + std::to_string(value) + ", must be at least 1";
    }
  }
  return std::nullopt;
}

std::string_view name(Iv::Start start) {
  constexpr std::array<std::string_view, 3> names = {"regular", "a_priori", "least_squares"};
  return names[static_cast<std::size_t>(start)];
}

namespace {

// ZZ of frame j as the link frame calls it: the joint's axis may be another one there.
ParameterKind about_axis(const Chain::Link& link) {
  for (const ParameterKind kind : {ParameterKind::XX, ParameterKind::YY}) {
    if (inertial_column(link, kind).index == static_cast<int>(ParameterKind::ZZ)) {
      return kind;
    }
  }
  return ParameterKind::ZZ;
}

}  // namespace

Vector regular_start(const Robot& robot, const BaseParameters& base) {
  Vector chi_st = Vector::Zero(static_cast<Index>(base.standard.size()));
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& joint = robot.joints[j];
    const ParameterKind kind = joint.rotor_inertia                 ? ParameterKind::Ia
                               : joint.type == JointType::revolute ? about_axis(robot.chain.links[j])
                                                                   : ParameterKind::M;
    for (std::size_t i = 0; i < base.standard.size(); ++i) {
      if (base.standard[i].joint == static_cast<int>(j) && base.standard[i].kind == kind) {
        chi_st[static_cast<Index>(i)] = 1.0;
      }
    }
  }
  return base.from_standard(chi_st);
}

Identification identify(const Robot& robot, std::span<const Log> logs, const Iv& method) {
  return Run(robot, logs, method).result();
}

}  // namespace rivid
