#include <algorithm>
#include <cmath>

#include "experiment/json_fields.hpp"
#include "report/document.hpp"
#include "rivid/report/plan.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

std::string seconds(double time) {
  return std::isfinite(time) ? number(time, 3) + " s" : std::string("no time");
}

std::string worth_of(const PlanFile& a, const PlanFile& b, const PlanComparison& comparison) {
  const std::string b_in_words = b.path.string() + " (" + number(b.duration, 4) + " s)";
  const std::string a_in_words = a.path.string() + " (" + number(a.duration, 4) + " s)";
  const std::string sigmas = ": its standard deviations are " + number(comparison.sigma_ratio, 3) +
                             " times as large (geometric mean)";
  if (std::isnan(comparison.time)) {
    return b_in_words + " beside " + a_in_words + sigmas;
  }
  if (std::isinf(comparison.time)) {
    return b_in_words + " determines parameters that " + a_in_words +
           " does not, however often it is repeated";
  }
  return b_in_words + " is worth " + seconds(comparison.time) + " of " + a_in_words + sigmas;
}

Document plans_document(const PlanFile& a, const PlanFile& b, const PlanComparison& comparison) {
  using P = PlanComparison::Parameter;
  Document out;
  out.line = worth_of(a, b, comparison);
  if (!comparison.same_noise) {
    out.opening.push_back({Sentence{"The plans assume different noise, which is part of the difference"}});
  }
  if (std::isnan(comparison.time)) {
    out.opening.push_back({Sentence{
        "Earlier logs count in the forecasts, which repeated motions do not add to in proportion"}});
  }
  out.sections.push_back(
      {.heading = "Forecast standard deviations",
       .blocks = {{table_of(comparison.parameters,
                            {{{"parameter", format::name}, &P::name},
                             {{"σ of A", format::significant(3)}, &P::sigma_a},
                             {{"σ of B", format::significant(3)}, &P::sigma_b},
                             {{"unit"}, &P::unit},
                             {{"B / A", format::fixed(3)}, &P::ratio},
                             {{"time of A for σ of B, s", format::significant(3)}, &P::time}})}}});
  return out;
}

Document check_document(const PlanFile& plan, const PlanCheck& check) {
  using J = PlanCheck::JointRatio;
  using P = PlanCheck::ParameterRatio;
  Document out;
  out.line = "Forecast of " + plan.path.string() + ": reported standard deviations are " +
             number(check.ratio, 3) + " times the forecast ones (geometric mean of " +
             counted(std::ssize(check.parameters), "parameter") + ")";
  out.sections.push_back(
      {.heading = "Reported over forecast standard deviations",
       .blocks = {{table_of(check.joints,
                            {{{"joint", format::name}, &J::name},
                             {{"reported / forecast", format::fixed(2)}, &J::ratio},
                             {{"parameters", format::count}, &J::parameters}},
                            [](const J& j) { return j.apart ? Mark::apart : Mark::none; })}}});
  std::vector<P> apart;
  std::ranges::copy_if(check.parameters, std::back_inserter(apart), &P::apart);
  Section parameters{.heading = "Parameters where plan and robot disagree"};
  if (apart.empty()) {
    parameters.blocks.push_back(
        {Sentence{"none: all reported deviations are between 2/3 and 3/2 of the forecast ones"}});
  } else {
    parameters.blocks.push_back({table_of(apart, {{{"parameter", format::name}, &P::name},
                                                  {{"forecast σ", format::significant(3)}, &P::forecast},
                                                  {{"reported σ", format::significant(3)}, &P::reported},
                                                  {{"unit"}, &P::unit},
                                                  {{"reported / forecast", format::fixed(2)}, &P::ratio}})});
    parameters.blocks.push_back(
        {Sentence{"Larger: torque errors are larger or slower than planned, or the robot did not follow the "
                  "motion. Smaller: they are smaller"}});
  }
  out.sections.push_back(std::move(parameters));
  return out;
}

}  // namespace

}  // namespace detail

std::string in_words(const PlanFile& a, const PlanFile& b, const PlanComparison& comparison) {
  return detail::text_of(detail::plans_document(a, b, comparison));
}

std::string to_json(const PlanFile& a, const PlanFile& b, const PlanComparison& comparison) {
  return detail::json_text({{"format", 1},
                            {"a", a.path.string()},
                            {"b", b.path.string()},
                            {"duration_a", a.duration},
                            {"duration_b", b.duration},
                            {"sigma_ratio", comparison.sigma_ratio},
                            {"time", comparison.time},
                            {"same_noise", comparison.same_noise},
                            {"parameters", detail::json_of(comparison.parameters)}});
}

std::string in_words(const PlanFile& plan, const PlanCheck& check) {
  return detail::text_of(detail::check_document(plan, check));
}

std::string to_json(const PlanFile& plan, const PlanCheck& check) {
  return detail::json_text({{"format", 1},
                            {"plan", plan.path.string()},
                            {"ratio", check.ratio},
                            {"joints", detail::json_of(check.joints)},
                            {"parameters", detail::json_of(check.parameters)}});
}

}  // namespace rivid
