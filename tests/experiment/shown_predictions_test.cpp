// A report shows logs within its memory; which ones, and what it says of the others.

#include "rivid/experiment/shown_predictions.hpp"

#include <gtest/gtest.h>

namespace rivid {
namespace {

class ShownLogs : public testing::Test {
 protected:
  [[nodiscard]] ShownPredictions within(Index most) const {
    return shown_predictions(experiment, identified, most);
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
  EXPECT_EQ(names(shown_predictions(experiment, identified)).size(), 2U);
}

}  // namespace
}  // namespace rivid
