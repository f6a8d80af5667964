// A run reads each log once, whatever it needs them for; a report shows logs within its memory: which ones,
// and what it says of the others.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid {
namespace {

class ShownLogs : public testing::Test {
 protected:
  [[nodiscard]] ShownPredictions within(Index most) const {
    Reading reading;
    return shown_predictions(experiment, identified, reading, most);
  }
  [[nodiscard]] static std::vector<std::string> names(const ShownPredictions& shown) {
    std::vector<std::string> out;
    for (const Prediction& prediction : shown.predictions) {
      out.push_back(std::filesystem::path(prediction.source).filename());
    }
    return out;
  }
  [[nodiscard]] Index numbers_of(const LogSource& source) const {
    return read_logs(source, experiment.robot).front().q.size();
  }

  Experiment experiment = read_experiment(std::filesystem::path(RIVID_DATA) / "scara/scara.toml");
  Identification identified = run(experiment);
  Index first = numbers_of(experiment.log);
  Index validation = numbers_of(experiment.validation);
};

TEST_F(ShownLogs, AreAllThatFit) {
  const ShownPredictions all = within(first + validation);
  EXPECT_EQ(names(all), (std::vector<std::string>{"scara_s2.csv", "scara_validation.csv"}));
  EXPECT_FALSE(all.predictions.front().validation);
  EXPECT_TRUE(all.predictions.back().validation);
  EXPECT_TRUE(all.left_out.empty());
}

TEST_F(ShownLogs, BeyondTheLimitAreNamed) {
  const ShownPredictions one = within(first + validation - 1);
  EXPECT_EQ(names(one), (std::vector<std::string>{"scara_s2.csv"}));
  ASSERT_EQ(one.left_out.size(), 1U);
  EXPECT_TRUE(one.left_out.front().ends_with("scara_validation.csv")) << one.left_out.front();
  EXPECT_EQ(within(0).left_out.size(), 2U);
  EXPECT_TRUE(within(0).predictions.empty());
}

TEST_F(ShownLogs, AreThoseOfTheCommandByDefault) {
  Reading reading;
  EXPECT_EQ(names(shown_predictions(experiment, identified, reading)).size(), 2U);
}

// What rivid identify --report does, with friction laws to be chosen: five readings of the log and two of the
// validation before there was one reading for all.
TEST(Reading, ParsesEachLogOnceForAllThatARunNeeds) {
  const std::vector<std::string> settings = {"robot.friction=auto"};
  Experiment experiment =
      read_experiment(std::filesystem::path(RIVID_DATA) / "scara/scara.toml", Use::identification, settings);
  std::vector<std::string> parsed;
  Reading reading([&](std::string_view stage, double fraction) {
    if (stage.starts_with("reading ") && fraction == 1.0) {
      parsed.emplace_back(stage);
    }
  });
  const std::vector<Log>& logs = reading.logs(experiment.log, experiment.robot);
  take_friction(experiment, reading);
  take_gains(experiment, reading);
  const Identification result = run(experiment, reading);
  EXPECT_EQ(result.validation.size(), 1U);
  EXPECT_EQ(shown_predictions(experiment, result, reading).predictions.size(), 2U);
  EXPECT_EQ(&reading.logs(experiment.log, experiment.robot), &logs);
  EXPECT_EQ(reading.files(), 2U);
  EXPECT_EQ(parsed, (std::vector<std::string>{"reading scara_s2.csv", "reading scara_validation.csv"}));
}

TEST(Reading, ReadsWhatIsToBeReadInAnotherWayAgain) {
  const Experiment experiment = read_experiment(std::filesystem::path(RIVID_DATA) / "scara/scara.toml");
  Reading reading;
  const std::vector<Log>& logs = reading.logs(experiment.log, experiment.robot);
  LogSource other = experiment.log;
  other.torque_lag = 1.0;
  EXPECT_NE(reading.logs(other, experiment.robot).front().samples(), logs.front().samples());
  EXPECT_EQ(reading.files(), 2U);
}

TEST(Reading, OfALogThatCanNotBeReadKeepsNothing) {
  Experiment experiment = read_experiment(std::filesystem::path(RIVID_DATA) / "scara/scara.toml");
  experiment.log.files = {"no_such_log.csv"};
  Reading reading;
  EXPECT_THROW((void)reading.logs(experiment.log, experiment.robot), InputError);
  EXPECT_THROW((void)reading.logs(experiment.log, experiment.robot), InputError);
  EXPECT_EQ(reading.files(), 0U);
}

}  // namespace
}  // namespace rivid
