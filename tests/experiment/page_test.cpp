// Every example on docs/experiment.md is an experiment file that can be read.

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

TEST(ExperimentPage, ShowsFilesThatCanBeRead) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "rivid_experiment_page";
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(std::string(RIVID_DATA) + "/scara/scara.urdf", folder / "my_robot.urdf",
                             std::filesystem::copy_options::overwrite_existing);
  std::ofstream(folder / "emps_mdh.csv") << "joint,type,alpha,a,d,theta\n1,P,1.570796326795,0,0,0\n";

  std::ifstream in(RIVID_DOCS "/experiment.md");
  std::ostringstream page;
  page << in.rdbuf();
  const std::vector<std::string> blocks = toml_blocks(page.str());
  ASSERT_GE(blocks.size(), 7U);
  for (std::string text : blocks) {
    // A fragment that shows one section gets the others that must be there.
    if (text.find("[robot]") == std::string::npos) {
      text = "[robot]\nurdf = \"my_robot.urdf\"\n" + text + "[signal]\ncutoff_hz = 20\n";
    }
    const std::filesystem::path file = folder / "experiment.toml";
    std::ofstream(file) << text;
    EXPECT_NO_THROW((void)read_experiment(file)) << text;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace rivid
