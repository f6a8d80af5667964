// rivid_identify payload: logs with loads, on logs without or on a result.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/complaint.hpp"
#include "support/identify_tool.hpp"
#include "support/process.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

using test::Json;
using test::Outcome;

// The arm of data/six_axis, simulated without load and with two kilograms at the centre of mass of its last link.
class PayloadTool : public testing::Test {
 protected:
  PayloadTool() {
    for (const char* const file :
         {"six_axis.toml", "six_axis.urdf", "simulate.toml", "six_axis_reference.csv"}) {
      folder_.write(file, test::content_of(std::filesystem::path(RIVID_DATA) / "six_axis" / file));
    }
    simulate("simulate.toml", "made");
    replace("six_axis.urdf", "loaded.urdf", "<mass value=\"0.2\"/>", "<mass value=\"2.2\"/>");
    replace("simulate.toml", "loaded.toml", "urdf = \"six_axis.urdf\"", "urdf = \"loaded.urdf\"");
    replace("loaded.toml", "loaded.toml", "4001", "77");
    simulate("loaded.toml", "heavy");
  }

  // The last one of a text.
  void replace(const std::string& file, const std::string& to, const std::string& from,
               const std::string& by) const {
    std::string content = folder_.read(file);
    const std::size_t at = content.rfind(from);
    ASSERT_NE(at, std::string::npos) << file << " does not hold " << from;
    folder_.write(to, content.replace(at, from.size(), by));
  }

  void simulate(const std::string& experiment, const std::string& output) const {
    const Outcome run = test::outcome_of({RIVID_SIMULATE, experiment, "-o", output, "-q"}, folder_.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  [[nodiscard]] Outcome payload(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"payload", "six_axis.toml"});
    return test::outcome_of(test::identify_command(arguments), folder_.path());
  }

  [[nodiscard]] Json found() const { return Json::parse(folder_.read("six_axis_result/payload.json")); }

  void identify_arm() const {
    const Outcome run = test::outcome_of(
        test::identify_command({"six_axis.toml", "--method", "wls", "-o", "arm", "-q"}), folder_.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  test::TemporaryFolder folder_;
};

void expect_two_kilograms(const Json& payload) {
  const Json& mass = payload.at("values").at("mass");
  EXPECT_LE(mass.at("interval_95").at(0), 2.0) << mass;
  EXPECT_GE(mass.at("interval_95").at(1), 2.0) << mass;
  EXPECT_LT(mass.at("sigma"), 0.02);
  EXPECT_NEAR(payload.at("values").at("com_z").at("value"), 0.042, 0.002);
}

TEST_F(PayloadTool, FindsALoadFromLogsWithoutIt) {
  const Outcome run = payload({"--loaded", "heavy/log.csv"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(test::says(run.out, "set_target_payload(2.0"));
  ASSERT_EQ(found().at("payloads").size(), 1U);
  EXPECT_TRUE(found().at("differences").empty());
  expect_two_kilograms(found().at("payloads").at(0));
}

TEST_F(PayloadTool, FindsLoadsOnAResult) {
  identify_arm();
  const Outcome run = payload(
      {"--arm", "arm/result.json", "--loaded", "heavy=heavy/log.csv", "none=made/log.csv", "--gains", "1"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json payloads = found().at("payloads");
  ASSERT_EQ(payloads.size(), 2U);
  EXPECT_EQ(payloads.at(0).at("name"), "heavy");
  expect_two_kilograms(payloads.at(0));
  EXPECT_EQ(payloads.at(1).at("values").size(), 1U);
  EXPECT_EQ(found().at("differences").at(0).at("name"), "none - heavy");
  EXPECT_EQ(found().at("gains").size(), 6U);
  EXPECT_TRUE(test::says(run.out, "Difference none - heavy"));
}

TEST_F(PayloadTool, RefusesWhatDoesNotFit) {
  identify_arm();
  const auto refused = [&](std::vector<std::string> arguments, const char* words) {
    const Outcome run = payload(std::move(arguments));
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_TRUE(test::says(run.err, words));
  };
  const std::string arm = "arm/result.json";
  const std::string heavy = "heavy/log.csv";
  refused({"--arm", arm, "--log", heavy, "--loaded", heavy}, "excludes --arm");
  refused({"--arm", "six_axis.urdf", "--loaded", heavy}, "is no result.json");
  refused({"--loaded", "a=" + heavy, "--mass", "b=2"}, "no logs of --loaded are those of \"b\"");
  refused({"--loaded", heavy, "--mass", "2", "3"}, "the mass of \"payload\" is given twice");
  refused({"--loaded", heavy, "--gains", "estimate"}, "give the mass of a payload");
  Json without = Json::parse(folder_.read(arm));
  without.at("covariance").erase("gain_slopes");
  folder_.write("older.json", without.dump());
  refused({"--arm", "older.json", "--loaded", heavy}, "has no gain_slopes");
  Json moved = Json::parse(folder_.read(arm));
  moved.at("robot").at("joints").at(2).at("frame").at("origin").at(0) = 0.5;
  folder_.write("moved.json", moved.dump());
  refused({"--arm", "moved.json", "--loaded", heavy}, "is another one than");
}

}  // namespace
}  // namespace rivid
