#include <algorithm>
#include <array>

#include "report/document.hpp"
#include "rivid/report/excitation.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

Mark forecast_mark(const ForecastParameter& parameter) {
  switch (parameter.prospect) {
    case ForecastParameter::Prospect::weak:
      return Mark::weak;
    case ForecastParameter::Prospect::unseen:
      return Mark::unseen;
    case ForecastParameter::Prospect::good:
      break;
  }
  return Mark::none;
}

Table forecast_table(const Forecast& forecast) {
  return table_of<std::vector<ForecastParameter>>(
      forecast.parameters,
      {{{"parameter", format::name}, [](const ForecastParameter& p) { return p.name; }},
       {{"a priori", format::deviation}, [](const ForecastParameter& p) { return Cell(p.value, p.sigma); }},
       {{"forecast σ", format::significant(2)}, [](const ForecastParameter& p) { return p.sigma; }},
       {{"%σ", format::fixed(1)}, [](const ForecastParameter& p) { return p.relative_sigma_percent; }},
       {{"unit"}, [](const ForecastParameter& p) { return p.unit; }}},
      forecast_mark);
}

Table limit_table(const Forecast& forecast) {
  return table_of<std::vector<LimitUse>>(
      forecast.limits,
      {{{"joint", format::name}, [](const LimitUse& l) { return l.joint; }},
       {{"limit"}, [](const LimitUse& l) { return l.quantity; }},
       {{"used", format::percents(1)}, [](const LimitUse& l) { return l.share; }},
       {{"extreme", format::significant(4)}, [](const LimitUse& l) { return l.value; }},
       {{"allowed", format::significant(4)}, [](const LimitUse& l) { return l.limit; }},
       {{"unit"}, [](const LimitUse& l) { return l.unit; }},
       {{"at s", format::fixed(2)}, [](const LimitUse& l) { return l.time; }}},
      [](const LimitUse& l) { return l.share > 1.0 ? Mark::bad : Mark::none; });
}

Table clearance_table(const Forecast& forecast) {
  return table_of<std::vector<ClearanceUse>>(
      forecast.clearances,
      {{{"link", format::name}, [](const ClearanceUse& c) { return c.first; }},
       {{"from"}, [](const ClearanceUse& c) { return c.second; }},
       {{"smallest distance m", format::fixed(4)}, [](const ClearanceUse& c) { return c.distance; }},
       {{"asked", format::fixed(4)}, [](const ClearanceUse& c) { return c.wanted; }},
       {{"at s", format::fixed(2)}, [](const ClearanceUse& c) { return c.time; }}},
      [](const ClearanceUse& c) { return c.distance < c.wanted ? Mark::bad : Mark::none; });
}

// "52 parameters, of which 49 within 30 %, 3 weak, none unseen".
std::string forecast_verdict(const Forecast& forecast) {
  const auto of = [&](ForecastParameter::Prospect prospect) {
    return std::ranges::count(forecast.parameters, prospect, &ForecastParameter::prospect);
  };
  return counted(std::ssize(forecast.parameters), "base parameter") + ": " +
         std::to_string(of(ForecastParameter::Prospect::good)) + " will be known within 30 %, " +
         std::to_string(of(ForecastParameter::Prospect::weak)) + " are weak (?), " +
         std::to_string(of(ForecastParameter::Prospect::unseen)) + " unseen (x)";
}

Document motion_document(const Forecast& forecast) {
  Document out;
  out.line = forecast_verdict(forecast);
  out.opening.push_back(
      {Sentence{"log det of the information " + number(forecast.log_det, 6) +
                ", condition of the weighted observation matrix " + number(forecast.condition, 4)}});
  out.opening.push_back({FindingList{forecast.findings}});
  Section parameters{.id = "parameters", .title = "Parameters", .heading = "Forecast standard deviations"};
  parameters.blocks.push_back({forecast_table(forecast)});
  Section limits{.id = "limits", .title = "Limits", .heading = "Limits"};
  limits.blocks.push_back({limit_table(forecast)});
  out.sections = {std::move(parameters), std::move(limits)};
  if (!forecast.clearances.empty()) {
    Section space{.id = "clearances", .title = "Clearances", .heading = "Clearances"};
    space.blocks.push_back({clearance_table(forecast)});
    out.sections.push_back(std::move(space));
  }
  return out;
}

Document motion_document(const Excitation& excitation) {
  Document out = motion_document(excitation.forecast);
  const double duration = excitation.series.duration;
  out.line = "Motion of " + number(duration, 4) + " s: " + out.line;
  if (excitation.stopped) {
    out.opening.insert(out.opening.begin(),
                       {Sentence{"the search was ended early: this is the best so far"}});
  }
  return out;
}

}  // namespace

}  // namespace detail

std::string summary(const Forecast& forecast) { return detail::text_of(detail::motion_document(forecast)); }
std::string summary(const Excitation& excitation) {
  return detail::text_of(detail::motion_document(excitation));
}

std::string motion_csv(const Excitation& excitation) {
  const Motion& motion = excitation.motion;
  const std::array<std::pair<const char*, const Matrix*>, 4> columns = {
      {{"q", &motion.q}, {"qd", &motion.qd}, {"qdd", &motion.qdd}, {"tau", &excitation.forecast.tau}}};
  std::string out = "t";
  for (const auto& [name, values] : columns) {
    for (Index j = 0; j < values->cols(); ++j) {
      out += "," + std::string(name) + std::to_string(j + 1);
    }
  }
  out += '\n';
  for (Index k = 0; k < excitation.t.size(); ++k) {
    out += exact(excitation.t[k]);
    for (const auto& [name, values] : columns) {
      for (Index j = 0; j < values->cols(); ++j) {
        out += "," + exact((*values)(k, j));
      }
    }
    out += '\n';
  }
  return out;
}

}  // namespace rivid
