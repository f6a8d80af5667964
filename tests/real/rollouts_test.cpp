// Rollouts of real robots: open loop the identified model moves like the robot, in a stiff loop any model
// does.

#include "rivid/identify/rollouts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "support/real_data.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

class RolloutsOf : public test::RealData {
 protected:
  using RealData::RealData;

  // The identified model beside the description, on the validation logs.
  [[nodiscard]] Rollouts judged(const std::string& file) const {
    const Experiment experiment = read_experiment(file);
    const Identification found = run(experiment);
    const std::vector<ComparedModel> models = {
        {"identified", experiment.robot, found.base.to_standard(found.chi)},
        {"description", experiment.robot, experiment.robot.chi_st()}};
    RolloutOptions options;
    if (experiment.control) {
      options.control = experiment.control->control;
      options.sampling = experiment.control->sampling;
    }
    return rollouts(models, read_logs(experiment.validation, experiment.robot), options);
  }
  [[nodiscard]] static const Rollout& after(const Rollouts& all, Drive drive, double horizon) {
    return *std::ranges::find_if(
        all.found, [&](const Rollout& one) { return one.drive == drive && one.horizon == horizon; });
  }

  test::TemporaryFolder folder_;
};

struct RolloutsOfADoublePendulum : RolloutsOf {
  RolloutsOfADoublePendulum() : RolloutsOf("dfki_double_pendulum") {}
};

TEST_F(RolloutsOfADoublePendulum, BeatItsMakersUrdf) {
  folder_.write("pendulum.toml", "[robot]\nurdf = \"" + path("acrobot.urdf") +
                                     "\"\nfriction = \"symmetric\"\n[log]\nfiles = [\"" + path("run_1.csv") +
                                     "\", \"" + path("run_2.csv") +
                                     "\"]\ntime = \"time\"\nposition = [\"q1\", \"q2\"]\ntorque = [\"tau1\", "
                                     "\"tau2\"]\nirregular = \"resample\"\n[method]\nname = \"wls\"\n"
                                     "[validation]\nfiles = [\"" +
                                     path("run_3.csv") + "\"]\n");
  const Rollouts all = judged(folder_.path() / "pendulum.toml");
  for (const double horizon : {0.1, 0.3}) {
    const Rollout& one = after(all, Drive::torques, horizon);
    ASSERT_TRUE(one.tests.front().better.has_value()) << horizon;
    EXPECT_EQ(*one.tests.front().better, 0U) << horizon;
    EXPECT_LT(one.models[0].q.norm(), 0.3 * one.models[1].q.norm()) << horizon;
  }
}

struct RolloutsOfEmps : RolloutsOf {
  RolloutsOfEmps() : RolloutsOf("emps") {}
};

TEST_F(RolloutsOfEmps, SayThatItsStiffLoopHidesTheModel) {
  folder_.write("emps.toml",
                "[robot]\nurdf = \"" + path("emps.urdf") +
                    "\"\nfriction = \"symmetric\"\nrotor_inertia = false\ndrive_gain = 35.15065188\n"
                    "[log]\nfiles = [\"" +
                    path("emps_ident.csv") +
                    "\"]\nposition = [\"q1\"]\ncontrol = [\"v1\"]\nreference = [\"qref1\"]\nrate_hz = 1000\n"
                    "[method]\nname = \"ols\"\n[validation]\nfiles = [\"" +
                    path("emps_pulses.csv") +
                    "\"]\n[control]\nlaw = \"pd\"\nk_p = 160.18\nk_v = 243.45\nv_tau_max = 10\n"
                    "rate_hz = 1000\nvelocity_filter = \"central\"\n");
  const Rollouts all = judged(folder_.path() / "emps.toml");
  EXPECT_EQ(*after(all, Drive::torques, 0.3).tests.front().better, 0U);
  const Rollout& closed = after(all, Drive::controller, 0.3);
  EXPECT_FALSE(closed.tests.front().better.has_value());
  EXPECT_LT(closed.models[0].q[0], 2e-4);
  EXPECT_LT(closed.models[1].q[0], 2e-4);
}

}  // namespace
}  // namespace rivid
