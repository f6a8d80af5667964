#include <algorithm>
#include <cmath>
#include <numbers>

#include "identify/figures/residual_shape.hpp"
#include "normal_quantile.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using enum Shown;

// p says whether a difference is seen at all, the shift whether it matters.
std::string in_words(const HausmanTest& hausman) {
  constexpr double significant = 0.05;  // level of the test: the usual 5 %
  constexpr double small_shift = 1.0;   // standard deviations
  const std::string figures = " (Durbin-Wu-Hausman: p = " + number(hausman.test.p, 2) + ", largest shift " +
                              number_that_says(hausman.largest_shift, 2) + " sigma, of " + hausman.parameter +
                              ")";
  if (!(hausman.test.p < significant)) {
    return "Least squares on these rows gives the same" + figures;
  }
  return (hausman.largest_shift < small_shift
              ? "Least squares on these rows differs, by less than the standard deviations"
              : "Least squares on these rows is biased: instruments were needed") +
         figures;
}

std::string in_words(const TorqueLag& lag) {
  return "Torques lag the motion by " + fixed(lag.samples, 2) + " ± " + fixed(lag.sigma, 2) +
         " samples, which moves " + lag.parameter + " by " + number_that_says(lag.largest_shift, 2) +
         " sigma";
}

std::string joint_remark(const ResidualShape& shape) {
  return counted(shape.rows, "row") +
         (shape.outside > 0 ? ", " + counted(shape.outside, "row") + " beyond five deviations" : "");
}

Chart residual_cloud(const Evidence& evidence, std::size_t joint, const StackedRows& rows, bool over_speed) {
  const JointFit& fit = evidence.result.fit.joints[joint];
  const Joint& of = evidence.robot.joints[joint];
  const std::string over = over_speed ? "speed" : "position";
  Chart out{.id = chart_id("residual-" + over, joint),
            .title = "over " + over,
            .label = "Residual of " + fit.name + " over " + over,
            .x_label = over_speed ? "q̇ [" + speed_unit(of) + "]" : "q [" + position_unit(of) + "]",
            .y_label = "residual [" + fit.unit + "]"};
  out.series.push_back(cloud("rows", "residual", over_speed ? rows.velocity : rows.position, rows.residual));
  return out;
}

Chart spectrum_chart(const JointFit& fit, const Spectrum& spectrum, const std::string& id,
                     const std::string& title, const std::string& x_label) {
  Chart out{.id = id,
            .title = title,
            .label = "Amplitude spectrum of the residual of " + fit.name + ", " + title,
            .x_label = x_label,
            .y_label = "amplitude [" + fit.unit + "]"};
  out.series.push_back({"amplitude", "residual", Series::Kind::line, spectrum.frequency, spectrum.amplitude});
  out.rules.push_back({false, spectrum.noise, "bound"});
  out.y_shown = {0.0, spectrum.noise};
  return out;
}

// Over time and over position, of so many rows that the page does not wait for it.
void add_spectra(const Evidence& evidence, std::size_t joint, const StackedRows& rows,
                 std::vector<Plot>& out) {
  constexpr Index frequencies = 240;     // points of a spectrum; a choice of drawing
  constexpr double most_orders = 128.0;  // cycles a turn, or over the whole way
  const Index most_rows = std::min<Index>(rows.residual.size(), 16'384);
  const Vector residual = rows.residual.head(most_rows);
  const Vector velocity = rows.velocity.head(most_rows);
  const Prediction& log = *rows.logs.front();
  const JointFit& fit = evidence.result.fit.joints[joint];
  const double nyquist = 0.5 * log.f_m / static_cast<double>(log.row_stride);
  const Spectrum over_time = amplitude_spectrum(rows.time.head(most_rows), residual, nyquist, frequencies);
  if (over_time.frequency.size() > 0) {
    out.emplace_back(
        spectrum_chart(fit, over_time, chart_id("residual-spectrum", joint), "spectrum over time", "f [Hz]"));
  }
  const bool turns = evidence.robot.joints[joint].type == JointType::revolute;
  const double turn = turns ? 2.0 * std::numbers::pi : 1.0;
  const Vector place = rows.position.head(most_rows) / turn;
  const double rate = std::sqrt(velocity.squaredNorm() / static_cast<double>(most_rows)) / turn;
  const double orders =
      std::min(nyquist / rate, turns ? most_orders : most_orders / (place.maxCoeff() - place.minCoeff()));
  const Spectrum over_place = amplitude_spectrum(place, residual, orders, frequencies);
  if (over_place.frequency.size() > 0) {
    out.emplace_back(spectrum_chart(fit, over_place, chart_id("residual-orders", joint),
                                    "spectrum over position",
                                    turns ? "order [cycles a turn of the joint]" : "cycles a metre"));
  }
}

Chart histogram_chart(const JointFit& fit, const ResidualShape& shape, std::size_t joint) {
  const auto bins = std::ssize(shape.counts);
  Vector middles(bins);
  Vector normal(bins);
  for (Index k = 0; k < bins; ++k) {
    middles[k] = shape.first_edge + (static_cast<double>(k) + 0.5) * shape.bin;
    const double z = (middles[k] - shape.mean) / shape.sigma;
    normal[k] = static_cast<double>(shape.rows) * shape.bin /
                (shape.sigma * std::sqrt(2.0 * std::numbers::pi)) * std::exp(-0.5 * z * z);
  }
  Chart out{.id = chart_id("residual-histogram", joint),
            .title = "distribution",
            .label = "Histogram of the residual of " + fit.name,
            .x_label = "residual [" + fit.unit + "]",
            .y_label = "rows"};
  out.series.push_back(
      {"rows", "residual", Series::Kind::bars, middles, Eigen::Map<const Vector>(shape.counts.data(), bins)});
  out.series.push_back({"normal distribution", "predicted", Series::Kind::line, middles, normal});
  out.x_shown = {shape.first_edge, shape.first_edge + static_cast<double>(bins) * shape.bin};
  out.y_shown = {0.0};
  return out;
}

Chart autocorrelation_chart(const JointFit& fit, const ResidualShape& shape, std::size_t joint) {
  const auto lags = std::ssize(shape.autocorrelation);
  const double bound = normal_quantile_975 / std::sqrt(static_cast<double>(shape.rows));
  Chart out{.id = chart_id("residual-autocorrelation", joint),
            .title = "autocorrelation",
            .label = "Autocorrelation of the residual of " + fit.name,
            .x_label = "lag [rows]",
            .y_label = "autocorrelation"};
  out.series.push_back({"autocorrelation", "residual", Series::Kind::bars,
                        Vector::LinSpaced(lags, 1.0, static_cast<double>(lags)),
                        Eigen::Map<const Vector>(shape.autocorrelation.data(), lags)});
  out.rules = {{false, bound, "bound"}, {false, -bound, "bound"}};
  out.x_shown = {0.5, static_cast<double>(lags) + 0.5};
  out.y_shown = {-2.0 * bound, 2.0 * bound};
  return out;
}

std::vector<Block> residual_charts(const Evidence& evidence) {
  Plots out{"panels"};
  Plots others{"panels", {}, {"The other joints"}};
  const std::size_t worst = worst_joint(evidence.result.fit);
  for (std::size_t j = 0; j < evidence.joints() && predicted(evidence.result); ++j) {
    const ResidualShape shape = residual_shape(evidence.logs, j);
    if (shape.counts.empty()) {
      continue;
    }
    const JointFit& fit = evidence.result.fit.joints[j];
    const StackedRows rows = stacked_rows(evidence.fitted(), j);
    Plots::Group& group =
        (j == worst ? out : others).groups.emplace_back(Plots::Group{fit.name, joint_remark(shape)});
    group.plots.emplace_back(residual_cloud(evidence, j, rows, true));
    group.plots.emplace_back(residual_cloud(evidence, j, rows, false));
    add_spectra(evidence, j, rows, group.plots);
    group.plots.emplace_back(histogram_chart(fit, shape, j));
    group.plots.emplace_back(autocorrelation_chart(fit, shape, j));
  }
  if (out.groups.empty()) {
    std::swap(out.groups, others.groups);
  }
  if (out.groups.empty()) {
    return {};
  }
  std::vector<Block> blocks = {
      {Sentence{
           "Measured less predicted torque, the joint with the largest error first. Over speed, a trend or a "
           "step indicates another friction law; over position, a wave indicates gear, gravity or a spring. "
           "Peaks in the spectra above the dashed line (99 % of white noise) indicate elasticity or the "
           "controller (over time), gear or motor ripple (at a whole order over position). Histogram and "
           "autocorrelation are drawn with the normal distribution and the 95 % bounds of white noise"},
       Shown::page},
      {std::move(out), Shown::page}};
  if (!others.groups.empty()) {
    blocks.push_back({std::move(others), Shown::page});
  }
  return blocks;
}

}  // namespace

// Tests and shape of the residual of the rows of the fit; no blocks where there is neither.
Section residual_section(const Identification& result, const Evidence* evidence) {
  using R = ResidualTests;
  Section out{"residual", "Residual", "Residual"};
  if (const std::optional<Diagnostics>& found = result.diagnostics) {
    Table tests =
        table_of(found->residuals,
                 {{{"joint"}, &R::joint},
                  {{"autocorrelation", format::fixed(2)}, &R::autocorrelation},
                  {{"p (Ljung-Box)", format::significant(2)}, [](const R& r) { return r.whiteness.p; }},
                  {{"skewness", format::fixed(2)}, &R::skewness},
                  {{"exc. kurtosis", format::fixed(2)}, &R::excess_kurtosis},
                  {{"p (Jarque-Bera)", format::significant(2)}, [](const R& r) { return r.normality.p; }}});
    tests.fold = {
        "Tests of each joint's residual: small p mean that it is not white, or not normal; with many rows "
        "also by "
        "effects too small to matter"};
    out.blocks.push_back({std::move(tests)});
    if (found->hausman) {
      out.blocks.push_back({Sentence{in_words(*found->hausman)}});
    }
    if (found->torque_lag) {
      out.blocks.push_back({Sentence{in_words(*found->torque_lag)}});
    }
  }
  out.shown = out.blocks.empty() ? page : everywhere;
  if (evidence != nullptr) {
    std::ranges::move(residual_charts(*evidence), std::back_inserter(out.blocks));
  }
  return out;
}

}  // namespace rivid::detail
