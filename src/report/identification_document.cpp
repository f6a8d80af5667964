#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ranges>

#include "report/documents.hpp"
#include "report/identification_charts.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid::detail {

namespace {

using enum Shown;
using Parameters = std::vector<ParameterEstimate>;

// What one record of a list says, by its place in the list.
using Indexed = ColumnOf<std::size_t>;

auto places(std::size_t count) { return std::views::iota(std::size_t{0}, count); }

double at(const Vector& values, std::size_t i) {
  const auto k = static_cast<Index>(i);
  return k < values.size() ? values[k] : std::numeric_limits<double>::quiet_NaN();
}

std::string comma_list(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) {
    out += (out.empty() ? "" : ", ") + word;
  }
  return out;
}

List list_of(std::string kind, const std::vector<std::string>& texts) {
  List out{std::move(kind)};
  for (const std::string& text : texts) {
    out.items.push_back({.text = text});
  }
  return out;
}

// ---------------------------------------------------------------------------------------------- words

// residuals  whether they were looked at: factors of logs do not have them
std::string in_words(const CovarianceReport& covariance, bool residuals) {
  std::string out =
      residuals ? "from the residuals, correlated over " + number(covariance.lag, 3) + " s (Newey-West)"
                : "as if residuals were independent (classical)";
  if (covariance.decimation_factor != 1.0) {
    out += ", divided by " + number(covariance.decimation_factor, 3) + " to undo the decimation";
  }
  if (covariance.blocks > 0) {
    out += ", scaled to " + std::to_string(covariance.blocks) + " blocks of time (median " +
           number(covariance.block_ratio, 3) + ")";
  }
  return out;
}

// p says whether a difference is seen at all, the shift whether it matters.
std::string in_words(const HausmanTest& hausman) {
  constexpr double significant = 0.05;
  constexpr double small_shift = 1.0;
  const std::string figures = " (Durbin-Wu-Hausman: p = " + number(hausman.test.p, 2) + ", largest shift " +
                              number(hausman.largest_shift, 2) + " sigma, of " + hausman.parameter + ")";
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
         " samples, which moves " + lag.parameter + " by " + number(lag.largest_shift, 2) + " sigma";
}

std::string in_words(const RobustReport& robust) {
  std::string out = robust.options.kind == RobustKind::huber ? "Huber's loss" : "Bisquare loss";
  out += ", tuning " + number(robust.options.loss().tuning, 4) + ", in " + counted(robust.rounds, "round") +
         "; against the estimate without it ";
  return robust.parameter.empty()
             ? out + "nothing moves"
             : out + robust.parameter + " moves the most, by " + number(robust.largest_shift, 2) + " sigma";
}

// ---------------------------------------------------------------------------------------------- parameters

Mark mark_of(const ParameterEstimate& p) {
  return p.verdict == Verdict::identified ? Mark::none
         : p.verdict == Verdict::weak     ? Mark::weak
                                          : Mark::unseen;
}

std::string interval_words(const ParameterEstimate& p) {
  if (!std::isfinite(p.sigma)) {
    return "not determined";
  }
  return "[" + with_decimals_of(p.interval_95[0], p.sigma) + ", " +
         with_decimals_of(p.interval_95[1], p.sigma) + "]";
}

Cell interval_bar(const ParameterEstimate& p) {
  if (!std::isfinite(p.sigma)) {
    return "";
  }
  return Interval{p.interval_95[0], p.interval_95[1], p.value, p.a_priori,
                  p.name + ": " + interval_words(p) + ", a priori " + number(p.a_priori, 4)};
}

std::string group_words(const ParameterEstimate& p) { return p.regrouped == p.name ? "" : p.regrouped; }

// One line a column.
Table parameters_table(const Parameters& parameters) {
  using P = ParameterEstimate;
  return table_of(parameters,
                  {{{"parameter", format::name}, [](const P& p) { return p.name; }},
                   {{"value", format::deviation}, [](const P& p) { return Cell(p.value, p.sigma); }},
                   {{"unit"}, [](const P& p) { return p.unit; }},
                   {{"sigma", format::deviation}, [](const P& p) { return Cell(p.sigma, p.sigma); }},
                   {{"%sigma", format::fixed(3)}, [](const P& p) { return p.relative_sigma_percent; }},
                   {{"95 % interval"}, interval_words},
                   {{"grouped from"}, group_words}},
                  mark_of);
}

// The same on a page, those that are known best first; what is narrow stands before what is wide. Deviations by the residuals
// alone only where they differ.
Table page_table(Parameters parameters, Fold fold) {
  using P = ParameterEstimate;
  std::ranges::stable_sort(parameters, [](const P& a, const P& b) {
    const auto key = [](const P& p) {
      return std::isfinite(p.relative_sigma_percent) ? p.relative_sigma_percent
                                                     : std::numeric_limits<double>::infinity();
    };
    return key(a) < key(b);
  });
  const bool plain_differs =
      std::ranges::any_of(parameters, [](const P& p) { return p.plain_sigma != p.sigma; });
  std::vector<ColumnOf<P>> fields = {
      {{"parameter", format::name}, [](const P& p) { return p.name; }},
      {{"value", format::deviation}, [](const P& p) { return Cell(p.value, p.sigma); }},
      {{"", format::interval}, interval_bar},
      {{"unit"}, [](const P& p) { return p.unit; }},
      {{"%sigma", format::fixed(3)}, [](const P& p) { return p.relative_sigma_percent; }},
      {{"sigma", format::deviation}, [](const P& p) { return Cell(p.sigma, p.sigma); }},
      {{"95 % interval"}, interval_words},
      {{"a priori", format::significant(4)}, [](const P& p) { return p.a_priori; }},
      {{"bias", format::fixed(2), "σ"}, [](const P& p) { return p.noise_bias; }}};
  if (plain_differs) {
    fields.push_back(
        {{"HAC", format::deviation}, [](const P& p) { return Cell(p.plain_sigma, p.plain_sigma); }});
  }
  fields.push_back({{"grouped from"}, group_words});
  Table out = table_of(parameters, fields, mark_of);
  out.fold = std::move(fold);
  return out;
}

// Parameters that are known, and those that are not, folded.
void add_page_tables(const Parameters& parameters, Section& out) {
  Parameters known;
  Parameters others;
  for (const ParameterEstimate& p : parameters) {
    (p.verdict == Verdict::identified ? known : others).push_back(p);
  }
  if (!known.empty()) {
    out.blocks.push_back({page_table(std::move(known), {}), page});
  }
  if (!others.empty()) {
    const std::string title =
        counted(std::ssize(others), "parameter") + " that the data leave weak or do not excite";
    out.blocks.push_back({page_table(std::move(others), {title}), page});
  }
}

// Weak parameters by their names; those that are not excited with what they need.
Table verdicts(const Parameters& parameters) {
  Table out{{{""}, {""}}};
  std::vector<std::string> weak;
  for (const ParameterEstimate& p : parameters) {
    if (p.verdict == Verdict::weak) {
      weak.push_back(p.name);
    } else if (p.verdict == Verdict::not_excited) {
      out.rows.push_back({{std::string(sign(Mark::unseen)) + " " + p.name, p.advice}});
    }
  }
  if (!weak.empty()) {
    out.rows.insert(out.rows.begin(), {{std::string(sign(Mark::weak)) + " weak", comma_list(weak)}});
  }
  return out;
}

// What the data determine badly, and the motion that would help; folded where it is long.
List advice(const Parameters& parameters) {
  constexpr std::ptrdiff_t few = 10;
  List out{"advice"};
  const auto weak = std::ranges::count(parameters, Verdict::weak, &ParameterEstimate::verdict);
  for (const ParameterEstimate& p : parameters) {
    if (p.verdict != Verdict::identified) {
      out.items.push_back({p.name, (p.verdict == Verdict::weak ? " weak: " : " not excited: ") + p.advice});
    }
  }
  out.fold = {std::to_string(weak) + " weak, " + std::to_string(std::ssize(out.items) - weak) +
                  " not excited, of " + counted(std::ssize(parameters), "parameter") +
                  ": why, and the motion that would help",
              std::ssize(out.items) <= few};
  return out;
}

Section parameters_section(const Identification& result) {
  Section out{"parameters", "Parameters", "Parameters"};
  out.blocks = {
      {Legend{{{"bar", "interval and value"},
               {"apriori", "a priori, from the robot description"},
               {"zero", "zero"}},
              "The parameter known best comes first. Each bar has a scale of its own; it is red where the "
              "parameter is weak. Click a heading to sort."},
       page},
      {parameters_table(result.parameters), screen},
      {verdicts(result.parameters), screen}};
  add_page_tables(result.parameters, out);
  if (result.covariance.quantile_975 != 0.0) {
    out.blocks.push_back({Sentence{"sigma: " + in_words(result.covariance, result.diagnostics.has_value())}});
    out.blocks.push_back(
        {Sentence{"Intervals are value ± " + number(result.covariance.quantile_975, 4) + " sigma"}, page});
  }
  if (List why = advice(result.parameters); !why.items.empty()) {
    out.blocks.push_back({std::move(why), page});
  }
  return out;
}

// ---------------------------------------------------------------------------------------------- fit

Table fit_table(const Fit& fit) {
  using J = JointFit;
  Table out = table_of(
      fit.joints, {{{"joint"}, [](const J& j) { return j.name; }},
                   {{"rows", format::count}, [](const J& j) { return static_cast<double>(j.rows); }},
                   {{"left out", format::count}, [](const J& j) { return static_cast<double>(j.left_out); }},
                   {{"rel. error", format::percent}, [](const J& j) { return j.relative_error; }},
                   {{"centred", format::percent}, [](const J& j) { return j.centred_relative_error; }},
                   {{"sigma_rho", format::significant(4)}, [](const J& j) { return j.sigma_rho; }},
                   {{"unit"}, [](const J& j) { return j.unit; }}});
  if (fit.joints.size() > 1) {
    Index left_out = 0;
    for (const JointFit& joint : fit.joints) {
      left_out += joint.left_out;
    }
    out.rows.push_back({{"all", static_cast<double>(fit.rows), static_cast<double>(left_out),
                         fit.relative_error, fit.centred_relative_error, "", ""},
                        Mark::sum});
  }
  return out;
}

// What another model costs in fit.
Table price_table(const Fit& plain, const Fit& other, const std::string& title) {
  Table out{{{"joint"},
             {"rel. error", format::percent},
             {title, format::percent},
             {"centred", format::percent},
             {title, format::percent}}};
  for (std::size_t j = 0; j < plain.joints.size(); ++j) {
    const JointFit& of_plain = plain.joints[j];
    const JointFit& of_other = other.joints[j];
    out.rows.push_back({{of_plain.name, of_plain.relative_error, of_other.relative_error,
                         of_plain.centred_relative_error, of_other.centred_relative_error}});
  }
  if (plain.joints.size() > 1) {
    out.rows.push_back({{"all", plain.relative_error, other.relative_error, plain.centred_relative_error,
                         other.centred_relative_error},
                        Mark::sum});
  }
  return out;
}

// What another set of parameters than the estimate costs in fit, and on the logs of the validation.
void add_prices(Section& out, const Identification& result, const Fit& fit,
                std::optional<Fit> Validation::* of_validation, const std::string& title) {
  out.blocks.push_back({Heading{"Their price in fit"}});
  out.blocks.push_back({price_table(result.fit, fit, title)});
  for (const Validation& validation : result.validation) {
    if (const std::optional<Fit>& other = validation.*of_validation) {
      out.blocks.push_back({Heading{"Their price on " + validation.file}});
      out.blocks.push_back({price_table(validation.fit, *other, title)});
    }
  }
}

Section weights_section(const RobustReport& report) {
  using R = RobustJoint;
  const bool rejects = report.options.kind == RobustKind::bisquare;
  const auto share = [](Index rows, const R& joint) {
    return static_cast<double>(rows) / static_cast<double>(joint.rows);
  };
  Section out{"weights", "Weights", "Weights of the rows"};
  out.blocks = {
      {table_of(report.joints,
                {{{"joint"}, [](const R& j) { return j.name; }},
                 {{"scale", format::significant(4)}, [](const R& j) { return j.scale; }},
                 {{rejects ? "no weight" : "weight below 1", format::percent},
                  [=](const R& j) { return share(rejects ? j.rejected : j.below_one, j); }},
                 {{"below 1/2", format::percent}, [=](const R& j) { return share(j.below_half, j); }}})},
      {Sentence{in_words(report)}}};
  return out;
}

// ---------------------------------------------------------------------------------------------- plots

// Tests and shape of the residual of the rows of the fit; no blocks where there is neither.
Section residual_section(const Identification& result, std::vector<Block> charts) {
  using R = ResidualTests;
  Section out{"residual", "Residual", "Residual"};
  if (const std::optional<Diagnostics>& found = result.diagnostics) {
    out.blocks.push_back(
        {Sentence{"Of the rows of the fit. Small p-values mean that the residual is not white, or not "
                  "normal; with many rows they come with effects too small to matter"},
         page});
    out.blocks.push_back({table_of(
        found->residuals,
        {{{"joint"}, [](const R& r) { return r.joint; }},
         {{"autocorrelation", format::fixed(2)}, [](const R& r) { return r.autocorrelation; }},
         {{"p (Ljung-Box)", format::significant(2)}, [](const R& r) { return r.whiteness.p; }},
         {{"skewness", format::fixed(2)}, [](const R& r) { return r.skewness; }},
         {{"exc. kurtosis", format::fixed(2)}, [](const R& r) { return r.excess_kurtosis; }},
         {{"p (Jarque-Bera)", format::significant(2)}, [](const R& r) { return r.normality.p; }}})});
    if (found->hausman) {
      out.blocks.push_back({Sentence{in_words(*found->hausman)}});
    }
    if (found->torque_lag) {
      out.blocks.push_back({Sentence{in_words(*found->torque_lag)}});
    }
  }
  out.shown = out.blocks.empty() ? page : everywhere;
  std::ranges::move(charts, std::back_inserter(out.blocks));
  return out;
}

// ---------------------------------------------------------------------------------------------- prefilter

Table noise_table(const Identification& result, const PrefilterReport& report) {
  return table_of(
      places(report.noise.size()),
      {{{"joint"}, [&](std::size_t j) { return report.noise[j].joint; }},
       {{"order", format::count},
        [&](std::size_t j) { return static_cast<double>(report.noise[j].ar.size()); }},
       {{"sigma of e", format::significant(4)}, [&](std::size_t j) { return report.noise[j].innovation; }},
       {{"unit"},
        [&](std::size_t j) {
          return j < result.fit.joints.size() ? result.fit.joints[j].unit : std::string();
        }},
       {{"a_1, a_2, …"}, [&](std::size_t j) {
          std::vector<std::string> coefficients;
          for (const double a : report.noise[j].ar) {
            coefficients.push_back(number(a, 3));
          }
          return comma_list(coefficients);
        }}});
}

// The estimate beside another one, in deviations of that one; marked where they are apart by more than both intervals.
Table shift_table(const Identification& result, const PrefilterReport& plain) {
  const auto shift = [&](std::size_t i) { return std::abs(result.parameters[i].value - at(plain.chi, i)); };
  const auto sigma = [&](std::size_t i) { return at(plain.sigma, i); };
  const auto mark = [&](std::size_t i) {
    const double half_width = std::max(plain.covariance.quantile_975 * sigma(i),
                                       result.covariance.quantile_975 * result.parameters[i].sigma);
    return shift(i) > half_width ? Mark::apart : Mark::none;
  };
  const Parameters& all = result.parameters;
  return table_of(
      places(all.size()),
      {{{"parameter", format::name}, [&](std::size_t i) { return all[i].name; }},
       {{"without", format::deviation}, [&](std::size_t i) { return Cell(at(plain.chi, i), sigma(i)); }},
       {{"sigma", format::deviation}, [&](std::size_t i) { return Cell(sigma(i), sigma(i)); }},
       {{"with prefilter", format::deviation},
        [&](std::size_t i) { return Cell(all[i].value, all[i].sigma); }},
       {{"sigma", format::deviation}, [&](std::size_t i) { return Cell(all[i].sigma, all[i].sigma); }},
       {{"unit"}, [&](std::size_t i) { return all[i].unit; }},
       {{"apart by", format::fixed(2), "σ"}, [&](std::size_t i) { return shift(i) / sigma(i); }}},
      mark);
}

Section prefilter_section(const Identification& result, const PrefilterReport& report) {
  std::vector<std::string> orders;
  for (const NoiseModel& model : report.noise) {
    orders.push_back(std::to_string(model.ar.size()));
  }
  Section out{"prefilter", "Prefilter", "Prefilter"};
  out.blocks = {
      {Sentence{"prefilter: autoregressive noise of order " + comma_list(orders) + " taken off " +
                counted(report.rows, "row") + ", in " + counted(report.rounds, "round")}},
      {Sentence{"The error of each joint's rows is taken for ρ_t = Σ a_i ρ_{t−i} + e_t with white e"}, page},
      {noise_table(result, report), page}};
  if (report.chi.size() == static_cast<Index>(result.parameters.size())) {
    out.blocks.push_back({Heading{"Against the estimate without it"}, page});
    out.blocks.push_back(
        {Sentence{
             "Whitening moves no parameter far where the model is right. How far they are apart is given "
             "in deviations of the estimate without the prefilter; marked where that is beyond both "
             "95 % intervals"},
         page});
    out.blocks.push_back({shift_table(result, report), page});
  }
  return out;
}

// ---------------------------------------------------------------------------------------------- iterations

Table iteration_table(const std::vector<IvIteration>& all) {
  return table_of(
      places(all.size()),
      {{{"k", format::count}, [](std::size_t k) { return static_cast<double>(k); }},
       // The residual of Y against the simulated regressor shows whether the assumed loop is the actual one.
       {{"|Y - V chi| / |Y|", format::percent}, [&](std::size_t k) { return all[k].relative_error; }},
       {{"largest step", format::significant(3), "sigma"},
        [&](std::size_t k) { return k == 0 ? Cell("") : Cell(all[k].largest_step); }},
       {{"sim. to measured q", format::percent},
        [&](std::size_t k) {
          const Vector& q = all[k].to_measured.q;
          return q.size() > 0 ? q.maxCoeff() : std::numeric_limits<double>::quiet_NaN();
        }},
       {{"condition V", format::significant(4)}, [&](std::size_t k) { return all[k].condition_V; }},
       {{"of Q'W", format::significant(4), "", page}, [&](std::size_t k) { return all[k].condition_VW; }},
       {{"remark"}, [&](std::size_t k) { return all[k].safeguard; }}});
}

// The path of each parameter over the iterations, fig. 10 of [RIV], towards its interval.
Plots parameter_paths(const Parameters& parameters, const std::vector<IvIteration>& iterations) {
  Plots out{"paths"};
  Plots::Group& all = out.groups.emplace_back();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterEstimate& p = parameters[i];
    PathPlot path{p.name, with_decimals_of(p.value, p.sigma) + " " + p.unit, "", {}};
    for (const IvIteration& k : iterations) {
      path.steps.push_back(at(k.chi, i));
    }
    if (std::isfinite(p.sigma)) {
      path.interval = p.interval_95;
    }
    path.label = p.name + " from " + number(path.steps.front(), 4) + " to " + number(path.steps.back(), 4) +
                 " " + p.unit;
    all.plots.emplace_back(std::move(path));
  }
  return out;
}

// The loop as it was simulated last, and how far it is from the recorded one.
Table loop_table(const IvHistory& history, const std::vector<JointFit>& joints) {
  const IvIteration& last = history.iterations.back();
  std::vector<Indexed> fields = {
      {{"joint"}, [&](std::size_t j) { return joints[j].name; }},
      {{"design inertia", format::significant(4)}, [&](std::size_t j) { return at(last.J, j); }}};
  for (const Gain& gain : last.gains) {
    fields.push_back(
        {{gain.name, format::significant(4)}, [&](std::size_t j) { return at(gain.values, j); }});
  }
  fields.push_back({{"control signal", format::percent},
                    [&](std::size_t j) { return at(history.loop.control_error, j); }});
  fields.push_back({{"tracking ratio", format::significant(3)},
                    [&](std::size_t j) { return at(history.loop.tracking_ratio, j); }});
  return table_of(places(joints.size()), fields);
}

Section iterations_section(const Identification& result, const IvHistory& history) {
  Section out{"iterations", "Iterations", "Iterations"};
  out.blocks = {
      {iteration_table(history.iterations)},
      {Heading{"Torque error"}, page},
      {Sentence{
           "Of the model along the simulated motion, relative to the norm of all torques; the squares of "
           "the joints' shares add up to the square of the whole"},
       page},
      {Plots{"", {}, {{"", "", {torque_error_chart(result)}}}}, page},
      {Heading{"Parameters over the iterations"}, page},
      {Sentence{"With the 95 % interval of the result as a band"}, page},
      {parameter_paths(result.parameters, history.iterations), page},
      {Heading{"Motion errors"}, page},
      {Sentence{"Distance of the simulated motion from the measured one (solid) and from the reference "
                "(dashed), relative to the norm of the latter two"},
       page},
      {motion_error_charts(result), page},
      {Heading{"The assumed controller"}, page},
      {Sentence{"Design inertias and gains of the last simulation, SI units. Then how far the control signal "
                "of the assumed law is from the recorded one, and how far the simulated positions are from "
                "the measured ones, compared with the reference. Both are small where the assumed loop is "
                "the actual one"},
       page},
      {loop_table(history, result.fit.joints), page}};
  return out;
}

// ---------------------------------------------------------------------------------------------- other models

// Which removal took a parameter away; empty where it stays.
std::string removal(const EssentialParameters& found, const std::string& name) {
  const auto gone = std::ranges::find(found.eliminated, name, &EliminatedParameter::name);
  if (gone == found.eliminated.end()) {
    return {};
  }
  return "removal " + std::to_string(gone - found.eliminated.begin() + 1) + ": F = " + number(gone->F, 3) +
         ", p = " + number(gone->p, 2);
}

Table essential_table(const Parameters& all, const EssentialParameters& found) {
  const auto gone = [&](std::size_t i) { return !removal(found, all[i].name).empty(); };
  const auto sigma = [&](std::size_t i) {
    const auto k = static_cast<Index>(i);
    return std::sqrt(found.C_chi(k, k));
  };
  return table_of(
      places(all.size()),
      {{{"parameter", format::name}, [&](std::size_t i) { return all[i].name; }},
       {{"all", format::deviation}, [&](std::size_t i) { return Cell(all[i].value, all[i].sigma); }},
       {{"%sigma", format::fixed(3)}, [&](std::size_t i) { return all[i].relative_sigma_percent; }},
       {{"essential", format::deviation},
        [&](std::size_t i) { return gone(i) ? Cell("") : Cell(at(found.chi, i), sigma(i)); }},
       {{"%sigma", format::fixed(3)},
        [&](std::size_t i) {
          return gone(i) ? Cell("") : Cell(100.0 * sigma(i) / std::abs(at(found.chi, i)));
        }},
       {{"unit"}, [&](std::size_t i) { return all[i].unit; }},
       {{"eliminated"}, [&](std::size_t i) { return removal(found, all[i].name); }}},
      [&](std::size_t i) { return gone(i) ? Mark::gone : Mark::none; });
}

Section essential_section(const Identification& result, const EssentialModel& model) {
  const EssentialParameters& found = model.parameters;
  const std::string all = std::to_string(result.base.size());
  Section out{"essential", "Essential",
              "Essential parameters: " + std::to_string(found.kept.size()) + " of " + all};
  if (found.eliminated.empty()) {
    out.blocks.push_back({Sentence{"All " + all + " are needed: none can go"}});
    return out;
  }
  out.blocks = {{Sentence{std::to_string(found.kept.size()) + " of " + all +
                          " parameters are enough for these data. The others are taken out one by one, the "
                          "least certain first, as long as an F-test at " +
                          number(100.0 * model.options.significance, 3) +
                          " % does not reject their removal. Of all removals together F = " +
                          number(found.F, 3) + ", p = " + number(found.p, 2)}},
                {essential_table(result.parameters, found)}};
  if (!found.held.empty()) {
    out.blocks.push_back({Sentence{"Held, since no robot would move without: " + comma_list(found.held)}});
  }
  add_prices(out, result, model.fit, &Validation::essential, "essential");
  return out;
}

// All standard parameters of a link in one line.
Table links_table(const BaseParameters& base, const Vector& chi_st) {
  Table out{{{"link", format::count}, {"standard parameters, SI on the joint side"}}};
  std::vector<std::string> links;
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const auto joint = static_cast<std::size_t>(base.standard[i].joint);
    links.resize(std::max(links.size(), joint + 1));
    // Glued, so that no line is broken within.
    links[joint] += base.standard[i].name() + "=" + number(at(chi_st, i), 4) + " ";
  }
  for (std::size_t j = 0; j < links.size(); ++j) {
    out.rows.push_back({{static_cast<double>(j + 1), links[j]}});
  }
  return out;
}

Section physical_section(const Identification& result, const PhysicalModel& model) {
  const Parameters& all = result.parameters;
  const Vector& chi = model.parameters.chi;
  Table standard =
      table_of(places(result.base.standard.size()),
               {{{"parameter", format::name}, [&](std::size_t i) { return result.base.standard[i].name(); }},
                {{"value, SI on the joint side", format::significant(6)},
                 [&](std::size_t i) { return at(model.parameters.chi_st, i); }}});
  standard.fold = {"Standard parameters of all links"};
  Section out{"physical", "Physical",
              "Physically consistent parameters: prior " + std::string(name(model.options.prior)) +
                  " with weight " + number(model.options.weight, 4) + ", divergence " +
                  number(model.parameters.divergence, 4) + " from the robot description"};
  out.blocks = {
      {links_table(result.base, model.parameters.chi_st), screen},
      {table_of(
           places(all.size()),
           {{{"parameter", format::name}, [&](std::size_t i) { return all[i].name; }},
            {{"estimate", format::deviation},
             [&](std::size_t i) { return Cell(all[i].value, all[i].sigma); }},
            {{"physical", format::deviation}, [&](std::size_t i) { return Cell(at(chi, i), all[i].sigma); }},
            {{"unit"}, [&](std::size_t i) { return all[i].unit; }},
            {{"apart by", format::fixed(2), "σ"},
             [&](std::size_t i) { return std::abs(at(chi, i) - all[i].value) / all[i].sigma; }}}),
       page}};
  add_prices(out, result, model.fit, &Validation::physical, "physical");
  out.blocks.push_back({std::move(standard), page});
  return out;
}

// ---------------------------------------------------------------------------------------------- conditioning

Section conditioning_section(const Identification& result) {
  constexpr std::size_t few = 16;
  const Vector& R = result.R_diagonal;
  const double largest = R.size() > 0 ? R.maxCoeff() : 0.0;
  // On a logarithmic scale: 1 for the largest, 0 for one that is zero to rounding.
  const auto share = [&](std::size_t i) {
    const double decades = -std::log10(std::numeric_limits<double>::epsilon());
    return at(R, i) > 0.0 ? std::max(1.0 + std::log10(at(R, i) / largest) / decades, 0.0) : 0.0;
  };
  std::vector<Indexed> fields = {
      {{"parameter", format::name}, [&](std::size_t i) { return result.parameters[i].name; }},
      {{"|R_ii|", format::significant(4)}, [&](std::size_t i) { return at(R, i); }},
      {{"", format::share}, share}};
  if (result.iv && result.iv->first_stage_F.size() == result.base.size()) {
    fields.push_back({{"strength of the instruments, F", format::significant(4)},
                      [&](std::size_t i) { return at(result.iv->first_stage_F, i); }});
  }
  Table pivots =
      table_of(places(std::min(result.parameters.size(), static_cast<std::size_t>(R.size()))), fields);
  pivots.fold = {"Pivots of all parameters, on a logarithmic scale", result.parameters.size() <= few};
  Section out{"conditioning", "Conditioning", "Conditioning", {}, page};
  out.blocks = {
      {Sentence{"The condition number of the problem is " + number(result.condition, 4) +
                ". A parameter is hard to distinguish from the others where its pivot |R_ii| of the "
                "factored observation matrix is small" +
                (result.iv ? ", or where the simulated motion, F below 10, hardly shows it" : "")}},
      {std::move(pivots)}};
  return out;
}

// ---------------------------------------------------------------------------------------------- provenance

List coupling_list(const Robot& robot) {
  const auto joint = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  List out{"couplings"};
  for (const Coupling& coupling : robot.couplings) {
    std::vector<std::string> turned_by;
    for (std::size_t k = 0; k < coupling.joints.size(); ++k) {
      turned_by.push_back(joint(coupling.joints[k]) + " (" + number(coupling.ratios[k], 6) + ")");
    }
    out.items.push_back({.text = "The motor of " + joint(coupling.motor) + " is turned by " +
                                 comma_list(turned_by) + " as well: inertia " +
                                 std::string(name(coupling.inertia)) + ", Coulomb " +
                                 std::string(name(coupling.coulomb)) + "."});
  }
  return out;
}

std::string friction_words(const Joint& joint) {
  return std::string(name(joint.friction)) +
         (joint.sign_speed > 0.0 ? ", smooth over " + number(joint.sign_speed, 4) : "");
}

Section provenance_section(const Robot& robot, const Identification& result, const Provenance& provenance) {
  using J = Joint;
  std::vector<std::pair<std::string, std::string>> settings = {
      {"Program", provenance.program + ", rivid " + std::string(version)},
      {"Run", run_id(provenance)},
      {"Method", result.title}};
  std::ranges::move(row_settings(result.estimation.signal), std::back_inserter(settings));
  for (const auto& [flag, value] : provenance.overrides) {
    settings.emplace_back("Flag --" + flag, value);
  }
  const Eigen::Vector3d& g = robot.chain.gravity;
  Section out{"provenance", "Provenance", "Provenance", {}, page};
  out.blocks = {
      {settings_table(settings)},
      {inputs_table(provenance)},
      {Heading{"Robot"}},
      {table_of(
          robot.joints,
          {{{"joint"}, [](const J& j) { return j.name; }},
           {{"moves"}, [](const J& j) { return j.link; }},
           {{"type"}, [](const J& j) { return j.type == JointType::revolute ? "revolute" : "prismatic"; }},
           {{"friction"}, friction_words},
           {{"rotor inertia"}, [](const J& j) { return j.rotor_inertia ? "yes" : "no"; }},
           {{"drive gain", format::significant(6)}, [](const J& j) { return j.drive_gain; }},
           {{"gear ratio", format::significant(6)}, [](const J& j) { return j.gear_ratio; }}})},
      {coupling_list(robot)},
      {Sentence{"Gravity in the frame of the base: " + number(g.x(), 6) + ", " + number(g.y(), 6) + ", " +
                number(g.z(), 6) + " m/s²"}}};
  return out;
}

// ---------------------------------------------------------------------------------------------- the whole

// What was chosen in place of what was left open.
std::vector<std::string> choices_of(const Identification& result) {
  std::vector<std::string> out;
  if (result.method_choice) {
    out.push_back("method: " + result.method_choice->reason);
  }
  if (result.row_choice) {
    out.push_back("rows: " + result.row_choice->reason);
  }
  return out;
}

KeyFigures figures_of(const Identification& result) {
  const auto known = std::ranges::count(result.parameters, Verdict::identified, &ParameterEstimate::verdict);
  KeyFigures out{
      {{std::to_string(known) + " of " + std::to_string(result.columns), "base parameters identified"},
       {std::to_string(result.fit.rows), "rows"}}};
  if (predicted(result)) {
    out.figures.emplace_back(percent(result.fit.relative_error), "torque error of the fit");
  }
  for (const Validation& validation : result.validation) {
    out.figures.emplace_back(percent(validation.fit.relative_error),
                             "torque error on " + std::filesystem::path(validation.file).filename().string());
  }
  return out;
}

// One finding of each code, the others by their subjects.
std::vector<Finding> told_once(const std::vector<Finding>& findings) {
  std::vector<Finding> out;
  std::vector<std::vector<std::string>> others;
  for (const Finding& finding : findings) {
    const auto at = std::ranges::find(out, finding.code, &Finding::code);
    if (at == out.end() || finding.subject.empty()) {
      out.push_back(finding);
      others.emplace_back();
    } else {
      others[static_cast<std::size_t>(at - out.begin())].push_back(finding.subject);
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!others[i].empty()) {
      out[i].text += "; the same of " + listed(others[i]);
    }
  }
  return out;
}

Document verdict_of(const Identification& result) {
  const bool identified = result.status == Status::identified;
  Document out;
  out.subtitle = result.title;
  out.verdict = identified ? Mark::good : Mark::bad;
  out.headline = identified ? "Identified"
                 : result.status == Status::doubtful
                     ? "Doubtful: " + std::string(why_not(result.status))
                     : "Not identified: " + std::string(why_not(result.status));
  out.line = result.title + ": " + std::string(name(result.status)) + ", " + std::to_string(result.columns) +
             " base parameters from " + std::to_string(result.fit.rows) + " rows, relative error " +
             percent(result.fit.relative_error) + ", condition " + number(result.condition, 4);
  // The reasons of a doubtful result are findings, which say what to do as well.
  const bool told_below = result.status == Status::doubtful;
  out.opening = {{list_of("reasons", told_below ? std::vector<std::string>() : result.reasons)},
                 {FindingList{told_once(result.warnings)}},
                 {list_of("choices", choices_of(result))},
                 {figures_of(result), page}};
  return out;
}

// Section that is there only if it says anything.
void add_if_any(Section section, std::vector<Section>& out) {
  if (!section.blocks.empty()) {
    out.push_back(std::move(section));
  }
}

// Those parts of a result that are there, in the order in which they are read. Without evidence there are no pictures.
std::vector<Section> sections_of(const Identification& result, const Evidence* evidence) {
  std::vector<Section> out;
  if (evidence != nullptr) {
    add_if_any(friction_section(*evidence), out);
    out.push_back(torques_section(*evidence));
  }
  out.push_back(parameters_section(result));
  if (evidence != nullptr) {
    add_if_any(correlation_section(result), out);
  }
  if (result.prefilter) {
    out.push_back(prefilter_section(result, *result.prefilter));
  }
  if (result.iv && !result.iv->iterations.empty()) {
    out.push_back(iterations_section(result, *result.iv));
  }
  out.push_back({"fit", "Fit", "Fit", {{fit_table(result.fit)}}});
  add_if_any(
      residual_section(result, evidence != nullptr ? residual_charts(*evidence) : std::vector<Block>()), out);
  if (result.robust) {
    out.push_back(weights_section(*result.robust));
  }
  for (const Validation& validation : result.validation) {
    out.push_back({"", "", "Validation on " + validation.file, {{fit_table(validation.fit)}}});
  }
  if (evidence != nullptr) {
    if (predicted(result)) {
      out.push_back(description_section(*evidence));
    }
    out.push_back(coverage_section(*evidence));
    add_if_any(robot_section(*evidence), out);
  }
  if (result.essential) {
    out.push_back(essential_section(result, *result.essential));
  }
  if (result.physical) {
    out.push_back(physical_section(result, *result.physical));
  }
  out.push_back(conditioning_section(result));
  if (!result.notes.empty()) {
    out.push_back({"notes", "Notes", "Notes", {{list_of("notes", result.notes)}}, page});
  }
  return out;
}

std::string cutoff(double hz, int order) {
  return hz > 0.0 ? number(hz, 4) + " Hz, order " + std::to_string(order) + ", forward and backward" : "none";
}

std::string decimation(const std::vector<int>& factors) {
  std::string out;
  for (const int n_d : factors) {
    out += (out.empty() ? "by " : ", then by ") + std::to_string(n_d);
  }
  return out.empty() ? "none" : out;
}

std::string thresholds(const SignalOptions& signal) {
  std::vector<std::string> speeds;
  for (const double speed : signal.velocity_threshold) {
    speeds.push_back(number(speed, 4));
  }
  return speeds.empty() ? std::string(signal.exact_rows() ? "about reversals and standstill" : "none")
                        : "below " + comma_list(speeds) + " rad/s or m/s, joint by joint";
}

}  // namespace

std::string_view why_not(Status status) {
  switch (status) {
    case Status::identified:
      return "";
    case Status::doubtful:
      return "there are reasons not to trust the estimate";
    case Status::rank_deficient:
      return "the data do not determine all parameters";
    case Status::not_converged:
      return "the iteration did not settle";
    case Status::cycling:
      return "the iteration goes round among a few estimates";
    case Status::weak_instruments:
      return "the simulated motion says too little about some parameters";
    case Status::not_simulable:
      return "no closed loop could be simulated with the estimate";
    case Status::gave_up:
      break;
  }
  return "a budget of steps or seconds was used up first";
}

std::vector<std::pair<std::string, std::string>> row_settings(const SignalOptions& signal) {
  std::vector<std::pair<std::string, std::string>> out = {
      {"Rows", std::string(name(signal.exact_rows() ? RowScheme::exact : RowScheme::paper)) +
                   (signal.convention == Convention::matlab ? ", convention matlab" : "") +
                   (signal.held() ? ", torques held between samples" : "")},
      {"Filter of the positions", cutoff(signal.cutoff_hz, signal.order)},
      {"Filter of the torques", cutoff(signal.torque_cutoff_hz, signal.torque_order)},
      {"Decimation", decimation(signal.decimation)},
      {"Left out", thresholds(signal)}};
  if (signal.trim) {
    out.emplace_back("Trimmed at either end", std::to_string((*signal.trim)[0]) + " and " +
                                                  std::to_string((*signal.trim)[1]) + " samples");
  }
  if (signal.window) {
    out.emplace_back("Window", number((*signal.window)[0]) + " to " + number((*signal.window)[1]) + " s");
  }
  return out;
}

Table settings_table(const std::vector<std::pair<std::string, std::string>>& settings) {
  Table out{{{""}, {""}}};
  for (const auto& [what, value] : settings) {
    out.rows.push_back({{what, value}});
  }
  return out;
}

Table inputs_table(const Provenance& provenance) {
  Table out{{{"input"}, {"SHA-256"}}};
  for (const InputFile& file : provenance.inputs) {
    out.rows.push_back({{file.path, file.sha256}});
  }
  return out;
}

Document document_of(const Identification& result) {
  Document out = verdict_of(result);
  out.sections = sections_of(result, nullptr);
  return out;
}

Document document_of(const Robot& robot, const Identification& result,
                     std::span<const Prediction> predictions, const Provenance& provenance) {
  Document out = verdict_of(result);
  out.title = robot.name + " · " + result.title;
  out.heading = robot.name;
  out.subtitle += provenance.inputs.empty() ? "" : " · " + provenance.inputs.front().path;
  const Evidence evidence{robot, result, predictions};
  if (!evidence.empty()) {
    out.first_look = first_look(evidence);
  }
  out.sections = sections_of(result, evidence.empty() ? nullptr : &evidence);
  out.sections.push_back(provenance_section(robot, result, provenance));
  return out;
}

}  // namespace rivid::detail
