// Simulations beside each other in the lanes of a register are, to the last bit, those by themselves.

#include "simulate/simulation_group.hpp"

#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/measurement.hpp"
#include "rivid/simulate/references.hpp"
#include "support/monte_carlo_rows.hpp"
#include "support/scara_study.hpp"

namespace {

using rivid::Index;
using rivid::Matrix;
using rivid::Outcome;
using rivid::Simulation;
using rivid::SimulationOptions;
using rivid::Vector;
using rivid::detail::LoopPack;
using rivid::detail::LoopPackStep;
using rivid::detail::LoopRun;
using rivid::detail::SimulationGroup;

using Task = std::function<Simulation()>;

// What each task gives in a thread of its own, all of one group.
std::vector<std::optional<Simulation>> together(const std::vector<Task>& tasks) {
  SimulationGroup group(static_cast<int>(tasks.size()));
  std::vector<std::optional<Simulation>> out(tasks.size());
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    threads.emplace_back([&, k] {
      const SimulationGroup::Member member(group);
      try {
        out[k].emplace(tasks[k]());
      } catch (const std::runtime_error&) {
        out[k].reset();
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  return out;
}

void expect_same(const Simulation& a, const Simulation& b) {
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.t, b.t);
  EXPECT_EQ(a.motion.q, b.motion.q);
  EXPECT_EQ(a.motion.qd, b.motion.qd);
  EXPECT_EQ(a.motion.qdd, b.motion.qdd);
  EXPECT_EQ(a.v_tau, b.v_tau);
  EXPECT_EQ(a.tau, b.tau);
  EXPECT_EQ(a.q_measured, b.q_measured);
  EXPECT_EQ(a.element_changes, b.element_changes);
  EXPECT_EQ(a.effort.steps, b.effort.steps);
  EXPECT_EQ(a.effort.right_hand_sides, b.effort.right_hand_sides);
  EXPECT_EQ(a.effort.restarts, b.effort.restarts);
}

void expect_same_as_alone(const std::vector<Task>& tasks) {
  const std::vector<std::optional<Simulation>> found = together(tasks);
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    SCOPED_TRACE("task " + std::to_string(k));
    ASSERT_TRUE(found[k].has_value());
    expect_same(*found[k], tasks[k]());
  }
}

// The SCARA of [RIV] on a computer, with parameters and noise of a seed.
struct SeededScara : rivid::test::ScaraStudy {
  explicit SeededScara(std::uint64_t seed, Index rows = 2001) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> factor(0.8, 1.2);
    for (double& value : truth) {
      value *= factor(random);
    }
    options.samples = rows;
    options.sampling = computer();
    options.sampling.position_noise = rivid::white_noise(seed, 1, rows, Vector::Constant(2, encoder_noise));
    options.disturbance = rivid::white_noise(seed, 2, rows, disturbance);
  }

  [[nodiscard]] Simulation run() const {
    return simulate(robot, base, truth, control, J, moves(1.0), options);
  }

  SimulationOptions options{.f_m = f_m};
};

Task task(const SeededScara& scara) {
  return [scara] { return scara.run(); };
}

TEST(SimulationGroup, OtherRobotsAndNoiseInEachLaneGiveTheBitsOfLoopsByThemselves) {
  for (const std::size_t members : {2U, 5U, 8U}) {
    SCOPED_TRACE(members);
    std::vector<Task> tasks;
    for (std::uint64_t seed = 1; seed <= members; ++seed) {
      tasks.push_back(task(SeededScara(seed)));
    }
    expect_same_as_alone(tasks);
  }
}

// Six joints, of which several stick at a time, and steps that have to be shortened.
TEST(SimulationGroup, SixJointsWithStictionGiveTheBitsOfLoopsByThemselves) {
  const rivid::MonteCarlo plan =
      rivid::read_monte_carlo(std::filesystem::path(RIVID_DATA) / "six_axis" / "montecarlo.toml");
  std::vector<Task> tasks;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    tasks.emplace_back([&plan, seed] {
      rivid::Experiment experiment = plan.experiment;
      experiment.simulation->noise.seed = seed;
      experiment.simulation->duration = 2.0;
      Simulation out = run_simulation(experiment).simulation;
      EXPECT_GT(out.effort.mode_changes, 10);
      return out;
    });
  }
  expect_same_as_alone(tasks);
}

// What can not go along in a lane, or not to the end, changes nothing for the others.
TEST(SimulationGroup, LoopsThatEndEarlyOrGoAnotherWayLeaveTheOthersAlone) {
  std::vector<Task> tasks = {task(SeededScara(1)), task(SeededScara(2, 700))};
  SeededScara no_robot(3);
  no_robot.set("ZZ2", -0.01);
  tasks.push_back(task(no_robot));
  SeededScara diverges(4);
  diverges.options.max_velocity = 0.5;
  tasks.push_back(task(diverges));
  SeededScara continuous(5);
  continuous.options.sampling = {};
  tasks.push_back(task(continuous));
  SeededScara smooth(6);
  smooth.options.friction = rivid::DryFrictionScheme::smooth;
  tasks.push_back(task(smooth));
  SeededScara short_of_steps(7);
  short_of_steps.options.max_steps = 300;
  tasks.push_back(task(short_of_steps));
  SeededScara many_samples(8);
  many_samples.options.f_m = 700.0;
  tasks.push_back(task(many_samples));
  expect_same_as_alone(tasks);
  EXPECT_EQ(no_robot.run().outcome, Outcome::not_positive_definite);
  EXPECT_EQ(diverges.run().outcome, Outcome::diverged);
  EXPECT_EQ(short_of_steps.run().outcome, Outcome::too_slow);
}

// More than go into one pack, and one that ends early, by a thread that is in no group.
TEST(SimulatedMotions, BesideEachOtherAreThoseByThemselves) {
  std::deque<SeededScara> scaras;
  for (std::uint64_t seed = 1; seed <= 11; ++seed) {
    scaras.emplace_back(seed, seed == 5 ? 700 : 1200);
  }
  scaras[3].options.max_velocity = 0.5;
  const rivid::PointToPointReference reference = SeededScara::moves(1.0);
  std::deque<rivid::DynamicModel> models;
  std::vector<std::unique_ptr<rivid::ControlLaw>> laws;
  std::vector<rivid::detail::LoopTask> tasks;
  for (const SeededScara& scara : scaras) {
    const rivid::DynamicModel& model = models.emplace_back(scara.robot, scara.base, scara.truth);
    laws.push_back(scara.control({scara.robot, model, scara.J}));
    tasks.push_back({scara.robot, model, *laws.back(), reference, scara.options});
  }
  const std::vector<Simulation> found = rivid::detail::simulated_motions(tasks);
  ASSERT_EQ(found.size(), scaras.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    SCOPED_TRACE(k);
    const Simulation alone = scaras[k].run();
    EXPECT_EQ(found[k].outcome, alone.outcome);
    EXPECT_EQ(found[k].motion.q, alone.motion.q);
    EXPECT_EQ(found[k].motion.qdd, alone.motion.qdd);
    EXPECT_EQ(found[k].effort.steps, alone.effort.steps);
    EXPECT_EQ(found[k].effort.right_hand_sides, alone.effort.right_hand_sides);
  }
  EXPECT_EQ(found[3].outcome, Outcome::diverged);
}

class Failing final : public rivid::ControlLaw {
 public:
  void control(const rivid::ControlInput& input, const Eigen::Ref<const Vector>&, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector>) const override {
    v_tau.setZero();
    if (input.t > 1.0) {
      throw std::runtime_error("the law has failed");
    }
  }
};

TEST(SimulationGroup, AnExceptionIsForTheThreadWhoseLawThrewIt) {
  const SeededScara failing(1);
  const std::vector<Task> tasks = {
      task(SeededScara(2)),
      [&] {
        return rivid::simulate(failing.robot, rivid::DynamicModel(failing.robot, failing.base, failing.truth),
                               Failing(), SeededScara::moves(1.0), failing.options);
      },
      task(SeededScara(3))};
  const std::vector<std::optional<Simulation>> found = together(tasks);
  EXPECT_FALSE(found[1].has_value());
  for (const std::size_t k : {0U, 2U}) {
    ASSERT_TRUE(found[k].has_value());
    expect_same(*found[k], tasks[k]());
  }
}

// Without this all of the above would hold for packs that never take a step.
TEST(LoopPack, TakesNearlyAllStepsOfSampledLoops) {
  if (LoopPack::lanes() == 1) {
    GTEST_SKIP() << "this machine has no registers of four numbers";
  }
  const rivid::PointToPointReference reference = SeededScara::moves(1.0);
  std::deque<SeededScara> scaras;
  std::deque<rivid::DynamicModel> models;
  std::vector<std::unique_ptr<rivid::ControlLaw>> laws;
  std::deque<LoopRun> runs;
  std::vector<rivid::detail::LoopOde*> loops;
  constexpr std::uint64_t lanes = 4;
  for (std::uint64_t seed = 1; seed <= lanes; ++seed) {
    const SeededScara& scara = scaras.emplace_back(seed);
    const rivid::DynamicModel& model = models.emplace_back(scara.robot, scara.base, scara.truth);
    laws.push_back(scara.control({scara.robot, model, scara.J}));
    LoopRun& run = runs.emplace_back(scara.robot, model, *laws.back(), reference, scara.options);
    run.start_clock();
    loops.push_back(&run.ode());
  }
  LoopPack pack(loops);
  std::vector<LoopPackStep> steps(lanes);
  int taken = 0;
  int alone = 0;
  while (!runs.front().over()) {
    bool any = false;
    for (std::size_t k = 0; k < lanes; ++k) {
      steps[k] = {};
      if (!runs[k].over()) {
        if (runs[k].period_ended()) {
          runs[k].begin_period();
        }
        steps[k] = runs[k].step_for_pack();
        any = any || steps[k].h > 0.0;
      }
    }
    const bool stepped = any && pack.step(steps);
    for (std::size_t k = 0; k < lanes; ++k) {
      if (runs[k].over()) {
        continue;
      }
      if (stepped && steps[k].h > 0.0 && pack.valid(k)) {
        runs[k].take(pack, k);
        ++taken;
      } else {
        runs[k].finish_period();
        ++alone;
      }
    }
  }
  EXPECT_GT(taken, 50 * alone) << taken << " steps in a pack, " << alone << " alone";
}

TEST(MonteCarloRuns, AreTheSameInGroupsAsOneByOne) {
  rivid::MonteCarlo plan = rivid::test::scara_plan(11);
  plan.trials.resize(1);
  std::vector<int> wanted = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  std::vector<rivid::MonteCarloRow> found(wanted.size());
  rivid::monte_carlo_runs(plan, wanted, 1, [&](const std::vector<rivid::MonteCarloRow>& rows) {
    found[static_cast<std::size_t>(rows.front().run)] = rows.front();
  });
  for (const int run : {0, 7, 10}) {
    const rivid::MonteCarloRow alone = monte_carlo_run(plan, run).front();
    const rivid::MonteCarloRow& row = found[static_cast<std::size_t>(run)];
    EXPECT_EQ(row.status, alone.status);
    EXPECT_EQ(row.iterations, alone.iterations);
    EXPECT_EQ(row.value, alone.value);
    EXPECT_EQ(row.sigma, alone.sigma);
    EXPECT_EQ(row.quantile, alone.quantile);
  }
}

}  // namespace
