// What the URDF says of masses and inertias accuses no log that is right: wrong, placeholder and missing ones
// leave no more results doubtful than true ones do. (All links ten times too heavy are what torques in
// another unit look like, and are said to be.)

#include <gtest/gtest.h>

#include <array>
#include <fstream>

#include "odd/run.hpp"
#include "odd/user_folder.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "support/temporary_folder.hpp"

namespace rivid::odd {
namespace {

constexpr std::uint64_t seed = 3737;
constexpr std::uint64_t logs = 40;

struct Description {
  const char* name;
  void (*change)(Body&, Random&);
};

void scale(Body& body, double factor) {
  body.mass *= factor;
  body.inertia_com *= factor;
}

constexpr std::array descriptions = {
    Description{"true", [](Body&, Random&) {}},
    Description{"a fifth off", [](Body& body, Random& x) { scale(body, x.uniform(0.8, 1.2)); }},
    Description{"wrong by factors to three",
                [](Body& body, Random& x) {
                  scale(body, x.log_uniform(0.33, 3.0));
                  body.com *= x.uniform(0.0, 2.0);
                }},
    Description{"twice too heavy", [](Body& body, Random&) { scale(body, 2.0); }},
    Description{"one kilogram and unit inertia",
                [](Body& body, Random&) { body = {.mass = 1.0, .inertia_com = Matrix3d::Identity()}; }},
    Description{"a gram", [](Body& body,
                             Random&) { body = {.mass = 1e-3, .inertia_com = 1e-3 * Matrix3d::Identity()}; }},
    Description{"none", [](Body& body, Random&) { body = {}; }},
    Description{"some links without",
                [](Body& body, Random& x) {
                  if (x.chance(0.5)) {
                    body = {};
                  }
                }},
};

Identification drafted_result(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "experiment.toml";
  std::ofstream(file) << draft_experiment(file, folder / "robot.urdf", {},
                                          std::vector{folder / "log_1.csv", folder / "log_2.csv"})
                             .text;
  Experiment experiment = read_experiment(file);
  Reading reading;
  take_friction(experiment, reading);
  return run(experiment);
}

TEST(Descriptions, AccuseNoLogThatIsRight) {
  std::array<int, descriptions.size()> doubtful{};
  for (std::uint64_t number = 0; number < logs; ++number) {
    const test::TemporaryFolder folder;
    const Truth truth = write_experiment({seed, kinds_of("good").front(), number}, folder.path());
    for (std::size_t k = 0; k < descriptions.size(); ++k) {
      Random random(seed, descriptions[k].name, number);
      Arm arm = truth.machine.arm;
      for (ArmJoint& joint : arm.joints) {
        descriptions[k].change(joint.body, random);
      }
      folder.write("robot.urdf", urdf_of(arm, Numbers::Constant(arm.size(), 1e4)));
      doubtful[k] += drafted_result(folder.path()).status == Status::doubtful ? 1 : 0;
    }
  }
  for (std::size_t k = 0; k < descriptions.size(); ++k) {
    EXPECT_LE(doubtful[k], doubtful[0]) << descriptions[k].name;
  }
  EXPECT_LE(doubtful[0], 1);
}

}  // namespace
}  // namespace rivid::odd
