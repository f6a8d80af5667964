#pragma once

#include <cmath>
#include <iomanip>
#include <string>
#include <utility>
#include <vector>

#include "rivid/data/csv.hpp"
#include "rivid/experiment/experiment.hpp"
#include "support/identify_tool.hpp"
#include "support/process.hpp"
#include "support/real_data.hpp"
#include "support/temporary_folder.hpp"

namespace rivid::test {

/// Runs the command line tools on an experiment file of tests/real/, which names its files relative to
/// RIVID_REAL_DATA.
class RealExperiment : public RealData {
 protected:
  explicit RealExperiment(std::string robot) : RealData(robot), robot_(std::move(robot)) {}

  void SetUp() override {
    RealData::SetUp();
    if (IsSkipped()) {
      return;
    }
    std::filesystem::create_directory_symlink(std::filesystem::absolute(path("")), folder_.path() / robot_);
    const std::string file = robot_ + ".toml";
    folder_.write(file, content_of(std::filesystem::path(RIVID_TEST_DATA) / "real" / file));
  }

  /// Replaces a text that the experiment file holds once.
  void edit(std::string_view from, std::string_view to) const {
    const std::string file = robot_ + ".toml";
    std::string content = folder_.read(file);
    const std::size_t at = content.find(from);
    ASSERT_NE(at, std::string::npos) << file << " does not hold " << from;
    folder_.write(file, content.replace(at, from.size(), to));
  }

  [[nodiscard]] Json result(std::vector<std::string> arguments = {}, int exit_code = 0) const {
    arguments.insert(arguments.begin(), robot_ + ".toml");
    const Outcome outcome = identify_run(arguments);
    if (outcome.exit_code != exit_code) {
      ADD_FAILURE() << outcome.err;
      return {};
    }
    return Json::parse(folder_.read(robot_ + "_result/result.json"));
  }

  /// rivid_identify in the folder of the experiment file.
  [[nodiscard]] Outcome identify_run(const std::vector<std::string>& arguments) const {
    return outcome_of(identify_command(arguments), folder_.path());
  }

  [[nodiscard]] Experiment experiment() const { return read_experiment(folder_.path() / (robot_ + ".toml")); }

  /// The log of rivid_simulate, which must come to its end.
  [[nodiscard]] Log simulated() const {
    const Outcome run = outcome_of({RIVID_SIMULATE, robot_ + ".toml"}, folder_.path());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_csv(folder_.path() / (robot_ + "_simulation") / "log.csv");
  }

 private:
  std::string robot_;
  TemporaryFolder folder_;
};

/// An identification without any filter but that of the motion which a simulated loop follows, and its
/// relative errors on the filtered rows of the validation logs, or of its own where there are none.
inline std::pair<Identification, std::vector<double>> unfiltered(Experiment experiment,
                                                                 std::string_view method) {
  experiment.take_method(method);
  const SignalOptions filtered = experiment.estimation.signal;
  experiment.estimation.signal = {.decimation = {1},
                                  .trim = filtered.trim,
                                  .velocity_threshold = filtered.velocity_threshold,
                                  .window = filtered.window};
  Identification found = run(experiment);
  found.estimation.signal = filtered;
  std::vector<double> errors;
  const LogSource& judges = experiment.validation.files.empty() ? experiment.log : experiment.validation;
  for (const Log& log : read_logs(judges, experiment.robot)) {
    errors.push_back(validate(experiment.robot, found, log).fit.relative_error);
  }
  return {std::move(found), std::move(errors)};
}

/// A figure agrees with its printed digits, to half a unit of the last one.
inline testing::AssertionResult prints_as(double got, std::string_view printed) {
  const std::size_t point = printed.find('.');
  const std::size_t decimals = point == std::string_view::npos ? 0 : printed.size() - point - 1;
  const double half_unit = 0.5 * std::pow(10.0, -static_cast<double>(decimals));
  const double expected = std::stod(std::string(printed));
  if (std::abs(got - expected) <= half_unit) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << std::setprecision(12) << got << " does not print as " << printed;
}

}  // namespace rivid::test
