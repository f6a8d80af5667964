// Every example on docs/experiment.md, and that of the README, is an experiment file that can be read.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"

namespace rivid {
namespace {

std::vector<std::string> toml_blocks(const std::string& page) {
  const std::string begin = "```toml\n";
  const std::string end = "```";
  std::vector<std::string> out;
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, at)) {
    at += begin.size();
    const std::size_t stop = page.find(end, at);
    out.push_back(page.substr(at, stop - at));
    at = stop + end.size();
  }
  return out;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

class ExperimentPage : public testing::Test {
 protected:
  ExperimentPage()
      : folder_(std::filesystem::path(testing::TempDir()) /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "my_robot.urdf") << text_of(RIVID_DATA "/scara/scara.urdf");
    std::ofstream(folder_ / "emps_mdh.csv") << "joint,type,alpha,a,d,theta\n1,P,1.570796326795,0,0,0\n";
  }
  ~ExperimentPage() override { std::filesystem::remove_all(folder_); }

  void expect_readable(const std::string& text) const {
    const std::filesystem::path file = folder_ / "experiment.toml";
    std::ofstream(file) << text;
    const bool simulated = text.find("[simulation]") != std::string::npos;
    EXPECT_NO_THROW((void)read_experiment(file, simulated ? Use::simulation : Use::identification)) << text;
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(ExperimentPage, ShowsFilesThatCanBeRead) {
  const std::vector<std::string> blocks = toml_blocks(text_of(RIVID_DOCS "/experiment.md"));
  ASSERT_GE(blocks.size(), 8U);
  for (const std::string& text : blocks) {
    // A fragment that shows one section gets the others that must be there.
    const bool whole = text.find("[robot]") != std::string::npos;
    expect_readable(whole ? text
                          : "[robot]\nurdf = \"my_robot.urdf\"\n" + text + "[signal]\ncutoff_hz = 20\n");
  }
}

TEST_F(ExperimentPage, OfTheReadmeCanBeRead) {
  const std::vector<std::string> blocks = toml_blocks(text_of(RIVID_DOCS "/../README.md"));
  ASSERT_EQ(blocks.size(), 2U);
  expect_readable("[robot]\nurdf = \"my_robot.urdf\"\n" + blocks[1]);
  std::string text = blocks.front();
  const std::string tip = "tool0";
  text.replace(text.find(tip), tip.size(), "forearm");
  expect_readable(text);
}

}  // namespace
}  // namespace rivid
