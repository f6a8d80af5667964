#include <algorithm>
#include <cmath>

#include "csv_columns.hpp"
#include "report/documents.hpp"
#include "report/excitation_charts.hpp"
#include "rivid/report/excitation.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

Mark forecast_mark(const ForecastParameter& parameter) {
  using enum ForecastParameter::Prospect;
  return parameter.prospect == weak ? Mark::weak : parameter.prospect == unseen ? Mark::unseen : Mark::none;
}

// That of a weak parameter, in per cent of its value: see ForecastParameter::Prospect.
constexpr double known_percent = 30.0;

// Why a parameter is weak, and how many such motions would do.
std::string why_weak(const ForecastParameter& p) {
  if (p.prospect == ForecastParameter::Prospect::good) {
    return "";
  }
  if (p.prospect == ForecastParameter::Prospect::unseen) {
    return "the motion does not show it, or only together with others";
  }
  if (p.value == 0.0) {
    return "its a-priori value is zero";
  }
  const double alone = 100.0 * p.sigma_alone / std::abs(p.value);
  const std::string cause = alone > known_percent
                                ? "small beside the noise: " + fixed(alone, 0) + " % if all others were known"
                                : "hard to distinguish from " + p.closest + " (correlation " +
                                      fixed(p.correlation, 2) + "): " + fixed(alone, 0) +
                                      " % if all others were known";
  const double ratio = p.relative_sigma_percent / known_percent;
  constexpr double many = 1000.0;  // motions; a choice: nobody repeats one more often
  const double motions = std::ceil(ratio * ratio);
  return cause + (motions <= many ? "; " + number(motions) + " such motions would do" : "");
}

Table forecast_table(const Forecast& forecast) {
  return table_of(
      forecast.parameters,
      {{{"parameter", format::name}, &ForecastParameter::name},
       {{"a priori", format::deviation}, [](const ForecastParameter& p) { return Cell(p.value, p.sigma); }},
       {{"forecast σ", format::significant(2)}, &ForecastParameter::sigma},
       {{"%σ", format::fixed(1)}, &ForecastParameter::relative_sigma_percent},
       {{"unit"}, &ForecastParameter::unit},
       {{"why", format::text, "", Shown::page}, why_weak}},
      forecast_mark);
}

Table limit_table(const Forecast& forecast) {
  return table_of(forecast.limits,
                  {{{"joint", format::name}, &LimitUse::joint},
                   {{"limit"}, &LimitUse::quantity},
                   {{"used", format::percents(1)}, &LimitUse::share},
                   {{"", format::stack, "", Shown::page},
                    [](const LimitUse& l) {
                      return Stack{{{"fit", std::clamp(l.share, 0.0, 1.0)}},
                                   l.quantity + " " + percent(l.share)};
                    }},
                   {{"extreme", format::significant(4)}, &LimitUse::value},
                   {{"allowed", format::significant(4)}, &LimitUse::limit},
                   {{"unit"}, &LimitUse::unit},
                   {{"at s", format::fixed(2)}, &LimitUse::time}},
                  [](const LimitUse& l) { return l.share > 1.0 ? Mark::bad : Mark::none; });
}

Table clearance_table(const Forecast& forecast) {
  return table_of(forecast.clearances,
                  {{{"link", format::name}, &ClearanceUse::first},
                   {{"from"}, &ClearanceUse::second},
                   {{"smallest distance m", format::fixed(4)}, &ClearanceUse::distance},
                   {{"asked", format::fixed(4)}, &ClearanceUse::wanted},
                   {{"at s", format::fixed(2)}, &ClearanceUse::time}},
                  [](const ClearanceUse& c) { return c.distance < c.wanted ? Mark::bad : Mark::none; });
}

std::ptrdiff_t count_of(const Forecast& forecast, ForecastParameter::Prospect prospect) {
  return std::ranges::count(forecast.parameters, prospect, &ForecastParameter::prospect);
}

// "52 parameters, of which 49 within 30 %, 3 weak, none unseen".
std::string forecast_verdict(const Forecast& forecast) {
  using enum ForecastParameter::Prospect;
  return counted(std::ssize(forecast.parameters), "base parameter") + ": " +
         std::to_string(count_of(forecast, good)) + " will be known within 30 %, " +
         std::to_string(count_of(forecast, weak)) + " are weak (?), " +
         std::to_string(count_of(forecast, unseen)) + " unseen (x)";
}

bool keeps_limits(const Forecast& forecast) {
  return std::ranges::none_of(forecast.limits, [](const LimitUse& l) { return l.share > 1.0; }) &&
         std::ranges::none_of(forecast.clearances,
                              [](const ClearanceUse& c) { return c.distance < c.wanted; });
}

KeyFigures motion_figures(const ForecastMotion& of) {
  const Forecast& forecast = of.forecast;
  KeyFigures out{
      {{number(of.forecast.duration, 4) + " s", "of motion at " + number(of.forecast.f_m, 6) + " Hz"}}};
  if (std::isfinite(forecast.log_det)) {
    out.figures.emplace_back(fixed(forecast.condition, 0), "condition number");
  }
  const auto used = std::ranges::max_element(forecast.limits, {}, &LimitUse::share);
  if (used != forecast.limits.end()) {
    out.figures.emplace_back(fixed(100.0 * used->share, 1) + " %",
                             "used of the nearest limit: " + used->joint + ", " + used->quantity);
  }
  if (!forecast.clearances.empty() && !std::isnan(forecast.clearances.front().wanted)) {
    const ClearanceUse& nearest = forecast.clearances.front();
    out.figures.emplace_back(number(1000.0 * nearest.distance, 3) + " mm",
                             "smallest distance: " + nearest.first + " from " + nearest.second);
  }
  return out;
}

Section search_section(const Excitation& excitation) {
  using S = StartReport;
  return {
      "search",
      "Search",
      "Search",
      {{Sentence{
           "Objective of each start, smaller is better; the best one was then scaled to the limits on all "
           "samples"}},
       {table_of(excitation.starts, {{{"seed", format::count}, &S::seed},
                                     {{"random motion", format::fixed(2)}, &S::objective_begin},
                                     {{"found", format::fixed(2)}, &S::objective_end},
                                     {{"evaluations", format::count}, &S::evaluations}})}},
      Shown::page};
}

Section origin_section(const ForecastMotion& of, const Provenance& provenance) {
  return {"provenance",
          "Provenance",
          "Provenance",
          {{run_table(provenance, {{"Criterion", std::string(name(of.plan.options.criterion))}})},
           {inputs_table(provenance)}},
          Shown::page};
}

Document motion_document(const Forecast& forecast) {
  Document out;
  out.line = forecast_verdict(forecast);
  out.opening.push_back(
      {Sentence{std::isfinite(forecast.log_det)
                    ? "log det of the information " + number(forecast.log_det, 6) +
                          ", condition of the weighted observation matrix " + number(forecast.condition, 4)
                    : "the motion does not determine all parameters: its information has no log det"},
       Shown::screen});
  out.opening.push_back({FindingList{forecast.findings}});
  out.sections = {{"parameters", "Parameters", "Forecast standard deviations", {{forecast_table(forecast)}}},
                  {"limits", "Limits", "Limits", {{limit_table(forecast)}}}};
  if (!forecast.clearances.empty()) {
    out.sections.push_back({"clearances", "Clearances", "Clearances", {{clearance_table(forecast)}}});
  }
  return out;
}

Document motion_document(const Excitation& excitation) {
  Document out = motion_document(excitation.forecast);
  out.line = "Motion of " + number(excitation.forecast.duration, 4) + " s: " + out.line;
  if (excitation.stopped) {
    out.opening.insert(out.opening.begin(),
                       {Sentence{"the search was ended early: this is the best so far"}});
  }
  return out;
}

// The page of a motion that is designed, or that the user brought.
Document page_of(const ForecastMotion& of, const Excitation* excitation, const Provenance& provenance) {
  using enum ForecastParameter::Prospect;
  const Forecast& forecast = of.forecast;
  Document out = excitation != nullptr ? motion_document(*excitation) : motion_document(forecast);
  out.heading = of.plan.experiment.robot.name;
  out.title = out.heading + (excitation != nullptr ? " · excitation" : " · forecast");
  out.subtitle = (excitation != nullptr ? "Exciting trajectory" : "Forecast for a motion") +
                 (provenance.inputs.empty() ? "" : " · " + provenance.inputs.front().path);
  const std::ptrdiff_t known = count_of(forecast, good);
  const auto all = std::ssize(forecast.parameters);
  out.headline = (known == all ? "All " + counted(all, "base parameter")
                               : std::to_string(known) + " of " + counted(all, "base parameter")) +
                 " will be known within 30 %" + (keeps_limits(forecast) ? "" : ", but limits are exceeded");
  out.verdict = !keeps_limits(forecast) ? Mark::bad : known == all ? Mark::good : Mark::mixed;
  out.opening.insert(out.opening.begin(), {motion_figures(of), Shown::page});
  out.first_look = motion_at_a_glance(of);
  if (!forecast.clearances.empty() && std::isfinite(forecast.clearances.front().wanted)) {
    out.sections.back().blocks.push_back(clearances_over_time(of));
  }
  out.sections.push_back(motion_section(of));
  out.sections.push_back(information_section(of));
  if (excitation != nullptr) {
    out.sections.push_back(search_section(*excitation));
  }
  out.sections.push_back(origin_section(of, provenance));
  for (Section& section : out.sections) {
    section.folded = section.id == "limits" || section.id == "search" || section.id == "provenance";
  }
  return out;
}

}  // namespace

}  // namespace detail

std::string summary(const Forecast& forecast, std::size_t screen) {
  return detail::text_of(detail::motion_document(forecast), screen);
}
std::string summary(const Excitation& excitation, std::size_t screen) {
  return detail::text_of(detail::motion_document(excitation), screen);
}

std::string html_report(const ExcitationPlan& plan, const Excitation& excitation,
                        const Provenance& provenance) {
  return detail::html_of(
      detail::page_of({plan, excitation.motion, excitation.forecast}, &excitation, provenance));
}

std::string html_report(const ExcitationPlan& plan, const Motion& motion, const Forecast& forecast,
                        const Provenance& provenance) {
  return detail::html_of(detail::page_of({plan, motion, forecast}, nullptr, provenance));
}

std::string motion_csv(const Excitation& excitation) {
  detail::CsvColumns out(excitation.t.size());
  out.add("t", excitation.t.data());
  out.add_each("q", excitation.motion.q);
  out.add_each("qd", excitation.motion.qd);
  out.add_each("qdd", excitation.motion.qdd);
  out.add_each("tau", excitation.forecast.tau);
  return out.text();
}

}  // namespace rivid
