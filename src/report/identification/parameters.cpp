#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "joined.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using enum Shown;
using Parameters = std::vector<ParameterEstimate>;

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
  // 0 stands for what the description does not tell.
  const bool told = p.a_priori != 0.0;
  return Interval{p.interval_95[0], p.interval_95[1], p.value, told ? p.a_priori : no_value,
                  p.name + ": " + interval_words(p) + (told ? ", a priori " + number(p.a_priori, 4) : "")};
}

std::string group_words(const ParameterEstimate& p) { return p.regrouped == p.name ? "" : p.regrouped; }

// What makes most of a deviation, where that is not the errors in the rows.
std::string widening(const ParameterEstimate& p) {
  const double half = 0.5 * p.sigma * p.sigma;
  return p.model_shift * p.model_shift > half ? p.widened_by : p.row_shift * p.row_shift > half ? "rows" : "";
}

using Columns = std::vector<ColumnOf<ParameterEstimate>>;

// Columns that are there only if they say anything: what widens deviations, and behind the physically
// consistent parameters, which are the answer then, the estimate.
void add_occasional(const Identification& result, Columns& fields) {
  using P = ParameterEstimate;
  if (std::ranges::any_of(result.parameters, [](const P& p) { return !widening(p).empty(); })) {
    fields.push_back({{"widened by"}, widening});
  }
  if (result.physical_answers()) {
    const Vector& chi = result.physical->parameters.chi;
    // Tables of the page are sorted.
    const auto place = [&result](const P& p) {
      return std::ranges::find(result.parameters, p.name, &P::name) - result.parameters.begin();
    };
    fields.insert(fields.begin() + 1, {{"physical", format::deviation},
                                       [=, &chi](const P& p) { return Cell(chi[place(p)], p.sigma); }});
    fields[2].column.heading = "estimate";
  }
}

// One line a column.
Table parameters_table(const Identification& result) {
  using P = ParameterEstimate;
  Columns fields = {{{"parameter", format::name}, &P::name},
                    {{"value", format::deviation}, [](const P& p) { return Cell(p.value, p.sigma); }},
                    {{"unit"}, &P::unit},
                    {{"sigma", format::deviation}, [](const P& p) { return Cell(p.sigma, p.sigma); }},
                    {{"%sigma", format::fixed(3)}, &P::relative_sigma_percent},
                    {{"95 % interval"}, interval_words}};
  add_occasional(result, fields);
  fields.push_back({{"grouped from"}, group_words});
  return table_of(result.parameters, fields, mark_of);
}

// The same on a page, those that are known best first; what is narrow stands before what is wide. Deviations
// by the residuals alone only where they differ.
Table page_table(const Identification& result, Parameters parameters, Fold fold) {
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
  Columns fields = {{{"parameter", format::name}, &P::name},
                    {{"value", format::deviation}, [](const P& p) { return Cell(p.value, p.sigma); }},
                    {{"", format::interval}, interval_bar},
                    {{"unit"}, &P::unit},
                    {{"%sigma", format::fixed(3)}, &P::relative_sigma_percent},
                    {{"sigma", format::deviation}, [](const P& p) { return Cell(p.sigma, p.sigma); }},
                    {{"95 % interval"}, interval_words},
                    {{"a priori", format::significant(4)},
                     [](const P& p) { return Cell(p.a_priori != 0.0 ? p.a_priori : no_value); }},
                    {{"by noise", format::fixed(2), "σ"}, &P::noise_bias}};
  if (plain_differs) {
    fields.push_back(
        {{"row sigma", format::deviation}, [](const P& p) { return Cell(p.plain_sigma, p.plain_sigma); }});
  }
  add_occasional(result, fields);
  fields.push_back({{"grouped from"}, group_words});
  Table out = table_of(parameters, fields, mark_of);
  out.fold = std::move(fold);
  return out;
}

// Parameters that are known, and those that are not, folded.
void add_page_tables(const Identification& result, Section& out) {
  Parameters known;
  Parameters others;
  for (const ParameterEstimate& p : result.parameters) {
    (p.verdict == Verdict::identified ? known : others).push_back(p);
  }
  if (!known.empty()) {
    out.blocks.push_back({page_table(result, std::move(known), {}), page});
  }
  if (!others.empty()) {
    const std::string title =
        counted(std::ssize(others), "parameter") + " that the data leave weak or do not excite";
    out.blocks.push_back({page_table(result, std::move(others), {title}), page});
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
    out.rows.insert(out.rows.begin(), {{std::string(sign(Mark::weak)) + " weak", joined(weak)}});
  }
  return out;
}

// What the data determine badly, and the motion that would help; folded where it is long.
List advice(const Parameters& parameters) {
  constexpr std::ptrdiff_t few = 10;  // items of a list that is not folded; a choice
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

}  // namespace

Section parameters_section(const Identification& result) {
  Section out{"parameters", "Parameters", "Parameters"};
  out.blocks = {{Legend{{{"bar", "interval and value"},
                         {"apriori", "a priori, from the robot description"},
                         {"zero", "zero"}},
                        "The most accurate parameter comes first. All bars have one scale, from zero to "
                        "twice the value; red bars are weak parameters. Click a heading to sort."},
                 page},
                {parameters_table(result), screen},
                {verdicts(result.parameters), screen}};
  add_page_tables(result, out);
  if (result.covariance.quantile_975 != 0.0) {
    const std::string sigma = "sigma: " + in_words(result.covariance, result.diagnostics.has_value());
    out.blocks.push_back({Sentence{sigma}, screen});
    out.blocks.push_back(
        {List{"notes",
              {{.text = sigma},
               {.text = "Intervals are value ± " + number(result.covariance.quantile_975, 4) + " sigma"},
               {.text = "by noise: what the noise of the positions shifts the value by; row sigma: by the "
                        "residuals alone"}},
              {"Where sigma and the intervals come from"}},
         page});
  }
  if (List why = advice(result.parameters); !why.items.empty()) {
    out.blocks.push_back({std::move(why), page});
  }
  return out;
}

Section gains_section(const Identification& result) {
  struct Line {
    const GainEstimate& gain;
    std::string unit;

    // A gain that the scale hangs on has a deviation of rounding alone.
    [[nodiscard]] bool exact() const { return gain.sigma < 1e-4 * std::abs(gain.value); }
  };
  using L = Line;
  const GainReport& gains = *result.gains;
  Section out{"gains", "Drive gains", "Drive gains"};
  out.blocks.push_back({Sentence{gains.scale}});
  if (!gains.identified) {
    return out;
  }
  std::vector<Line> lines;
  std::string used;
  for (std::size_t j = 0; j < gains.joints.size(); ++j) {
    const GainEstimate& gain = gains.joints[j];
    lines.push_back({gain, result.fit.joints[j].unit + "/A"});
    used += (used.empty() ? "" : ", ") + number(gain.identifiable ? gain.value : gain.nominal, 5);
  }
  out.blocks.push_back({table_of(
      lines,
      {{{"joint"}, [](const L& l) { return l.gain.joint; }},
       {{"nominal", format::significant(5)}, [](const L& l) { return l.gain.nominal; }},
       {{"estimate", format::deviation},
        [](const L& l) {
          return l.exact() ? Cell(number(l.gain.value, 5)) : Cell(l.gain.value, l.gain.sigma);
        }},
       {{"unit"}, &L::unit},
       {{"sigma", format::deviation},
        [](const L& l) { return l.exact() ? Cell(no_value) : Cell(l.gain.sigma, l.gain.sigma); }},
       {{"95 % interval"},
        [](const L& l) {
          return l.exact() ? "counts as exact"
                           : number(l.gain.interval_95[0], 5) + " … " + number(l.gain.interval_95[1], 5);
        }},
       {{""},
        [](const L& l) { return l.gain.identifiable ? "" : "not identifiable, the nominal gain is used"; }}},
      [](const L& l) { return l.gain.identifiable ? Mark::none : Mark::unseen; })});
  out.blocks.push_back(
      {Sentence{"Used, on the joint side: " + used + ". The unit holds for control signals in A"}});
  return out;
}

Section loop_section(const OutputErrorReport& report) {
  using L = LoopEstimate;
  Section out{"loop", "Control loop", "Gains and delay of the control loop"};
  out.blocks.push_back({table_of(
      report.loop, {{{""}, &L::name},
                    {{"joint"}, &L::joint},
                    {{"before", format::deviation}, [](const L& l) { return Cell(l.prior, l.prior_sigma); }},
                    {{"σ before", format::significant(2)}, &L::prior_sigma},
                    {{"estimate", format::deviation}, [](const L& l) { return Cell(l.value, l.sigma); }},
                    {{"sigma", format::significant(2)}, &L::sigma},
                    {{"95 % interval"}, [](const L& l) {
                       return number(l.interval_95[0], 4) + " … " + number(l.interval_95[1], 4);
                     }}})});
  out.blocks.push_back({Sentence{report.scale}});
  return out;
}

}  // namespace rivid::detail
