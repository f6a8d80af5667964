#include "identify/choose/row_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dense.hpp"
#include "identify/choose/pilot_fits.hpp"
#include "identify/infer/noise_bias.hpp"
#include "identify/rows/factors.hpp"
#include "identify/rows/row_source.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// The first window: noise is this part of the worst joint's mean square acceleration.
constexpr double pilot_share = 1e-3;
// Largest expected bias of a parameter in σ, and of the noise in the mean square of a joint's residual.
constexpr double most_bias = 0.15;
constexpr double most_noise = 0.25;
// Largest bias in σ that errors of the torques could cause if all of them moved the arm; a window that serves
// this alone leaves enough rows, and this part of the mean square acceleration of each joint.
constexpr double most_disturbance = 0.5;
constexpr double kept_motion = 0.9;
// Rows slower than this part of a joint's rms velocity are left out.
constexpr double slow_part = 0.05;
// Rows for each parameter with which the window that noise asks for is taken as it is. With fewer the
// estimate errs more than noise would make it, and windows are chosen by what both do to the predicted
// torques, down to so many rows for each parameter.
constexpr double many_rows = 10.0;
constexpr double fewest_rows = 2.0;
// rows for each parameter, above which the first of the windows that serve is taken; a choice
constexpr double plenty = 40.0;
// Rows for each column of the joint that has the fewest, below which residuals say too little about the
// errors to be worth less noise.
constexpr double enough_rows = 10.0;
// Rows on which predicted torques are compared: long enough for noise to count as little, short enough for
// the motion [s]. And the part of all squared torques that each joint's are taken for at least.
constexpr double judged_spacing = 0.08;
constexpr double least_torque = 0.05;
// Shorter windows are no longer tried once one is so many times worse than the best.
constexpr double hopeless = 4.0;
// Deviations that noise moves the estimate at half the window, root mean square, beyond which that estimate
// says nothing of the model.
constexpr double drowned = 10.0;
// Rounds of a window and the fit from which the next one follows.
constexpr int most_rounds = 4;
// Windows that the longest and the shortest log have room for at least.
constexpr Index many_windows = 20;
constexpr Index some_windows = 4;
// A lag of the torques agrees with none or half a sample within so many deviations. Where it agrees with
// both, odds of held ones decide along: signals that a controller computed are held as a rule, torques are
// measured more often than not.
constexpr double lag_sigmas = 3.0;
constexpr double odds_of_control = 10.0;
constexpr double odds_of_torque = 0.5;

// 1, 2, 3, …, then in steps of some 20 %, in numbers that people like.
std::vector<int> windows(Index most) {
  // steps of some 20 %, round numbers
  constexpr std::array<int, 12> decade = {10, 12, 15, 18, 20, 25, 30, 40, 50, 60, 70, 80};
  std::vector<int> out = {1, 2, 3, 4, 5, 6, 7, 8};
  for (int scale = 1; scale <= 1'000'000; scale *= 10) {
    for (const int mantissa : decade) {
      out.push_back(mantissa * scale);
    }
  }
  std::erase_if(out, [&](int n_d) { return n_d > std::max<Index>(most, 1); });
  return out;
}

// The longest window that still divides the longest log into many, and the shortest one into some.
Index longest_window(std::span<const Log> logs) {
  Index longest = 0;
  Index shortest = logs.front().samples();
  for (const Log& log : logs) {
    longest = std::max(longest, log.samples());
    shortest = std::min(shortest, log.samples());
  }
  return std::min(longest / many_windows, shortest / some_windows);
}

class Chooser {
 public:
  Chooser(const Robot& robot, std::span<const Log> logs, const Estimation& asked, const LoadPoint& load)
      : robot_(robot),
        load_(load),
        fits_(robot, logs, asked, load),
        logs_(fits_.logs()),
        still_(hardly_moving(robot, squared_velocities(logs_, robot.size()))),
        noise_(position_noise(logs_)),
        windows_(windows(longest_window(logs_))) {
    if (fits_.signal().velocity_threshold.empty()) {
      fits_.signal().velocity_threshold = thresholds();
    }
  }

  RowChoice chosen() {
    std::size_t at = first();
    std::size_t longest = at;
    std::optional<Pilot> fit = tried(at);
    bool enough = fit && fits_.rows_a_parameter() >= many_rows;
    for (int round = 0; enough && round < most_rounds; ++round) {
      const std::size_t better = longest = wanted(*fit, at);
      if (better == at) {
        break;
      }
      std::optional<Pilot> next = identified_with(windows_[better]);
      enough = next && fits_.rows_a_parameter() >= many_rows;
      if (enough) {
        fit = std::move(next);
        at = better;
      }
    }
    if (!enough) {
      if (const auto best = best_prediction(longest)) {
        at = *best;
      }
      fit = identified_with(windows_[at]);
    }
    RowChoice out;
    out.by_prediction = !enough;
    if (fit && !fits_.signal().torque_held && held(*fit)) {
      fits_.signal().torque_held = true;
      fit = identified_with(windows_[at]);
    }
    fits_.signal().torque_held = fits_.signal().held();
    fits_.signal().decimation = {windows_[at]};
    out.decimation = windows_[at];
    out.row_spacing = windows_[at] / logs_.front().f_m;
    out.torque_held = fits_.signal().held();
    return out;
  }

  [[nodiscard]] const SignalOptions& signal() { return fits_.signal(); }

 private:
  [[nodiscard]] std::vector<double> thresholds() const {
    Vector squares = Vector::Zero(robot_.size());
    double count = 0.0;
    for (const Log& log : logs_) {
      const Index span = motion_span(log);
      const double scale = log.f_m / static_cast<double>(span);
      const auto m = static_cast<double>(std::max<Index>(log.samples() - span, 0));
      squares += m * scale * scale * motion(log, span, 0, log.samples());
      count += m;
    }
    std::vector<double> out =
        made_of(squares, [&](double square) { return slow_part * std::sqrt(square / std::max(count, 1.0)); });
    std::fill_n(out.begin(), robot_.base_joints, 0.0);
    return out;
  }

  // Noise of all joints' rows in all logs; joints that stand still have no vote.
  [[nodiscard]] std::vector<std::vector<DerivativeNoise>> noise_with(int n_d) const {
    std::vector<std::vector<DerivativeNoise>> out;
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      const RowBand band(fits_.with(n_d), logs_[l].f_m);
      std::vector<DerivativeNoise>& joints = out.emplace_back();
      for (std::size_t j = 0; j < noise_[l].size(); ++j) {
        joints.push_back(still_[j] != 0 ? DerivativeNoise{} : noise_[l][j].in(band));
      }
    }
    return out;
  }

  // The window that noise alone asks for.
  [[nodiscard]] std::size_t first() const {
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      const std::vector<std::vector<DerivativeNoise>> noise = noise_with(windows_[w]);
      double worst = 0.0;
      for (std::size_t j = 0; j < noise.front().size(); ++j) {
        double noisy = 0.0;
        double moving = 0.0;
        for (std::size_t l = 0; l < logs_.size(); ++l) {
          noisy += noise[l][j].acceleration * static_cast<double>(logs_[l].samples());
          moving += noise_[l][j].motion() * static_cast<double>(logs_[l].samples());
        }
        worst = std::max(worst, moving > 0.0 ? noisy / moving : 0.0);
      }
      if (worst <= pilot_share) {
        return w;
      }
    }
    return windows_.size() - 1;
  }

  // Least part of the mean square acceleration of a joint's motion that a window leaves.
  [[nodiscard]] double motion_kept(int n_d) const {
    double out = 1.0;
    for (std::size_t l = 0; l < logs_.size(); ++l) {
      const RowBand all(fits_.with(1), logs_[l].f_m);
      const RowBand band(fits_.with(n_d), logs_[l].f_m);
      for (std::size_t j = 0; j < noise_[l].size(); ++j) {
        const double whole = noise_[l][j].motion_in(all);
        out = std::min(out, still_[j] == 0 && whole > 0.0 ? noise_[l][j].motion_in(band) / whole : 1.0);
      }
    }
    return out;
  }

  // Nothing either where the rows do not determine all parameters.
  std::optional<Pilot> identified_with(int n_d) {
    std::optional<Pilot> out = fits_.fitted(n_d, true);
    return out && out->estimate.rank == out->estimate.chi.size() ? std::move(out) : std::nullopt;
  }

  // At the longest window, up to the one `at`, that leaves many rows.
  std::optional<Pilot> tried(std::size_t& at) {
    for (;; --at) {
      std::optional<Pilot> fit = identified_with(windows_[at]);
      if (fits_.rows_a_parameter() >= many_rows || at == 0) {
        return fit;
      }
    }
  }

  // Factors of rows that estimates from all windows are compared on.
  [[nodiscard]] std::vector<RowGroup> judged_rows() const {
    const int n_d = std::max(static_cast<int>(std::lround(judged_spacing * logs_.front().f_m)), 1);
    const std::vector<SignalOptions> signals(logs_.size(), fits_.with(n_d));
    ThreadTeam team(fits_.options().threads);
    BaseParameters base = base_parameters(robot_);
    base.load = load_;
    return all_factors(robot_, base, logs_, signals, team, {}).groups;
  }

  // Of the windows up to this one, that whose estimate is expected to predict torques best: by the bias of
  // noise, squared, and by the variance.
  std::optional<std::size_t> best_prediction(std::size_t longest) {
    std::optional<std::size_t> best;
    Vector chi;  // of the best one: shorter windows are the more biased
    try {
      const std::vector<RowGroup> judged = judged_rows();
      double least = std::numeric_limits<double>::infinity();
      constexpr std::size_t step = 2;  // some 40 %
      for (std::size_t k = 0; k <= longest; k += step) {
        const std::size_t w = longest - k;
        const std::optional<Pilot> fit = fits_.fitted(windows_[w], false);
        if (!fit || fits_.rows_a_parameter() < fewest_rows) {
          continue;
        }
        if (best && fits_.rows_a_parameter() > plenty) {
          break;
        }
        const Estimate estimate = anchored(fit->estimate);
        const double error = expected_squares(judged, estimate, best ? chi : estimate.chi);
        if (!best || error < least) {
          least = error;
          best = w;
          chi = estimate.chi;
        } else if (error > hopeless * least) {
          break;
        }
      }
    } catch (const InputError&) {  // the logs have no room for such rows
    }
    return best;
  }

  // The estimate beside a prior by which each parameter alone makes about as much torque as all do together:
  // what the rows hardly tell costs a prediction no more than that.
  [[nodiscard]] static Estimate anchored(const Estimate& estimate) {
    Estimate out = estimate;
    const Vector norms =
        estimate.root.colwise().norm().transpose().unaryExpr([](double x) { return x > 0.0 ? x : 1.0; });
    const Vector scale = norms.cwiseInverse();
    const double torques = (estimate.root * estimate.chi).norm();
    const double pull = torques > 0.0 ? std::pow(estimate.sigma / torques, 2) : 1.0;
    const SymmetricEigen rows = symmetric_eigen(
        scale.asDiagonal() * (estimate.root.transpose() * estimate.root) * scale.asDiagonal());
    const Vector with_prior = (rows.values.cwiseMax(0.0).array() + pull).inverse();
    out.bread = scale.asDiagonal() * rows.vectors * with_prior.asDiagonal() * rows.vectors.transpose() *
                scale.asDiagonal();
    out.unit_covariance = out.bread;
    out.chi = out.bread * (estimate.root.transpose() * (estimate.root * estimate.chi));
    return out;
  }

  // Σ_j a_j (tr(G_j C) + bᵀ G_j b) with G_j of the judged rows, bias b and covariance C.
  [[nodiscard]] double expected_squares(std::span<const RowGroup> judged, const Estimate& estimate,
                                        const Vector& chi) const {
    const Vector bias = noise_bias(fits_.problem(), estimate, chi);
    const double torques =
        sum_of(judged, [&](const RowGroup& joint) { return joint.qr.y_norm() * joint.qr.y_norm(); });
    double out = 0.0;
    for (const RowGroup& joint : judged) {
      const Matrix R = joint.qr.R();
      const Matrix C = estimate.unit_covariance(joint.columns, joint.columns);
      const double variance = estimate.sigma * estimate.sigma * (R * C).cwiseProduct(R).sum();
      out += (variance + (R * bias(joint.columns)).squaredNorm()) /
             (joint.qr.y_norm() * joint.qr.y_norm() + least_torque * torques);
    }
    return out;
  }

  // The window that the fit at another one asks for.
  [[nodiscard]] std::size_t wanted(const Pilot& fit, std::size_t at) const {
    const Vector& chi = fit.estimate.chi;
    const std::vector<double>& weights = fit.estimate.weights;
    const NoiseSensitivity sensitivity(robot_, fits_.problem().base, logs_, fits_.problem().signals,
                                       fits_.problem().data, chi);
    const Matrix& bread = fit.estimate.unit_covariance;
    const Vector sigma = fit.sigma();
    const auto here = sensitivity.effect(noise_with(windows_[at]), weights);
    // Of a window of one sample, as far as stretches of motion do not end within.
    const double of_samples = fits_.rows_a_parameter(fit) * windows_[at];
    double rows_a_column = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < still_.size(); ++j) {
      const RowGroup& joint = fits_.problem().data.groups[j];
      rows_a_column = still_[j] != 0
                          ? rows_a_column
                          : std::min(rows_a_column, static_cast<double>(joint.qr.rows()) * windows_[at] /
                                                        static_cast<double>(joint.columns.size()));
    }
    std::size_t best = 0;
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      if (w > 0 && of_samples < fewest_rows * windows_[w]) {
        break;
      }
      best = w;
      const auto effect = sensitivity.effect(noise_with(windows_[w]), weights);
      const double bias = (bread * effect.D_chi).cwiseAbs().cwiseQuotient(sigma).maxCoeff();
      double share = 0.0;
      std::vector<double> others;
      for (std::size_t j = 0; j < effect.mean_squares.size(); ++j) {
        // What the residual has beside this noise falls at most as that of white noise does.
        const double residual = fit.fit.joints[j].sigma_rho * fit.fit.joints[j].sigma_rho;
        const double other =
            std::max(residual - here.mean_squares[j], 0.1 * residual) * windows_[at] / windows_[w];
        share = std::max(share, effect.mean_squares[j] > 0.0
                                    ? effect.mean_squares[j] / (effect.mean_squares[j] + other)
                                    : 0.0);
        others.push_back(other);
      }
      const double moved =
          (bread * sensitivity.disturbance(others, weights)).cwiseAbs().cwiseQuotient(sigma).maxCoeff();
      const bool rows_left = w + 1 < windows_.size() && rows_a_column >= enough_rows * windows_[w + 1];
      const bool quiet = share <= most_noise || !rows_left;
      const bool still =
          moved <= most_disturbance || !rows_left || motion_kept(windows_[w + 1]) < kept_motion;
      if (bias <= most_bias && quiet && still) {
        break;
      }
    }
    return best;
  }

  [[nodiscard]] bool held(const Pilot& fit) const {
    if (!fit.statistics.diagnostics || !fit.statistics.diagnostics->torque_lag) {
      return false;
    }
    const TorqueLag& lag = *fit.statistics.diagnostics->torque_lag;
    const double from_none = lag.samples / lag.sigma;
    const double from_half = (lag.samples + 0.5) / lag.sigma;
    const bool computed = logs_.front().tau.size() == 0;
    const double log_odds = 0.5 * (from_none * from_none - from_half * from_half) +
                            std::log(computed ? odds_of_control : odds_of_torque);
    return std::abs(from_half) < lag_sigmas && (std::abs(from_none) > lag_sigmas || log_odds > 0.0);
  }

  const Robot& robot_;
  const LoadPoint& load_;
  PilotFits fits_;
  std::span<const Log> logs_;
  std::vector<std::uint8_t> still_;  // joints that stand, one a joint
  std::vector<std::vector<PositionNoise>> noise_;
  std::vector<int> windows_;
};

std::string reason(const RowChoice& choice) {
  std::string out =
      "a row every " + number(1e3 * choice.row_spacing, 3) +
      " ms (decimation = " + std::to_string(choice.decimation) + ")" +
      (choice.torque_held ? ", torques held between samples" : "") +
      (choice.by_prediction ? ", where few rows and noise together make the least of torque errors" : "");
  if (std::isfinite(choice.foretold.largest)) {
    out += ": noise of the positions is expected to move no parameter by more than " +
           number(std::abs(choice.foretold.largest), 2) + " σ (" + choice.foretold.parameter + ")";
  }
  const auto moves = [](const WindowShift& shift) {
    return number(std::abs(shift.largest), 2) + " σ (" + shift.parameter + ")";
  };
  if (std::isfinite(choice.at_half.largest)) {
    out += "; the estimate moves by " + moves(choice.at_half) + " at half that spacing";
  }
  if (std::isfinite(choice.at_double.largest)) {
    out += (std::isfinite(choice.at_half.largest) ? " and by " : "; the estimate moves by ") +
           moves(choice.at_double) + " at double";
  }
  return out;
}

}  // namespace

void report_noise(const std::vector<ParameterEstimate>& parameters, RowChoice& choice) {
  // In the deviations that are told.
  for (WindowShift* const shift : {&choice.at_half, &choice.at_double}) {
    if (shift->change.size() != std::ssize(parameters)) {
      continue;
    }
    shift->largest = 0.0;
    for (Index i = 0; i < shift->change.size(); ++i) {
      const ParameterEstimate& parameter = parameters[static_cast<std::size_t>(i)];
      if (const double change = shift->change[i] / parameter.sigma;
          std::abs(change) > std::abs(shift->largest)) {
        shift->largest = change;
        shift->parameter = parameter.name;
      }
    }
  }
  for (const ParameterEstimate& parameter : parameters) {
    if (std::isfinite(parameter.noise_bias) &&
        !(std::abs(parameter.noise_bias) <= std::abs(choice.foretold.largest))) {
      choice.foretold = {.largest = parameter.noise_bias, .parameter = parameter.name};
    }
  }
  choice.reason = reason(choice);
}

RowChoice choose_rows(const Robot& robot, std::span<const Log> logs, Estimation& estimation,
                      const LoadPoint& load) {
  std::vector<Log> room;
  Estimation of_stretch = estimation;
  of_stretch.signal.window.reset();
  Chooser chooser(robot, within_window(logs, estimation.signal, room), of_stretch, load);
  RowChoice out = chooser.chosen();
  const auto window = estimation.signal.window;
  estimation.signal = chooser.signal();
  estimation.signal.window = window;
  return out;
}

void compare_windows(const Robot& robot, std::span<const Log> logs, const Estimation& estimation,
                     const LoadPoint& load, RowChoice& choice) {
  std::vector<Log> room;
  Estimation of_stretch = estimation;
  of_stretch.signal.window.reset();
  PilotFits fits(robot, within_window(logs, estimation.signal, room), of_stretch, load);
  const std::optional<Pilot> fit = fits.fitted(choice.decimation, true);
  if (!fit || fit->estimate.rank < fit->estimate.chi.size()) {
    return;
  }
  const Vector sigma = fit->sigma();
  const Vector bias = noise_bias(fits.problem(), fit->estimate, fit->estimate.chi);
  const auto moved_at = [&](int n_d) {
    const auto other = n_d == choice.decimation ? std::nullopt : fits.fitted(n_d, false);
    if (!other || other->estimate.rank < bias.size()) {
      return WindowShift{};
    }
    const Vector change = other->estimate.chi - fit->estimate.chi;
    const Vector by_noise = noise_bias(fits.problem(), other->estimate, fit->estimate.chi) - bias;
    Vector beyond = (change.cwiseAbs() - by_noise.cwiseAbs()).cwiseMax(0.0);
    const double by_sigma =
        by_noise.cwiseQuotient(sigma).norm() / std::sqrt(static_cast<double>(beyond.size()));
    beyond *= by_sigma > drowned ? 0.0 : 1.0;
    Index worst = 0;
    WindowShift found{.largest = change.cwiseAbs().cwiseQuotient(sigma).maxCoeff(&worst),
                      .parameter = fits.problem().base.parameters[static_cast<std::size_t>(worst)].name,
                      .change = change,
                      .beyond_noise = beyond.cwiseProduct(change.cwiseSign())};
    found.largest *= change[worst] < 0.0 ? -1.0 : 1.0;
    return found;
  };
  choice.at_half = moved_at(std::max(choice.decimation / 2, 1));
  choice.at_double = moved_at(2 * choice.decimation);
}

}  // namespace rivid::detail
