// rivid export: an identified robot as a model for other programs, and as a C header.

#include <gtest/gtest.h>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/input.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class Export : public rivid::test::IdentifyTool {
 protected:
  // After an identification with physically consistent parameters, or with other options.
  [[nodiscard]] Outcome exported(const std::vector<std::string>& arguments,
                                 const std::vector<std::string>& options = {"--physical"}) const {
    std::vector<std::string> identification = {"scara.toml", "--quiet"};
    identification.insert(identification.end(), options.begin(), options.end());
    EXPECT_LE(identify(identification).exit_code, 1);
    return exported_again(arguments);
  }
  [[nodiscard]] Outcome exported_again(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command = {"export", "scara_result", "--to"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return identify(command);
  }

  [[nodiscard]] bool exists(const std::string& file) const {
    return std::filesystem::exists(folder().path() / file);
  }

  // Joint 2 stands still, and the log does not determine its parameters.
  void hold_joint_2() const {
    rewrite_rows("scara_s2.csv", [](const std::string& line) {
      std::vector<std::string> cells(1);
      for (const char c : line) {
        c == ',' ? cells.emplace_back() : (cells.back() += c, cells.back());
      }
      cells[2] = "0.5";
      std::string out;
      for (const std::string& cell : cells) {
        out += (out.empty() ? "" : ",") + cell;
      }
      return out;
    });
    edit("scara.toml", "trim = 20 ", "rows = \"paper\"\ntrim = 20 ");
  }
};

TEST_F(Export, TheUrdfHasTheIdentifiedBaseParameters) {
  const Outcome run = exported({"urdf", "--output", "new/out.urdf"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.err.ends_with("wrote new/out.urdf\n")) << run.err;
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  edit("scara.toml", "\"scara.urdf\"", "\"new/out.urdf\"");
  const rivid::Robot robot = rivid::read_experiment(folder().path() / "scara.toml").robot;
  const rivid::BaseParameters base = rivid::base_parameters(robot);
  const rivid::Vector chi = base.from_standard(robot.chi_st());
  ASSERT_EQ(result["parameters"].size(), static_cast<std::size_t>(base.size()));
  for (std::size_t i = 0; i < base.parameters.size(); ++i) {
    const double value = result["physical"]["chi"][i];
    const double sigma = result["parameters"][i]["sigma"];
    EXPECT_NEAR(value, result["parameters"][i]["value"].get<double>(), sigma) << base.parameters[i].name;
    // Roundings of the step to the centre of mass and back.
    EXPECT_NEAR(chi[static_cast<rivid::Index>(i)], value, 1e-12 * std::abs(value)) << base.parameters[i].name;
  }
}

TEST_F(Export, TheDifferenceIsPrintedAndNamesTheNumbersAlone) {
  const std::string before = folder().read("scara.urdf");
  const Outcome run = exported({"urdf", "--output", "out.urdf", "--diff"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, rivid::unified_diff(before, folder().read("out.urdf"), "scara.urdf", "out.urdf"));
  EXPECT_NE(
      run.out.find("-    <dynamics damping=\"0.03\" friction=\"0.82\"/>\n+    <dynamics damping=\"0.0247"),
      std::string::npos)
      << run.out;
  // Inertias and centres of mass, and friction, of two links; the comment on top.
  EXPECT_LE(std::ranges::count(run.out, '\n'), 50);
  EXPECT_EQ(folder().read("scara.urdf"), before);
}

TEST_F(Export, EachFormatIsCalledAfterTheRobotBesideTheResult) {
  EXPECT_EQ(exported({"mjcf", "--quiet"}).exit_code, 0);
  for (const char* const format : {"sdf", "drake", "pinocchio", "urdf", "header"}) {
    const Outcome run = exported_again({format, "--quiet"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out + run.err, "");
  }
  const auto written = [&](const std::string& ending) {
    return folder().read("scara_result/scara_identified" + ending);
  };
  EXPECT_NE(written(".xml").find("<default class=\"joint_2\">"), std::string::npos);
  EXPECT_NE(written(".sdf").find("<gravity>"), std::string::npos);
  EXPECT_NE(written("_drake.urdf").find("<drake:rotor_inertia value=\"0\"/>"), std::string::npos);
  EXPECT_NE(written("_drake.py").find("def load(plant):"), std::string::npos);
  EXPECT_NE(written("_pinocchio.srdf").find("<rotor_params>"), std::string::npos);
  EXPECT_NE(written("_pinocchio.py").find("def inverse_dynamics("), std::string::npos);
  EXPECT_NE(written("_pinocchio.urdf").find("<inertial>"), std::string::npos);
  EXPECT_NE(written(".urdf").find("<inertial>"), std::string::npos);
  EXPECT_NE(written(".h").find("static inline void scara_identified_inverse_dynamics("), std::string::npos);
}

TEST_F(Export, WhatAFormatDoesNotHaveIsNamedInTheFileAndOnTheScreen) {
  const Outcome run = exported({"drake"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string sentence =
      "MultibodyPlant has no friction but damping: friction_left_out() of scara_identified_drake.py has the "
      "rest";
  EXPECT_NE(run.err.find("warning [format_has_no_place] " + sentence), std::string::npos) << run.err;
  for (const char* const ending : {".urdf", ".py"}) {
    const std::string text = folder().read(std::string("scara_result/scara_identified_drake") + ending);
    EXPECT_NE(text.find(sentence), std::string::npos) << text;
  }
}

TEST_F(Export, AResultThatIsNotIdentifiedIsNotWrittenUnlessForced) {
  hold_joint_2();
  const Outcome refused = exported({"urdf", "--output", "out.urdf"});
  EXPECT_EQ(refused.exit_code, 1) << refused.err;
  EXPECT_NE(refused.err.find("error [rank_deficient] the result is rank_deficient, not identified\n"
                             "rivid export: out.urdf is not written; --force does it nevertheless\n"),
            std::string::npos)
      << refused.err;
  EXPECT_FALSE(exists("out.urdf"));
  const Outcome forced = exported_again({"urdf", "--output", "out.urdf", "--force"});
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
  EXPECT_TRUE(exists("out.urdf"));
}

TEST_F(Export, AUrdfFarFromTheRobotGetsBodiesAllTheSame) {
  edit("scara.urdf", "<mass value=\"2\"/>", "<mass value=\"1e-3\"/>");
  edit("scara.urdf", "<origin xyz=\"0.121 0.007 0\" rpy=\"0 0 0\"/>", "<origin xyz=\"0 0 0\"/>");
  edit("scara.urdf", "ixx=\"0.006\" ixy=\"0\" ixz=\"0\" iyy=\"0.031\" iyz=\"0\" izz=\"0.03262\"",
       "ixx=\"1e-6\" ixy=\"0\" ixz=\"0\" iyy=\"1e-6\" iyz=\"0\" izz=\"1e-6\"");
  const Outcome identification = identify({"scara.toml", "--physical"});
  EXPECT_NE(identification.err.find("with which the logs predict their own blocks of time best"),
            std::string::npos)
      << identification.err;
  const Outcome run = exported_again({"urdf"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err.find("no body has its inertia"), std::string::npos) << run.err;
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  // The description pulls no more than the logs themselves bear out.
  EXPECT_LT(result["physical"]["fit"]["relative_error"],
            1.06 * result["fit"]["relative_error"].get<double>());
  EXPECT_LT(result["physical"]["options"]["weight"], 1.0);
}

TEST_F(Export, ADryRunTellsTheFilesAndWritesNone) {
  EXPECT_EQ(identify({"scara.toml", "--physical"}).exit_code, 0);
  const auto before = folder().entries();
  const Outcome run = exported_again({"pinocchio", "--dry-run", "--output", "out.urdf"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "would write out.urdf\nwould write out.srdf\nwould write out.py\n");
  EXPECT_EQ(folder().entries(), before);
}

TEST_F(Export, NeedsPhysicallyConsistentParametersSaveForAHeader) {
  EXPECT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  expect_refused(
      {"scara_result/result.json: the result has no physically consistent parameters; identify with "
       "--physical"},
      {"export", "scara_result", "--to", "mjcf"});
  EXPECT_EQ(exported_again({"header"}).exit_code, 0);
}

TEST_F(Export, NeedsTheUrdfThatTheRobotWasReadFrom) {
  EXPECT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  const std::string urdf = folder().read("scara.urdf");
  folder().write("scara.urdf", urdf + "\n");
  expect_refused({"scara.urdf: has changed since scara_result/result.json was made from it"},
                 {"export", "scara_result", "--to", "mjcf"});
  EXPECT_EQ(exported_again({"mjcf", "--urdf", "scara.urdf"}).exit_code, 0);
  std::filesystem::rename(folder().path() / "scara.urdf", folder().path() / "moved.urdf");
  expect_refused({"its URDF scara.urdf is not there; --urdf says where it is now"},
                 {"export", "scara_result", "--to", "urdf"});
  EXPECT_EQ(exported_again({"urdf", "--urdf", "moved.urdf"}).exit_code, 0);
}

TEST_F(Export, NeedsARobotThatComesFromAUrdf) {
  folder().write("table.csv", "joint,type,alpha,a,d,theta\njoint_1,R,0,0,0,0\njoint_2,R,0,0.5,0,0\n");
  edit("scara.toml", "urdf = \"scara.urdf\"", "mdh = \"table.csv\"");
  EXPECT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  expect_refused({"does not say which URDF its robot comes from",
                  "--urdf ROBOT.urdf names it, --to header does without"},
                 {"export", "scara_result", "--to", "sdf"});
}

TEST_F(Export, RefusesFlagsThatDoNotGoTogether) {
  EXPECT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  expect_refused({"--to urdf"}, {"export", "scara_result", "--to", "mjcf", "--diff"});
  expect_refused({"--to", "gazebo"}, {"export", "scara_result", "--to", "gazebo"});
  expect_refused({"--to is required"}, {"export", "scara_result"});
}

TEST_F(Export, TheHeaderIsCalledAfterItsFile) {
  const Outcome run = exported({"header", "--output", "my-scara.h"}, {});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string header = folder().read("my-scara.h");
  EXPECT_TRUE(header.starts_with("/* Torques of a robot, written by rivid: IDIM-WLS of scara.toml, run "))
      << header;
  EXPECT_NE(header.find("static inline void my_scara_inverse_dynamics("), std::string::npos);
}

TEST_F(Export, TheHeaderHasThePhysicalParametersWhereTheyWereAskedFor) {
  const Outcome run = exported({"header", "--output", "scara.h"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string header = folder().read("scara.h");
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  const std::string origin = "IDIM-WLS of scara.toml, physically consistent parameters, run " +
                             result["provenance"]["run"].get<std::string>();
  EXPECT_NE(header.find(origin + ".\n"), std::string::npos) << header;
  const rivid::DynamicModel model =
      rivid::read_identified_model(folder().path() / "scara_result/result.json");
  EXPECT_EQ(header, rivid::c_header(model, "scara", origin));
}

TEST_F(Export, AControllerCanReadTheResult) {
  const Json result = result_of();
  rivid::InverseDynamics dynamics(rivid::read_identified_model(folder().path() / "scara_result/result.json"));
  const rivid::Vector zero = rivid::Vector::Zero(2);
  rivid::Vector tau(2);
  dynamics.torque(zero, zero, rivid::Vector::Unit(2, 0), tau);
  // M11 at q = 0, where link 2 is stretched along x: ZZ1R + ZZ2 + 2 L MX2.
  const double expected = rivid::test::parameter(result, "ZZ1R")["value"].get<double>() +
                          rivid::test::parameter(result, "ZZ2")["value"].get<double>() +
                          rivid::test::parameter(result, "MX2")["value"].get<double>();
  EXPECT_NEAR(tau[0], expected, 1e-14 * 64);
}

TEST_F(Export, SamplesAreNamedByTheirManifestAndComeAgainWithTheirSeed) {
  const Outcome run = exported({"mjcf", "--samples", "3", "--seed", "7", "--output", "a/arm.xml"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json manifest = Json::parse(folder().read("a/arm_samples.json"));
  EXPECT_EQ(manifest["seed"], 7);
  EXPECT_EQ(manifest["count"], 3);
  EXPECT_EQ(manifest["result"]["sha256"], rivid::sha256(folder().read("scara_result/result.json")));
  ASSERT_EQ(manifest["outputs"].size(), 4U);
  EXPECT_EQ(manifest["outputs"][2]["path"], "arm_002.xml");
  for (const Json& file : manifest["outputs"]) {
    const std::string text = folder().read("a/" + file["path"].get<std::string>());
    EXPECT_EQ(file["sha256"], rivid::sha256(text)) << file["path"];
  }
  EXPECT_EQ(exported_again({"mjcf", "--samples", "3", "--seed", "7", "--output", "b/arm.xml"}).exit_code, 0);
  EXPECT_EQ(exported_again({"mjcf", "--samples", "3", "--seed", "8", "--output", "c/arm.xml"}).exit_code, 0);
  EXPECT_EQ(folder().read("a/arm_samples.json"), folder().read("b/arm_samples.json"));
  EXPECT_EQ(folder().read("a/arm_001.xml"), folder().read("b/arm_001.xml"));
  EXPECT_NE(folder().read("a/arm_001.xml"), folder().read("c/arm_001.xml"));
}

// The interval of a parameter by 400 draws is that of the result, but for what they scatter by.
TEST_F(Export, RangesAreTheIntervalsOfTheResult) {
  EXPECT_EQ(exported({"npz", "--samples", "400", "--output", "arm.npz"}).exit_code, 0);
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  const Json ranges = Json::parse(folder().read("arm_ranges.json"));
  for (const auto& [parameter, joint] : {std::pair("Fc1", "joint_1"), std::pair("Fc2", "joint_2")}) {
    const Json interval = rivid::test::parameter(result, parameter)["interval_95"];
    const Json range = ranges["mujoco"]["dof_frictionloss"][joint];
    const double width = interval[1].get<double>() - interval[0].get<double>();
    EXPECT_NEAR(range[0], interval[0], 0.12 * width) << parameter;
    EXPECT_NEAR(range[1], interval[1], 0.12 * width) << parameter;
    const Json& term = ranges["isaac_lab"]["randomize_joint_parameters"][joint];
    EXPECT_EQ(term["friction_distribution_params"], range);
    EXPECT_EQ(term["operation"], "abs");
  }
  EXPECT_TRUE(folder().read("arm.npz").starts_with("PK"));
}

TEST_F(Export, SamplesNeedAFormatThatHoldsThem) {
  const Outcome none = exported({"npz"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("--to npz holds samples of the result's distribution; it needs --samples N"),
            std::string::npos)
      << none.err;
  EXPECT_EQ(exported_again({"header", "--samples", "2"}).exit_code, 2);
}

}  // namespace
