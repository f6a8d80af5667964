// What rivid_identify writes beside its result: a URDF, sidecars, a C header.

#include <gtest/gtest.h>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class WriteBack : public rivid::test::IdentifyTool {
 protected:
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

TEST_F(WriteBack, TheUrdfHasTheIdentifiedBaseParameters) {
  const Outcome run = identify({"scara.toml", "--write-urdf", "new/out.urdf"});
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

TEST_F(WriteBack, TheDifferenceIsPrintedAndNamesTheNumbersAlone) {
  const std::string before = folder().read("scara.urdf");
  const std::string table = identify({"scara.toml", "--physical"}).out;
  const Outcome run = identify({"scara.toml", "--write-urdf", "out.urdf", "--diff"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string diff = rivid::unified_diff(before, folder().read("out.urdf"), "scara.urdf", "out.urdf");
  EXPECT_EQ(run.out, table + diff);
  EXPECT_NE(diff.find("-    <dynamics damping=\"0.03\" friction=\"0.82\"/>\n+    <dynamics damping=\"0.0247"),
            std::string::npos)
      << diff;
  // Inertias and centres of mass, and friction, of two links.
  EXPECT_LE(std::ranges::count(diff, '\n'), 40);
  EXPECT_EQ(folder().read("scara.urdf"), before);
}

TEST_F(WriteBack, SidecarsStandBesideTheUrdf) {
  const Outcome run = identify(
      {"scara.toml", "--write-urdf", "out.urdf", "--sidecar", "mujoco", "drake", "pinocchio", "--quiet"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  EXPECT_NE(folder().read("out.mujoco.xml").find("<default class=\"joint_2\">"), std::string::npos);
  EXPECT_NE(folder().read("out.drake.xml").find("<drake:rotor_inertia value=\"0\"/>"), std::string::npos);
  EXPECT_NE(folder().read("out.srdf").find("<rotor_params>"), std::string::npos);
}

TEST_F(WriteBack, AResultThatIsNotIdentifiedIsNotWrittenUnlessForced) {
  hold_joint_2();
  const Outcome refused = identify({"scara.toml", "--write-urdf", "out.urdf", "--write-header", "out.h"});
  EXPECT_EQ(refused.exit_code, 1) << refused.err;
  EXPECT_NE(refused.err.find("error [rank_deficient] the result is rank_deficient, not identified\n"
                             "rivid_identify: out.urdf is not written; --force does it nevertheless\n"),
            std::string::npos)
      << refused.err;
  EXPECT_TRUE(exists("scara_result/result.json"));
  EXPECT_FALSE(exists("out.urdf"));
  EXPECT_FALSE(exists("out.h"));
  const Outcome forced =
      identify({"scara.toml", "--write-urdf", "out.urdf", "--write-header", "out.h", "--force"});
  EXPECT_EQ(forced.exit_code, 1) << forced.err;
  EXPECT_TRUE(exists("out.urdf"));
  EXPECT_TRUE(exists("out.h"));
}

TEST_F(WriteBack, AUrdfFarFromTheRobotGetsBodiesAllTheSame) {
  edit("scara.urdf", "<mass value=\"2\"/>", "<mass value=\"1e-3\"/>");
  edit("scara.urdf", "<origin xyz=\"0.121 0.007 0\" rpy=\"0 0 0\"/>", "<origin xyz=\"0 0 0\"/>");
  edit("scara.urdf", "ixx=\"0.006\" ixy=\"0\" ixz=\"0\" iyy=\"0.031\" iyz=\"0\" izz=\"0.03262\"",
       "ixx=\"1e-6\" ixy=\"0\" ixz=\"0\" iyy=\"1e-6\" iyz=\"0\" izz=\"1e-6\"");
  const Outcome run = identify({"scara.toml", "--write-urdf", "out.urdf"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err.find("no body has its inertia"), std::string::npos) << run.err;
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  // The description pulls no more than the logs themselves bear out.
  EXPECT_LT(result["physical"]["fit"]["relative_error"],
            1.06 * result["fit"]["relative_error"].get<double>());
  EXPECT_LT(result["physical"]["options"]["weight"], 1.0);
  EXPECT_NE(run.err.find("with which the logs predict their own blocks of time best"), std::string::npos)
      << run.err;
}

TEST_F(WriteBack, ADryRunTellsTheFilesAndWritesNone) {
  const auto before = folder().entries();
  const Outcome run = identify({"scara.toml", "--dry-run", "--write-urdf", "out.urdf", "--sidecar",
                                "pinocchio", "--write-header", "robot.h"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(
      run.out.ends_with("would write scara_result/result.json\nwould write out.urdf\nwould write out.srdf\n"
                        "would write robot.h\n"))
      << run.out;
  EXPECT_EQ(folder().entries(), before);
}

TEST_F(WriteBack, NeedsARobotThatComesFromAUrdf) {
  folder().write("table.csv", "joint,type,alpha,a,d,theta\njoint_1,R,0,0,0,0\njoint_2,R,0,0.5,0,0\n");
  edit("scara.toml", "urdf = \"scara.urdf\"", "mdh = \"table.csv\"");
  expect_refused({"--write-urdf: the robot comes from table.csv, which is no URDF"},
                 {"scara.toml", "--write-urdf", "out.urdf"});
}

TEST_F(WriteBack, RefusesFlagsThatDoNotGoTogether) {
  expect_refused({"--write-urdf"}, {"scara.toml", "--diff"});
  expect_refused({"--write-urdf"}, {"scara.toml", "--sidecar", "drake"});
  expect_refused({"--sidecar", "gazebo"}, {"scara.toml", "--write-urdf", "out.urdf", "--sidecar", "gazebo"});
  expect_refused({"--json"}, {"scara.toml", "--write-urdf", "out.urdf", "--diff", "--json"});
}

TEST_F(WriteBack, TheHeaderIsCalledAfterItsFile) {
  const Outcome run = identify({"scara.toml", "--write-header", "my-scara.h"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string header = folder().read("my-scara.h");
  EXPECT_TRUE(header.starts_with("/* Torques of a robot, written by rivid: IDIM-WLS of scara.toml, run "))
      << header;
  EXPECT_NE(header.find("static inline void my_scara_inverse_dynamics("), std::string::npos);
}

TEST_F(WriteBack, TheHeaderHasThePhysicalParametersWhereTheyWereAskedFor) {
  const Outcome run = identify({"scara.toml", "--physical", "--write-header", "scara.h"});
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

TEST_F(WriteBack, AControllerCanReadTheResult) {
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

}  // namespace
