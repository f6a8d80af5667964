// The same motion written in other ways gives the same parameters.

#include <gtest/gtest.h>

#include <charconv>
#include <iomanip>
#include <numbers>
#include <sstream>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::expect_same_parameters;
using rivid::test::Json;
using rivid::test::parameter;

// Scaling a column and back costs a rounding; the condition number of 20 and the second difference, whose
// terms are 1e4 times its value, carry it into the result.
constexpr double rounding = 1e-9;

std::vector<double> cells(const std::string& line) {
  std::vector<double> out;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    out.push_back(std::stod(cell));
  }
  return out;
}

std::string joined(const std::vector<double>& values) {
  std::ostringstream out;
  out << std::setprecision(17);
  for (std::size_t i = 0; i < values.size(); ++i) {
    out << (i == 0 ? "" : ",") << values[i];
  }
  return out.str();
}

class LogFormat : public rivid::test::IdentifyTool {
 protected:
  static constexpr std::array<const char*, 2> logs = {"scara_s2.csv", "scara_validation.csv"};

  template <typename Rewrite>
  void rewrite_numbers(const Rewrite& rewrite) const {
    for (const char* const log : logs) {
      rewrite_rows(log, [&](const std::string& line) { return joined(rewrite(cells(line))); });
    }
  }
};

TEST_F(LogFormat, SemicolonsDecimalCommasAndCrlfChangeNothing) {
  const Json plain = result_of();
  for (const char* const log : logs) {
    std::string out;
    for (const char c : folder().read(log)) {
      out += c == ',' ? ";" : c == '.' ? "," : c == '\n' ? "\r\n" : std::string(1, c);
    }
    folder().write(log, out);
  }
  const Json result = result_of();
  EXPECT_EQ(result["parameters"], plain["parameters"]);
  EXPECT_EQ(result["validation"], plain["validation"]);
}

TEST_F(LogFormat, CrlfInTheExperimentFileChangesNothing) {
  const Json plain = result_of();
  std::string out;
  for (const char c : folder().read("scara.toml")) {
    out += c == '\n' ? "\r\n" : std::string(1, c);
  }
  folder().write("scara.toml", "\xEF\xBB\xBF" + out);
  EXPECT_EQ(result_of()["parameters"], plain["parameters"]);
}

TEST_F(LogFormat, ColumnsOfAFileWithoutHeaderGoByNumber) {
  const Json plain = result_of();
  for (const char* const log : logs) {
    const std::string text = folder().read(log);
    folder().write(log, text.substr(text.find('\n') + 1));
  }
  edit("scara.toml", R"(time = "t")", "time = 1");
  edit("scara.toml", R"(position = ["q1", "q2"])", "position = [2, 3]");
  edit("scara.toml", R"(control = ["v1", "v2"])", "control = [4, 5]");
  edit("scara.toml", R"(reference = ["qref1", "qref2"])", "reference = [6, 7]");
  EXPECT_EQ(result_of()["parameters"], plain["parameters"]);
}

TEST_F(LogFormat, TimeIsFoundByNameAndOtherColumnsMayHoldAnything) {
  const Json plain = result_of();
  edit("scara.toml", R"(time = "t")", "");
  for (const char* const log : logs) {
    bool header = true;
    std::istringstream in(folder().read(log));
    std::string out;
    for (std::string line; std::getline(in, line); header = false) {
      out += line + (header ? ",Überhitzung,note" : ",nan,all well") + "\n";
    }
    folder().write(log, out);
  }
  EXPECT_EQ(result_of()["parameters"], plain["parameters"]);
}

TEST_F(LogFormat, DegreesMillisecondsSignsAndScalesComeBackToSi) {
  const Json plain = result_of();
  rewrite_numbers([](std::vector<double> x) {
    x[0] *= 1e3;
    x[1] *= 180.0 / std::numbers::pi;
    x[2] *= -180.0 / std::numbers::pi;
    x[3] *= 1e3;
    x[4] /= -0.25;
    return x;
  });
  edit("scara.toml", R"(time = "t")", R"(time = { column = "t", unit = "ms" })");
  edit("scara.toml", R"(position = ["q1", "q2"])",
       "units = { position = \"deg\" }\nposition = [\"q1\", { column = \"q2\", sign = -1 }]");
  edit("scara.toml", R"(control = ["v1", "v2"])",
       R"(control = [{ column = "v1", unit = "mNm" }, { column = "v2", scale = 0.25, sign = -1 }])");
  expect_same_parameters(plain, result_of(), rounding);
}

TEST_F(LogFormat, AnOffsetOfAPositionIsInSiUnits) {
  const Json plain = result_of();
  rewrite_numbers([](std::vector<double> x) {
    x[2] -= 0.5;
    return x;
  });
  edit("scara.toml", R"(position = ["q1", "q2"])", R"(position = ["q1", { column = "q2", offset = 0.5 }])");
  expect_same_parameters(plain, result_of(), rounding);
}

TEST_F(LogFormat, TorquesEqualControlSignalsTimesDriveGains) {
  edit("scara.toml", "gravity =", "drive_gain = [35.15, 0.7]\ngear_ratio = [1.0, -3.0]\ngravity =");
  // The gear turns the torque round, which is doubted.
  const Json control = result_of({"scara.toml"}, 1);
  edit("scara.toml", R"(control = ["v1", "v2"])",
       R"(torque = [{ column = "v1", scale = 35.15 }, { column = "v2", scale = -2.1 }])");
  const Json torque = result_of({"scara.toml"}, 1);
  expect_same_parameters(control, torque, rounding);
  EXPECT_NEAR(control["fit"]["error_norm"].get<double>(), torque["fit"]["error_norm"].get<double>(),
              rounding * control["fit"]["error_norm"].get<double>());
}

TEST_F(LogFormat, AStatedRateReplacesTheTimeColumn) {
  const Json plain = result_of();
  edit("scara.toml", R"(time = "t")", "rate_hz = 200");
  expect_same_parameters(plain, result_of(), rounding);
}

// Rows are lost, as by a busy computer: what is resampled comes close to the whole log, what is ignored does
// not.
TEST_F(LogFormat, ResamplingRepairsMissingRowsAndIgnoringDoesNot) {
  const Json plain = result_of();
  std::istringstream in(folder().read("scara_s2.csv"));
  std::string out;
  int row = 0;
  for (std::string line; std::getline(in, line); ++row) {
    if (row == 0 || row % 23 != 0) {
      out += line + "\n";
    }
  }
  folder().write("scara_s2.csv", out);
  expect_refused(
      {"scara_s2.csv:24 (t = 0.115 s): the time stamps are irregular", "173 gaps of 173 missing rows"});

  edit("scara.toml", "\n\n[signal]", "\nirregular = \"resample\"\n\n[signal]");
  const Json resampled = result_of();
  edit("scara.toml", "\"resample\"", "\"ignore\"");
  const Json ignored = result_of();
  // Rows taken for others than they are leave a residual of their own, as large as that of the noise.
  const auto error = [](const Json& result) { return result["fit"]["relative_error"].get<double>(); };
  EXPECT_LT(error(resampled), 1.1 * error(plain));
  EXPECT_GT(error(ignored), 1.5 * error(plain));
  const double sigma = parameter(plain, "ZZ1R")["sigma"];
  EXPECT_NEAR(parameter(resampled, "ZZ1R")["value"].get<double>(),
              parameter(plain, "ZZ1R")["value"].get<double>(), sigma);
  EXPECT_NE(resampled["notes"].dump().find("resampled to 200 Hz"), std::string::npos) << resampled["notes"];
  EXPECT_NE(ignored["notes"].dump().find("time stamps ignored"), std::string::npos) << ignored["notes"];
}

// A log cut in motion loses its borders; the rest is other rows of the same motion, with other noise.
TEST_F(LogFormat, ALogCutInTwoGivesNearlyTheSameParameters) {
  edit("scara.toml", "trim = 20 ", "trim = \"auto\" ");
  const Json plain = result_of();
  const std::string log = folder().read("scara_s2.csv");
  const std::size_t end_of_header = log.find('\n') + 1;
  const std::size_t middle = log.find("\n10,") + 1;
  folder().write("first.csv", log.substr(0, middle));
  folder().write("second.csv", log.substr(0, end_of_header) + log.substr(middle));
  const Json both = result_of({"scara.toml", "--log", "first.csv", "second.csv"});
  for (const Json& p : plain["parameters"]) {
    const double sigma = p["sigma"];
    EXPECT_NEAR(parameter(both, p["name"].get<std::string>())["value"].get<double>(),
                p["value"].get<double>(), 2.0 * sigma)
        << p["name"];
  }
}

}  // namespace
