#include "rivid/identify/rollouts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <ranges>
#include <utility>

#include "accept.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Blocks of windows that the test takes at most, as of compare().
constexpr int test_blocks = 12;

// Control signals of zero, beside which the logged torques act.
class Silent final : public ControlLaw {
 public:
  void control(const ControlInput& /*input*/, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    v_tau.setZero();
  }
};

// A reference from some instant on.
class Stretch final : public Reference {
 public:
  Stretch(const Reference& whole, double begin, double duration)
      : whole_(whole), begin_(begin), duration_(duration) {}

  [[nodiscard]] Index joints() const override { return whole_.joints(); }
  [[nodiscard]] double begin() const override { return begin_; }
  [[nodiscard]] double duration() const override { return duration_; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
          Eigen::Ref<Vector> qdd_r) const override {
    whole_.at(t, q_r, qd_r, qdd_r);
  }

 private:
  const Reference& whole_;
  double begin_;
  double duration_;
};

// A log as rollouts need it.
struct RolloutLog {
  const Log& log;
  Motion motion;  // filtered
  Matrix tau;
  std::unique_ptr<Reference> reference;  // none where the log has none

  RolloutLog(const Robot& robot, const Log& of, double cutoff_hz) : log(of), tau(effort(robot, of)) {
    constexpr double highest = 0.2;  // of the sampling rate
    motion = differentiate(zero_phase(of.q, of.f_m, std::min(cutoff_hz, highest * of.f_m)), of.f_m);
    if (of.q_r.size() > 0) {
      const Vector t =
          Vector::NullaryExpr(of.samples(), [&](Index k) { return static_cast<double>(k) / of.f_m; });
      reference = std::make_unique<LoggedReference>(t, of.q_r);
    }
  }
};

// Squared errors at the end of a window, (n); infinite where the simulation did not come so far.
struct WindowError {
  Vector q;
  Vector qd;

  [[nodiscard]] bool lost() const { return !q.allFinite(); }
};

WindowError simulated_error(const Robot& robot, const DynamicModel& model, const ControlLaw& law,
                            const RolloutLog& of, Drive drive, const Sampling& sampling, Index first,
                            Index length) {
  const double f_m = of.log.f_m;
  const Index end = first + length;
  SimulationOptions options{
      .f_m = f_m, .samples = length + 1, .q_0 = of.motion.q.row(first), .qd_0 = of.motion.qd.row(first)};
  const double begin = static_cast<double>(first) / f_m;
  const double duration = static_cast<double>(length) / f_m;
  const LinearReference still(Eigen::Vector2d(begin, begin + duration),
                              options.q_0.transpose().replicate(2, 1));
  const bool open = drive == Drive::torques;
  if (open) {
    options.sampling.period = 1.0 / f_m;
    options.disturbance = of.tau.middleRows(first, length);
  } else {
    options.sampling = sampling;
  }
  const Reference& followed = open ? static_cast<const Reference&>(still) : *of.reference;
  const Stretch stretch(followed, begin, duration);
  const Simulation run = simulate(robot, model, law, stretch, options);
  if (run.outcome != Outcome::completed || run.t.size() <= length) {
    const Vector infinite = Vector::Constant(robot.size(), std::numeric_limits<double>::infinity());
    return {infinite, infinite};
  }
  return {(run.motion.q.row(length) - of.log.q.row(end)).cwiseAbs2().transpose(),
          (run.motion.qd.row(length) - of.motion.qd.row(end)).cwiseAbs2().transpose()};
}

// Mean squares of each joint over all logs, (n), each log about its mean.
Vector spread_of(std::span<const RolloutLog> logs, Matrix Motion::* what) {
  Vector out = Vector::Zero((logs.front().motion.*what).cols());
  double samples = 0.0;
  for (const RolloutLog& of : logs) {
    const Matrix& x = of.motion.*what;
    out += (x.rowwise() - x.colwise().mean()).colwise().squaredNorm().transpose();
    samples += static_cast<double>(x.rows());
  }
  return (out / samples).unaryExpr([](double s) { return s > 0.0 ? s : 1.0; });
}

// Errors of one kind of window: by model, log and window.
using RolloutErrors = std::vector<std::vector<std::vector<WindowError>>>;

// Windows that one model is lost in count for none, but for a model that is lost in all of them.
Rollout::Error rollout_error(const RolloutErrors& errors, std::size_t model) {
  Rollout::Error out;
  double count = 0.0;
  std::vector<std::uint8_t> nowhere;
  for (const auto& of : errors) {
    nowhere.push_back(std::ranges::all_of(
        of, [](const auto& log) { return std::ranges::all_of(log, &WindowError::lost); }));
  }
  for (std::size_t l = 0; l < errors[model].size(); ++l) {
    for (std::size_t w = 0; w < errors[model][l].size(); ++w) {
      const WindowError& own = errors[model][l][w];
      out.lost += own.lost() ? 1 : 0;
      const auto spoils = [&](std::size_t m) {
        return errors[m][l][w].lost() && (m == model || nowhere[m] == 0);
      };
      if (std::ranges::any_of(std::views::iota(std::size_t{0}, errors.size()), spoils)) {
        continue;
      }
      out.q = out.q.size() > 0 ? Vector(out.q + own.q) : own.q;
      out.qd = out.qd.size() > 0 ? Vector(out.qd + own.qd) : own.qd;
      ++count;
    }
  }
  out.q = (out.q / count).cwiseSqrt();
  out.qd = (out.qd / count).cwiseSqrt();
  return out;
}

PairedTest rollout_test(const RolloutErrors& errors, std::size_t other, const Vector& q, const Vector& qd) {
  const auto square = [&](const WindowError& of) {
    return of.q.cwiseQuotient(q).sum() + of.qd.cwiseQuotient(qd).sum();
  };
  std::vector<Vector> series;
  double squares = 0.0;
  double other_squares = 0.0;
  for (std::size_t l = 0; l < errors.front().size(); ++l) {
    Vector& scores = series.emplace_back(std::ssize(errors.front()[l]));
    for (std::size_t w = 0; w < errors.front()[l].size(); ++w) {
      const WindowError& a = errors.front()[l][w];
      const WindowError& b = errors[other][l][w];
      double& score = scores[static_cast<Index>(w)];
      if (a.lost() || b.lost()) {
        score = (a.lost() ? 1.0 : 0.0) - (b.lost() ? 1.0 : 0.0);
        continue;
      }
      squares += square(a);
      other_squares += square(b);
      score = (square(a) - square(b)) / std::max(square(a) + square(b), std::numeric_limits<double>::min());
    }
  }
  PairedTest out = paired_test(series, test_blocks);
  out.a = 0;
  out.b = other;
  out.ratio = squares / other_squares;
  return out;
}

// The law of the first model, with the reason where there is none, or with what favours that model.
std::unique_ptr<ControlLaw> law_of_rollouts(const ComparedModel& first, const DynamicModel& model,
                                            std::span<const RolloutLog> logs, const RolloutOptions& options,
                                            std::string& why) {
  if (!options.control) {
    why = "no closed-loop rollouts: the experiment file has no [control]";
    return nullptr;
  }
  if (std::ranges::any_of(logs, [](const RolloutLog& of) { return !of.reference; })) {
    why = "no closed-loop rollouts: a log has no reference columns for the controller to follow";
    return nullptr;
  }
  try {
    const Vector J = design_inertia(model, logs.front().log.q_r);
    std::unique_ptr<ControlLaw> law = detail::law_of(options.control, Plant{first.robot, model, J});
    if (law->states() == 0) {
      const auto stiffer = detail::law_of(options.control, Plant{first.robot, model, 2.0 * J});
      if (by_name(law->description().gains) != by_name(stiffer->description().gains)) {
        why = "closed loop: the gains of the control law are matched to the inertias of " + first.name +
              ", for all models";
      }
      return law;
    }
    why =
        "no closed-loop rollouts: what the integral of the control law is at the start of a window is not "
        "logged";
  } catch (const NumericsError& e) {
    why = std::string("no closed-loop rollouts: gains can not be matched to ") + first.name + ": " + e.what();
  }
  return nullptr;
}

}  // namespace

std::optional<std::string> RolloutOptions::complaint() const {
  if (horizons.empty() ||
      std::ranges::any_of(horizons, [](double h) { return !std::isfinite(h) || h <= 0.0; })) {
    return "horizons must be positive, at least one";
  }
  if (windows < 1) {
    return "windows is " + std::to_string(windows) + ", must be at least 1";
  }
  if (!(level > 0.0 && level < 1.0) || !(cutoff_hz > 0.0)) {
    return "level is " + number(level) + " and cutoff_hz " + number(cutoff_hz) +
           ", must be between 0 and 1, and positive";
  }
  return std::nullopt;
}

Rollouts rollouts(std::span<const ComparedModel> models, std::span<const Log> logs,
                  const RolloutOptions& options) {
  if (models.empty() || logs.empty()) {
    throw InputError("rollouts: there is no model, or no log to judge it by");
  }
  detail::accept("rollouts", options.complaint());
  Rollouts out;
  std::vector<DynamicModel> dynamics;
  for (const ComparedModel& model : models) {
    out.models.push_back(model.name);
    dynamics.emplace_back(model.robot, model.chi_st);
  }
  std::vector<RolloutLog> all;
  std::vector<Log> room;
  for (const Log& log : detail::within_window(logs, {.window = options.window}, room)) {
    all.emplace_back(models.front().robot, log, options.cutoff_hz);
  }
  const Vector q = spread_of(all, &Motion::q);
  const Vector qd = spread_of(all, &Motion::qd);
  std::string why;
  const std::unique_ptr<ControlLaw> law =
      law_of_rollouts(models.front(), dynamics.front(), all, options, why);
  if (!why.empty()) {
    out.notes.push_back(why);
  }
  const Silent silent;
  for (const Drive drive : {Drive::torques, Drive::controller}) {
    for (const double horizon : options.horizons) {
      if (drive == Drive::controller && !law) {
        continue;
      }
      RolloutErrors errors(models.size(), std::vector<std::vector<WindowError>>(all.size()));
      Rollout found;
      found.drive = drive;
      found.horizon = horizon;
      for (std::size_t l = 0; l < all.size(); ++l) {
        const auto length = std::max<Index>(std::lround(horizon * all[l].log.f_m), 1);
        const Index steps = all[l].log.samples() - 1;
        const Index count = std::min<Index>(options.windows, steps / length);
        for (Index w = 0; w < count; ++w) {
          for (std::size_t m = 0; m < models.size(); ++m) {
            errors[m][l].push_back(
                simulated_error(models[m].robot, dynamics[m],
                                drive == Drive::torques ? static_cast<const ControlLaw&>(silent) : *law,
                                all[l], drive, options.sampling, steps * w / count, length));
          }
        }
        found.windows += static_cast<int>(count);
      }
      if (found.windows == 0) {
        continue;
      }
      for (std::size_t m = 0; m < models.size(); ++m) {
        found.models.push_back(rollout_error(errors, m));
        if (m > 0) {
          found.tests.push_back(rollout_test(errors, m, q, qd));
        }
      }
      out.found.push_back(std::move(found));
    }
  }
  double tests = 0.0;
  for (const Rollout& each : out.found) {
    tests += static_cast<double>(each.tests.size());
  }
  for (Rollout& each : out.found) {
    for (PairedTest& test : each.tests) {
      test.p = std::isfinite(test.p) ? std::min(1.0, test.p * tests) : test.p;
      if (test.p < options.level) {
        test.better = test.t < 0.0 ? test.a : test.b;
      }
    }
  }
  return out;
}

}  // namespace rivid
