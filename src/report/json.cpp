#include "rivid/report/json.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <sstream>

#include "experiment/json_fields.hpp"
#include "report/documents.hpp"
#include "rivid/input.hpp"
#include "rivid/model/dependent.hpp"
#include "rivid/report/comparison.hpp"
#include "rivid/report/excitation.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/report/rehearsal.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

using detail::at;
using detail::Json;
using detail::json_list;
using detail::json_of;
using detail::json_text;
using detail::places;
using detail::position_unit;
using detail::warnings_of;

// A member that is there only where it has a value.
template <typename Value>
void add(Json& to, const char* name, const std::optional<Value>& value) {
  if (value) {
    to[name] = json_of(*value);
  }
}

Json parameters(const Identification& result) {
  Json out = json_of(result.parameters);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i]["regrouping"] = Json::object();
    for (const auto& [name, coefficient] : result.base.regrouping(static_cast<Index>(i))) {
      out[i]["regrouping"][name] = coefficient;
    }
  }
  return out;
}

// The standard parameters, link by link.
Json links(const Robot& robot, const BaseParameters& base, const Vector& chi_st) {
  const Vector a_priori = robot.chi_st();
  const auto of_link = [](const std::string& link, const std::string& joint) {
    return Json{{"link", link}, {"joint", joint}, {"parameters", Json::array()}};
  };
  Json out = json_list(robot.joints, [&](const Joint& joint) { return of_link(joint.link, joint.name); });
  for (const Chain::Dependent& dependent : robot.chain.dependents) {
    out.push_back(of_link(dependent.link, dependent.joint));
  }
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const StandardParameter& p = base.standard[i];
    const auto j = static_cast<std::size_t>(p.joint);
    out[j]["parameters"].push_back({{"name", p.name()},
                                    {"value", at(chi_st, i)},
                                    {"unit", unit(p.kind, robot.chain.links[j].type)},
                                    {"a_priori", at(a_priori, i)}});
  }
  return out;
}

Json physical(const Robot& robot, const BaseParameters& base, const PhysicalModel& model) {
  Json out = json_of(model.parameters);
  out["links"] = links(robot, base, model.parameters.chi_st);
  out["fit"] = json_of(model.fit);
  out["options"] = json_of(model.options);
  out["better"] = model.better;
  out["sigma"] = json_of(Vector(model.C_chi.diagonal().cwiseSqrt()));
  out["C_chi"] = json_of(model.C_chi);
  return out;
}

Json paired_tests(std::span<const PairedTest> tests, std::span<const std::string> names) {
  const auto model = [&](std::size_t i) { return Json(names[i]); };
  return json_list(tests, [&](const PairedTest& test) {
    return Json{{"a", model(test.a)},
                {"b", model(test.b)},
                {"ratio", test.ratio},
                {"t", test.t},
                {"p", test.p},
                {"blocks", test.blocks},
                {"better", test.better ? model(*test.better) : Json()}};
  });
}

Json rollout_members(const Rollouts& all) {
  Json found = json_list(all.found, [&](const Rollout& one) {
    Json models = json_list(places(one.models.size()), [&](std::size_t m) {
      return Json{{"name", all.models[m]},
                  {"position", json_of(one.models[m].q)},
                  {"velocity", json_of(one.models[m].qd)},
                  {"lost", one.models[m].lost}};
    });
    return Json{{"drive", name(one.drive)},
                {"horizon", one.horizon},
                {"windows", one.windows},
                {"models", std::move(models)},
                {"tests", paired_tests(one.tests, all.models)}};
  });
  return {{"found", std::move(found)}, {"notes", all.notes}};
}

Json essential(const Identification& result, const EssentialModel& model) {
  const EssentialParameters& found = model.parameters;
  Json out = json_of(found);
  out["parameters"] = json_list(found.kept, [&](Index i) {
    const double sigma = std::sqrt(found.C_chi(i, i));
    return Json{{"name", result.base.parameters[static_cast<std::size_t>(i)].name},
                {"value", found.chi[i]},
                {"sigma", sigma},
                {"relative_sigma_percent", 100.0 * sigma / std::abs(found.chi[i])}};
  });
  out["significance"] = model.options.significance;
  out["fit"] = json_of(model.fit);
  return out;
}

Json prefilter(const PrefilterReport& report) {
  Json out = json_of(report);
  out["without"] = {{"chi", json_of(report.chi)}, {"sigma", json_of(report.sigma)}};
  return out;
}

Json robust(const RobustReport& report) {
  Json out = json_of(report);
  out["without"] = {{"chi", json_of(report.chi)}};
  return out;
}

// Of frame j in frame j − 1 at q_j = 0; the axes of the link frame as those of frame j, counted from 1, with
// their signs.
Json frame(const Chain::Link& link) {
  Json axes = Json::array();
  for (std::size_t k = 0; k < 3; ++k) {
    axes.push_back(link.signs[k] * (link.axes[k] + 1));
  }
  return {{"rotation", json_of(link.R)}, {"origin", json_of(link.p)}, {"axes", std::move(axes)}};
}

// Of a link and its joint, with what else belongs to that.
Json joint_members(const Robot& robot, std::size_t k, const std::string& name, const Json& more) {
  const Chain& chain = robot.chain;
  Json members = {{"name", name},
                  {"link", robot.link_name(k)},
                  {"type", chain.links[k].type == JointType::revolute ? "revolute" : "prismatic"}};
  members.update(more);
  members["frame"] = frame(chain.links[k]);
  if (chain.branches() || !chain.dependents.empty()) {
    const int parent = chain.parent(k);
    members["carried_by"] = parent < 0 ? robot.base : robot.link_name(static_cast<std::size_t>(parent));
  }
  return members;
}

Json joints(const Robot& robot) {
  return json_list(places(robot.joints.size()), [&](std::size_t k) {
    return joint_members(robot, k, robot.joints[k].name, json_of(robot.joints[k]));
  });
}

Json dependents(const Robot& robot) {
  const std::vector<DependentJoint> all = dependent_joints(robot);
  return json_list(places(all.size()), [&](std::size_t k) {
    Json follows = {{"of", all[k].of}, {"offset", all[k].offset}};
    if (all[k].curve) {
      follows["curve"] = json_of(*all[k].curve);
    }
    return joint_members(robot, robot.joints.size() + k, all[k].joint, follows);
  });
}

Json couplings(const Robot& robot) {
  const auto joint_name = [&](int j) { return robot.joints[static_cast<std::size_t>(j)].name; };
  return json_list(robot.couplings, [&](const Coupling& c) {
    Json members = {{"motor", joint_name(c.motor)}, {"joints", json_list(c.joints, joint_name)}};
    members.update(json_of(c));
    return members;
  });
}

Json robot_members(const Robot& robot) {
  Json out = {{"name", robot.name},
              {"base", robot.base},
              {"gravity", json_of(robot.chain.gravity)},
              {"joints", joints(robot)},
              {"coupling", couplings(robot)},
              {"gear_matrix", robot.gear_matrix.size() > 0 ? json_of(robot.gear_matrix) : Json()}};
  if (robot.base_joints > 0) {
    out["base_joints"] = robot.base_joints;
  }
  if (!robot.chain.dependents.empty()) {
    out["dependent"] = dependents(robot);
  }
  return out;
}

Json fit_members(const Identification& result) {
  Json out = json_of(result.fit);
  out["columns"] = result.columns;
  out["condition"] = result.condition;
  out["R_diagonal"] = json_of(result.R_diagonal);
  out["weights"] = result.weights;
  return out;
}

Json validation(const Validation& v) {
  Json out = {{"file", v.file}};
  out.update(json_of(v.fit));
  out["forecast"] = json_of(v.forecast);
  add(out, "physical", v.physical);
  add(out, "essential", v.essential);
  return out;
}

Json covariance(const Identification& result) {
  Json out = json_of(result.covariance);
  out["C_chi"] = json_of(result.C_chi);
  out["gain_slopes"] = json_of(result.gain_slopes);
  return out;
}

// Settings section by section: "method.physical.weight" is the member of an object in an object. What is
// there stays.
void add(Json& options, const std::vector<Setting>& settings) {
  for (const Setting& setting : settings) {
    Json* at = &options;
    std::istringstream names(setting.key);
    for (std::string name; std::getline(names, name, '.');) {
      at = at->is_object() || at->is_null() ? &(*at)[name] : at;
    }
    if (at->is_null()) {
      *at = Json::parse(setting.value);
    }
  }
}

// Program, versions and inputs, then all options.
Json members(const Provenance& provenance, Json options) {
  const auto files = [](const std::vector<InputFile>& of) {
    return json_list(
        of, [](const InputFile& file) { return Json{{"path", file.path}, {"sha256", file.sha256}}; });
  };
  Json overrides = Json::object();
  for (const auto& [flag, value] : provenance.overrides) {
    overrides[flag] = value;
  }
  add(options, provenance.settings);
  options["overrides"] = std::move(overrides);
  return {{"run", run_id(provenance)},
          {"program", provenance.program},
          {"rivid", version},
          {"eigen", std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                        std::to_string(EIGEN_MINOR_VERSION)},
          {"compiler", __VERSION__},
          {"inputs", files(provenance.inputs)},
          {"outputs", files(provenance.outputs)},
          {"options", std::move(options)}};
}

Json simulated_parameters(const SimulationRecord& record) {
  return json_list(places(record.base.parameters.size()), [&](std::size_t i) {
    const BaseParameter& p = record.base.parameters[i];
    return Json{{"name", p.name}, {"value", at(record.chi, i)}, {"unit", p.unit}, {"regrouped", p.regrouped}};
  });
}

Json tracking(const Robot& robot, const SimulationRecord& record) {
  return json_list(places(robot.joints.size()), [&](std::size_t j) {
    return Json{{"name", robot.joints[j].name},
                {"largest_tracking_error", at(record.simulation.max_tracking_error, j)},
                {"unit", position_unit(robot.joints[j])}};
  });
}

Json friction(const Simulation& simulation) {
  return json_list(places(simulation.element_names.size()), [&](std::size_t e) {
    return Json{{"name", simulation.element_names[e]}, {"mode_changes", simulation.element_changes[e]}};
  });
}

Json control(const SimulationRecord& record) {
  return {{"law", record.control.law},
          {"assumed", record.control_assumed},
          {"rate_hz", record.control_hz > 0.0 ? Json(record.control_hz) : Json()},
          {"J", json_of(record.J)},
          {"gains", json_of(by_name(record.control.gains))}};
}

Json forecast_members(const ExcitationPlan& plan, const Forecast& forecast) {
  return {{"format", 1},
          {"robot", robot_members(plan.experiment.robot)},
          {"duration", forecast.duration},
          {"rate_hz", forecast.f_m},
          {"log_det", forecast.log_det},
          {"condition", forecast.condition},
          {"parameters", json_of(forecast.parameters)},
          {"limits", json_of(forecast.limits)},
          {"clearances", json_of(forecast.clearances)},
          {"joints", json_of(forecast.joints)},
          {"information", json_of(forecast.information)},
          {"warnings", warnings_of(forecast.findings)}};
}

}  // namespace

InputFile input_file(const std::filesystem::path& path) { return {path.string(), input_sha256(path)}; }

std::filesystem::path recorded_experiment(const std::filesystem::path& document) {
  const auto content = nlohmann::json::parse(read_input(document).bytes(), nullptr, false);
  const nlohmann::json::json_pointer experiment("/provenance/inputs/0/path");
  const bool says = content.is_structured() && content.contains(experiment);
  return says && content.at(experiment).is_string() ? content.at(experiment).get<std::string>()
                                                    : std::string();
}

std::string run_id(const Provenance& provenance) {
  std::string text = provenance.program + '\n' + version + '\n';
  for (const InputFile& input : provenance.inputs) {
    text += input.sha256 + '\n';
  }
  for (const auto& [flag, value] : provenance.overrides) {
    text += flag + '=' + value + '\n';
  }
  for (const Setting& setting : provenance.settings) {
    text += setting.key + '=' + setting.value + '\n';
  }
  constexpr std::size_t digits = 16;  // hexadecimal, 64 bits: enough to tell settings from each other
  return sha256(text).substr(0, digits);
}

std::string to_json(const Robot& robot, const Identification& result, const Provenance& provenance) {
  detail::require_fitting("to_json", robot, result, {});
  Json options = Json::object();
  add(options, settings(result.estimation));
  Json out = {{"format", 1},
              {"method", result.method},
              {"status", name(result.status)},
              {"reasons", result.reasons},
              {"warnings", warnings_of(result.warnings)},
              {"notes", result.notes},
              {"robot", robot_members(robot)},
              {"parameters", parameters(result)},
              {"covariance", covariance(result)},
              {"fit", fit_members(result)},
              {"validation", json_list(result.validation, validation)},
              {"provenance", members(provenance, std::move(options))}};
  add(out, "forecast", result.forecast);
  add(out, "tests", result.diagnostics);
  if (!result.alternatives.empty()) {
    out["alternatives"] = json_of(result.alternatives);
  }
  add(out, "row_choice", result.row_choice);
  add(out, "method_choice", result.method_choice);
  add(out, "gains", result.gains);
  if (result.iv) {
    out["iterations"] = json_of(result.iv->iterations);
    out["loop"] = json_of(result.iv->loop);
    out["first_stage_F"] = json_of(result.iv->first_stage_F);
  }
  if (result.prefilter) {
    out["prefilter"] = prefilter(*result.prefilter);
  }
  add(out, "output_error", result.output_error);
  if (result.robust) {
    out["robust"] = robust(*result.robust);
  }
  if (result.essential) {
    out["essential"] = essential(result, *result.essential);
  }
  if (result.physical) {
    out["physical"] = physical(robot, result.base, *result.physical);
  }
  return json_text(out);
}

std::string to_json(const ExcitationPlan& plan, const Forecast& forecast, const Provenance& provenance) {
  Json out = forecast_members(plan, forecast);
  out["provenance"] = members(provenance, Json::object());
  return json_text(out);
}

std::string to_json(const ExcitationPlan& plan, const Excitation& excitation, const Provenance& provenance) {
  Json out = forecast_members(plan, excitation.forecast);
  if (excitation.series) {
    out["motion"] = json_of(*excitation.series);
  }
  if (excitation.lead_in) {
    out["lead_in"] = excitation.lead_in->durations.sum();
    out["lead_out"] = excitation.lead_out->durations.sum();
  }
  out["stopped"] = excitation.stopped;
  out["starts"] = json_of(excitation.starts);
  out["best_start"] = excitation.best_start;
  out["provenance"] = members(provenance, Json::object());
  return json_text(out);
}

std::string to_json(const ExcitationPlan& plan, const Rehearsal& rehearsal, const Provenance& provenance) {
  const auto of_run = [](const RehearsedRun& run) {
    return Json{{"trouble", run.trouble ? Json(name(*run.trouble)) : Json()},
                {"status", run.status},
                {"warnings", warnings_of(run.findings)},
                {"torque_error", run.torque_error},
                {"sigma_ratio", run.sigma_ratio},
                {"parameters", json_of(run.parameters)}};
  };
  return json_text({{"format", 1},
                    {"robot", plan.experiment.robot.name},
                    {"passes", rehearsal.passes()},
                    {"as_planned", of_run(rehearsal.as_planned)},
                    {"troubles", json_list(rehearsal.troubles, of_run)},
                    {"provenance", members(provenance, Json::object())}});
}

std::string to_json(const Robot& robot, const SimulationRecord& record, const Provenance& provenance) {
  const Simulation& simulation = record.simulation;
  return json_text({{"format", 1},
                    {"outcome", name(simulation.outcome)},
                    {"reason", simulation.reason},
                    {"warnings", warnings_of(record.warnings)},
                    {"robot", robot.name},
                    {"samples", record.log.samples()},
                    {"rate_hz", record.log.f_m},
                    {"seed", record.seed},
                    {"parameters", simulated_parameters(record)},
                    {"control", control(record)},
                    {"joints", tracking(robot, record)},
                    {"friction", friction(simulation)},
                    {"effort", json_of(simulation.effort)},
                    {"provenance", members(provenance, Json::object())}});
}

std::string to_json(const Comparison& comparison, std::span<const ResultChanges> changes,
                    std::span<const Finding> warnings, const Provenance& provenance) {
  Json models = json_list(comparison.models, [](const Comparison::Error& error) {
    return Json{
        {"name", error.name}, {"relative_error", error.relative_error}, {"joints", json_of(error.joints)}};
  });
  std::vector<std::string> names;
  std::ranges::transform(comparison.models, std::back_inserter(names), &Comparison::Error::name);
  const auto change = [](const ParameterChange& of) {
    return Json{{"name", of.name},   {"unit", of.unit}, {"a", of.a}, {"b", of.b},
                {"sigma", of.sigma}, {"z", of.z},       {"p", of.p}};
  };
  Json all_changes = json_list(changes, [&](const ResultChanges& pair) {
    return Json{{"a", pair.a}, {"b", pair.b}, {"parameters", json_list(pair.parameters, change)}};
  });
  Json out = {{"format", 1},
              {"logs", comparison.logs},
              {"joints", comparison.joints},
              {"rows", comparison.rows},
              {"models", std::move(models)},
              {"tests", paired_tests(comparison.tests, names)},
              {"warnings", warnings_of(warnings)},
              {"changes", std::move(all_changes)},
              {"provenance", members(provenance, Json::object())}};
  if (comparison.rollouts) {
    out["rollouts"] = rollout_members(*comparison.rollouts);
  }
  return json_text(out);
}

std::string to_json(std::span<const MonteCarloSummary> summaries, const std::string& run) {
  Json out = {{"format", 1},
              {"program", "rivid_montecarlo"},
              {"trials", json_of(std::vector(summaries.begin(), summaries.end()))}};
  if (!run.empty()) {
    out["run"] = run;
  }
  return json_text(out);
}

std::string to_json(const HintTrial& trial) {
  return json_text({{"format", 1},
                    {"helps", trial.helps()},
                    {"finding", warnings_of(std::span(&trial.finding, 1)).front()},
                    {"before", json_of(trial.before)},
                    {"after", json_of(trial.after)},
                    {"lines", trial.lines}});
}

std::string to_json(std::span<const Finding> findings) {
  const auto count = [&](Severity wanted) { return std::ranges::count(findings, wanted, severity); };
  Json list = json_list(findings, [](const Finding& f) {
    return Json{{"severity", name(severity(f))},
                {"code", f.code},
                {"subject", f.subject},
                {"text", f.text},
                {"advice", cure(f)}};
  });
  return json_text({{"format", 1},
                    {"usable", count(Severity::error) == 0},
                    {"errors", count(Severity::error)},
                    {"warnings", count(Severity::warning)},
                    {"findings", std::move(list)}});
}

}  // namespace rivid
