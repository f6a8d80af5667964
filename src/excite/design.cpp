#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <thread>

#include "dense.hpp"
#include "excite/design_parts.hpp"
#include "excite/prior.hpp"
#include "excite/problem.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"
#include "threads.hpp"

namespace rivid {

namespace {

using detail::Curve;
using detail::DenseCheck;
using detail::Problem;
using detail::Task;

// Soft maxima are above the maximum by log(200) / 300 = 1.8 % of half the range at most; near the end the
// sharper ones, shifted to what the dense grid shows, by nothing.
constexpr double first_rho = 300.0;
constexpr double last_rho = 1000.0;
constexpr int polishings = 3;  // of the best start; a choice: each takes a third of the evaluations
// What polishing may lose of the criterion without a word: of log det, a confidence ellipsoid √e times as
// large.
constexpr double told_loss = 1.0;
// Part of a limit that is kept free for peaks that move between polishing and check.
constexpr double reserve = 2e-4;
// Of a motion, as it is played.
constexpr double most_samples = 1e6;
// for each sample: 1600 in a period of the highest harmonic by default, between which a sine rises by 2e-6
constexpr Index denser = 40;
constexpr int poses = 500;  // random ones, then as many near the best one; a choice
constexpr int draws = 20;   // random motions from a pose; a choice
// What an objective counts that is not defined.
constexpr double undefined_objective = 1e6;

// The state that other motions pass through, for the torques that are predicted along them.
Matrix torque_weight(const Task& task, double frequency, std::uint64_t seed) {
  constexpr Index states = 1000;  // random ones of the mean; a choice
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  const Index n = task.robot.size();
  const MotionBounds& bounds = task.bounds;
  Motion motion{.q = Matrix(states, n), .qd = Matrix(states, n), .qdd = Matrix(states, n)};
  for (Index k = 0; k < states; ++k) {
    for (Index j = 0; j < n; ++j) {
      const double most = std::min(bounds.acceleration[j], bounds.velocity[j] * frequency);
      motion.q(k, j) = 0.5 * (bounds.lower[j] + bounds.upper[j]) +
                       0.5 * (bounds.upper[j] - bounds.lower[j]) * symmetric(random);
      motion.qd(k, j) = bounds.velocity[j] * symmetric(random);
      motion.qdd(k, j) = most * symmetric(random);
    }
  }
  detail::SampledRegressor regressor(task.robot, task.base);
  std::vector<Matrix> W;
  regressor.rows(motion, W);
  Matrix out = Matrix::Zero(task.base.size(), task.base.size());
  detail::add_information(regressor, W, task.weights, out);
  return out / task.weights.sum();
}

detail::Objective objective_of(const Task& task, const Curve& curve, const ExcitationOptions& options) {
  if (options.criterion == Criterion::torque) {
    return detail::TorqueError{torque_weight(task, curve.highest_frequency(), options.seed)};
  }
  if (options.criterion == Criterion::condition) {
    return detail::Condition{};
  }
  if (options.criterion == Criterion::parameters) {
    detail::Deviations out;
    std::vector<std::string> names(task.base.parameters.size());
    std::ranges::transform(task.base.parameters, names.begin(), &BaseParameter::name);
    for (const std::string& wanted : options.parameters) {
      const auto found = std::ranges::find(names, wanted);
      if (found == names.end()) {
        throw InputError("design: the robot has no base parameter " + in_quotes(wanted) +
                         did_you_mean(wanted, names));
      }
      out.parameters.push_back(found - names.begin());
    }
    return out;
  }
  return detail::Information{};
}

// One search after the other, each with its own scratch.
class Designer {
 public:
  Designer(const Robot& robot, const ExcitationOptions& options);

  // Starts of all seeds on some threads, each brought to its limits, then the best of them once more.
  Excitation designed();

  // Moves to the motion from rest at a pose, and from the motion to one.
  void add_lead(Excitation& found);

 private:
  struct Found {
    Vector rest;  // variables of the pose that the motion grew from
    Vector z;
    Vector kept;  // what of it keeps all limits on the dense grid
    double objective = std::numeric_limits<double>::infinity();  // of what is kept
    StartReport report;
  };

  Found search(std::uint64_t seed);
  Vector pose_at_rest(DenseCheck& check, std::mt19937_64& random) const;
  Vector random_motion(Problem& problem, const Vector& rest, std::mt19937_64& random) const;
  detail::MmaResult improved(Problem& problem, const Vector& z, int evaluations, std::string_view stage);
  void polish(Found& found, int rounds);
  [[nodiscard]] Vector drawn_peaks(const Curve& curve, const Vector& z) const;
  void leave_room(Found& best);
  std::optional<Vector> mended(Problem& problem, DenseCheck& check, const Vector& rest, Vector z) const;
  [[noreturn]] void refuse(const Found& best) const;
  void check(const Reference& reference, Index intervals, std::vector<ClearanceUse>& found) const;
  void tell_loss(double kept, Excitation& found) const;
  void tell(std::string_view stage, double objective);
  [[nodiscard]] bool is_stopped();
  [[nodiscard]] Index samples() const {
    const bool spline = options_.curve == CurveKind::spline;
    return options_.samples > 0 ? options_.samples : spline ? 16 * options_.points : 40 * options_.harmonics;
  }
  [[nodiscard]] Index played() const {
    return static_cast<Index>(std::floor(options_.duration * options_.rate_hz + 1e-6)) + 1;
  }
  [[nodiscard]] Index dense() const { return std::max(denser * samples() + 1, played()); }

  const ExcitationOptions& options_;
  std::vector<Finding> findings_;
  Task task_;
  std::unique_ptr<Curve> curve_;
  std::mutex telling_;
  std::atomic<int> done_ = 0;
  std::atomic<bool> stopped_ = false;
  double best_ = std::numeric_limits<double>::infinity();
};

std::unique_ptr<Curve> curve_within(const Robot& robot, const Task& task, const ExcitationOptions& options) {
  if (const auto fault = missing_limit(robot, task.bounds)) {
    throw InputError("design: " + *fault);
  }
  return detail::curve_of(options, task.bounds);
}

Designer::Designer(const Robot& robot, const ExcitationOptions& options)
    : options_(options),
      task_(detail::task_of("design", robot, options, options.rate_hz, findings_)),
      curve_(curve_within(robot, task_, options)) {
  task_.objective = objective_of(task_, *curve_, options);
}

bool Designer::is_stopped() {
  // The question may come from several threads.
  const std::scoped_lock lock(telling_);
  if (!stopped_ && options_.stopped && options_.stopped()) {
    stopped_ = true;
  }
  return stopped_;
}

void Designer::tell(std::string_view stage, double objective) {
  if (!options_.progress) {
    return;
  }
  // Of each start its search and the first polishing, of the best start the others.
  const double total =
      (options_.starts + (options_.starts + polishings - 1.0) / polishings) * options_.evaluations;
  const std::scoped_lock lock(telling_);
  best_ = std::min(best_, objective);
  options_.progress(std::string(stage) + ", " + number(-best_, 5),
                    std::min(1.0, static_cast<double>(++done_) / total));
}

// The first of random poses with the room that soft maxima need, else the one with the most.
Vector Designer::pose_at_rest(DenseCheck& check, std::mt19937_64& random) const {
  const double room = std::log(static_cast<double>(samples())) / first_rho + reserve;
  std::uniform_real_distribution<double> within(0.1, 0.9);
  const MotionBounds& bounds = task_.bounds;
  double least = std::numeric_limits<double>::infinity();
  Index limit = 0;
  Vector least_of_each;
  Vector best;
  Vector best_pose(curve_->joints());
  for (int k = 0; k < (curve_->starts_fixed() ? 1 : 2 * poses); ++k) {
    Vector pose = best_pose;
    for (Index j = 0; j < pose.size(); ++j) {
      // A random pose rarely suits all of many joints: then a few of the best one's are drawn again.
      if (k < poses || random() % 4 == 0) {
        pose[j] = bounds.lower[j] + within(random) * (bounds.upper[j] - bounds.lower[j]);
      }
    }
    const Vector z = curve_->at_rest(pose);
    const Vector values = check(z);
    least_of_each = k == 0 ? values : Vector(least_of_each.cwiseMin(values));
    Index at = 0;
    const double worst = values.maxCoeff(&at);
    if (worst < least) {
      least = worst;
      limit = at;
      best = z;
      best_pose = pose;
    }
    if (least < -room) {
      return best;
    }
  }
  if (least < -reserve) {
    return best;
  }
  // A limit that none of the poses keeps says more than the best pose.
  Index never = 0;
  if (least_of_each.maxCoeff(&never) >= -reserve) {
    limit = never;
    least = least_of_each[never];
  }
  throw InputError(std::string("design: ") +
                   (curve_->starts_fixed()
                        ? "the robot can not rest at start within its limits: "
                        : "no pose was found in which the robot can rest within its limits; in the "
                          "best of " +
                              std::to_string(2 * poses) + " random ones ") +
                   detail::excess_in_words(task_, limit, least));
}

// A random motion about the pose, as large as the limits allow.
Vector Designer::random_motion(Problem& problem, const Vector& rest, std::mt19937_64& random) const {
  constexpr int shrinkings = 60;  // the last is 0.8^59 = 2e-6: then a motion stands
  constexpr double factor = 0.8;  // each; a choice: the largest motion that fits is met to a fifth
  std::normal_distribution<double> normal;
  Vector worst;
  for (int draw = 0; draw < draws; ++draw) {
    Vector step(rest.size());
    for (double& x : step) {
      x = normal(random);
    }
    for (Index j = 0; !curve_->starts_fixed() && j < curve_->joints(); ++j) {
      step[j * curve_->per_joint()] = 0.0;
    }
    for (int k = 0; k < shrinkings; ++k, step *= factor) {
      const Problem::Value value = problem(rest + step);
      if (value.limits.maxCoeff() <= 0.0) {
        if (value.defined) {
          return rest + step;
        }
        break;
      }
      worst = value.limits;
    }
  }
  throw InputError("design: no motion within the limits was found that determines all base parameters, in " +
                   std::to_string(draws) + " random ones; " +
                   (worst.size() > 0 ? [&] {
                     Index at = 0;
                     (void)worst.maxCoeff(&at);
                     return detail::limit_in_words(task_, at) + " leaves the least room";
                   }()
                                     : std::string("a longer duration gives more room")));
}

detail::MmaResult Designer::improved(Problem& problem, const Vector& z, int evaluations,
                                     std::string_view stage) {
  // Differences of the objective below 1 % of a standard deviation of all parameters do not matter.
  const double tolerance = 2e-3;
  return detail::minimised(
      [&](const Vector& at, Vector& gradient, Matrix& jacobian) -> detail::MmaValue {
        Problem::Value value = problem(at, &gradient, &jacobian);
        if (!value.defined) {
          gradient.setZero(problem.variables());
          jacobian.setZero(problem.variables(), problem.limits());
          value.objective = undefined_objective;
        } else if (value.limits.maxCoeff() <= 0.0) {
          tell(stage, value.objective);
        }
        return {value.objective, std::move(value.limits)};
      },
      z, {.tolerance = tolerance, .evaluations = evaluations, .stopped = [this] { return is_stopped(); }});
}

Designer::Found Designer::search(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  DenseCheck check(task_, *curve_, 2);
  Problem problem(task_, *curve_, samples(), first_rho);
  Found out;
  out.rest = pose_at_rest(check, random);
  // Where no pose has that room, from what the soft maxima are at rest.
  const Vector soft = problem(out.rest).limits;
  problem.shift(out.rest, (soft.array() > 0.0).select(check(out.rest), soft));
  const Vector begin = random_motion(problem, out.rest, random);
  out.report.seed = seed;
  out.report.objective_begin = problem(begin).objective;
  const detail::MmaResult result =
      improved(problem, begin, options_.evaluations, "start " + std::to_string(seed));
  out.z = result.z;
  out.report.objective_end = result.objective;
  out.report.evaluations = result.evaluations;
  polish(out, 1);
  return out;
}

// The nearest motion that keeps the limits of the problem, by Newton's steps along the gradients of those
// that are exceeded, each halved until it makes the worst better, or is a hundredth; nothing where the steps
// do not come to one.
std::optional<Vector> within_limits(Problem& problem, Vector z) {
  constexpr int steps = 20;          // of Newton; a choice that ends what does not come near
  constexpr double smallest = 1e-2;  // part of a step, below which it is not halved again
  // [parts of a limit] limits that a step would soon reach are kept as well
  constexpr double inner = 0.5 * reserve;
  Vector gradient;
  Matrix jacobian;
  for (int k = 0; k < steps; ++k) {
    const Problem::Value value = problem(z, &gradient, &jacobian);
    const double worst = value.limits.maxCoeff();
    if (worst <= 0.0) {
      return z;
    }
    if (!value.defined) {
      return std::nullopt;
    }
    std::vector<Index> exceeded;
    for (Index l = 0; l < value.limits.size(); ++l) {
      if (value.limits[l] > -inner) {
        exceeded.push_back(l);
      }
    }
    const Vector beyond = value.limits(exceeded).array() + inner;
    const Vector step =
        detail::minimum_norm_solution(jacobian(Eigen::all, exceeded).transpose(), beyond, 1e-9);
    double part = 1.0;
    while (part > smallest && !(problem(z - part * step).limits.maxCoeff() < worst)) {
      part *= 0.5;
    }
    z -= part * step;
  }
  return std::nullopt;
}

// A motion near this one that keeps all limits on the dense grid: mended where it exceeds them, and where
// that fails, as large a part of it as does; nothing where a small one does not, either.
std::optional<Vector> Designer::mended(Problem& problem, DenseCheck& check, const Vector& rest,
                                       Vector z) const {
  constexpr int rounds = 40;  // of mending; a choice that ends what does not come to an end
  const Vector whole = z;
  for (int k = 0; k < rounds; ++k) {
    const Vector found = check(z);
    if (found.maxCoeff() <= 0.0) {
      return z;
    }
    problem.shift(z, found.array() + reserve);
    std::optional<Vector> inside = within_limits(problem, z);
    if (!inside) {
      break;
    }
    z = *std::move(inside);
  }
  constexpr double smallest = 1e-3;  // part of the motion; a smaller one excites nothing
  double part = 1.0;
  for (double step = 1e-4; part > smallest; part = std::max(part - step, 0.8 * part), step *= 1.3) {
    Vector at = rest + part * (whole - rest);
    if (check(at).maxCoeff() <= 0.0) {
      return at;
    }
  }
  return std::nullopt;
}

// Brings a start to its limits, in so many rounds, with sharper maxima.
void Designer::polish(Found& found, int rounds) {
  Problem problem(task_, *curve_, samples(), last_rho);
  DenseCheck check(task_, *curve_, dense());
  const auto keep = [&](const std::optional<Vector>& candidate) {
    if (!candidate) {
      return;
    }
    const Problem::Value value = problem(*candidate);
    if (value.defined && value.objective < found.objective) {
      found.kept = *candidate;
      found.objective = value.objective;
    }
  };
  keep(mended(problem, check, found.rest, found.z));
  for (int k = 0; k < rounds && !is_stopped(); ++k) {
    // Not from what was mended: from beyond its limits the search leaves poor optima, 10 to 20 nats below
    // others.
    problem.shift(found.z, check(found.z).array() + reserve);
    const int evaluations = std::max(options_.evaluations / polishings, 1);
    const detail::MmaResult result = improved(problem, found.z, evaluations, "polishing");
    found.report.evaluations += result.evaluations;
    const bool within = problem(result.z).limits.maxCoeff() <= 0.0;
    keep(mended(problem, check, found.rest, result.z));
    // Where neither the search nor mending has come back within the limits but at a loss, the next one begins
    // there.
    const bool lost = !within && found.objective > result.objective + told_loss;
    found.z = lost && found.kept.size() > 0 ? found.kept : result.z;
  }
}

// Of robots that the description may stand for, the largest torque of each joint along a motion, (n).
Vector Designer::drawn_peaks(const Curve& curve, const Vector& z) const {
  // So many that hardly one of a hundred others needs more.
  constexpr Index robots = 1500;
  Matrix chi(task_.base.size(), robots);
  for (Index k = 0; k < robots; ++k) {
    const auto seed = options_.seed + static_cast<std::uint64_t>(k);
    const Robot drawn = detail::drawn_about(task_.robot, options_.limits.prior_spread, seed);
    chi.col(k) = task_.base.from_standard(drawn.chi_st());
  }
  const Vector t = Vector::LinSpaced(8 * samples(), 0.0, curve.duration());
  detail::SampledRegressor regressor(task_.robot, task_.base);
  Vector out = Vector::Zero(curve.joints());
  regressor.pieces(curve.motion(curve.tables(t), curve.coefficients(z)),
                   [&](Index, std::span<const Matrix> W) {
                     for (std::size_t i = 0; i < W.size(); ++i) {
                       const Matrix tau = W[i] * chi(regressor.columns(i), Eigen::all);
                       double& peak = out[static_cast<Index>(i)];
                       peak = std::max(peak, tau.cwiseAbs().maxCoeff());
                     }
                   });
  return out;
}

// Takes as much from the torques that the motion may use as drawn robots need beyond their limits.
void Designer::leave_room(Found& best) {
  constexpr int rounds = 6;  // a choice: each takes two polishings
  // of the torque, beyond what drawn robots lack; a choice that spares a round
  constexpr double little = 5e-3;
  const Vector whole = task_.bounds.torque / options_.limits.torque_share;
  Vector over;
  for (int k = 0; best.kept.size() > 0; ++k) {
    over = drawn_peaks(*curve_, best.kept).cwiseQuotient(whole);
    if (over.maxCoeff() <= 1.0) {
      return;
    }
    if (k == rounds) {
      break;
    }
    task_.bounds.torque = task_.bounds.torque.cwiseQuotient((over.array() + little).max(1.0).matrix());
    best.kept.resize(0);
    best.objective = std::numeric_limits<double>::infinity();
    polish(best, polishings - 1);
  }
  Index joint = 0;
  const double worst = over.maxCoeff(&joint);
  throw InputError("design: prior_spread is " + number(options_.limits.prior_spread) + ": " +
                   task_.robot.joints[static_cast<std::size_t>(joint)].name + " needs up to " +
                   number(100.0 * worst, 3) +
                   " % of its torque in robots that differ by so much from the description; "
                   "give the masses better, or more torque");
}

// What keeps the best of the starts from any motion.
void Designer::refuse(const Found& best) const {
  DenseCheck check(task_, *curve_, dense());
  // Dry friction that is more than the torque may be lets a joint rest, but not move.
  constexpr double little = 0.01;
  Index at = 0;
  const double excess = check(best.rest + little * (best.z - best.rest)).maxCoeff(&at);
  if (excess > 0.0) {
    throw InputError("design: no motion within the limits was found: in a small one " +
                     detail::excess_in_words(task_, at, excess));
  }
  const double whole = check(best.z).maxCoeff(&at);
  throw InputError("design: no motion within the limits was found: between the instants of the search " +
                   detail::excess_in_words(task_, at, whole) + "; try another seed, or more samples");
}

// The finished motion, as it is played, by code that shares nothing with the search, on instants twice as
// dense.
void Designer::check(const Reference& reference, Index intervals, std::vector<ClearanceUse>& found) const {
  // [m] a choice: above clearance_reserve, below any clearance that matters
  constexpr double tolerance = 1e-3;
  const std::vector<bool> kept = task_.clearances->kept();
  if (kept.empty()) {
    return;
  }
  const double rate = static_cast<double>(intervals) / reference.duration();
  Matrix q(intervals + 1, curve_->joints());
  Vector at(q.cols());
  Vector qd(q.cols());
  Vector qdd(q.cols());
  for (Index k = 0; k <= intervals; ++k) {
    reference.at(static_cast<double>(k) / rate, at, qd, qdd);
    q.row(k) = at;
  }
  found = detail::checked_clearances(task_.robot, task_.space, kept, q, rate);
  for (const ClearanceUse& use : found) {
    if (use.distance < use.wanted - tolerance) {
      throw InputError("design: the motion that was found brings " + use.first + " to " +
                       number(use.distance, 4) + " m from " + use.second + " at " + number(use.time, 4) +
                       " s, where it must be at least " + number(use.wanted, 4) +
                       " m; a larger number of samples keeps it");
    }
  }
}

// What keeping the limits on the dense grid cost against the best that the searches found.
void Designer::tell_loss(double kept, Excitation& found) const {
  const double searched = std::ranges::min(found.starts, {}, &StartReport::objective_end).objective_end;
  const double lost = kept - searched;
  if (lost > told_loss) {
    found.forecast.findings.push_back(Finding{
        "polishing_lost",
        {},
        "the best search came to " + number(-searched, 5) + ", within all limits between its instants " +
            number(-kept, 5) + " are left; another seed, more starts or more samples may keep more"});
  }
}

Excitation Designer::designed() {
  const auto starts = static_cast<std::size_t>(options_.starts);
  std::vector<Found> found(starts);
  std::vector<std::exception_ptr> faults(starts);
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    // The first start is made in any case: there is a motion then.
    for (std::size_t k = next++; k < starts && (k == 0 || !is_stopped()); k = next++) {
      try {
        found[k] = search(options_.seed + k);
      } catch (...) {
        faults[k] = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    const int most = std::min(detail::useful_threads(options_.threads), options_.starts);
    for (int t = 1; t < most && detail::started(threads, work);) {
      ++t;
    }
    work();
  }
  Excitation out;
  std::vector<Found*> order;
  for (std::size_t k = 0; k < starts; ++k) {
    if (!faults[k] && found[k].rest.size() > 0) {  // the latter: begun before the search was stopped
      out.starts.push_back(found[k].report);
      order.push_back(&found[k]);
    }
  }
  if (order.empty()) {
    std::rethrow_exception(faults.front());
  }
  Found& best = **std::ranges::min_element(order, {}, [](const Found* each) { return each->objective; });
  if (best.kept.size() == 0) {
    refuse(best);
  }
  polish(best, polishings - 1);
  const double polished = best.objective;
  if (options_.limits.prior_spread > 0.0 && task_.chi.size() > 0) {
    leave_room(best);
  }
  const Vector& z = best.kept;
  out.best_start = std::ranges::find(out.starts, best.report.seed, &StartReport::seed) - out.starts.begin();
  out.stopped = stopped_;
  out.series = curve_->series(z);
  out.t = Vector::LinSpaced(played(), 0.0, static_cast<double>(played() - 1) / options_.rate_hz);
  out.motion = curve_->motion(curve_->tables(out.t), curve_->coefficients(z));
  out.forecast = forecast(task_.robot, out.motion, options_.rate_hz, options_);
  tell_loss(polished, out);
  check(*out.reference(), 2 * dense(), out.forecast.clearances);
  return out;
}

std::unique_ptr<const Reference> with_lead(const PointToPoint& in, std::unique_ptr<const Reference> between,
                                           const PointToPoint& out) {
  std::vector<std::unique_ptr<const Reference>> parts;
  parts.push_back(std::make_unique<PointToPointReference>(in));
  parts.push_back(std::move(between));
  parts.push_back(std::make_unique<PointToPointReference>(out));
  return std::make_unique<detail::SequenceReference>(std::move(parts));
}

void Designer::add_lead(Excitation& found) {
  const double rate = options_.rate_hz;
  std::unique_ptr<const Reference> between = found.reference();
  const Vector& to = options_.lead_to.size() > 0 ? options_.lead_to : options_.lead_from;
  const Vector rest = found.motion.q.row(0);
  const Vector middle = found.motion.q.colwise().mean();
  const auto suits = [&](const Curve& line) {
    return options_.limits.prior_spread == 0.0 || task_.chi.size() == 0 ||
           (drawn_peaks(line, Vector::Ones(line.variables())) * options_.limits.torque_share)
                   .cwiseQuotient(task_.bounds.torque)
                   .maxCoeff() <= 1.0;
  };
  found.lead_in = detail::lead("lead_from", task_, options_.lead_from, rest, middle, rate, 0.0, suits);
  // The whole ends with a sample.
  const double more = std::ceil(between->duration() * rate - 1e-6) / rate - between->duration();
  found.lead_out = detail::lead("lead_to", task_, rest, to, middle, rate, more, suits);
  constexpr Index intervals = 5000;  // of a lead that are checked; a choice
  std::vector<ClearanceUse> along;
  for (const PointToPoint& moves : {*found.lead_in, *found.lead_out}) {
    check(PointToPointReference(moves), intervals, along);
  }
  const std::unique_ptr<const Reference> whole =
      with_lead(*found.lead_in, std::move(between), *found.lead_out);
  const auto samples = static_cast<Index>(std::lround(whole->duration() * rate)) + 1;
  found.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / rate);
  found.motion = {
      .q = Matrix(samples, to.size()), .qd = Matrix(samples, to.size()), .qdd = Matrix(samples, to.size())};
  Vector q(to.size());
  Vector qd(to.size());
  Vector qdd(to.size());
  for (Index k = 0; k < samples; ++k) {
    whole->at(found.t[k], q, qd, qdd);
    found.motion.q.row(k) = q;
    found.motion.qd.row(k) = qd;
    found.motion.qdd.row(k) = qdd;
  }
  std::vector<Finding> findings = std::move(found.forecast.findings);
  found.forecast = forecast(task_.robot, found.motion, rate, options_);
  found.forecast.findings = std::move(findings);
}

}  // namespace

std::unique_ptr<const Reference> Excitation::reference() const {
  const auto rows = [&](const std::optional<PointToPoint>& lead) {
    return lead ? static_cast<Index>(std::lround(lead->durations.sum() * forecast.f_m)) : 0;
  };
  std::unique_ptr<const Reference> out;
  if (series) {
    out = std::make_unique<FourierReference>(*series);
  } else {
    const Index count = t.size() - rows(lead_in) - rows(lead_out);
    out = std::make_unique<LoggedReference>(t.segment(rows(lead_in), count),
                                            motion.q.middleRows(rows(lead_in), count));
  }
  return lead_in ? with_lead(*lead_in, std::move(out), *lead_out) : std::move(out);
}

std::optional<std::string> ExcitationOptions::complaint(const Robot& robot) const {
  if (has_load(robot)) {
    return "a motion is designed for parameters that the torques are linear in, and friction of a joint "
           "follows its load; "
           "design it with friction = \"symmetric\"";
  }
  const Index n = robot.size();
  if (auto fault = range_fault(*this)) {
    return fault;
  }
  if (auto fault = limits.complaint(n)) {
    return fault;
  }
  if (auto fault = space.complaint(robot)) {
    return fault;
  }
  if (noise.sigma.size() != 0 && (noise.sigma.size() != n || !(noise.sigma.array() > 0.0).all())) {
    return "noise must have one positive number for each of the " + counted(n, "joint");
  }
  if (known.size() != 0 && !detail::is_positive_semidefinite(known)) {
    return "known is (" + std::to_string(known.rows()) + " × " + std::to_string(known.cols()) +
           "), must be finite, symmetric and positive semidefinite";
  }
  for (const auto& [key, pose] :
       {std::pair{"start", &start}, std::pair{"lead_from", &lead_from}, std::pair{"lead_to", &lead_to}}) {
    if (pose->size() != 0 && pose->size() != n) {
      return std::string(key) + " has " + counted(pose->size(), "entry") +
             ", must have one for each of the " + counted(n, "joint");
    }
  }
  if (lead_to.size() > lead_from.size()) {
    return "lead_to goes with lead_from, where the robot begins";
  }
  if ((criterion == Criterion::parameters) == parameters.empty()) {
    return parameters.empty() ? "criterion = \"parameters\" must say for which"
                              : "parameters are named, which goes with criterion = \"parameters\"";
  }
  if (target.wanted() && curve != CurveKind::fourier) {
    return "a target is for curve = \"fourier\", whose motion can be repeated";
  }
  if (!(duration * rate_hz >= 10.0)) {
    return "duration is " + number(duration) + " s, must be at least ten samples of " + number(rate_hz) +
           " Hz";
  }
  const double intervals = duration * rate_hz;
  if (!(intervals <= most_samples)) {
    return "duration is " + number(duration) + " s, must be at most " + number(most_samples) +
           " samples of " + number(rate_hz) + " Hz";
  }
  if (curve == CurveKind::spline && std::abs(intervals - std::round(intervals)) > 1e-6 * intervals) {
    return "duration is " + number(duration) + " s, must be a whole number of samples of " + number(rate_hz) +
           " Hz for curve = \"spline\"";
  }
  return std::nullopt;
}

Excitation design(const Robot& robot, const ExcitationOptions& options) {
  const auto once = [&](const ExcitationOptions& of) { return Designer(robot, of).designed(); };
  Excitation out =
      options.target.wanted() ? detail::designed_for_target(robot, options, once) : once(options);
  if (options.lead_from.size() > 0) {
    Designer(robot, options).add_lead(out);
  }
  return out;
}

}  // namespace rivid
