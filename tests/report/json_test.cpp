// result.json number by number: each is the member of the Identification that it is named after, and none
// goes unchecked.

#include "rivid/report/json.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

using Json = nlohmann::json;

// The numbers of a document by their paths, "/fit/rows"; each has to be asked for.
class Numbers {
 public:
  Numbers(const Robot& robot, const Identification& result)
      : flat_(Json::parse(to_json(robot, result, {})).flatten()) {
    for (const auto& [path, value] : flat_.items()) {
      if (value.is_number() && !path.starts_with("/provenance") && path != "/format") {
        left_.insert(path);
      }
    }
  }

  template <class Number>
    requires std::is_arithmetic_v<Number>
  void are(const std::string& path, Number value) {
    left_.erase(path);
    ASSERT_TRUE(flat_.contains(path)) << path;
    const bool finite = std::isfinite(static_cast<double>(value));
    EXPECT_EQ(flat_[path], finite ? Json(value) : Json()) << path;
  }
  template <class List>
    requires(!std::is_arithmetic_v<List>)
  void are(const std::string& path, const List& values) {
    std::size_t at = 0;
    for (const auto& value : values) {
      are(path + "/" + std::to_string(at++), value);
    }
    EXPECT_FALSE(flat_.contains(path + "/" + std::to_string(at))) << path;
  }

  [[nodiscard]] const std::set<std::string>& left() const { return left_; }

 private:
  Json flat_;
  std::set<std::string> left_;
};

std::string at(const std::string& list, std::size_t k) { return list + "/" + std::to_string(k); }

void fit_is(Numbers& numbers, const std::string& path, const Fit& fit) {
  numbers.are(path + "/relative_error", fit.relative_error);
  numbers.are(path + "/centred_relative_error", fit.centred_relative_error);
  numbers.are(path + "/error_norm", fit.error_norm);
  numbers.are(path + "/sigma_rho", fit.sigma_rho);
  numbers.are(path + "/rows", fit.rows);
  for (std::size_t j = 0; j < fit.joints.size(); ++j) {
    const std::string joint = at(path + "/joints", j);
    numbers.are(joint + "/relative_error", fit.joints[j].relative_error);
    numbers.are(joint + "/centred_relative_error", fit.joints[j].centred_relative_error);
    numbers.are(joint + "/sigma_rho", fit.joints[j].sigma_rho);
    numbers.are(joint + "/rows", fit.joints[j].rows);
    numbers.are(joint + "/left_out", fit.joints[j].left_out);
    numbers.are(joint + "/velocity_threshold", fit.joints[j].velocity_threshold);
  }
}

void test_is(Numbers& numbers, const std::string& path, const TestResult& test) {
  numbers.are(path + "/statistic", test.statistic);
  numbers.are(path + "/freedom", test.freedom);
  numbers.are(path + "/p", test.p);
}

void motion_error_is(Numbers& numbers, const std::string& path, const MotionError& error) {
  numbers.are(path + "/position", error.q);
  numbers.are(path + "/velocity", error.qd);
  numbers.are(path + "/acceleration", error.qdd);
}

void parameters_are(Numbers& numbers, const Identification& result) {
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const std::string path = at("/parameters", i);
    const ParameterEstimate& p = result.parameters[i];
    numbers.are(path + "/value", p.value);
    numbers.are(path + "/sigma", p.sigma);
    numbers.are(path + "/relative_sigma_percent", p.relative_sigma_percent);
    numbers.are(path + "/plain_sigma", p.plain_sigma);
    numbers.are(path + "/interval_95", p.interval_95);
    numbers.are(path + "/noise_bias", p.noise_bias);
    numbers.are(path + "/model_shift", p.model_shift);
    numbers.are(path + "/a_priori", p.a_priori);
    for (const auto& [name, coefficient] : result.base.regrouping(static_cast<Index>(i))) {
      numbers.are(path + "/regrouping/" + name, coefficient);
    }
  }
}

void diagnostics_are(Numbers& numbers, const Diagnostics& found) {
  for (std::size_t j = 0; j < found.residuals.size(); ++j) {
    const std::string path = at("/tests/residuals", j);
    test_is(numbers, path + "/whiteness", found.residuals[j].whiteness);
    numbers.are(path + "/autocorrelation", found.residuals[j].autocorrelation);
    test_is(numbers, path + "/normality", found.residuals[j].normality);
    numbers.are(path + "/skewness", found.residuals[j].skewness);
    numbers.are(path + "/excess_kurtosis", found.residuals[j].excess_kurtosis);
  }
  if (found.hausman) {
    test_is(numbers, "/tests/hausman", found.hausman->test);
    numbers.are("/tests/hausman/largest_shift", found.hausman->largest_shift);
  }
  if (found.torque_lag) {
    numbers.are("/tests/torque_lag/samples", found.torque_lag->samples);
    numbers.are("/tests/torque_lag/sigma", found.torque_lag->sigma);
    numbers.are("/tests/torque_lag/largest_shift", found.torque_lag->largest_shift);
  }
}

void iterations_are(Numbers& numbers, const IvHistory& history) {
  for (std::size_t k = 0; k < history.iterations.size(); ++k) {
    const std::string path = at("/iterations", k);
    const IvIteration& i = history.iterations[k];
    numbers.are(path + "/chi", i.chi);
    numbers.are(path + "/error_norm", i.error_norm);
    numbers.are(path + "/relative_error", i.relative_error);
    numbers.are(path + "/joint_error_norm", i.joint_error_norm);
    numbers.are(path + "/largest_step_sigmas", i.largest_step);
    motion_error_is(numbers, path + "/simulated_to_measured", i.to_measured);
    motion_error_is(numbers, path + "/simulated_to_reference", i.to_reference);
    numbers.are(path + "/design_inertia", i.J);
    for (const Gain& gain : i.gains) {
      numbers.are(path + "/gains/" + gain.name, gain.values);
    }
    numbers.are(path + "/condition_V", i.condition_V);
    numbers.are(path + "/condition_VW", i.condition_VW);
    numbers.are(path + "/steps", i.effort.steps);
    numbers.are(path + "/right_hand_sides", i.effort.right_hand_sides);
    numbers.are(path + "/mode_changes", i.effort.mode_changes);
  }
  numbers.are("/loop/control_error", history.loop.control_error);
  numbers.are("/loop/tracking_ratio", history.loop.tracking_ratio);
  numbers.are("/first_stage_F", history.first_stage_F);
}

void physical_is(Numbers& numbers, const Robot& robot, const BaseParameters& base,
                 const PhysicalModel& model) {
  const PhysicalParameters& found = model.parameters;
  numbers.are("/physical/chi", found.chi);
  fit_is(numbers, "/physical/fit", model.fit);
  numbers.are("/physical/sigma", Vector(model.C_chi.diagonal().cwiseSqrt()));
  for (Index row = 0; row < model.C_chi.rows(); ++row) {
    numbers.are(at("/physical/C_chi", static_cast<std::size_t>(row)), Vector(model.C_chi.row(row)));
  }
  numbers.are("/physical/cost", found.cost);
  numbers.are("/physical/distance", found.distance);
  numbers.are("/physical/divergence", found.divergence);
  numbers.are("/physical/gap", found.gap);
  numbers.are("/physical/steps", found.steps);
  numbers.are("/physical/options/weight", model.options.weight);
  numbers.are("/physical/options/tolerance", model.options.tolerance);
  numbers.are("/physical/options/max_steps", model.options.max_steps);
  for (const Physical::MassBounds& bounds : model.options.masses) {
    numbers.are("/physical/options/masses/" + bounds.link, std::array{bounds.least, bounds.most});
  }
  numbers.are("/physical/options/total_mass", model.options.total_mass.value());
  const Vector a_priori = robot.chi_st();
  std::vector<std::size_t> count(robot.joints.size(), 0);
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const auto j = static_cast<std::size_t>(base.standard[i].joint);
    const std::string path = at(at("/physical/links", j) + "/parameters", count[j]++);
    numbers.are(path + "/value", found.chi_st[static_cast<Index>(i)]);
    numbers.are(path + "/a_priori", a_priori[static_cast<Index>(i)]);
  }
}

void essential_is(Numbers& numbers, const EssentialModel& model) {
  const EssentialParameters& found = model.parameters;
  for (std::size_t k = 0; k < found.kept.size(); ++k) {
    const std::string path = at("/essential/parameters", k);
    const double value = found.chi[found.kept[k]];
    const double sigma = std::sqrt(found.C_chi(found.kept[k], found.kept[k]));
    numbers.are(path + "/value", value);
    numbers.are(path + "/sigma", sigma);
    numbers.are(path + "/relative_sigma_percent", 100.0 * sigma / std::abs(value));
  }
  for (std::size_t k = 0; k < found.eliminated.size(); ++k) {
    numbers.are(at("/essential/eliminated", k) + "/F", found.eliminated[k].F);
    numbers.are(at("/essential/eliminated", k) + "/p", found.eliminated[k].p);
  }
  numbers.are("/essential/F", found.F);
  numbers.are("/essential/p", found.p);
  numbers.are("/essential/significance", model.options.significance);
  fit_is(numbers, "/essential/fit", model.fit);
}

void prefilter_is(Numbers& numbers, const PrefilterReport& report) {
  for (std::size_t j = 0; j < report.noise.size(); ++j) {
    numbers.are(at("/prefilter/noise", j) + "/ar", report.noise[j].ar);
    numbers.are(at("/prefilter/noise", j) + "/innovation", report.noise[j].innovation);
  }
  numbers.are("/prefilter/rounds", report.rounds);
  numbers.are("/prefilter/rows", report.rows);
  numbers.are("/prefilter/without/chi", report.chi);
  numbers.are("/prefilter/without/sigma", report.sigma);
}

void robust_is(Numbers& numbers, const RobustReport& report) {
  numbers.are("/robust/tuning", report.options.loss().tuning);
  numbers.are("/robust/rounds", report.rounds);
  for (std::size_t j = 0; j < report.joints.size(); ++j) {
    const std::string path = at("/robust/joints", j);
    numbers.are(path + "/scale", report.joints[j].scale);
    numbers.are(path + "/rows", report.joints[j].rows);
    numbers.are(path + "/below_one", report.joints[j].below_one);
    numbers.are(path + "/below_half", report.joints[j].below_half);
    numbers.are(path + "/rejected", report.joints[j].rejected);
  }
  numbers.are("/robust/largest_shift", report.largest_shift);
  numbers.are("/robust/without/chi", report.chi);
}

void robot_is(Numbers& numbers, const Robot& robot) {
  numbers.are("/robot/gravity", robot.chain.gravity);
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const std::string path = at("/robot/joints", j);
    numbers.are(path + "/sign_speed", robot.joints[j].sign_speed);
    numbers.are(path + "/drive_gain", robot.joints[j].drive_gain);
    numbers.are(path + "/gear_ratio", robot.joints[j].gear_ratio);
    const Chain::Link& link = robot.chain.links[j];
    numbers.are(path + "/frame/origin", link.p);
    for (Index row = 0; row < 3; ++row) {
      numbers.are(at(path + "/frame/rotation", static_cast<std::size_t>(row)), Vector(link.R.row(row)));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      numbers.are(at(path + "/frame/axes", k), link.signs[k] * (link.axes[k] + 1));
    }
  }
  for (std::size_t c = 0; c < robot.couplings.size(); ++c) {
    numbers.are(at("/robot/coupling", c) + "/ratios", robot.couplings[c].ratios);
  }
  for (Index row = 0; row < robot.gear_matrix.rows(); ++row) {
    numbers.are(at("/robot/gear_matrix", static_cast<std::size_t>(row)), Vector(robot.gear_matrix.row(row)));
  }
}

void result_is(const Robot& robot, const Identification& result) {
  Numbers numbers(robot, result);
  robot_is(numbers, robot);
  parameters_are(numbers, result);
  for (Index row = 0; row < result.C_chi.rows(); ++row) {
    const auto at_row = static_cast<std::size_t>(row);
    numbers.are(at("/covariance/C_chi", at_row), Vector(result.C_chi.row(row)));
    numbers.are(at("/covariance/gain_slopes", at_row), Vector(result.gain_slopes.row(row)));
  }
  numbers.are("/covariance/lag", result.covariance.lag);
  numbers.are("/covariance/blocks", result.covariance.blocks);
  numbers.are("/covariance/block_ratio", result.covariance.block_ratio);
  numbers.are("/covariance/decimation_factor", result.covariance.decimation_factor);
  numbers.are("/covariance/quantile_975", result.covariance.quantile_975);
  fit_is(numbers, "/fit", result.fit);
  numbers.are("/fit/reference_error", result.fit.reference_error);
  if (result.forecast) {
    numbers.are("/forecast/relative_error", result.forecast->relative_error);
    numbers.are("/forecast/joints", result.forecast->joints);
  }
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    numbers.are(at("/parameters", i) + "/row_shift", result.parameters[i].row_shift);
  }
  numbers.are("/fit/columns", result.columns);
  numbers.are("/fit/condition", result.condition);
  numbers.are("/fit/R_diagonal", result.R_diagonal);
  numbers.are("/fit/weights", result.weights);
  for (std::size_t k = 0; k < result.validation.size(); ++k) {
    const Validation& one = result.validation[k];
    fit_is(numbers, at("/validation", k), one.fit);
    numbers.are(at("/validation", k) + "/reference_error", one.fit.reference_error);
    numbers.are(at("/validation", k) + "/forecast/relative_error", one.forecast.relative_error);
    numbers.are(at("/validation", k) + "/forecast/joints", one.forecast.joints);
    if (one.physical) {
      fit_is(numbers, at("/validation", k) + "/physical", *one.physical);
    }
    if (one.essential) {
      fit_is(numbers, at("/validation", k) + "/essential", *one.essential);
    }
  }
  if (result.diagnostics) {
    diagnostics_are(numbers, *result.diagnostics);
  }
  if (result.iv) {
    iterations_are(numbers, *result.iv);
  }
  if (result.row_choice) {
    numbers.are("/row_choice/decimation", result.row_choice->decimation);
    numbers.are("/row_choice/row_spacing", result.row_choice->row_spacing);
    numbers.are("/row_choice/foretold/largest", result.row_choice->foretold.largest);
    numbers.are("/row_choice/at_half/largest", result.row_choice->at_half.largest);
    numbers.are("/row_choice/at_double/largest", result.row_choice->at_double.largest);
  }
  for (std::size_t k = 0; k < result.alternatives.size(); ++k) {
    const ModelTest& one = result.alternatives[k];
    const std::string path = "/alternatives/" + std::to_string(k);
    numbers.are(path + "/test/statistic", one.test.statistic);
    numbers.are(path + "/test/freedom", one.test.freedom);
    numbers.are(path + "/test/p", one.test.p);
    numbers.are(path + "/estimate", one.estimate);
    numbers.are(path + "/sigma", one.sigma);
    numbers.are(path + "/explained", one.explained);
    numbers.are(path + "/largest_shift", one.largest_shift);
  }
  if (result.method_choice) {
    numbers.are("/method_choice/least_squares", result.method_choice->least_squares);
  }
  if (result.physical) {
    physical_is(numbers, robot, result.base, *result.physical);
  }
  if (result.essential) {
    essential_is(numbers, *result.essential);
  }
  if (result.prefilter) {
    prefilter_is(numbers, *result.prefilter);
  }
  if (result.robust) {
    robust_is(numbers, *result.robust);
  }
  EXPECT_EQ(numbers.left(), std::set<std::string>()) << "numbers that no line above asks for";
}

class ResultJson : public testing::Test, public test::ScaraStudy {};

TEST_F(ResultJson, HasTheNumbersOfAnInstrumentalResult) {
  const SignalOptions signal = {.rows = RowScheme::exact, .torque_held = true};
  Estimation estimation = iv();
  std::get<Iv>(estimation.method).prefilter = true;
  estimation.signal = signal;
  estimation.physical = Physical{.masses = {{.link = "link_1", .least = 1.0, .most = 50.0}},
                                 .total_mass = std::array{2.0, 60.0}};
  estimation.essential = Essential{.significance = 0.04};
  Identification result = identify(robot, log(1.0, 1), estimation);
  result.validation.push_back(validate(robot, result, log(1.5, 2)));
  ASSERT_TRUE(result.iv && result.prefilter && result.physical && result.essential && result.diagnostics);
  ASSERT_TRUE(result.diagnostics->hausman);
  result_is(robot, result);
}

TEST_F(ResultJson, HasTheNumbersOfARobustResult) {
  const SignalOptions signal = {.rows = RowScheme::exact, .torque_held = true, .decimation = {10}};
  Log bad = log(1.0, 1);
  for (Index k = 0; k < bad.samples(); k += 97) {
    bad.v_tau.row(k).array() += 20.0;
  }
  const Identification result = identify(
      robot, bad, {.method = Wls{}, .signal = signal, .robust = Robust{.kind = RobustKind::bisquare}});
  ASSERT_TRUE(result.robust);
  result_is(robot, result);
}

TEST_F(ResultJson, HasTheLagOfTheTorques) {
  const SignalOptions signal = {.rows = RowScheme::exact, .torque_held = true, .decimation = {10}};
  const Identification result = identify(robot, log(2.0, 1), {.method = Wls{}, .signal = signal});
  ASSERT_TRUE(result.diagnostics && result.diagnostics->torque_lag);
  result_is(robot, result);
}

TEST_F(ResultJson, HasTheNumbersOfTheRobot) {
  std::mt19937_64 random(5);
  Robot other = test::random_robot(3, random);
  for (std::size_t j = 0; j < 3; ++j) {
    const auto k = static_cast<double>(j);
    other.joints[j].sign_speed = 0.01 + k;
    other.joints[j].drive_gain = 0.02 + k;
    other.joints[j].gear_ratio = 0.03 + k;
  }
  other.couplings = {{.motor = 1, .joints = {0, 1}, .ratios = {0.25, 0.75}}};
  other.gear_matrix = Matrix::Identity(3, 3) + 0.1 * Matrix::Constant(3, 3, 1.0);
  other.gear_matrix(0, 2) = 7.0;
  result_is(other, {});
}

}  // namespace
}  // namespace rivid
