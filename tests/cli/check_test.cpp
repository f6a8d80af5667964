// rivid check and explain: faults planted in the SCARA of data/scara are named by their code and
// their joint, and a sound experiment is told to be sound.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <sstream>

#include "rivid/finding.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class Check : public rivid::test::IdentifyTool {
 protected:
  [[nodiscard]] Json findings(int exit_code) const {
    const Outcome run = identify({"check", "scara.toml", "--json"});
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    EXPECT_EQ(run.err, "");
    return Json::parse(run.out);
  }

  // A finding that makes an identification useless.
  void expect_error(std::string_view code, std::string_view subject) const {
    const Json report = findings(1);
    EXPECT_EQ(report.at("usable"), false);
    expect_finding(report, "error", code, subject);
    // The identification alone says so too, where it does not refuse the log.
    const Outcome run = identify({"scara.toml", "--quiet"});
    EXPECT_NE(run.exit_code, 0) << run.err;
    if (run.exit_code == 1) {
      const Json result = Json::parse(folder().read("scara_result/result.json"));
      EXPECT_NE(result.at("status"), "identified");
      expect_finding({{"findings", result.at("warnings")}}, "error", code, subject);
    }
  }

  static void expect_finding(const Json& report, std::string_view severity, std::string_view code,
                             std::string_view subject) {
    for (const Json& f : report.at("findings")) {
      if (f.at("severity") == severity && f.at("code") == code && f.at("subject") == subject) {
        EXPECT_NE(f.at("text"), "");
        return;
      }
    }
    ADD_FAILURE() << "no " << severity << " " << code << " of " << subject << " in " << report.dump(1);
  }

  void expect_sound() const {
    const Json report = findings(0);
    EXPECT_EQ(report.at("errors"), 0) << report.dump(1);
    EXPECT_EQ(report.at("warnings"), 0) << report.dump(1);
    EXPECT_EQ(report.at("usable"), true);
  }

  void replace(std::string_view from, std::string_view to) const { edit("scara.toml", from, to); }

  // Instrumental variables, by the controller that made the logs.
  void follow_the_reference() const {
    replace("name = \"wls\"",
            "name = \"iv\"\n\n[control]\nlaw = \"pd\"\nomega_n = [1, 10]\nzeta = 1\nrate_hz = 200\n"
            "velocity_filter = \"backward\"");
  }

  // Changes the rows of the log; the columns are t q1 q2 v1 v2 qref1 qref2.
  void rewrite(const std::function<void(std::vector<double>&)>& change) const {
    std::istringstream in(folder().read("scara_s2.csv"));
    std::ostringstream out;
    out.precision(17);
    std::string line;
    std::getline(in, line);
    out << line << '\n';
    while (std::getline(in, line)) {
      std::vector<double> row;
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) {
        row.push_back(std::strtod(cell.c_str(), nullptr));
      }
      change(row);
      for (std::size_t c = 0; c < row.size(); ++c) {
        out << (c == 0 ? "" : ",") << row[c];
      }
      out << '\n';
    }
    folder().write("scara_s2.csv", out.str());
  }
};

TEST_F(Check, FindsNothingInASoundExperiment) { expect_sound(); }

TEST_F(Check, FindsNothingInOtherMotionsOfThatRobot) {
  replace("files = [\"scara_s2.csv\"]", "files = [\"scara_s2.csv\", \"scara_validation.csv\"]");
  const Json report = findings(0);
  EXPECT_EQ(report.at("errors"), 0) << report.dump(1);
  EXPECT_EQ(report.at("warnings"), 1) << "that one of them is to validate, too: " << report.dump(1);
  EXPECT_NE(report.dump().find("validation_log_used"), std::string::npos);
}

TEST_F(Check, HardlyMoreRowsThanParametersAreDoubted) {
  const Json result = result_of({"scara.toml", "--set", "signal.window=[1, 1.6]"}, 1);
  EXPECT_EQ(result.at("status"), "doubtful");
  expect_finding({{"findings", result.at("warnings")}}, "error", "few_rows", "all joints");
}

TEST_F(Check, NamesExchangedTorques) {
  replace("control = [\"v1\", \"v2\"]", "control = [\"v2\", \"v1\"]");
  expect_error("torque_order", "joint_1 and joint_2");
}

TEST_F(Check, NamesExchangedPositions) {
  replace("position = [\"q1\", \"q2\"]", "position = [\"q2\", \"q1\"]");
  expect_error("position_order", "joint_1 and joint_2");
}

TEST_F(Check, NamesExchangedJoints) {
  replace("position = [\"q1\", \"q2\"]", "position = [\"q2\", \"q1\"]");
  replace("control = [\"v1\", \"v2\"]", "control = [\"v2\", \"v1\"]");
  expect_error("joint_order", "joint_1 and joint_2");
}

TEST_F(Check, NamesATorqueWithTheWrongSign) {
  replace("\"v1\"", "{ column = \"v1\", sign = -1 }");
  expect_error("torque_sign", "joint_1");
  EXPECT_NE(identify({"check", "scara.toml"}).out.find("; in [log]: control = [\"v1\", \"v2\"]"),
            std::string::npos);
}

TEST_F(Check, NamesAllTorquesWithTheWrongSign) {
  replace("\"v1\", \"v2\"", "{ column = \"v1\", sign = -1 }, { column = \"v2\", sign = -1 }");
  expect_error("torque_sign", "all joints");
}

TEST_F(Check, NamesAPositionWithTheWrongSign) {
  rewrite([](std::vector<double>& row) { row[2] *= -1.0; });
  expect_error("position_sign", "joint_2");
  const Outcome run = identify({"check", "scara.toml"});
  EXPECT_NE(run.out.find("; in [log]: position = [\"q1\", { column = \"q2\", sign = -1 }]"),
            std::string::npos)
      << run.out;
}

TEST_F(Check, NamesDegreesThatAreTakenForRadians) {
  rewrite([](std::vector<double>& row) { row[2] *= 180.0 / M_PI; });
  expect_error("position_unit", "joint_2");
}

TEST_F(Check, NamesAnotherUnitOfTheTorque) {
  rewrite([](std::vector<double>& row) {
    row[3] *= 1e3;
    row[4] *= 1e3;
  });
  expect_error("torque_unit", "joint_1");
  expect_error("torque_unit", "joint_2");
}

TEST_F(Check, NamesATorqueThatIsTooSmallForItsFriction) {
  replace("control = [\"v1\", \"v2\"]", "control = [\"v1\", \"v2\"]\nunits = { control = \"mV\" }");
  expect_error("torque_unit", "all joints");
}

TEST_F(Check, NamesADelayOfTheTorqueToASample) {
  replace("control = [\"v1\", \"v2\"]", "control = [\"v1\", \"v2\"]\ntorque_lag = -20");
  const Json report = findings(1);
  expect_finding(report, "error", "torque_delay", "all joints");
  // The delay that this log has by itself is below two samples.
  const auto of_delay = std::ranges::find_if(report.at("findings"),
                                             [](const Json& f) { return f.at("code") == "torque_delay"; });
  const std::string text = of_delay->at("text");
  const int samples = std::atoi(text.substr(text.find("are ") + 4).c_str());
  EXPECT_NEAR(samples, 20, 2) << text;
}

TEST_F(Check, NamesASaturatedTorque) {
  rewrite([](std::vector<double>& row) { row[3] = std::clamp(row[3], -4.0, 4.0); });
  const Json found = findings(1);  // 17 % of it are not there
  expect_finding(found, "warning", "torque_saturated", "joint_1");
  expect_finding(found, "error", "poor_fit", "joint_1");
}

TEST_F(Check, NamesATorqueThatIsNotConnected) {
  rewrite([](std::vector<double>& row) { row[4] = 0.25; });
  const Json found = findings(1);
  expect_finding(found, "warning", "dead_torque", "joint_2");
  expect_finding(found, "note", "not_tested", "all joints");
  // The rows of the first joint tell all but the friction of the second one.
  expect_finding(found, "error", "not_excited", "Fv2");
  expect_finding(found, "error", "not_excited", "Fc2");
  EXPECT_EQ(found.at("errors"), 3);
}

TEST_F(Check, NamesAJointThatNeverMoves) {
  rewrite([](std::vector<double>& row) {
    row[2] = 0.3 + 1e-5 * std::sin(1e4 * row[0]);
    row[6] = 0.3;
    row[4] = 0.01 * std::sin(7.0 * row[0]);
  });
  expect_error("joint_still", "joint_2");
}

TEST_F(Check, NamesARobotAtRest) {
  rewrite([](std::vector<double>& row) {
    for (const std::size_t column : {1U, 2U}) {
      row[column] = 0.2 + 1e-5 * std::sin(1e4 * row[0] + static_cast<double>(column));
    }
  });
  expect_error("at_rest", "all joints");
}

TEST_F(Check, NamesTheReferenceOfAnotherLog) {
  replace("reference = [\"qref1\", \"qref2\"]",
          "reference_file = { file = \"scara_validation.csv\", position = [\"qref1\", \"qref2\"] }");
  // Least squares do not use it: no error of theirs.
  expect_finding(findings(0), "warning", "reference_unlike", "joint_1");
  follow_the_reference();
  expect_finding(findings(1), "error", "reference_mismatch", "joint_1");
  expect_finding(findings(1), "error", "reference_mismatch", "joint_2");
}

TEST_F(Check, NamesAReferenceInAnotherUnit) {
  rewrite([](std::vector<double>& row) { row[6] *= 180.0 / M_PI; });
  expect_finding(findings(0), "warning", "reference_unlike", "joint_2");
  follow_the_reference();
  expect_finding(findings(1), "error", "reference_unit", "joint_2");
}

TEST_F(Check, NamesAReferenceThatComesAfterItsMotion) {
  rewrite([](std::vector<double>& row) {
    row[5] = row[1];
    row[6] = row[2];
  });
  replace("reference = [\"qref1\", \"qref2\"]",
          "reference_file = { file = \"late.csv\", position = [\"qref1\", \"qref2\"], outside = \"hold\", "
          "delay = 0.25 }");
  folder().write("late.csv", folder().read("scara_s2.csv"));
  expect_finding(findings(0), "warning", "reference_leads", "all joints");
}

TEST_F(Check, NamesAClockThatIsTooSlow) {
  replace("time = \"t\"", "rate_hz = 20");
  replace("cutoff_hz = 20", "cutoff_hz = 2");
  expect_error("time_scale", "all joints");
}

TEST_F(Check, NamesVelocitiesOfAnotherColumn) {
  replace("position = [\"q1\", \"q2\"]", "position = [\"q1\", \"q2\"]\nvelocity = [\"qref1\", \"qref2\"]");
  const Json report = findings(0);
  expect_finding(report, "warning", "velocity_mismatch", "joint_1");
  expect_finding(report, "warning", "velocity_mismatch", "joint_2");
}

TEST_F(Check, NamesACutoffFarBelowTheMotion) {
  replace("cutoff_hz = 20", "cutoff_hz = 0.3");
  expect_error("cutoff_low", "joint_2");
}

TEST_F(Check, NamesAMissingFilterOnlyForLeastSquares) {
  replace("cutoff_hz = 20", "cutoff_hz = \"off\"");
  expect_sound();  // the window of the decimation takes the noise away
  replace("decimation = 20\n", "");
  expect_sound();  // a window that the noise asks for does so too
  replace("cutoff_hz = \"off\"", "cutoff_hz = \"off\"\ndecimation = 1");
  const Json found = findings(1);  // noise makes the inertias far too small
  expect_finding(found, "warning", "cutoff_high", "joint_1");
  expect_finding(found, "error", "poor_fit", "joint_1");
  replace("name = \"wls\"", "name = \"iv\"");
  folder().write("scara.toml", folder().read("scara.toml") +
                                   "\n[control]\nlaw = \"pd\"\nomega_n = [1, 10]\nzeta = 1\nrate_hz = 200\n");
  expect_finding(findings(0), "note", "cutoff_high_iv", "joint_1");
}

TEST_F(Check, NamesALogThatCountsTwice) {
  folder().write("copy.csv", folder().read("scara_s2.csv"));
  replace("files = [\"scara_s2.csv\"]", "files = [\"scara_s2.csv\", \"copy.csv\"]");
  const Json report = findings(0);
  const auto twice = std::ranges::find_if(report.at("findings"),
                                          [](const Json& f) { return f.at("code") == "duplicate_log"; });
  ASSERT_NE(twice, report.at("findings").end());
  EXPECT_EQ(twice->at("severity"), "warning");
  EXPECT_TRUE(twice->at("subject").get<std::string>().ends_with("copy.csv")) << *twice;
}

TEST_F(Check, NamesTwoJointsWithOneColumn) {
  rewrite([](std::vector<double>& row) { row[2] = row[1]; });
  expect_error("duplicate_column", "joint_2");
}

TEST_F(Check, NamesPositionsBeyondTheLimits) {
  rewrite([](std::vector<double>& row) { row[1] += 3.0; });
  expect_finding(findings(0), "warning", "position_limits", "joint_1");
}

TEST_F(Check, SaysWhichZeroWouldKeepTheLimits) {
  edit("scara.urdf", "lower=\"-3.5\" upper=\"3.5\"", "lower=\"-2.2\" upper=\"2\"");
  rewrite([](std::vector<double>& row) { row[1] += 1.5707963; });
  const Json report = findings(0);
  const auto limits = std::ranges::find_if(report.at("findings"),
                                           [](const Json& f) { return f.at("code") == "position_limits"; });
  ASSERT_NE(limits, report.at("findings").end());
  EXPECT_NE(limits->at("text").get<std::string>().find("within them with offset = -1.5708"),
            std::string::npos)
      << *limits;
}

TEST_F(Check, NamesASignalChainThatLeavesNothing) {
  replace("trim = 20", "trim = 2000");
  expect_error("rows_unusable", "signal");
}

TEST_F(Check, NamesParametersThatDoNotShow) {
  // Joint 2 alone moves: the inertia of joint 1 stays unseen.
  rewrite([](std::vector<double>& row) {
    row[1] = 1e-5 * std::sin(1e4 * row[0]);
    row[3] = 0.01 * std::sin(7.0 * row[0]);
  });
  expect_error("joint_still", "joint_1");
}

TEST_F(Check, PrintsOneLineAFinding) {
  replace("\"v1\"", "{ column = \"v1\", sign = -1 }");
  const Outcome run = identify({"check", "scara.toml"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(run.out.starts_with("error [torque_sign] joint_1: ")) << run.out;
  EXPECT_NE(run.out.find("Set sign = -1"), std::string::npos) << run.out;
}

TEST_F(Check, TellsBadInputByItsExitCode) {
  const Outcome run = identify({"check", "absent.toml"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.out, "");
  EXPECT_TRUE(run.err.starts_with("rivid_identify: error: ")) << run.err;
}

TEST_F(Check, WritesNothing) {
  const std::vector<std::string> before = folder().entries();
  (void)findings(0);
  EXPECT_EQ(folder().entries(), before);
}

using Try = Check;

TEST_F(Try, TakesAHintAndWritesTheExperiment) {
  replace("control = [\"v1\", \"v2\"]", "control = [\"v1\", { column = \"v2\", sign = -1 }]  # motors");
  const Outcome run = identify({"try", "torque_sign", "scara.toml", "--json", "--write", "mended.toml"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const Json trial = Json::parse(run.out);
  EXPECT_EQ(trial.at("helps"), true);
  EXPECT_EQ(trial.at("finding").at("subject"), "joint_2");
  EXPECT_LT(trial.at("after").at("held_out"), 0.1 * trial.at("before").at("held_out").get<double>());
  EXPECT_EQ(trial.at("lines"), Json({"[log]", "control = [\"v1\", { column = \"v2\" }]"}));
  EXPECT_NE(folder().read("mended.toml").find("{ column = \"v2\" }]  # motors"), std::string::npos);
  EXPECT_EQ(result_of({"mended.toml", "--output", "scara_result"}).at("status"), "identified");
  // A file of somebody's own stays, as does one whose hint would not help.
  EXPECT_EQ(identify({"try", "torque_sign", "scara.toml", "--write", "scara.toml"}).exit_code, 2);
  const Outcome none = identify({"try", "torque_sign", "mended.toml"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("has no finding \"torque_sign\""), std::string::npos) << none.err;
}

TEST_F(Try, ComparesHalvesWithoutAValidation) {
  replace("control = [\"v1\", \"v2\"]", "control = [\"v2\", \"v1\"]");
  replace("[validation]\nfiles = [\"scara_validation.csv\"]\n", "");
  const Outcome run = identify({"try", "torque_order", "scara.toml", "--of", "joint_1 and joint_2"});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("control = [\"v1\", \"v2\"]"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("unknown"), std::string::npos) << run.out;
}

using Explain = Check;

TEST_F(Explain, TellsCauseAndCureOfEveryCode) {
  const Outcome list = identify({"explain"});
  EXPECT_EQ(list.exit_code, 0);
  for (const rivid::DiagnosticCode& code : rivid::diagnostic_codes()) {
    EXPECT_NE(list.out.find(std::string(code.code) + " "), std::string::npos) << code.code;
    const Outcome one = identify({"explain", std::string(code.code)});
    EXPECT_EQ(one.exit_code, 0) << one.err;
    for (const std::string_view part : {code.meaning, code.cause, code.cure}) {
      EXPECT_NE(one.out.find(part), std::string::npos) << one.out;
    }
  }
}

TEST_F(Explain, SuggestsTheNearestCode) {
  const Outcome run = identify({"explain", "torque_sing"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("did you mean \"torque_sign\"?"), std::string::npos) << run.err;
}

}  // namespace
