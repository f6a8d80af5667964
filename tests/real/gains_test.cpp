// UR10e: drive gains from its currents, as an experiment file asks for them.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "support/real_experiment.hpp"

namespace rivid {
namespace {

// Those of the controller's own model, target currents over target torques of its logs.
constexpr std::array<double, 6> controllers_gains = {11.78, 11.98, 9.82, 10.69, 10.53, 10.63};

class Ur10eGains : public test::RealExperiment {
 protected:
  Ur10eGains() : RealExperiment("ur10e") {}

  void SetUp() override {
    RealExperiment::SetUp();
    if (!IsSkipped()) {
      edit("drive_gain = [11.78, 11.98, 9.82, 10.69, 10.53, 10.63]", "drive_gain = 10");
      edit("rows = \"paper\"", "rows = \"exact\"");
      edit("cutoff_hz = 7\norder = 4\ndecimation = 5\ntrim = 50\n", "");
      edit("files = [\"ur10e/ident_30s_12harm.csv\"]",
           "files = [\"ur10e/unload_14harm.csv\", \"ur10e/ident_30s_12harm.csv\", "
           "\"ur10e/ident_40s_12harm.csv\"]");
      edit("\n[validation]\nfiles = [\"ur10e/ident_40s_12harm.csv\", \"ur10e/unload_14harm.csv\"]\n", "");
    }
  }
};

TEST_F(Ur10eGains, AreThoseOfTheControllerByAKnownMass) {
  edit("name = \"wls\"", "name = \"wls\"\ngains = { loaded = \"ur10e/load_14harm.csv\", mass = 2.805 }");
  const test::Json found = result();
  const test::Json& gains = found.at("gains").at("joints");
  for (std::size_t j = 0; j < 6; ++j) {
    const auto value = gains.at(j).at("value").get<double>();
    const double off = std::abs(value / controllers_gains[j] - 1.0);
    if (gains.at(j).at("identifiable").get<bool>()) {
      EXPECT_LE(off, j == 0 ? 0.15 : 0.05) << j;
      EXPECT_DOUBLE_EQ(found.at("robot").at("joints").at(j).at("drive_gain").get<double>(), value);
    } else {
      EXPECT_EQ(j, 0U);
    }
  }
  EXPECT_TRUE(found.at("provenance").at("options").at("method").at("gains").at("mass").get<double>() ==
              2.805);
}

TEST_F(Ur10eGains, AreInTheSummaryAndThePlan) {
  edit("name = \"wls\"", "name = \"wls\"\ngains = \"estimate\"");
  const test::Outcome plan = identify_run({"ur10e.toml", "--dry-run"});
  EXPECT_NE(plan.out.find("method.gains"), std::string::npos) << plan.out;
  const test::Outcome run = identify_run({"ur10e.toml", "--verbose"});
  EXPECT_NE(run.out.find("Drive gains"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("Only ratios of the gains are determined"), std::string::npos) << run.out;
}

}  // namespace
}  // namespace rivid
