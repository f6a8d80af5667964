#include <algorithm>
#include <cmath>

#include "report/document.hpp"
#include "rivid/report/rehearsal.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

using P = RehearsedParameter;

// The codes of the gravest findings, those of an identification first: the robot's own log will have them
// too.
std::string found_by(const RehearsedRun& run, double usual_error) {
  constexpr std::size_t most = 2;  // codes in a cell; a choice
  std::vector<std::string> codes;
  for (const bool own : {false, true}) {
    for (const Finding& finding : run.findings) {
      if (finding.code.starts_with("rehearsal_") == own && codes.size() < most &&
          std::ranges::find(codes, finding.code) == codes.end()) {
        codes.push_back(finding.code);
      }
    }
  }
  if (!codes.empty()) {
    return listed(codes);
  }
  const auto off = [](const P& p) { return std::isfinite(p.sigmas_off()) ? p.sigmas_off() : 0.0; };
  const auto worst = std::ranges::max_element(run.parameters, {}, off);
  if (worst != run.parameters.end() && off(*worst) > 0.0) {
    return "not seen: " + worst->name + " is " + fixed(off(*worst), 1) + " σ off";
  }
  constexpr double as_well = 1.1;  // times the usual error; a choice
  return run.torque_error <= as_well * usual_error ? "not seen: the torques do not show it" : "not seen";
}

Table trouble_table(const Rehearsal& rehearsal) {
  using R = RehearsedRun;
  return table_of(
      rehearsal.troubles,
      {{{"what if", format::name}, [](const R& r) { return Cell(std::string(about(*r.trouble))); }},
       {{"error", format::percents(1)}, &R::torque_error},
       {{"found by"}, [&](const R& r) { return Cell(found_by(r, rehearsal.as_planned.torque_error)); }}},
      [](const R& r) { return r.findings.empty() ? Mark::bad : Mark::good; });
}

// What will not be known, or is not where its interval says.
Table odd_parameters(std::vector<P> odd) {
  constexpr std::size_t most = 8;  // parameters in a table; a choice
  std::ranges::stable_sort(odd, std::ranges::greater(), &P::sigmas_off);
  odd.resize(std::min(most, odd.size()));
  return table_of(odd,
                  {{{"parameter", format::name}, &P::name},
                   {{"truth", format::deviation}, [](const P& p) { return Cell(p.truth, p.sigma); }},
                   {{"estimate", format::deviation}, [](const P& p) { return Cell(p.estimate, p.sigma); }},
                   {{"σ", format::significant(2)}, &P::sigma},
                   {{"forecast σ", format::significant(2)}, &P::forecast},
                   {{"unit"}, &P::unit}},
                  [](const P& p) { return p.covered ? Mark::weak : Mark::apart; });
}

Document rehearsal_document(const Rehearsal& rehearsal) {
  const RehearsedRun& run = rehearsal.as_planned;
  const auto is_known = [](const P& p) { return p.verdict == Verdict::identified; };
  std::vector<P> odd;
  std::ranges::copy_if(run.parameters, std::back_inserter(odd),
                       [&](const P& p) { return !is_known(p) || !p.covered; });
  const auto count = [&](const auto& what) {
    return std::to_string(std::ranges::count_if(run.parameters, what));
  };
  Document out;
  out.line = std::string(rehearsal.passes() ? "Go: " : "No go: ") + run.status;
  if (!run.parameters.empty()) {
    out.line += ", " + count(is_known) + " of " + counted(std::ssize(run.parameters), "parameter") +
                " known, " + count(&P::covered) + " in their intervals, σ " + number(run.sigma_ratio, 2) +
                " times the forecast";
  }
  out.opening.push_back({FindingList{run.findings}});
  if (!odd.empty()) {
    out.sections.push_back({.heading = "Hardly known (?), or outside of the interval (!)",
                            .blocks = {{odd_parameters(std::move(odd))}}});
  }
  if (!rehearsal.troubles.empty()) {
    // A heading is not shown where it comes first.
    out.sections.push_back(
        {.heading = {},
         .blocks = {{Sentence{"Troubles, one at a time: error of the torques (" +
                              fixed(100.0 * run.torque_error, 1) + " % as planned), and what finds them"}},
                    {trouble_table(rehearsal)}}});
  }
  return out;
}

}  // namespace

}  // namespace detail

std::string summary(const Rehearsal& rehearsal, std::size_t screen) {
  return detail::text_of(detail::rehearsal_document(rehearsal), screen);
}

}  // namespace rivid
