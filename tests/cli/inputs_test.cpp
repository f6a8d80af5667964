// Each file is read once: what others do with it meanwhile neither ends a run nor mixes two versions in one
// result.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "rivid/input.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::Process;

class Inputs : public rivid::test::IdentifyTool {
 protected:
  // Through a shell, which ends what hangs.
  [[nodiscard]] Outcome shell(const std::string& script) const {
    return outcome_of({"/bin/sh", "-c", "timeout 300 " + script}, folder().path());
  }
  std::string tool = "'" + std::string(RIVID_IDENTIFY) + "' ";
};

TEST_F(Inputs, MayBeALogFromStandardInput) {
  const Json of_file = result_of({"scara.toml", "--log", "scara_s2.csv", "--report"});
  for (const char* const feed : {"--log - < scara_s2.csv", "--log /dev/stdin < scara_s2.csv"}) {
    const Outcome run = shell(tool + "scara.toml --report " + feed);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json result = Json::parse(folder().read("scara_result/result.json"));
    EXPECT_EQ(result["parameters"], of_file["parameters"]);
    EXPECT_EQ(result["provenance"]["inputs"][2]["sha256"], of_file["provenance"]["inputs"][2]["sha256"]);
  }
  const Outcome piped =
      outcome_of({"/bin/sh", "-c", "cat scara_s2.csv | timeout 300 " + tool + "scara.toml --report --log -"},
                 folder().path());
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_EQ(Json::parse(folder().read("scara_result/result.json"))["parameters"], of_file["parameters"]);
}

TEST_F(Inputs, ThatAreNoFilesAreRefusedAtOnce) {
  ASSERT_EQ(::mkfifo((folder().path() / "pipe.urdf").c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo((folder().path() / "pipe.csv").c_str(), 0600), 0);
  for (const char* const arguments :
       {"pipe.csv", "init pipe.urdf scara_s2.csv", "init scara.urdf pipe.csv --output new.toml", "/dev/zero",
        "init scara.urdf /dev/zero --output new.toml", "scara.toml --log /dev/zero"}) {
    const Outcome run = shell(tool + arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments << run.err;
    EXPECT_TRUE(run.err.find("is a pipe, a file is required") != std::string::npos ||
                run.err.find("/dev/zero: is a device, a file is required") != std::string::npos)
        << arguments << ": " << run.err;
  }
}

TEST_F(Inputs, ThatCanNotBeLookedAtAreRefusedInWords) {
  std::filesystem::create_symlink("loop", folder().path() / "loop");
  const std::string long_name(300, 'a');
  for (const std::string& path : {std::string("loop"), long_name}) {
    const std::string why = path == "loop" ? "Too many levels of symbolic links" : "File name too long";
    for (const std::string& arguments :
         {path + "/scara.toml", path, "export " + path + " --to header", "scara.toml --output " + path,
          "scara.toml --plan " + path, "merge " + path, "init scara.urdf scara_s2.csv --output " + path}) {
      const Outcome run = shell(tool + arguments);
      EXPECT_EQ(run.exit_code, 2) << arguments << ": " << run.err;
      EXPECT_NE(run.err.find(why), std::string::npos) << arguments << ": " << run.err;
    }
  }
}

TEST_F(Inputs, HaveALimit) {
  std::filesystem::resize_file(folder().path() / "scara_s2.csv", std::uintmax_t{3} << 20U);
  const Outcome run = shell(tool + "scara.toml --max-size 2");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("scara_s2.csv: has more than 2 MiB, the limit of an input; --max-size raises it"),
            std::string::npos)
      << run.err;
}

// While the program runs, its log is cut, grows and is replaced.
TEST_F(Inputs, ThatChangeEndInAResultOfOneVersionOrInARefusal) {
  const std::string log = folder().read("scara_s2.csv");
  const std::size_t half = log.find('\n', log.size() / 2) + 1;
  const std::string other = log.substr(0, half);
  const std::set<std::string> versions = {rivid::sha256(log), rivid::sha256(other)};
  const std::filesystem::path file = folder().path() / "scara_s2.csv";
  int results = 0;
  for (int round = 0; round < 30; ++round) {
    folder().write("scara_s2.csv", log);
    Process process(
        rivid::test::identify_command({"scara.toml", "--report", "--validate", "scara_validation.csv"}),
        folder().path());
    std::this_thread::sleep_for(std::chrono::milliseconds(1 + 3 * (round % 10)));
    if (round % 3 == 0) {
      std::filesystem::resize_file(file, half);
    } else if (round % 3 == 1) {
      folder().write("other.csv", other);
      std::filesystem::rename(folder().path() / "other.csv", file);
    } else {
      std::ofstream(file, std::ios::app) << "rubbish\n";
    }
    const Outcome run = process.wait();
    EXPECT_EQ(run.signal, 0);
    if (run.exit_code == 0) {
      ++results;
      const Json result = Json::parse(folder().read("scara_result/result.json"));
      const std::string digest = result["provenance"]["inputs"][2]["sha256"];
      EXPECT_TRUE(versions.contains(digest)) << digest;
      const auto rows = result["fit"]["rows"].get<int>();
      EXPECT_EQ(rows > 250, digest == rivid::sha256(log))
          << "of the whole log there are 353 rows, got " << rows;
    } else {
      EXPECT_EQ(run.exit_code, 2) << run.err;
      EXPECT_NE(run.err.find("scara_s2.csv"), std::string::npos) << run.err;
    }
  }
  EXPECT_GT(results, 0);
}

}  // namespace
