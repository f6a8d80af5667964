#include "rivid/experiment/plan_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "experiment/json_node.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::JsonNode;

constexpr double infinite = std::numeric_limits<double>::infinity();

// Infinite numbers are null in JSON.
double number_or(const JsonNode& node, double otherwise) {
  return node.json().is_null() ? otherwise : node.number();
}

ForecastParameter planned_parameter(const JsonNode& node) {
  ForecastParameter out;
  out.name = node.at("name").text();
  out.unit = node.at("unit").text();
  out.value = node.at("value").number();
  out.sigma = number_or(node.at("sigma"), infinite);
  out.relative_sigma_percent = number_or(node.at("relative_sigma_percent"), infinite);
  return out;
}

double geometric_mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += std::log(value);
  }
  return std::exp(sum / static_cast<double>(values.size()));
}

bool ratio_is_apart(double ratio) {
  return !(ratio <= PlanCheck::disagreement && ratio >= 1.0 / PlanCheck::disagreement);
}

template <typename A, typename B>
void expect_same_parameters(const std::string& who, const std::vector<A>& a, const std::string& other,
                            const std::vector<B>& b) {
  if (!std::ranges::equal(a, b, {}, [](const A& p) { return p.name; }, [](const B& p) { return p.name; })) {
    throw InputError(who + ": its " + counted(std::ssize(a), "base parameter") + " are not the " +
                     std::to_string(b.size()) + " of " + other +
                     "; robot, friction and gravity must be the same");
  }
}

}  // namespace

PlanFile read_plan(const std::filesystem::path& path) {
  PlanFile out;
  std::error_code error;
  out.path = std::filesystem::is_directory(path, error) ? path / "plan.json" : path;
  const nlohmann::json content =
      detail::parsed_json(out.path, "the plan", "is no plan.json of rivid excite: ");
  const JsonNode file(content, out.path.string());
  if (!file.has("log_det") || !file.has("parameters") || !file.has("duration")) {
    file.fail("is no plan.json of rivid excite: it has no log_det, parameters and duration");
  }
  out.duration = file.at("duration").number();
  out.log_det = number_or(file.at("log_det"), -infinite);
  const double rate = file.at("rate_hz").number();
  std::vector<double> noise;
  for (const JsonNode& joint : file.at("joints").list()) {
    noise.push_back(joint.at("sigma").number() / std::sqrt(rate));
  }
  out.noise = Eigen::Map<const Vector>(noise.data(), std::ssize(noise));
  for (const JsonNode& parameter : file.at("parameters").list()) {
    out.parameters.push_back(planned_parameter(parameter));
  }
  const JsonNode options = file.at("provenance").at("options").at("excitation");
  out.known = options.has("known") && !options.at("known").list().empty();
  return out;
}

PlanComparison compare(const PlanFile& a, const PlanFile& b) {
  expect_same_parameters(b.path.string(), b.parameters, a.path.string(), a.parameters);
  constexpr double same = 1e-6;  // relative: noise that was printed and read is the same
  PlanComparison out;
  out.same_noise = a.noise.size() == b.noise.size() && a.noise.isApprox(b.noise, same);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    const ForecastParameter& p = a.parameters[i];
    const double sigma_b = b.parameters[i].sigma;
    const double ratio = sigma_b / p.sigma;
    out.parameters.push_back({.name = p.name,
                              .unit = p.unit,
                              .sigma_a = p.sigma,
                              .sigma_b = sigma_b,
                              .ratio = ratio,
                              .time = a.duration / (ratio * ratio)});
    if (std::isfinite(ratio) && ratio > 0.0) {
      ratios.push_back(ratio);
    }
  }
  out.sigma_ratio = geometric_mean(ratios);
  const auto count = static_cast<double>(a.parameters.size());
  out.time = a.known || b.known ? std::numeric_limits<double>::quiet_NaN()
                                : a.duration * std::exp((b.log_det - a.log_det) / count);
  return out;
}

void require_parameters(const PlanFile& plan, const BaseParameters& base) {
  expect_same_parameters(plan.path.string(), plan.parameters, "the experiment", base.parameters);
}

PlanCheck check_against(const PlanFile& plan, const Robot& robot, const Identification& result) {
  expect_same_parameters(plan.path.string(), plan.parameters, "the result", result.parameters);
  PlanCheck out;
  std::vector<double> all;
  std::vector<std::vector<double>> of_joints(robot.joints.size());
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    const ParameterEstimate& reported = result.parameters[i];
    const double ratio = reported.sigma / plan.parameters[i].sigma;
    if (!std::isfinite(ratio) || !(ratio > 0.0)) {
      continue;
    }
    out.parameters.push_back({.name = reported.name,
                              .unit = reported.unit,
                              .forecast = plan.parameters[i].sigma,
                              .reported = reported.sigma,
                              .ratio = ratio,
                              .apart = ratio_is_apart(ratio)});
    all.push_back(ratio);
    const auto joint = static_cast<std::size_t>(result.base.parameters[i].leading.joint);
    if (joint < of_joints.size()) {  // no link of a dependent one
      of_joints[joint].push_back(ratio);
    }
  }
  out.ratio = geometric_mean(all);
  for (std::size_t j = 0; j < of_joints.size(); ++j) {
    if (!of_joints[j].empty()) {
      const double ratio = geometric_mean(of_joints[j]);
      out.joints.push_back({.name = robot.joints[j].name,
                            .parameters = std::ssize(of_joints[j]),
                            .ratio = ratio,
                            .apart = ratio_is_apart(ratio)});
    }
  }
  return out;
}

}  // namespace rivid
