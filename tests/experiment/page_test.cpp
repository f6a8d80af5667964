// Every example on docs/experiment.md and docs/experiment_more.md, and those of the README and of
// docs/instrumental.md, are experiment files that can be read.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "support/temporary_folder.hpp"

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

class ExperimentPage : public testing::Test {
 protected:
  ExperimentPage() {
    folder_.write("my_robot.urdf", test::content_of(RIVID_DATA "/scara/scara.urdf"));
    folder_.write("emps_mdh.csv", "joint,type,alpha,a,d,theta\n1,P,1.570796326795,0,0,0\n");
  }

  void expect_readable(const std::string& text) const {
    const std::string name = "experiment.toml";
    folder_.write(name, text);
    const bool simulated = text.find("[simulation]") != std::string::npos;
    EXPECT_NO_THROW(
        (void)read_experiment(folder_.path() / name, simulated ? Use::simulation : Use::identification))
        << text;
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(ExperimentPage, ShowsFilesThatCanBeRead) {
  const std::vector<std::string> blocks = toml_blocks(test::content_of(RIVID_DOCS "/experiment.md") +
                                                      test::content_of(RIVID_DOCS "/experiment_more.md"));
  ASSERT_GE(blocks.size(), 4U);
  for (const std::string& text : blocks) {
    // A fragment that shows one section gets the others that must be there.
    const bool whole = text.find("[robot]") != std::string::npos;
    expect_readable(whole ? text
                          : "[robot]\nurdf = \"my_robot.urdf\"\n" + text + "[signal]\ncutoff_hz = 20\n");
  }
}

TEST_F(ExperimentPage, OfInstrumentalVariablesCanBeRead) {
  const std::vector<std::string> blocks = toml_blocks(test::content_of(RIVID_DOCS "/instrumental.md"));
  ASSERT_EQ(blocks.size(), 1U);
  expect_readable("[robot]\nurdf = \"my_robot.urdf\"\n" + blocks.front());
}

TEST_F(ExperimentPage, OfTheReadmeCanBeRead) {
  const std::vector<std::string> blocks = toml_blocks(test::content_of(RIVID_DOCS "/../README.md"));
  ASSERT_EQ(blocks.size(), 1U);
  std::string text = blocks.front();
  const std::string tip = "tool0";
  text.replace(text.find(tip), tip.size(), "forearm");
  expect_readable(text);
}

}  // namespace
}  // namespace rivid
