// rivid payload: logs with loads, on logs without or on a result.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "rivid/text.hpp"
#include "support/complaint.hpp"
#include "support/identify_tool.hpp"
#include "support/process.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

using test::Json;
using test::Outcome;

using Rows = std::vector<std::vector<double>>;

// The arm of data/six_axis, simulated without load and with two kilograms at the centre of mass of its last
// link.
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

  // The loaded log with something wrong, as bad.csv. Rows are t, q1 … q6, v1 … v6 and more; a fault may
  // exchange them.
  void spoil(const std::function<void(Rows&)>& fault) const {
    std::istringstream in(folder_.read("heavy/log.csv"));
    std::string line;
    std::getline(in, line);
    std::string out = line + '\n';
    Rows rows;
    while (std::getline(in, line)) {
      std::istringstream cells(line);
      std::vector<double>& row = rows.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) {
        row.push_back(std::stod(cell));
      }
    }
    fault(rows);
    for (const std::vector<double>& row : rows) {
      for (std::size_t c = 0; c < row.size(); ++c) {
        out += (c > 0 ? "," : "") + number(row[c], 12);
      }
      out += '\n';
    }
    folder_.write("bad.csv", out);
  }

  void identify_arm() const {
    const Outcome run = test::outcome_of(
        test::identify_command({"six_axis.toml", "--method", "wls", "-o", "arm", "-q"}), folder_.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  test::TemporaryFolder folder_;
};

constexpr std::size_t t = 0;
constexpr std::size_t q = 1;
constexpr std::size_t v = 7;
constexpr std::size_t joints = 6;

struct Fault {
  std::string name;
  std::function<void(Rows&)> plant;
};

// Columns times a factor.
Fault scaled(const std::string& name, std::size_t from, std::size_t count, double factor) {
  return {name + " times " + number(factor), [=](Rows& rows) {
            for (std::vector<double>& row : rows) {
              for (std::size_t c = from; c < from + count; ++c) {
                row[c] *= factor;
              }
            }
          }};
}

// Torques so many samples late, or early.
Fault shifted(int samples) {
  return {"torques " + std::to_string(samples) + " samples late", [=](Rows& rows) {
            const Rows before = rows;
            const auto last = static_cast<int>(rows.size()) - 1;
            for (int k = 0; k <= last; ++k) {
              const auto& from = before[static_cast<std::size_t>(std::clamp(k - samples, 0, last))];
              std::copy_n(from.begin() + v, joints, rows[static_cast<std::size_t>(k)].begin() + v);
            }
          }};
}

std::vector<Fault> miswirings() {
  std::vector<Fault> out;
  for (std::size_t j = 0; j < joints; ++j) {
    const std::string joint = "torque " + std::to_string(j + 1);
    out.push_back(scaled(joint, v + j, 1, -1.0));
    out.push_back(scaled(joint, v + j, 1, j == 1 ? 1.05 : 1.2));
    if (j > 0) {
      out.push_back({joint + " exchanged with the one before", [=](Rows& rows) {
                       for (std::vector<double>& row : rows) {
                         std::swap(row[v + j - 1], row[v + j]);
                       }
                     }});
    }
  }
  for (const double factor : {-1.0, 0.8, 1.2, 1000.0}) {
    out.push_back(scaled("torques", v, joints, factor));
  }
  out.push_back(scaled("torque 4", v + 3, 1, 1000.0));
  out.push_back(scaled("positions", q, joints, 57.29577951));
  out.push_back(scaled("position 3", q + 2, 1, 57.29577951));
  out.push_back(scaled("time", t, 1, 1.1));
  out.push_back(scaled("time", t, 1, 2.0));
  out.push_back(shifted(20));
  out.push_back(shifted(100));
  return out;
}

// Torques that have nothing to do with the motion.
void randomise(Rows& rows) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0.0, 20.0);
  for (std::vector<double>& row : rows) {
    std::generate_n(row.begin() + v, joints, [&] { return normal(random); });
  }
}

bool has_line(const Outcome& run) {
  return run.out.find("set_target_payload(") != std::string::npos ||
         run.out.find("setLoad(") != std::string::npos;
}

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

TEST_F(PayloadTool, TellsNoWrongPayloadOfAMiswiredLog) {
  const std::vector<Fault> all = miswirings();
  ASSERT_EQ(all.size(), 28U);
  for (const Fault& fault : all) {
    spoil(fault.plant);
    const Outcome run = payload({"--loaded", "bad.csv"});
    if (run.exit_code == 0) {
      const Json mass = found().at("payloads").at(0).at("values").at("mass");
      EXPECT_LE(std::abs(mass.at("value").get<double>() - 2.0), 4.0 * mass.at("sigma").get<double>())
          << fault.name;
    } else {
      EXPECT_TRUE(run.exit_code == 1 || run.exit_code == 2) << fault.name << run.err;
      EXPECT_FALSE(has_line(run)) << fault.name;
    }
  }
}

TEST_F(PayloadTool, DoubtsTorquesThatHaveNothingToDoWithTheMotion) {
  spoil(randomise);
  const Outcome run = payload({"--loaded", "bad.csv"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(run.out.starts_with("DOUBTFUL: ")) << run.out;
  EXPECT_TRUE(test::says(run.out, "no line for a controller: the result is doubtful"));
  EXPECT_FALSE(has_line(run)) << run.out;
  EXPECT_EQ(found().at("status"), "doubtful");
  EXPECT_TRUE(found().at("payloads").at(0).at("urscript").is_null());
  EXPECT_FALSE(found().at("warnings").empty());
}

TEST_F(PayloadTool, DoubtsANegativeMass) {
  const Outcome run = payload({"--log", "heavy/log.csv", "--loaded", "made/log.csv"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::says(run.out, "error [negative_mass] payload: -2"));
  EXPECT_FALSE(has_line(run)) << run.out;
}

TEST_F(PayloadTool, SaysThatThereIsNoPayload) {
  replace("simulate.toml", "again.toml", "4001", "78");
  simulate("again.toml", "again");
  const Outcome run = payload({"--loaded", "again/log.csv"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.out.starts_with("identified: no payload (less than 0.0")) << run.out;
  EXPECT_FALSE(has_line(run)) << run.out;
  EXPECT_GT(found().at("payloads").at(0).at("least_mass"), 0.0);
}

TEST_F(PayloadTool, DoubtsGainsFromAMiswiredLog) {
  spoil(scaled("torque 2", v + 1, 1, -1.0).plant);
  const auto gains_from = [&](const std::string& log) {
    return test::outcome_of(test::identify_command({"six_axis.toml", "--set", "method.name=\"wls\"", "--set",
                                                    "method.gains={loaded=\"" + log + "\",mass=2}"}),
                            folder_.path());
  };
  const Outcome good = gains_from("heavy/log.csv");
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  const Outcome bad = gains_from("bad.csv");
  EXPECT_EQ(bad.exit_code, 1) << bad.out << bad.err;
  EXPECT_TRUE(test::says(bad.out, "loaded: joint_"));
}

TEST_F(PayloadTool, FailsAComparisonOnAMiswiredLog) {
  identify_arm();
  const auto validated = [&](const std::string& log) {
    return test::outcome_of(test::identify_command({"validate", "arm/result.json", log}), folder_.path());
  };
  EXPECT_EQ(validated("heavy/log.csv").exit_code, 0);
  spoil(scaled("torque 2", v + 1, 1, -1.0).plant);
  const Outcome signs = validated("bad.csv");
  EXPECT_EQ(signs.exit_code, 1) << signs.out;
  EXPECT_TRUE(test::says(signs.out, "[torque_sign] joint_2"));
  spoil(scaled("torques", v, joints, -1.0).plant);
  EXPECT_TRUE(test::says(validated("bad.csv").out, "no torque at all would be"));
}

TEST_F(PayloadTool, SendsNothingOfAMiswiredLogThatIsReplayed) {
  identify_arm();
  const auto replayed = [&](const std::string& log) {
    return test::outcome_of({RIVID_ONLINE, log, "--result", "arm", "--experiment", "six_axis.toml"},
                            folder_.path());
  };
  const Outcome good = replayed("heavy/log.csv");
  EXPECT_TRUE(has_line(good)) << good.out;
  spoil(scaled("torques", v, joints, 1.2).plant);
  const Outcome bad = replayed("bad.csv");
  EXPECT_TRUE(test::says(bad.out, ", not good"));
  EXPECT_FALSE(has_line(bad)) << bad.out;
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

// Taken and put down again within one log, which is that of the experiment too.
TEST_F(PayloadTool, DividesALogWhereTheGripperMoves) {
  std::string out;
  double begin = 0.0;
  double taken = 0.0;
  for (const char* const part : {"made/log.csv", "heavy/log.csv", "made/log.csv"}) {
    std::istringstream in(folder_.read(part));
    std::string line;
    std::getline(in, line);
    out += out.empty() ? line + '\n' : "";
    double time = 0.0;
    while (std::getline(in, line)) {
      const std::size_t comma = line.find(',');
      time = begin + std::stod(line.substr(0, comma));
      out += number(time, 12) + line.substr(comma) + '\n';
    }
    begin = time + 0.001;
    taken = taken > 0.0 ? taken : begin;
  }
  folder_.write("carry.csv", out);
  const std::string times = number(taken, 12) + ":" + number(2.0 * taken, 12);
  const Outcome run = payload({"--log", "carry.csv", "--loaded", "box=carry.csv@" + times});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_EQ(found().at("payloads").at(0).at("name"), "box");
  expect_two_kilograms(found().at("payloads").at(0));
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
  refused({"--loaded", heavy + "@soon"}, "\"soon\" must be the time in s at which the payload is taken");
  refused({"--loaded", heavy + "@3:2"}, "\"3:2\" must be the time");
  refused({"--loaded", heavy + "@900"}, "log.csv@900: the log, from 0 to ");
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
