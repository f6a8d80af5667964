// rivid compare on a UR10e: its identified models and the URDF of its maker on logs that took part
// in no fit.

#include <gtest/gtest.h>

#include <vector>

#include "support/real_experiment.hpp"

namespace {

using rivid::test::Json;

class CompareUr10e : public rivid::test::RealExperiment {
 protected:
  CompareUr10e() : RealExperiment("ur10e") {}

  // The experiment identified with a friction law, into a folder called after that.
  void identify(const std::string& law) const {
    edit("\nfriction = \"symmetric\"", "\nfriction = \"" + law + "\"");
    EXPECT_EQ(identify_run({"ur10e.toml", "--output", law, "--quiet"}).exit_code, 0);
    edit("\nfriction = \"" + law + "\"", "\nfriction = \"symmetric\"");
  }
};

TEST_F(CompareUr10e, AnIdentifiedModelPredictsBetterThanTheUrdfAndLoadFrictionBetterStill) {
  identify("symmetric");
  identify("load");
  const auto compared = identify_run({"compare", "symmetric", "load", "ur10e/ur10e.urdf", "--log",
                                      "ur10e/ident_40s_12harm.csv", "ur10e/unload_14harm.csv", "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  const Json found = Json::parse(compared.out);
  const auto error = [&](std::size_t model) {
    return found.at("models")[model].at("relative_error").get<double>();
  };
  // Without friction and rotors the URDF misses more than a third of the torque.
  EXPECT_LT(error(0), 0.045);
  EXPECT_LT(error(1), 0.9 * error(0));
  EXPECT_GT(error(2), 0.35);
  ASSERT_EQ(found.at("tests").size(), 3U);
  for (const Json& test : found.at("tests")) {
    EXPECT_LT(test.at("p"), 0.01) << test;
    const bool with_urdf = test.at("b") == "ur10e/ur10e.urdf";
    EXPECT_EQ(test.at("better"), with_urdf ? test.at("a") : Json("load")) << test;
  }
}

TEST_F(CompareUr10e, AnotherLogOfTheSameRobotChangesFewParameters) {
  identify("symmetric");
  EXPECT_EQ(
      identify_run({"ur10e.toml", "--log", "ur10e/ident_40s_12harm.csv", "--output", "later", "--quiet"})
          .exit_code,
      0);
  const auto compared =
      identify_run({"compare", "symmetric", "later", "--log", "ur10e/unload_14harm.csv", "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  const Json parameters = Json::parse(compared.out).at("changes")[0].at("parameters");
  EXPECT_EQ(parameters.size(), 58U);
  // One in a hundred, and friction differs from day to day.
  const auto changed = [](const Json& change) { return change.at("p") < 0.01; };
  EXPECT_LE(std::ranges::count_if(parameters, changed), 2) << parameters.dump(1);
}

}  // namespace
