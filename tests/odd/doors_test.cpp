// The library, the tool and the Python package give one answer: status, findings, verdicts, intervals, to the
// last digit.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "odd/run.hpp"
#include "odd/user_folder.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/report/json.hpp"
#include "support/process.hpp"
#include "support/temporary_folder.hpp"

namespace rivid::odd {
namespace {

using Json = nlohmann::json;
using test::content_of;

// Good logs, logs with what no model has, and six whose user errs.
constexpr std::array kinds_tried = {"good",
                                    "good",
                                    "good",
                                    "good",
                                    "misaligned",
                                    "jitter_hidden",
                                    "dropped_stamped",
                                    "torque_filtered",
                                    "torque_spikes",
                                    "stribeck",
                                    "asymmetric",
                                    "load_friction",
                                    "elastic",
                                    "no_rotor",
                                    "torque_sign",
                                    "swapped",
                                    "deg_rad",
                                    "mNm",
                                    "gain_20pct",
                                    "gravity_axis"};
constexpr std::size_t first_faulted = 14;
constexpr std::uint64_t seed = 35;

// Where a result was made is all that may differ, and the line of the file that an experiment's finding says.
Json answer(const std::string& text) {
  Json out = Json::parse(text);
  out.erase("provenance");
  for (const char* const list : {"warnings", "reasons"}) {
    for (Json& each : out[list]) {
      Json& words = each.is_object() ? each["text"] : each;
      const auto said = words.get<std::string>();
      words = said.substr(0, said.find("; in [log]: "));
    }
  }
  return out;
}

void expect_same(const Json& a, const Json& b, const char* kind) {
  EXPECT_TRUE(a == b) << kind << ": " << Json::diff(a, b).dump(2).substr(0, 2000);
}

class Doors : public testing::Test {
 protected:
  Doors() {
    for (std::size_t k = 0; k < kinds_tried.size(); ++k) {
      const std::filesystem::path at = folder_.path() / std::to_string(k);
      std::filesystem::create_directory(at);
      static_cast<void>(write_experiment({seed, kinds_of(kinds_tried[k]).front(), k}, at));
      const std::vector<std::filesystem::path> logs = {at / "log_1.csv"};
      folder_.write(std::to_string(k) + "/arm.toml",
                    draft_experiment(at / "arm.toml", at / "robot.urdf", {}, logs).text +
                        "\n[validation]\nfiles = [\"log_2.csv\"]\n");
      folders_.push_back(at);
    }
  }

  // By the functions that a program calls.
  [[nodiscard]] static Json by_library(const std::filesystem::path& at) {
    Experiment e = read_experiment(at / "arm.toml");
    Reading reading;
    take_friction(e, reading);
    const std::vector<Log>& logs = reading.logs(e.log, e.robot);
    const std::vector<Log>& validation = reading.logs(e.validation, e.robot);
    return answer(to_json(e.robot, identify(e.robot, logs, e.estimation, validation), {}));
  }

  test::TemporaryFolder folder_;
  std::vector<std::filesystem::path> folders_;
};

TEST_F(Doors, LeadToTheSameAnswers) {
  std::string scripts =
      "import json, sys, rivid\n"
      "for arm in sys.argv[1:]:\n"
      "    found = rivid.identify(arm).document\n"
      "    json.dump(found, open(arm + '.json', 'w'))\n";
  std::vector<std::string> python = {RIVID_PYTHON_INTERPRETER, "-c", scripts};
  std::size_t accused = 0;
  std::vector<Json> found;
  for (std::size_t k = 0; k < folders_.size(); ++k) {
    const std::filesystem::path& at = folders_[k];
    const Json library = by_library(at);
    const std::string file = (at / "arm.toml").string();
    test::Process tool({RIVID_IDENTIFY, file, "--output", "arm_result", "--quiet"}, at);
    const int code = tool.wait().exit_code;
    EXPECT_EQ(code, library["status"] == "identified" ? 0 : 1) << kinds_tried[k];
    expect_same(library, answer(content_of(at / "arm_result" / "result.json")), kinds_tried[k]);
    accused += k >= first_faulted && library["status"] != "identified" ? 1U : 0U;
    python.push_back(file);
    found.push_back(library);
  }
  // What is judged is told by all: most of the errors.
  EXPECT_GE(accused, 4U);
  if (std::string(RIVID_PYTHON_PACKAGE).empty()) {
    GTEST_SKIP() << "the Python package is not built: library and tool alone were compared";
  }
  ::setenv("PYTHONPATH", RIVID_PYTHON_PACKAGE, 1);
  test::Process process(python, folder_.path());
  const test::Outcome outcome = process.wait();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (std::size_t k = 0; k < folders_.size(); ++k) {
    expect_same(found[k], answer(content_of(folders_[k] / "arm.toml.json")), kinds_tried[k]);
  }
}

}  // namespace
}  // namespace rivid::odd
