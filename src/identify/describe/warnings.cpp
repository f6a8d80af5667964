#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "identify/describe/describe.hpp"
#include "ranges.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Part of a joint's rows with less than half their weight from which these are no outliers any more: normal
// errors have 0.7 % of them (Huber) or 1.1 % (bisquare).
constexpr double too_many = 0.1;
// Parameters that one sentence names.
constexpr std::size_t most_named = 5;
// First-stage F statistic below which instruments count as weak, after Staiger & Stock (1997).
constexpr double least_F = 10.0;
// The assumed loop is in doubt where the law rebuilds the control signal worse than this, or the simulated
// motion lies farther from the measured one than this part of the tracking error.
constexpr double doubtful_control = 0.2;
constexpr double doubtful_tracking = 0.5;
// The bandwidth is doubtful where the residual with V is so much of Y, and so many times the one with W.
constexpr double doubtful_residual = 0.2;
constexpr double doubtful_ratio = 4.0;

}  // namespace

void find_outliers(const Identification& result, Findings& out) {
  if (!result.robust) {
    return;
  }
  const RobustReport& report = *result.robust;
  std::string moved;
  for (Index i = 0; i < result.base.size(); ++i) {
    const ParameterEstimate& p = result.parameters[static_cast<std::size_t>(i)];
    if (std::abs(result.chi[i] - report.chi[i]) > result.covariance.quantile_975 * p.sigma) {
      moved += (moved.empty() ? "" : ", ") + p.name + " (" + number(report.chi[i], 4) + " to " +
               number(p.value, 4) + ")";
    }
  }
  if (!moved.empty()) {
    out.add("outliers_decide", {},
            "outliers decide: weights on the rows move " + moved +
                " by more than the 95 % intervals; rows of little weight may be outliers, or what the model "
                "misses, friction at low speed say: look at them before either estimate is trusted");
  }
  for (const RobustJoint& joint : report.joints) {
    const double share = static_cast<double>(joint.below_half) / static_cast<double>(joint.rows);
    if (share > too_many) {
      out.add("many_outliers", {},
              "joint \"" + joint.name + "\": " + number(100.0 * share, 3) +
                  " % of its rows have less than half their weight, which is more than outliers: "
                  "the model misses something there, or a decimation smears each outlier over "
                  "many rows");
    }
  }
}

void find_noise(const Identification& result, Findings& out) {
  // Beyond their intervals in one run of six instead of twenty.
  constexpr double notable = 1.0;
  std::vector<const ParameterEstimate*> biased;
  for (const ParameterEstimate& parameter : result.parameters) {
    if (parameter.verdict != Verdict::not_excited && std::abs(parameter.noise_bias) > notable) {
      biased.push_back(&parameter);
    }
  }
  if (biased.empty()) {
    return;
  }
  std::ranges::sort(biased, {}, [](const ParameterEstimate* p) { return -std::abs(p->noise_bias); });
  std::string text;
  for (std::size_t k = 0; k < std::min(biased.size(), most_named); ++k) {
    const double bias = biased[k]->noise_bias;
    text += (k == 0 ? "" : ", ") + biased[k]->name + " by " + (bias < 0.0 ? "-" : "") +
            number_that_says(std::abs(bias), 2) + " σ";
  }
  out.add(
      "noise_bias", {},
      "noise of the positions is expected to bias " + text +
          (biased.size() > most_named ? " and " + std::to_string(biased.size() - most_named) + " more" : ""));
}

void find_predictions(const Identification& result, Findings& out) {
  // Of the residual of the fit, of the torque, and of the error that was to be expected.
  constexpr double too_much_worse = 10.0;
  constexpr double useless = 1.0;
  constexpr double forecast_missed = 3.0;
  // Where a model leaves less, it is good whatever the fit leaves.
  constexpr double good = 1e-3;
  // No gain of a drive is known better: it is worse than it could be, and not useless.
  constexpr double usable = 0.01;
  // A joint whose torque is below this part of the largest one of its unit carries none that counts.
  constexpr double counting = 0.01;
  // factor of the residual of the fit; a choice: noise of the torque is in both
  constexpr double worse = 2.0;
  // Rows that hold the noise of accelerations leave as much in the fit.
  if (result.forecast && std::isfinite(result.forecast->relative_error) &&
      result.forecast->relative_error > std::max(useless, worse * result.answer_fit().relative_error)) {
    out.add("prediction_fails", "all joints",
            "of random motion within the range of the logs, as fast as they are, an error of " +
                number_that_says(100.0 * result.forecast->relative_error, 3) +
                " % of the torques is forecast: the model is good for the motion of its logs at most");
  }
  for (const Validation& validation : result.validation) {
    const Fit& found = result.answer_fit(validation);
    const auto torque = [](const JointFit& joint) { return joint.sigma_rho / joint.relative_error; };
    for (std::size_t j = 0; j < found.joints.size(); ++j) {
      const JointFit& there = found.joints[j];
      const JointFit& here = result.answer_fit().joints[j];
      const bool counts = std::ranges::all_of(found.joints, [&](const JointFit& other) {
        return other.unit != there.unit || other.rows == 0 || torque(there) > counting * torque(other);
      });
      const double ratio = there.sigma_rho / here.sigma_rho;
      const double missed = there.relative_error / validation.forecast.joints[static_cast<Index>(j)];
      if (here.rows == 0 || there.rows == 0 || !counts || !(there.relative_error > good) ||
          !(ratio > too_much_worse || (there.relative_error > useless && ratio > worse) ||
            missed > forecast_missed)) {
        continue;
      }
      out.add(there.relative_error > usable ? FindingCode("prediction_fails") : "validation_worse",
              there.name,
              validation.file + ": the model leaves " + number_that_says(100.0 * there.relative_error, 3) +
                  " % of its torque, " + number_that_says(ratio, 2) + " times what it leaves of the fit's; " +
                  number_that_says(100.0 * there.relative_error / missed, 3) + " % were forecast");
    }
  }
}

void find_torque_lag(const Identification& result, Findings& out) {
  // Outside of their intervals, by a lag that is there.
  constexpr double significant = 3.0;
  constexpr double harmful = 2.0;
  if (!result.diagnostics || !result.diagnostics->torque_lag) {
    return;
  }
  const TorqueLag& lag = *result.diagnostics->torque_lag;
  if (!(std::abs(lag.samples) > significant * lag.sigma) || lag.largest_shift < harmful) {
    return;
  }
  const auto is = [&](double samples) { return std::abs(lag.samples - samples) < 2.0 * lag.sigma; };
  std::string cure = "add " + fixed(lag.samples, 2) + " to [log] torque_lag";
  Change change{.key = "log.torque_lag", .numbers = {lag.samples}};
  if (!result.estimation.signal.held() && is(-0.5)) {
    cure = "so are torques that a controller holds until its next sample: [signal] torque_held = true";
    change = {.key = "signal.torque_held", .word = "true"};
  } else if (result.estimation.signal.held() && is(0.5)) {
    cure = "so are torques that were measured at their samples: [signal] torque_held = false";
    change = {.key = "signal.torque_held", .word = "false"};
  }
  out.add("torque_lag", {},
          "torques look " + fixed(std::abs(lag.samples), 2) + " ± " + fixed(lag.sigma, 2) + " samples " +
              (lag.samples > 0.0 ? "late" : "early") + " beside the motion, which moves " + lag.parameter +
              " by " + number_that_says(lag.largest_shift, 2) + " of its standard deviations; " + cure,
          {change});
}

std::string weakness_of_instruments(const IvHistory& iv, const BaseParameters& base) {
  std::vector<Index> ones = detail::places_where(iv.first_stage_F.size(),
                                                 [&](Index i) { return !(iv.first_stage_F[i] > least_F); });
  std::ranges::stable_sort(ones, {}, [&](Index i) { return iv.first_stage_F[i]; });
  std::string weak;
  for (std::size_t k = 0; k < std::min(ones.size(), most_named); ++k) {
    weak += (k == 0 ? "" : ", ") + base.parameters[static_cast<std::size_t>(ones[k])].name +
            " (F = " + number(iv.first_stage_F[ones[k]], 3) + ")";
  }
  if (ones.size() > most_named) {
    weak += " and " + std::to_string(ones.size() - most_named) + " more";
  }
  return weak.empty() ? weak
                      : "the simulated motion says too little about " + weak + ", which need F above " +
                            number(least_F) +
                            "; the assumed loop moves otherwise than the actual one, so try a wider "
                            "bandwidth, the actual gains, or a larger motion";
}

void find_prefilter(const Identification& result, Findings& out) {
  if (!result.prefilter) {
    return;
  }
  const PrefilterReport& report = *result.prefilter;
  std::string moved;
  for (Index i = 0; i < result.base.size(); ++i) {
    const ParameterEstimate& p = result.parameters[static_cast<std::size_t>(i)];
    const double half_width =
        std::max(report.covariance.quantile_975 * report.sigma[i], result.covariance.quantile_975 * p.sigma);
    if (std::abs(p.value - report.chi[i]) > half_width) {
      moved += (moved.empty() ? "" : ", ") + p.name + " (" + number(report.chi[i], 4) + " to " +
               number(p.value, 4) + ")";
    }
  }
  if (!moved.empty()) {
    out.add("prefilter_shift", {},
            "the prefilter moves " + moved +
                " by more than the 95 % intervals: the model of the robot is not right at the "
                "frequencies that whitening amplifies; prefer the estimate without prefilter");
  }
}

void find_loop(double with_V, const Identification& result, Findings& out) {
  // The start of output error follows the loop as it was given, whatever is estimated of it.
  if (!result.iv || (result.output_error && !result.output_error->loop.empty())) {
    return;
  }
  const LoopDiagnosis& loop = result.iv->loop;
  const auto warn = [&](const Vector& error, double limit, std::string_view what) {
    for (Index j = 0; j < error.size(); ++j) {
      if (error[j] > limit) {
        out.add("loop_mismatch", {},
                "joint \"" + result.fit.joints[static_cast<std::size_t>(j)].name +
                    "\": " + std::string(what) + " by " + number_that_says(100.0 * error[j], 3) +
                    " %; the assumed controller may not be the actual one, which makes the instruments "
                    "weaker");
      }
    }
  };
  warn(loop.control_error, doubtful_control, "the control law misses the recorded control signal");
  warn(loop.tracking_ratio, doubtful_tracking,
       "the simulated motion misses the measured one, in units of the tracking error,");
  const double with_W = result.fit.relative_error;
  if (with_V > doubtful_residual && with_V > doubtful_ratio * with_W) {
    out.add("loop_bandwidth", {},
            "the simulated motion misses " + number_that_says(100.0 * with_V, 3) +
                " % of the torques, the measured one " + number_that_says(100.0 * with_W, 3) +
                " %: the bandwidth of the assumed controller may be far from the actual one");
  }
}

}  // namespace rivid::detail
