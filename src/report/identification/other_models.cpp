#include <algorithm>
#include <cmath>

#include "joined.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using enum Shown;
using Parameters = std::vector<ParameterEstimate>;

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
          return joined(report.noise[j].ar, ", ", [](double a) { return number(a, 3); });
        }}});
}

// The estimate beside another one, in deviations of that one; marked where they are apart by more than both
// intervals.
Table shift_table(const Identification& result, const PrefilterReport& plain) {
  const auto shift = [&](std::size_t i) { return std::abs(result.parameters[i].value - at(plain.chi, i)); };
  const auto sigma = [&](std::size_t i) { return at(plain.sigma, i); };
  const auto mark = [&](std::size_t i) {
    const double half_width = std::max(plain.covariance.quantile_975 * sigma(i),
                                       result.covariance.quantile_975 * result.parameters[i].sigma);
    return shift(i) > half_width ? Mark::apart : Mark::none;
  };
  const std::vector<ParameterEstimate>& all = result.parameters;
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

}  // namespace

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
    out.blocks.push_back({Sentence{"Held, since no robot would move without: " + joined(found.held)}});
  }
  add_prices(out, result, model.fit, &Validation::essential, "essential");
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
  Section out{"physical", "Physical", "Physically consistent parameters"};
  out.blocks = {
      {Sentence{"Nearest to the robot description: prior " + std::string(name(model.options.prior)) +
                " with weight " + number(model.options.weight, 4) + ", divergence " +
                number(model.parameters.divergence, 4)}},
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

Section prefilter_section(const Identification& result, const PrefilterReport& report) {
  const auto order = [](const NoiseModel& model) { return std::to_string(model.ar.size()); };
  Section out{"prefilter", "Prefilter", "Prefilter"};
  out.blocks = {
      {Sentence{"prefilter: autoregressive noise of order " + joined(report.noise, ", ", order) +
                " taken off " + counted(report.rows, "row") + ", in " + counted(report.rounds, "round")}},
      {Sentence{"The error of each joint's rows is taken for ρ_t = Σ a_i ρ_{t−i} + e_t with white e"}, page},
      {noise_table(result, report), page}};
  if (report.chi.size() == static_cast<Index>(result.parameters.size())) {
    out.blocks.push_back({Heading{"Against the estimate without it"}, page});
    out.blocks.push_back(
        {Sentence{
             "Whitening moves no parameter far where the model is right. How far they are apart is given "
             "in deviations of the estimate without the prefilter; marked where that is beyond both 95 % "
             "intervals"},
         page});
    out.blocks.push_back({shift_table(result, report), page});
  }
  return out;
}

}  // namespace rivid::detail
