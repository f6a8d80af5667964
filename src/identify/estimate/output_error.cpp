// Closed-loop output error: parameters with which the simulated loops move as the logs say, by Gauss-Newton
// steps.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "identify/estimate/closed_loops.hpp"
#include "identify/estimate/estimate.hpp"
#include "identify/rows/factors.hpp"
#include "identify/rows/time_blocks.hpp"
#include "ranges.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Parameters are moved by this part of the deviation that least squares has, for differences: far above what
// tolerances of the integration leave, far below what the simulation is curved over.
constexpr double difference_step = 0.1;
// Instants of all logs that are compared at most, of more every second, third … : b matrices of so many rows
// are kept.
constexpr Index most_compared = 20000;
// Halvings of a step that does not lead closer.
constexpr int most_shorter = 5;
// What holds a parameter: of a step that it would take this part is left.
constexpr double holding = 1e6;
// of its step: a parameter that moves by less is held by its bound; rounding is below
constexpr double at_zero = 1e-9;
// Unknowns of the loop are moved by this part of their deviation beforehand, for differences, at most so far.
constexpr double prior_step = 0.05;
constexpr double longest_step = 0.1;
// The others then by this part of themselves at least.
constexpr double least_part = 0.005;
// Where all parameters and gains grow alike, positions that move by a smaller part of what one gain moves
// them by stay: errors of the differences, which would count as knowledge of the scale.
constexpr double scale_seen = 0.05;
// Part of the parameter tolerance below which a step is none.
constexpr double at_rest = 0.2;
// Part of the sum of squares that a step promises and need not keep: joints that stick and break away make
// the simulation jump.
constexpr double promised_in_vain = 0.005;
// A motion repeats itself where it comes back to within so many times what the simulation leaves, at three of
// four instants, of which so many are looked at.
constexpr double as_close = 2.0;
constexpr Index most_looked_at = 1000;
// Measured less simulated positions, one matrix a log, (instants × n).
using PositionErrors = std::vector<Matrix>;

class OutputError {
 public:
  OutputError(const EstimationProblem& problem, Estimated& out)
      : problem_(problem), method_(problem.iv()), out_(out), loops_(problem) {
    const Index samples = sum_of(problem.logs, &Log::samples);
    const Index every = (samples + most_compared - 1) / most_compared;
    for (std::size_t k = 0; k < problem.logs.size(); ++k) {
      const Log& log = problem.logs[k];
      const auto& window = problem.signals[k].window;
      std::vector<Index>& at = instants_.emplace_back();
      for (Index i = 0; i < log.samples(); i += every) {
        if (!window || (log.t[i] >= (*window)[0] && log.t[i] <= (*window)[1])) {
          at.push_back(i);
        }
      }
      count_ += static_cast<Index>(at.size());
      every_.push_back(static_cast<double>(every) / log.f_m);
    }
  }

  // Steps from `start` on, with out.output_error; whether they came to rest. Where a start is missing or can
  // not be simulated, they begin with the estimate by least squares, or with the robot description.
  bool iterate(const std::optional<Vector>& start) {
    const LeastSquares ls = least_squares(problem_.data.groups, base().size(), joint_weights(problem_));
    if (!ls.full_rank()) {
      explain_rank(base(), ls.rank, ls.undetermined, "these data", out_);
      return false;
    }
    Vector chi = start.value_or(ls.chi);
    gains_ = loops_.simulated(chi, {});
    for (const Vector& other : {ls.chi, base().from_standard(problem_.robot.chi_st())}) {
      if (!gains_.failure.empty() && !gains_.gave_up && problem_.iv().chi_0.size() == 0) {
        gains_ = loops_.simulated(chi = other, {});
      }
    }
    if (!gains_.failure.empty()) {
      return fail("the start can not be simulated: ", gains_);
    }
    out_.status = Status::identified;
    out_.reasons.clear();
    unknowns_ = loop_unknowns(method_, *gains_.laws.front());
    loops_.estimate_beside(unknowns_);
    const auto g = std::ssize(unknowns_);
    prior_ = Vector::NullaryExpr(g, [&](Index i) { return unknowns_[static_cast<std::size_t>(i)].prior; });
    prior_sigma_ =
        Vector::NullaryExpr(g, [&](Index i) { return unknowns_[static_cast<std::size_t>(i)].sigma; });
    steps_.resize(base().size() + g);
    Vector own = difference_step * ls.unit_covariance.diagonal().cwiseSqrt();
    if (g > 0) {
      own = own.cwiseMax(least_part * chi.cwiseAbs());
    }
    steps_ << own, (prior_step * prior_sigma_).cwiseMin(longest_step);
    errors_ = errors(gains_);
    OutputErrorReport& report = out_.output_error.emplace();
    report.instants = count_;
    report.start = chi;
    report.start_error = rms(errors_);
    Vector all(steps_.size());
    all << chi, prior_;
    for (chi_ = loops_.feasible(all);; ++report.steps) {
      report.joint_error = rms(errors_);
      if (!linearise()) {
        return false;
      }
      const double step = largest(step_);
      if (step <= at_rest * method_.parameter_tolerance) {
        return true;
      }
      if (report.steps == method_.max_iterations) {
        out_.status = Status::not_converged;
        out_.reasons.push_back("not converged after " + counted(report.steps, "step") +
                               ": parameters still move by " + number_that_says(step, 3) +
                               " standard deviations");
        return false;
      }
      const double before = cost(errors_, chi_);
      const bool closer = advance(before);
      const double gained = closer ? 1.0 - cost(errors_, chi_) / before : 0.0;
      const bool rests = gained <= method_.tolerance && step <= method_.parameter_tolerance;
      if (closer && rests) {
        // Statistics belong to where the last step ended.
        ++report.steps;
        report.joint_error = rms(errors_);
        return linearise();
      }
      if (!closer) {
        if (rests || promised() <= promised_in_vain) {
          return true;
        }
        out_.status = Status::not_converged;
        out_.reasons.push_back(
            "a step of " + number(step, 3) +
            " standard deviations and shorter ones lead away from the positions of the log");
        return false;
      }
    }
  }

  // Whether the law asks for other torques of another plant. Then its gains are as wrong as the start.
  [[nodiscard]] bool gains_follow_the_start() const {
    constexpr double small = 1e-6;  // far below what saturates
    const DynamicModel heavier(problem_.robot, 2.0 * gains_.chi_st);
    const Vector J = 2.0 * gains_.J;
    const auto other = law_of(problem_.iv().control, {problem_.robot, heavier, J});
    const Vector none = Vector::Zero(problem_.joints());
    const Vector error = Vector::Constant(problem_.joints(), small);
    const auto asked = [&](const ControlLaw& law) {
      Vector v(problem_.joints());
      Vector rates(law.states());
      law.control({0.0, none, none, error, error, none}, Vector::Zero(law.states()), v, rates);
      return v;
    };
    return asked(*other) != asked(*gains_.laws.front());
  }

  // The unknowns of the loop, their deviations left open.
  [[nodiscard]] std::vector<LoopEstimate> loop() const {
    const std::vector<Gain> gains = gains_.laws.front()->description().gains;
    std::vector<LoopEstimate> out;
    for (std::size_t i = 0; i < unknowns_.size(); ++i) {
      const LoopUnknown& unknown = unknowns_[i];
      const double value = chi_[base().size() + static_cast<Index>(i)];
      if (unknown.gain < 0) {
        out.push_back({.name = "delay",
                       .joint = {},
                       .prior = unknown.prior,
                       .prior_sigma = unknown.sigma,
                       .value = value});
        continue;
      }
      const Gain& gain = gains[static_cast<std::size_t>(unknown.gain)];
      const double before = gain.values[unknown.joint];
      out.push_back({.name = gain.name,
                     .joint = problem_.robot.joints[static_cast<std::size_t>(unknown.joint)].name,
                     .prior = before,
                     .prior_sigma = std::abs(before) * unknown.sigma,
                     .value = before * value});
    }
    return out;
  }

  // Where the steps came to rest.
  [[nodiscard]] Estimate estimate() const {
    const Index b = base().size();
    Estimate out;
    out.chi = chi_.head(b);
    out.weights = torque_weights();
    out.rows = count_ * problem_.joints();
    out.rank = b;
    out.condition = solution_.condition;
    out.sigma = out.sigma_rho = sigma();
    // χ behind the unknowns of the loop: what these take is not its own.
    StreamingQr turned(chi_.size(), 1);
    Matrix R(chi_.size(), chi_.size());
    R << solution_.R.rightCols(prior_.size()), solution_.R.leftCols(b);
    turned.add(R, Vector::Zero(chi_.size()));
    out.root = solved(std::move(turned)).R.bottomRightCorner(b, b);
    out.unit_covariance = out.bread = solution_.unit_covariance.topLeftCorner(b, b);
    out.signals = problem_.signals;
    out.scores = scores();
    return out;
  }

 private:
  [[nodiscard]] const BaseParameters& base() const { return problem_.base; }

  bool fail(const std::string& what, const SimulatedLoops& loops) {
    out_.status = loops.gave_up ? Status::gave_up : Status::not_simulable;
    out_.reasons.push_back(what + loops.failure);
    return false;
  }

  [[nodiscard]] PositionErrors errors(const SimulatedLoops& loops) const {
    return made_of(instants_.size(), [&](std::size_t k) {
      return Matrix(problem_.logs[k].q(instants_[k], Eigen::all) -
                    loops.motions[k].q(instants_[k], Eigen::all));
    });
  }

  // Of each joint, (n).
  [[nodiscard]] Vector rms(const PositionErrors& errors) const {
    Vector squares = Vector::Zero(problem_.joints());
    for (const Matrix& e : errors) {
      squares += e.colwise().squaredNorm().transpose();
    }
    return (squares / static_cast<double>(count_)).cwiseSqrt();
  }

  [[nodiscard]] double misfit(const PositionErrors& errors) const {
    return rms(errors).cwiseProduct(weights_).squaredNorm();
  }

  // What the unknowns of the loop are off what was known of them, in its deviations. Of gains it is the
  // logarithm: by differences the scale of many gains would come out too small, where they scatter less.
  [[nodiscard]] Vector off(const Vector& chi) const {
    return Vector::NullaryExpr(prior_.size(), [&](Index i) {
      const double value = chi[base().size() + i];
      return (is_gain(i) ? std::log(value / prior_[i]) : value - prior_[i]) / prior_sigma_[i];
    });
  }
  [[nodiscard]] bool is_gain(Index i) const { return unknowns_[static_cast<std::size_t>(i)].gain >= 0; }

  // With them, as the last linearisation weighs them.
  [[nodiscard]] double cost(const PositionErrors& errors, const Vector& chi) const {
    return misfit(errors) + (off_weight_ * off(chi)).squaredNorm() / static_cast<double>(count_);
  }

  // Standard deviation of a weighted position error.
  [[nodiscard]] double sigma() const {
    const auto rows = static_cast<double>(count_ * problem_.joints());
    return std::sqrt(misfit(errors_) * static_cast<double>(count_) /
                     std::max(rows - static_cast<double>(base().size()), 1.0));
  }

  // Part of the sum of squares that the whole step would take off if positions were linear in the parameters.
  [[nodiscard]] double promised() const {
    const Vector fitted = solution_.R * solution_.chi;
    const double off = fitted.squaredNorm() - (fitted - solution_.R * step_).squaredNorm();
    return off / (cost(errors_, chi_) * static_cast<double>(count_));
  }

  // The largest entry of a step, in standard deviations.
  [[nodiscard]] double largest(const Vector& step) const {
    return (step.array() / (sigma() * solution_.unit_covariance.diagonal().array().sqrt())).abs().maxCoeff();
  }

  // Derivatives of the positions at chi_ by all parameters, and the step that they ask for; false where there
  // are none.
  bool linearise() {
    const Index b = chi_.size();
    const Index n = problem_.joints();
    weights_ = Vector::Ones(n);
    if (method_.weights == Iv::Weights::by_joint) {
      weights_ = rms(errors_).unaryExpr([](double e) { return e > 0.0 ? 1.0 / e : 1.0; });
    }
    derivatives_.assign(errors_.size(), {});
    for (std::size_t k = 0; k < errors_.size(); ++k) {
      derivatives_[k].assign(static_cast<std::size_t>(n), Matrix(errors_[k].rows(), b));
    }
    for (Index first = 0; first < b; first += loops_.worthwhile()) {
      if (!differentiate(first, std::min(loops_.worthwhile(), b - first))) {
        return false;
      }
    }
    leave_scale_open();
    StreamingQr qr(b, 1);
    for (std::size_t k = 0; k < errors_.size(); ++k) {
      for (Index j = 0; j < n; ++j) {
        qr.add(weights_[j] * derivatives_[k][static_cast<std::size_t>(j)], weights_[j] * errors_[k].col(j));
      }
    }
    off_weight_ = sigma();
    prior_weights_ = off_weight_ * prior_sigma_.cwiseInverse();
    for (Index i = 0; i < prior_.size(); ++i) {
      prior_weights_[i] /= is_gain(i) ? chi_[base().size() + i] : 1.0;
    }
    Matrix prior = Matrix::Zero(prior_.size(), b);
    prior.rightCols(prior_.size()) = prior_weights_.asDiagonal();
    qr.add(prior, -off_weight_ * off(chi_));
    solution_ = solved(std::move(qr));
    if (!solution_.full_rank()) {
      for (std::vector<Index>& set : solution_.undetermined) {
        std::erase_if(set, [&](Index i) { return i >= base().size(); });
      }
      explain_rank(base(), solution_.rank, solution_.undetermined, "the positions of the simulated loops",
                   out_);
      return false;
    }
    hold_friction_at_zero();
    return true;
  }

  // What differences tell of the scale by their errors alone is taken off the derivatives by one gain.
  void leave_scale_open() {
    Vector scale = chi_;
    Index gain = -1;
    for (std::size_t i = 0; i < unknowns_.size(); ++i) {
      const Index at = base().size() + static_cast<Index>(i);
      scale[at] = unknowns_[i].in_signals ? chi_[at] : 0.0;
      gain = unknowns_[i].in_signals ? at : gain;
    }
    if (gain < 0) {
      return;
    }
    double grown = 0.0;
    double one = 0.0;
    for (const auto& log : derivatives_) {
      for (const Matrix& J : log) {
        const Vector together = J * scale;
        grown += together.squaredNorm();
        one += J.col(gain).squaredNorm();
      }
    }
    if (grown < scale_seen * scale_seen * one) {
      // The scale is that which is known beforehand: no simulation is needed for it, nor tells it.
      Vector alike = Vector::Ones(chi_.size());
      const Vector known =
          (scale.tail(prior_.size()).array() != 0.0).select(prior_sigma_.cwiseInverse(), 0.0);
      const double factor = std::exp(-known.dot(off(chi_)) / known.squaredNorm());
      alike = (scale.array() != 0.0).select(factor * alike, alike);
      chi_ = chi_.cwiseProduct(alike);
      scale = scale.cwiseProduct(alike);
      for (auto& log : derivatives_) {
        for (Matrix& J : log) {
          J = J * alike.cwiseInverse().asDiagonal();
          const Vector together = J * (scale / scale[gain]);
          J.col(gain) -= together;
        }
      }
    }
  }

  // Friction that is zero and would become negative stays where it is: the step is that of all others.
  void hold_friction_at_zero() {
    step_ = solution_.chi;
    Vector held = Vector::Zero(step_.size());
    for (bool more = true; more;) {
      const Vector moved = loops_.feasible(chi_ + step_) - chi_;
      const Eigen::Array<bool, Eigen::Dynamic, 1> stays =
          held.array() == 0.0 && moved.array().abs() <= at_zero * step_.array().abs() && step_.array() != 0.0;
      more = stays.any();
      held += stays.matrix().cast<double>();
      if (more) {
        StreamingQr qr(step_.size(), 1);
        qr.add(solution_.R, solution_.R * solution_.chi);
        qr.add(Matrix(held.asDiagonal()) * (holding * solution_.R.norm()), Vector::Zero(step_.size()));
        step_ = solved(std::move(qr)).chi;
      }
    }
  }

  // The fit of all parameters to rows that are weighted already.
  [[nodiscard]] LeastSquares solved(StreamingQr qr) const {
    const Index columns = qr.columns();
    RowGroup group{std::vector<Index>(static_cast<std::size_t>(columns)), std::move(qr)};
    std::iota(group.columns.begin(), group.columns.end(), Index{0});
    const double one = 1.0;
    return least_squares(std::span(&group, 1), columns, std::span(&one, 1));
  }

  // Fills columns of the derivatives; false where there is none. With unknowns of the loop the differences
  // are central: what others are off along the scale of all would count as knowledge of it.
  bool differentiate(Index first, Index count) {
    std::vector<SimulatedLoops> all =
        loops_.simulated(changed_one_by_one(chi_, steps_, first, count), {}, &gains_);
    std::vector<SimulatedLoops> behind;
    if (!unknowns_.empty()) {
      behind = loops_.simulated(backwards(first, count), {}, &gains_);
    }
    for (Index i = first; i < first + count; ++i) {
      SimulatedLoops& loops = all[static_cast<std::size_t>(i - first)];
      double step = steps_[i];
      PositionErrors from = errors_;
      if (!loops.failure.empty()) {
        step = -step;
        loops = loops_.simulated(changed_one_by_one(chi_, -steps_, i, 1).front(), {}, &gains_);
      } else if (!behind.empty() && behind[static_cast<std::size_t>(i - first)].failure.empty()) {
        from = errors(behind[static_cast<std::size_t>(i - first)]);
        step += is_feasible(i, -step) ? step : 0.0;
      }
      if (!loops.failure.empty()) {
        return fail("parameters near the estimate can not be simulated: ", loops);
      }
      const PositionErrors moved = errors(loops);
      for (std::size_t k = 0; k < moved.size(); ++k) {
        for (Index j = 0; j < problem_.joints(); ++j) {
          derivatives_[k][static_cast<std::size_t>(j)].col(i) = (from[k].col(j) - moved[k].col(j)) / step;
        }
      }
    }
    return true;
  }

  // Whether parameter i may move so far.
  [[nodiscard]] bool is_feasible(Index i, double by) const {
    const Vector there = changed_one_by_one(chi_, Vector::Constant(chi_.size(), by), i, 1).front();
    return std::abs(loops_.feasible(there)[i] - there[i]) <= at_zero * std::abs(by);
  }

  // Parameters that are moved against their steps, or not where they may not.
  [[nodiscard]] std::vector<Vector> backwards(Index first, Index count) const {
    Vector steps = -steps_;
    for (Index i = first; i < first + count; ++i) {
      steps[i] *= is_feasible(i, steps[i]) ? 1.0 : 0.0;
    }
    return changed_one_by_one(chi_, steps, first, count);
  }

  // Takes the step or a part of it that leads closer; false where none does.
  bool advance(double before) {
    double part = 1.0;
    for (int halving = 0; halving <= most_shorter; ++halving, part *= 0.5) {
      const Vector chi = loops_.feasible(chi_ + part * step_);
      const SimulatedLoops loops = loops_.simulated(chi, {}, &gains_);
      if (!loops.failure.empty()) {
        continue;
      }
      PositionErrors closer = errors(loops);
      if (cost(closer, chi) < before) {
        chi_ = chi;
        errors_ = std::move(closer);
        return true;
      }
    }
    return false;
  }

  // 1/σ of each joint's rows of torques with the estimate.
  [[nodiscard]] std::vector<double> torque_weights() const {
    return made_of(problem_.data.groups, [&](const RowGroup& group) {
      return residual_weight(group, chi_.head(base().size())).value_or(1.0);
    });
  }

  // Instants after which a log's motion repeats itself, all where it does not. The steps of an encoder, and
  // errors of the model, are then the same again, and another period tells no more of them.
  [[nodiscard]] Index period(std::size_t k) const {
    const Matrix q = problem_.logs[k].q(instants_[k], Eigen::all);
    const Index m = q.rows();
    const Index stride = 1 + m / most_looked_at;
    const double spread = (q.rowwise() - q.colwise().mean()).rowwise().squaredNorm().mean();
    const double close = as_close * as_close * errors_[k].rowwise().squaredNorm().mean();
    bool away = false;
    for (Index lag = 1; lag <= m - m / 4; ++lag) {
      Index compared = 0;
      Index back = 0;
      double squares = 0.0;
      for (Index i = 0; i + lag < m; i += stride) {
        const double off = (q.row(i + lag) - q.row(i)).squaredNorm();
        squares += off;
        back += off <= close ? 1 : 0;
        ++compared;
      }
      if (away && 4 * back >= 3 * compared) {
        return lag;
      }
      away = away || squares > spread * static_cast<double>(compared);
    }
    return m;
  }

  [[nodiscard]] EstimateScores scores() const {
    const Index b = chi_.size();
    EstimateScores out;
    out.bread = solution_.unit_covariance;
    out.of_prior = (sigma() * prior_weights_).cwiseAbs2();
    std::vector<Duration> compared;  // as logs of the instants
    std::vector<Duration> once;      // without what repeats
    for (std::size_t k = 0; k < errors_.size(); ++k) {
      compared.push_back({errors_[k].rows(), 1.0 / every_[k]});
      once.push_back({period(k), 1.0 / every_[k]});
    }
    const TimeIntervals intervals(compared, *std::ranges::max_element(every_));
    const TimeBlocks blocks(once, blocks_of_time);
    out.interval = intervals.seconds();
    out.blocks.assign(static_cast<std::size_t>(blocks.count()), {Matrix::Zero(b, b), Vector::Zero(b)});
    for (std::size_t k = 0; k < errors_.size(); ++k) {
      const Index repeats = once[k].samples;
      Matrix& series = out.series.emplace_back(Matrix::Zero(intervals.of(k, repeats - 1) + 1, b));
      for (Index i = 0; i < errors_[k].rows(); ++i) {
        BlockSums& block = out.blocks[static_cast<std::size_t>(blocks.of(k, i % repeats))];
        for (Index j = 0; j < problem_.joints(); ++j) {
          const double w = weights_[j] * weights_[j];
          const auto J = derivatives_[k][static_cast<std::size_t>(j)].row(i);
          const Vector score = w * errors_[k](i, j) * J.transpose();
          block.ZW.noalias() += w * J.transpose() * J;
          block.Z_rho += score;
          series.row(intervals.of(k, i % repeats)) += score;
        }
      }
    }
    return out;
  }

  const EstimationProblem& problem_;
  const Iv& method_;
  Estimated& out_;
  ClosedLoops loops_;
  std::vector<std::vector<Index>> instants_;  // that are compared, one list a log
  std::vector<double> every_;                 // time from one to the next [s]
  Index count_ = 0;                           // of all logs
  std::vector<LoopUnknown> unknowns_;         // g, behind χ in all that follows
  Vector prior_, prior_sigma_;                // of them, (g)
  double off_weight_ = 0.0;                   // of off(), beside weighted positions
  Vector prior_weights_;                      // the same of their differences, (g)
  Vector steps_;                              // of the differences, (b + g)
  SimulatedLoops gains_;                      // of the start, whose control law all others have
  Vector chi_;
  PositionErrors errors_;  // with chi_
  Vector weights_;         // 1/σ of each joint's positions, (n)
  // Derivatives of the positions at chi_: of each log and joint, (instants × b + g).
  std::vector<std::vector<Matrix>> derivatives_;
  LeastSquares solution_;  // of the step from chi_
  Vector step_;            // the same without friction that stays zero
};

}  // namespace

void output_error_estimate(const EstimationProblem& problem, Estimated& out) {
  const std::optional<Vector> start = start_of_loop_fit(problem, out);
  if (!start && out.status == Status::gave_up) {
    return;
  }
  OutputError solver(problem, out);
  if (solver.iterate(start)) {
    out.estimate = solver.estimate();
    out.output_error->loop = solver.loop();
    if (!solver.gains_follow_the_start()) {
      out.start.reset();
    }
  }
}

}  // namespace rivid::detail
