// Pieces of good logs of real robots are hardly ever called doubtful by an error, whether they are cut to
// files or by a window.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "rivid/data/adjust.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/friction_choice.hpp"
#include "support/real_experiment.hpp"

namespace {

using rivid::Index;
using rivid::Log;
using rivid::Robot;

struct GoodLog {
  const char* robot;
  const char* file;
};

// Motions that the motors make, with their whole torque: not those of a hand or of a passive joint.
constexpr std::array good_logs = {GoodLog{"emps", "emps_ident.csv"},
                                  GoodLog{"emps", "emps_pulses.csv"},
                                  GoodLog{"panda", "panda_1khz.csv"},
                                  GoodLog{"ur10e", "ident_30s_12harm.csv"},
                                  GoodLog{"ur10e", "ident_40s_12harm.csv"},
                                  GoodLog{"ur10e", "unload_14harm.csv"},
                                  GoodLog{"ur10e", "load_14harm.csv"},
                                  GoodLog{"tx40", "tx40_ident.csv"},
                                  GoodLog{"kuka_kr300", "kr300_A.csv"},
                                  GoodLog{"kuka_kr300", "kr300_B.csv"},
                                  GoodLog{"ur10_vrep", "ur10_traj1.csv"},
                                  GoodLog{"kinova_gen3", "opti_1.csv"},
                                  GoodLog{"kinova_gen3", "opti_2.csv"},
                                  GoodLog{"dfki_double_pendulum", "run_1.csv"},
                                  GoodLog{"dfki_double_pendulum", "run_2.csv"},
                                  GoodLog{"dfki_double_pendulum", "run_3.csv"},
                                  GoodLog{"bam_servo", "xl330_1.csv"},
                                  GoodLog{"bam_servo", "xl330_2.csv"},
                                  GoodLog{"bam_servo", "xl330_3.csv"},
                                  GoodLog{"bam_servo", "xl330_4.csv"}};

std::filesystem::path urdf_in(const std::filesystem::path& folder, const std::string& robot) {
  const std::string name = robot == "dfki_double_pendulum" ? "acrobot.urdf" : "";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::filesystem::path& path = entry.path();
    if (path.extension() == ".urdf" && (name.empty() || path.filename() == name)) {
      return path;
    }
  }
  return {};
}

// The errors of a result: their codes and subjects, and in words.
struct Errors {
  std::string names;
  std::string words;

  Errors() = default;
  explicit Errors(const rivid::Identification& result) {
    for (const rivid::Finding& finding : result.warnings) {
      if (severity(finding) == rivid::Severity::error) {
        names += finding.code + " of " + finding.subject + "; ";
        words += "\n    " + in_words(finding);
      }
    }
  }
};

class Pieces : public rivid::test::RealData {
 protected:
  Pieces() : RealData("") {}

  // The log as an experiment file has it: that of this folder, or a drafted one.
  [[nodiscard]] rivid::Experiment experiment_of(const GoodLog& good) const {
    const std::filesystem::path data = std::filesystem::absolute(path(good.robot));
    const std::string file = std::string(good.robot) + ".toml";
    const std::filesystem::path written = std::filesystem::path(RIVID_TEST_DATA) / "real" / file;
    const std::filesystem::path here = folder_.path() / file;
    if (std::filesystem::exists(written)) {
      if (!std::filesystem::exists(folder_.path() / good.robot)) {
        std::filesystem::create_directory_symlink(data, folder_.path() / good.robot);
      }
      folder_.write(file, rivid::test::content_of(written));
    } else {
      const std::vector logs = {data / good.file};
      folder_.write(file, rivid::draft_experiment(here, urdf_in(data, good.robot), {}, logs).text);
    }
    rivid::Experiment out = rivid::read_experiment(here);
    out.log.files = {data / good.file};
    return out;
  }

 private:
  rivid::test::TemporaryFolder folder_;
};

TEST_F(Pieces, OfGoodLogsAreNotCalledDoubtful) {
  Index pieces = 0;
  std::array<Index, 2> doubtful = {0, 0};
  std::string told;
  for (const GoodLog& good : good_logs) {
    rivid::Experiment experiment;
    std::vector<Log> logs;
    try {
      experiment = experiment_of(good);
      logs = read_logs(experiment.log, experiment.robot);
    } catch (const rivid::InputError& error) {
      std::cout << "[ LEFT OUT ] " << good.file << ": " << error.what() << '\n';
      continue;
    }
    const Log& log = logs.front();
    for (Index parts = 1; parts <= 3; ++parts) {
      for (Index part = 0; part < parts; ++part) {
        const Index begin = part * log.samples() / parts;
        const Index count = (part + 1) * log.samples() / parts - begin;
        const double half = 0.5 / log.f_m;
        rivid::Estimation by_window;
        by_window.signal.window = {log.t[begin] - half, log.t[begin + count - 1] + half};
        std::array<Errors, 2> errors;
        for (std::size_t way = 0; way < 2; ++way) {
          try {
            errors[way] = Errors(way == 0 ? identify(experiment.robot, excerpt(log, begin, count), {})
                                          : identify(experiment.robot, log, by_window));
          } catch (const rivid::InputError&) {
            errors[way] = {};  // refused, not called doubtful
          }
        }
        ++pieces;
        const bool any = !errors[0].names.empty() || !errors[1].names.empty();
        for (std::size_t way = 0; way < 2; ++way) {
          doubtful[way] += errors[way].names.empty() ? 0 : 1;
        }
        if (any) {
          told += std::string("\n  ") + good.robot + "/" + good.file + " " + std::to_string(part + 1) +
                  " of " + std::to_string(parts) + ": " + errors[0].words +
                  (errors[0].names == errors[1].names ? "" : "\n   by window:" + errors[1].words);
        }
      }
    }
  }
  std::cout << "[ DOUBTFUL ] " << doubtful[0] << " of " << pieces << " pieces cut to files, " << doubtful[1]
            << " by a window" << told << '\n';
  for (const Index of_way : doubtful) {
    EXPECT_LE(of_way, pieces / 100) << told;
  }
}

// Whether logs together are said to be of different arms or tools.
bool differ(const Robot& robot, const std::vector<Log>& logs) {
  const rivid::FrictionChoices chosen = choose_friction(robot, logs, {});
  const rivid::Identification result =
      identify(chosen.kinds.empty() ? robot : with_friction(robot, chosen.kinds), logs, {});
  const auto says_so = [](const rivid::Finding& finding) { return finding.code == "logs_differ"; };
  return std::ranges::any_of(result.warnings, says_so);
}

TEST_F(Pieces, AreNotOfDifferentArms) {
  Index sets = 0;
  std::string accused;
  for (const GoodLog& good : good_logs) {
    const rivid::Experiment experiment = experiment_of(good);
    const Log log = read_logs(experiment.log, experiment.robot).front();
    for (Index parts = 2; parts <= 3; ++parts) {
      std::vector<Log> pieces;
      for (Index part = 0; part < parts; ++part) {
        const Index begin = part * log.samples() / parts;
        pieces.push_back(excerpt(log, begin, (part + 1) * log.samples() / parts - begin));
        pieces.back().source += "#" + std::to_string(part);
      }
      try {
        if (differ(experiment.robot, pieces)) {
          accused += std::string(" ") + good.file + "/" + std::to_string(parts);
        }
        ++sets;
      } catch (const rivid::InputError& /*a piece without torques*/) {
      }
    }
  }
  std::cout << "[ DIFFER   ] of " << sets << " sets:" << accused << '\n';
  EXPECT_GE(sets, 30);
  EXPECT_EQ(accused, "");
}

TEST_F(Pieces, OfAnArmWithAndWithoutALoadAre) {
  const rivid::Experiment with = experiment_of({"ur10e", "load_14harm.csv"});
  std::vector<Log> logs = read_logs(with.log, with.robot);
  const rivid::Experiment without = experiment_of({"ur10e", "unload_14harm.csv"});
  logs.push_back(read_logs(without.log, without.robot).front());
  EXPECT_TRUE(differ(with.robot, logs));
}

}  // namespace
