#include <filesystem>

#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::string in_words(const RobustReport& robust) {
  std::string out = robust.options.kind == RobustKind::huber ? "Huber's loss" : "Bisquare loss";
  out += ", tuning " + number(robust.options.loss().tuning, 4) + ", in " + counted(robust.rounds, "round") +
         "; against the estimate without it ";
  return robust.parameter.empty() ? out + "nothing moves"
                                  : out + robust.parameter + " moves the most, by " +
                                        number_that_says(robust.largest_shift, 2) + " sigma";
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

}  // namespace

Table fit_table(const Fit& fit) {
  using J = JointFit;
  Table out = table_of(fit.joints, {{{"joint"}, &J::name},
                                    {{"rows", format::count}, &J::rows},
                                    {{"left out", format::count}, &J::left_out},
                                    {{"rel. error", format::percent}, &J::relative_error},
                                    {{"centred", format::percent}, &J::centred_relative_error},
                                    {{"sigma_rho", format::significant(4)}, &J::sigma_rho},
                                    {{"unit"}, &J::unit}});
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
                {{{"joint"}, &R::name},
                 {{"scale", format::significant(4)}, &R::scale},
                 {{rejects ? "no weight" : "weight below 1", format::percent},
                  [=](const R& j) { return share(rejects ? j.rejected : j.below_one, j); }},
                 {{"below 1/2", format::percent}, [=](const R& j) { return share(j.below_half, j); }}})},
      {Sentence{in_words(report)}}};
  return out;
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
  out.blocks = {{Sentence{"Relative torque errors of the robot description, with its friction and rotor "
                          "inertia where given, and of the identified model. To plot both, choose \"robot "
                          "description\" in the legends of the torques"}},
                {table_of(rows, {{{"log"}, &Compared::log},
                                 {{"joint", format::name}, &Compared::joint},
                                 {{"robot description", format::percents(2)}, &Compared::description},
                                 {{"identified", format::percents(2)}, &Compared::identified},
                                 {{"better by", format::significant(3), "×"},
                                  [](const Compared& r) { return r.description / r.identified; }}})}};
  return out;
}

}  // namespace rivid::detail
