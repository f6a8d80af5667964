#include "report/identification_charts.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "report/analysis.hpp"
#include "report/documents.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

std::string chart_id(const std::string& kind, std::size_t joint, std::size_t log = 0) {
  return kind + "-" + std::to_string(joint + 1) + (log == 0 ? "" : "-log-" + std::to_string(log + 1));
}

std::string speed_unit(const Joint& joint) { return joint.type == JointType::revolute ? "rad/s" : "m/s"; }
std::string position_unit(const Joint& joint) { return joint.type == JointType::revolute ? "rad" : "m"; }

Vector picked(const Vector& values, const std::vector<Index>& rows) { return values(rows); }

// Of many rows those with the least and the largest value of each bucket, so that no peak is lost.
std::vector<Index> extremes(const Vector& values, Index most) {
  const Index rows = values.size();
  if (rows <= most) {
    return every_few(rows, rows);
  }
  std::vector<Index> out;
  const Index buckets = most / 2;
  for (Index b = 0; b < buckets; ++b) {
    const Index first = rows * b / buckets;
    const Index size = rows * (b + 1) / buckets - first;
    Index least = 0;
    Index largest = 0;
    values.segment(first, size).minCoeff(&least);
    values.segment(first, size).maxCoeff(&largest);
    out.push_back(first + std::min(least, largest));
    if (least != largest) {
      out.push_back(first + std::max(least, largest));
    }
  }
  return out;
}

// Rows over time, with a gap in front of each stretch but the first.
struct TimeRows {
  std::vector<Index> rows;  // −1: a gap
  Vector time;

  TimeRows(const StackedRows& from, const std::vector<Index>& wanted) {
    std::vector<double> instants;
    auto begin = from.begins.begin();
    for (const Index row : wanted) {
      bool begins = false;
      while (begin != from.begins.end() && *begin <= row) {
        begins = true;
        ++begin;
      }
      if (begins && !rows.empty()) {
        rows.push_back(-1);
        instants.push_back(0.5 * (instants.back() + from.time[row]));
      }
      rows.push_back(row);
      instants.push_back(from.time[row]);
    }
    time = Eigen::Map<const Vector>(instants.data(), std::ssize(instants));
  }

  [[nodiscard]] Vector of(const Vector& values) const {
    Vector out(time.size());
    for (Index k = 0; k < out.size(); ++k) {
      const Index row = rows[static_cast<std::size_t>(k)];
      out[k] = row < 0 ? no_value : values[row];
    }
    return out;
  }
};

// Torque of one joint over time. Few rows are all there, in double precision.
Chart torque_chart(const Evidence& evidence, std::size_t joint, const StackedRows& rows, Index most,
                   bool exact) {
  const JointFit& fit = evidence.result.fit.joints[joint];
  const TimeRows at(rows, extremes(rows.measured, most));
  Chart out{.title = "Torque of " + fit.name,
            .label = "Torque of " + fit.name + " over time, measured and predicted",
            .x_label = "t [s]",
            .y_label = "τ [" + fit.unit + "]"};
  out.size = Chart::Size::wide;
  using enum Series::Kind;
  out.series.push_back({"measured", "measured", line, at.time, at.of(rows.measured), {}, exact});
  if (predicted(evidence.result)) {
    out.series.push_back({"predicted", "predicted", line, at.time, at.of(rows.predicted), {}, exact});
  }
  out.series.push_back(
      {"robot description", "apriori", line, at.time, at.of(rows.a_priori), {}, false, true});
  return out;
}

std::string shown_rows(Index rows, Index most) {
  return counted(rows, "row") + " of the fit" +
         (rows > most ? ", of which the least and largest of each of " + std::to_string(most / 2) +
                            " stretches are drawn"
                      : "");
}

std::size_t worst_joint(const Fit& fit) {
  const auto error = [](const JointFit& joint) {
    return std::isfinite(joint.relative_error) && joint.rows > 0 ? joint.relative_error : -1.0;
  };
  return static_cast<std::size_t>(std::ranges::max_element(fit.joints, {}, error) - fit.joints.begin());
}

// ---------------------------------------------------------------------------------------------- first look

double relative_error(const StackedRows& rows) { return rows.residual.norm() / rows.measured.norm(); }

Stack error_bar(double error, double largest, const std::string& style, const std::string& label) {
  return {{{style, error / largest}}, label};
}

Table glance_table(const Evidence& evidence) {
  struct Glance {
    std::string name = {};
    double fit = 0.0;
    double validation = no_value;
    TorqueShares shares = {};
  };
  std::vector<Glance> joints;
  double largest = 0.0;
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    const JointFit& fit = evidence.result.fit.joints[j];
    Glance& at = joints.emplace_back(Glance{fit.name, fit.relative_error});
    if (!evidence.validation().empty() && predicted(evidence.result)) {
      at.validation = relative_error(stacked_rows(evidence.validation(), j));
    }
    at.shares = torque_shares(evidence.logs, j);
    for (const double error : {at.fit, at.validation}) {
      largest = std::isfinite(error) ? std::max(largest, error) : largest;
    }
  }
  const auto bar = [=](double error, const std::string& style, const std::string& words) -> Cell {
    return std::isfinite(error) && largest > 0.0
               ? Cell(error_bar(error, largest, style, words + " " + percent(error)))
               : Cell("");
  };
  std::vector<ColumnOf<Glance>> columns = {
      {{"joint", format::name}, [](const Glance& j) { return j.name; }},
      {{"fit error", format::percents(2)}, [](const Glance& j) { return j.fit; }},
      {{"", format::stack}, [=](const Glance& j) { return bar(j.fit, "fit", "error of the fit"); }}};
  if (!evidence.validation().empty()) {
    columns.push_back({{"validation", format::percents(2)}, [](const Glance& j) { return j.validation; }});
    columns.push_back({{"", format::stack}, [=](const Glance& j) {
                         return bar(j.validation, "validation", "error of the validation");
                       }});
  }
  columns.push_back({{"torque by cause", format::stack}, [](const Glance& j) -> Cell {
                       const TorqueShares& s = j.shares;
                       if (!std::isfinite(s.gravity)) {
                         return "";
                       }
                       return Stack{{{"gravity", s.gravity},
                                     {"inertia", s.inertia},
                                     {"coriolis", s.coriolis},
                                     {"friction", s.friction}},
                                    "gravity " + fixed(100.0 * s.gravity, 0) + " %, inertia " +
                                        fixed(100.0 * s.inertia, 0) + " %, Coriolis " +
                                        fixed(100.0 * s.coriolis, 0) + " %, friction " +
                                        fixed(100.0 * s.friction, 0) + " %"};
                     }});
  return table_of(joints, columns);
}

// ---------------------------------------------------------------------------------------------- residual

std::string joint_remark(const ResidualShape& shape) {
  return counted(shape.rows, "row") +
         (shape.outside > 0 ? ", " + counted(shape.outside, "row") + " beyond five deviations" : "");
}

Chart residual_cloud(const Evidence& evidence, std::size_t joint, const StackedRows& rows, bool over_speed) {
  constexpr Index most_points = 500;
  const JointFit& fit = evidence.result.fit.joints[joint];
  const Joint& of = evidence.robot.joints[joint];
  const std::vector<Index> some = every_few(rows.residual.size(), most_points);
  const std::string over = over_speed ? "speed" : "position";
  Chart out{.id = chart_id("residual-" + over, joint),
            .title = "over " + over,
            .label = "Residual of " + fit.name + " over " + over,
            .x_label = over_speed ? "q̇ [" + speed_unit(of) + "]" : "q [" + position_unit(of) + "]",
            .y_label = "residual [" + fit.unit + "]"};
  out.series.push_back({"rows", "residual", Series::Kind::points,
                        picked(over_speed ? rows.velocity : rows.position, some),
                        picked(rows.residual, some)});
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
  constexpr Index frequencies = 240;
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
  constexpr double quantile_975 = 1.96;
  const auto lags = std::ssize(shape.autocorrelation);
  const double bound = quantile_975 / std::sqrt(static_cast<double>(shape.rows));
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

}  // namespace

std::span<const Prediction> Evidence::fitted() const {
  const auto first = std::ranges::find(logs, true, &Prediction::validation);
  return {logs.begin(), first};
}

std::span<const Prediction> Evidence::validation() const { return logs.subspan(fitted().size()); }

std::vector<Block> first_look(const Evidence& evidence) {
  // Of so many rows all are there, and in double precision: the error of what is drawn is that of the table.
  constexpr Index most_rows = 12'000;
  const std::size_t worst = worst_joint(evidence.result.fit);
  const JointFit& fit = evidence.result.fit.joints[worst];
  const StackedRows rows = stacked_rows(evidence.fitted(), worst);
  Chart chart = torque_chart(evidence, worst, rows, most_rows, true);
  chart.id = "worst-joint";
  chart.height = 300.0;
  chart.log = 0;
  chart.remark = predicted(evidence.result)
                     ? "the joint with the largest error, " + percent(fit.relative_error) + ", on the " +
                           shown_rows(rows.measured.size(), most_rows)
                     : shown_rows(rows.measured.size(), most_rows);
  std::vector<std::pair<std::string, std::string>> keys = {{"fit", "rows of the fit"},
                                                           {"gravity", "gravity"},
                                                           {"inertia", "inertia"},
                                                           {"coriolis", "Coriolis"},
                                                           {"friction", "friction"}};
  if (!evidence.validation().empty()) {
    keys.insert(keys.begin() + 1, {"validation", "validation"});
  }
  return {
      {Plots{"hero", 0, {{"", "", {std::move(chart)}}}}, Shown::page},
      {glance_table(evidence), Shown::page},
      {Legend{std::move(keys), "Errors are ‖Y − Wχ‖ / ‖Y‖; causes are shares of the mean absolute torque."},
       Shown::page}};
}

Section torques_section(const Evidence& evidence) {
  Section out{"torques", "Torques", "Torques", {}, Shown::page};
  out.blocks.push_back({Sentence{
      "Measured and predicted torque of the rows of the fit, and below it what is left. Lines that lie on "
      "each "
      "other are a good fit; a residual with the rhythm of the motion is a part that the model lacks. Gaps "
      "are rows that the fit leaves out: too slow, or near a reversal. Drag to zoom, double-click to see "
      "all; all plots of a log show the same time"}});
  const auto logs = static_cast<Index>(evidence.logs.size());
  const Index most_rows = std::max<Index>(2400 / std::max<Index>(logs, 1), 800);
  for (std::size_t k = 0; k < evidence.logs.size(); ++k) {
    const Prediction& log = evidence.logs[k];
    const std::string title = (log.validation ? "Validation: " : "Identification: ") + log.source;
    if (!log.validation) {
      out.blocks.push_back({Heading{title}});
    }
    // Log 0 is that of the first look.
    Plots plots{"", k + 1};
    plots.fold.title = log.validation ? title : "";
    for (std::size_t j = 0; j < evidence.joints(); ++j) {
      const JointFit& fit = evidence.result.fit.joints[j];
      const StackedRows rows = stacked_rows(evidence.logs.subspan(k, 1), j);
      if (rows.measured.size() == 0) {
        continue;
      }
      Plots::Group& group =
          plots.groups.emplace_back(Plots::Group{fit.name, shown_rows(rows.measured.size(), most_rows)});
      Chart torque = torque_chart(evidence, j, rows, most_rows, false);
      torque.id = chart_id("torque", j, k);
      torque.log = k + 1;
      group.plots.emplace_back(std::move(torque));
      if (predicted(evidence.result)) {
        const TimeRows at(rows, extremes(rows.residual, most_rows));
        Chart residual{.id = chart_id("residual", j, k),
                       .title = "Residual of " + fit.name,
                       .label = "Residual of " + fit.name + " over time",
                       .x_label = "t [s]",
                       .y_label = "[" + fit.unit + "]"};
        residual.series.push_back(
            {"residual", "residual", Series::Kind::line, at.time, at.of(rows.residual)});
        residual.size = Chart::Size::wide;
        residual.height = 150.0;
        residual.log = k + 1;
        group.plots.emplace_back(std::move(residual));
      }
    }
    out.blocks.push_back({std::move(plots)});
  }
  return out;
}

Section friction_section(const Evidence& evidence) {
  constexpr Index most_points = 500;
  constexpr double past_rows = 1.05;
  Section out{"friction", "Friction", "Friction", {}, Shown::page};
  Plots plots{"panels"};
  Plots::Group& all = plots.groups.emplace_back();
  for (std::size_t j = 0; j < evidence.joints() && predicted(evidence.result); ++j) {
    const Joint& of = evidence.robot.joints[j];
    const StackedRows rows = stacked_rows(evidence.fitted(), j);
    if (parameters(of.friction).empty() || rows.velocity.size() == 0) {
      continue;
    }
    const JointFit& fit = evidence.result.fit.joints[j];
    const std::vector<Index> some = every_few(rows.velocity.size(), most_points);
    const double load = (rows.predicted - (rows.friction - rows.residual)).cwiseAbs().mean();
    const FrictionCurve curve = friction_curve(evidence.robot, evidence.result, static_cast<int>(j),
                                               past_rows * rows.velocity.cwiseAbs().maxCoeff(), load);
    Chart chart{.id = chart_id("friction", j),
                .title = fit.name,
                .remark = "law " + std::string(name(of.friction)),
                .label = "Friction of " + fit.name + " over its speed, measured and model",
                .x_label = "q̇ [" + speed_unit(of) + "]",
                .y_label = "τ_f [" + fit.unit + "]"};
    chart.series.push_back({"measured", "measured", Series::Kind::points, picked(rows.velocity, some),
                            picked(rows.friction, some)});
    // One gap, at rest.
    const Index half = curve.speed.size() / 2;
    const auto broken = [&](const Vector& values, double middle) {
      Vector with_gap(values.size() + 1);
      with_gap << values.head(half), middle, values.tail(half);
      return with_gap;
    };
    const Vector speed = broken(curve.speed, 0.0);
    const Vector torque = broken(curve.torque, no_value);
    const Vector width = broken(curve.half_width, no_value);
    chart.series.push_back(
        {"95 % confidence band", "predicted", Series::Kind::band, speed, torque - width, torque + width});
    chart.series.push_back({"model", "predicted", Series::Kind::line, speed, torque});
    all.plots.emplace_back(std::move(chart));
  }
  if (all.plots.empty()) {
    return out;
  }
  out.blocks = {
      {Sentence{
          "Friction torque over joint speed. A point is a row of the fit: the measured torque less the "
          "modelled gravity, "
          "inertia and Coriolis torques. The line is the friction law with the 95 % confidence band of its "
          "parameters. Points that bend away from the line ask for another law; two clouds at one speed are "
          "friction that depends on load, temperature or position"}},
      {std::move(plots)}};
  return out;
}

std::vector<Block> residual_charts(const Evidence& evidence) {
  Plots out{"panels"};
  for (std::size_t j = 0; j < evidence.joints() && predicted(evidence.result); ++j) {
    const ResidualShape shape = residual_shape(evidence.logs, j);
    if (shape.counts.empty()) {
      continue;
    }
    const JointFit& fit = evidence.result.fit.joints[j];
    const StackedRows rows = stacked_rows(evidence.fitted(), j);
    Plots::Group& group = out.groups.emplace_back(Plots::Group{fit.name, joint_remark(shape)});
    group.plots.emplace_back(residual_cloud(evidence, j, rows, true));
    group.plots.emplace_back(residual_cloud(evidence, j, rows, false));
    add_spectra(evidence, j, rows, group.plots);
    group.plots.emplace_back(histogram_chart(fit, shape, j));
    group.plots.emplace_back(autocorrelation_chart(fit, shape, j));
  }
  if (out.groups.empty()) {
    return {};
  }
  return {{Sentence{
               "What the model leaves over, joint by joint; time is above. Over speed: a trend or a step is "
               "friction that "
               "the law lacks. Over position: a wave is the gear, gravity or a spring. Spectra show "
               "amplitudes of "
               "sinusoids, dashed what white noise of the same size stays below at 99 % of the frequencies: "
               "a peak "
               "over frequency is elasticity or the controller, a peak at a whole order over position is the "
               "gear or the ripple of the motor. Histogram and autocorrelation stand beside the normal "
               "distribution and the 95 % bounds of white noise"},
           Shown::page},
          {std::move(out), Shown::page}};
}

Section description_section(const Evidence& evidence) {
  Section out{"description", "Description", "Comparison with the robot description", {}, Shown::page};
  struct Compared {
    std::string log;
    std::string joint;
    double description = 0.0;
    double identified = 0.0;
  };
  std::vector<Compared> rows;
  for (const Prediction& log : evidence.logs) {
    for (std::size_t j = 0; j < evidence.joints(); ++j) {
      if (log.joints[j].residual.size() > 0) {
        rows.push_back({std::filesystem::path(log.source).filename().string(),
                        evidence.result.fit.joints[j].name, a_priori_error(log, j),
                        relative_error(stacked_rows(std::span(&log, 1), j))});
      }
    }
  }
  out.blocks = {
      {Sentence{
          "Relative torque errors on the rows of each log: what the numbers of the robot description would "
          "have predicted, friction and rotor inertia included where they are given there, beside the "
          "identified "
          "model. The plots of torques show both: choose \"robot description\" in their legends"}},
      {table_of(rows, {{{"log"}, [](const Compared& r) { return r.log; }},
                       {{"joint", format::name}, [](const Compared& r) { return r.joint; }},
                       {{"robot description", format::percents(2)},
                        [](const Compared& r) { return r.description; }},
                       {{"identified", format::percents(2)}, [](const Compared& r) { return r.identified; }},
                       {{"better by", format::significant(3), "×"},
                        [](const Compared& r) { return r.description / r.identified; }}})}};
  return out;
}

Section coverage_section(const Evidence& evidence) {
  constexpr Index most_points = 500;
  constexpr std::size_t few = 16;
  Section out{"coverage", "Coverage", "Coverage and excitation", {}, Shown::page};
  Plots plots{"panels"};
  Plots::Group& all = plots.groups.emplace_back();
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    const Joint& of = evidence.robot.joints[j];
    const StackedRows rows = stacked_rows(evidence.fitted(), j);
    const std::vector<Index> some = every_few(rows.position.size(), most_points);
    Chart chart{.id = chart_id("coverage", j),
                .title = evidence.result.fit.joints[j].name,
                .label = "Speed over position of " + evidence.result.fit.joints[j].name,
                .x_label = "q [" + position_unit(of) + "]",
                .y_label = "q̇ [" + speed_unit(of) + "]"};
    chart.series.push_back(
        {"fit", "measured", Series::Kind::points, picked(rows.position, some), picked(rows.velocity, some)});
    if (!evidence.validation().empty()) {
      const StackedRows others = stacked_rows(evidence.validation(), j);
      const std::vector<Index> few_others = every_few(others.position.size(), most_points);
      chart.series.insert(chart.series.begin(),
                          {"validation", "validation", Series::Kind::points,
                           picked(others.position, few_others), picked(others.velocity, few_others)});
    }
    all.plots.emplace_back(std::move(chart));
  }
  out.blocks = {
      {Sentence{
          "Rows in the plane of position and speed. The model is known where the dots are: a validation or a "
          "task that leaves the cloud is extrapolation. Empty corners are motions to record next"}},
      {std::move(plots)}};
  if (predicted(evidence.result)) {
    const Vector shown = excitation(evidence.result, evidence.logs);
    std::vector<std::size_t> order(static_cast<std::size_t>(shown.size()));
    for (std::size_t i = 0; i < order.size(); ++i) {
      order[i] = i;
    }
    std::ranges::stable_sort(order, std::greater<>(),
                             [&](std::size_t i) { return shown[static_cast<Index>(i)]; });
    const double largest = std::max(shown.size() > 0 ? shown.maxCoeff() : 1.0, 1.0);
    const auto at = [&](std::size_t i) { return shown[static_cast<Index>(i)]; };
    // Three decades below the residual are the left end.
    const auto bar = [&](std::size_t i) {
      constexpr double decades_below = 3.0;
      const double decades = std::log10(largest) + decades_below;
      return at(i) > 0.0 ? std::clamp((std::log10(at(i)) + decades_below) / decades, 0.0, 1.0) : 0.0;
    };
    Table table = table_of(order, {{{"parameter", format::name},
                                    [&](std::size_t i) { return evidence.result.parameters[i].name; }},
                                   {{"torque / residual", format::significant(3)}, at},
                                   {{"", format::share}, bar}});
    table.fold = {"Excitation of the " + counted(std::ssize(order), "parameter"), order.size() <= few};
    out.blocks.push_back(
        {Sentence{"Excitation of each parameter: root mean square of the torque that it causes in the joint "
                  "that shows it best, divided by the deviation of that joint's residual, on a "
                  "logarithmic scale. Below 1 a parameter is seen by averaging alone"}});
    out.blocks.push_back({std::move(table)});
  }
  return out;
}

Section correlation_section(const Identification& result) {
  constexpr double strong = 0.9;
  constexpr std::size_t most_pairs = 12;
  Section out{"correlation", "Correlation", "Correlation of the estimates", {}, Shown::page};
  if (result.C_chi.rows() != std::ssize(result.parameters) || result.parameters.size() < 2) {
    return out;
  }
  HeatMap map{"correlation-map",
              "Correlation of the estimates",
              "Correlation matrix of the estimates",
              {},
              correlation(result.C_chi)};
  struct Pair {
    std::string names;
    double r = 0.0;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    map.names.push_back(result.parameters[i].name);
    for (std::size_t j = 0; j < i; ++j) {
      const double r = map.values(static_cast<Index>(i), static_cast<Index>(j));
      if (std::abs(r) > strong) {
        pairs.push_back({result.parameters[j].name + " and " + result.parameters[i].name, r});
      }
    }
  }
  std::ranges::stable_sort(pairs, std::greater<>(), [](const Pair& p) { return std::abs(p.r); });
  const std::size_t strong_pairs = pairs.size();
  pairs.resize(std::min(pairs.size(), most_pairs));
  std::string words;
  for (const Pair& pair : pairs) {
    words += (words.empty() ? "" : ", ") + pair.names + " (" + fixed(pair.r, 2) + ")";
  }
  out.blocks = {
      {Legend{{{"together", "estimated too large together"}, {"against", "one for the other"}},
              "The stronger the colour, the harder it is to distinguish two parameters: their sum or "
              "difference is known better than "
              "either. Move over the map for names and values."}},
      {Plots{"", {}, {{"", "", {std::move(map)}}}}},
      {Sentence{strong_pairs == 0 ? "No two estimates have a correlation above 0.9"
                                  : counted(static_cast<std::ptrdiff_t>(strong_pairs), "pair") +
                                        " above 0.9: " + words + (strong_pairs > most_pairs ? ", …" : "")}}};
  return out;
}

Section robot_section(const Evidence& evidence) {
  Section out{"robot", "Robot", "Robot", {}, Shown::page};
  const Robot& robot = evidence.robot;
  // The posture at the middle of the first log's rows.
  Vector q = Vector::Zero(robot.size());
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    const Vector& position = evidence.logs.front().joints[j].fitted.position;
    q[static_cast<Index>(j)] = position.size() > 0 ? position[position.size() / 2] : 0.0;
  }
  Skeleton skeleton = skeleton_of(robot, q);
  skeleton.id = "robot-picture";
  skeleton.title = "Arm and ellipsoids of inertia";
  skeleton.label = "The robot as lines with the ellipsoids of inertia of its links";
  add_ellipsoids(robot, q, robot.inertials, "described", skeleton);
  std::vector<std::pair<std::string, std::string>> keys = {{"arm", "joints, base to tip"},
                                                           {"described", "robot description"}};
  std::string remark = "Identified links need physically consistent parameters: --physical.";
  if (evidence.result.physical) {
    std::vector<Inertial> identified(robot.inertials.size(), Inertial::Zero());
    for (std::size_t i = 0; i < evidence.result.base.standard.size(); ++i) {
      const StandardParameter& parameter = evidence.result.base.standard[i];
      if (role(parameter.kind) == Role::inertial) {
        identified[static_cast<std::size_t>(parameter.joint)][static_cast<Index>(parameter.kind)] =
            evidence.result.physical->parameters.chi_st[static_cast<Index>(i)];
      }
    }
    add_ellipsoids(robot, q, identified, "identified", skeleton);
    keys.emplace_back("identified", "identified, physically consistent");
    remark = "An ellipsoid of uniform density with the mass and the inertia of its link.";
  }
  if (skeleton.ellipsoids.empty() && robot.size() < 2) {
    return out;
  }
  out.blocks = {{Legend{std::move(keys), remark + " Drag, or use the arrow keys, to turn the robot."}},
                {Plots{"", {}, {{"", "", {std::move(skeleton)}}}}}};
  return out;
}

// ---------------------------------------------------------------------------------------------- iterations

namespace {

Chart iteration_chart(const std::string& id, const std::string& title, std::size_t iterations) {
  Chart out{.id = id,
            .title = title,
            .label = title + " by iteration",
            .x_label = "iteration",
            .y_label = "error [%]"};
  out.logarithmic = true;
  out.x_shown = {0.0, static_cast<double>(std::max<std::size_t>(iterations, 2) - 1)};
  return out;
}

template <typename Of>
Vector over_iterations(const std::vector<IvIteration>& all, const Of& of) {
  Vector out(std::ssize(all));
  for (Index k = 0; k < out.size(); ++k) {
    const double value = 100.0 * of(all[static_cast<std::size_t>(k)]);
    out[k] = value > 0.0 ? value : no_value;
  }
  return out;
}

Vector counting(std::size_t count) {
  return Vector::LinSpaced(static_cast<Index>(count), 0.0, static_cast<double>(count) - 1.0);
}

double entry(const Vector& values, std::size_t i) {
  return static_cast<Index>(i) < values.size() ? values[static_cast<Index>(i)] : no_value;
}

}  // namespace

Chart torque_error_chart(const Identification& result) {
  const std::vector<IvIteration>& all = result.iv->iterations;
  Chart out = iteration_chart("torque-error", "Torque error", all.size());
  out.size = Chart::Size::wide;
  const Vector k = counting(all.size());
  out.series.push_back({"all joints", "all", Series::Kind::line, k,
                        over_iterations(all, [](const IvIteration& i) { return i.relative_error; })});
  for (std::size_t j = 0; j < result.fit.joints.size(); ++j) {
    out.series.push_back({result.fit.joints[j].name, "series-" + std::to_string(j % 8), Series::Kind::line, k,
                          over_iterations(all, [&](const IvIteration& i) {
                            return entry(i.joint_error_norm, j) * (i.relative_error / i.error_norm);
                          })});
  }
  return out;
}

Plots motion_error_charts(const Identification& result) {
  struct Order {
    const char* name;
    Vector MotionError::* member;
  };
  constexpr std::array<Order, 3> orders = {
      {{"q", &MotionError::q}, {"q̇", &MotionError::qd}, {"q̈", &MotionError::qdd}}};
  const std::vector<IvIteration>& all = result.iv->iterations;
  Plots out{"panels"};
  Plots::Group& group = out.groups.emplace_back();
  for (std::size_t j = 0; j < result.fit.joints.size(); ++j) {
    Chart chart = iteration_chart(chart_id("motion-error", j), result.fit.joints[j].name, all.size());
    for (std::size_t o = 0; o < orders.size(); ++o) {
      const std::string style = "series-" + std::to_string(o);
      const auto series = [&](MotionError IvIteration::* from, const std::string& name,
                              const std::string& dashes) {
        chart.series.push_back({name, style + dashes, Series::Kind::line, counting(all.size()),
                                over_iterations(all, [&](const IvIteration& i) {
                                  return entry((i.*from).*(orders[o].member), j);
                                })});
      };
      series(&IvIteration::to_measured, orders[o].name, "");
      series(&IvIteration::to_reference, std::string(orders[o].name) + " to reference", " dashed");
    }
    group.plots.emplace_back(std::move(chart));
  }
  return out;
}

}  // namespace rivid::detail
