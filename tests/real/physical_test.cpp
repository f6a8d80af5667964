// Physically consistent models of real arms, tests/real/*.toml.

#include <gtest/gtest.h>

#include <algorithm>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/references.hpp"
#include "support/real_experiment.hpp"

namespace rivid {
namespace {

using test::Json;

class PhysicalPanda : public test::RealExperiment {
 protected:
  PhysicalPanda() : RealExperiment("panda") {}
};

// The published set and every least-squares fit have a negative inertia of link 7 about its axis.
TEST_F(PhysicalPanda, CostsLittleThoughThePlainFitIsNoRobot) {
  const Json found = result({"--method", "wls", "--physical"});
  const Json& parameters = found["parameters"];
  const auto ZZ7 = std::ranges::find_if(parameters, [](const Json& p) { return p["name"] == "ZZ7"; });
  ASSERT_NE(ZZ7, parameters.end());
  EXPECT_LT((*ZZ7)["value"], 0.0);
  const Json& physical = found["physical"];
  EXPECT_TRUE(physical["reached"]);
  const double plain = found["fit"]["relative_error"];
  const double price = physical["fit"]["relative_error"].get<double>() - plain;
  EXPECT_GE(price, 0.0);
  EXPECT_LE(price, 0.003);
  ASSERT_EQ(physical["links"].size(), 7U);
  for (const Json& parameter : physical["links"][6]["parameters"]) {
    if (parameter["name"] == "ZZ7" || parameter["name"] == "M7" || parameter["name"] == "Fv7") {
      EXPECT_GT(parameter["value"], 0.0) << parameter["name"];
    }
  }
}

TEST_F(PhysicalPanda, RunsTheWholeReferenceWhereThePlainFitCanNot) {
  Experiment experiment = this->experiment();
  experiment.estimation.method = Wls{};
  experiment.estimation.physical = Physical{};
  const Identification found = run(experiment);
  ASSERT_TRUE(found.physical);
  const Robot& robot = experiment.robot;
  const Log log = read_logs(experiment.log, robot).at(0);
  const Matrix followed = zero_phase(log.q, log.f_m, experiment.estimation.signal.cutoff_hz);

  EXPECT_THROW((void)design_inertia(DynamicModel(robot, found.base, found.chi), followed), NumericsError);

  const DynamicModel model(robot, found.physical->parameters.chi_st);
  for (Index k = 0; k < log.samples(); k += 10) {
    ASSERT_GT(smallest_eigenvalue(model, followed.row(k).transpose()), 0.0) << "sample " << k;
  }
  const auto law = experiment.control->control({robot, model, design_inertia(model, followed)});
  const LoggedReference reference(log.t, followed);
  const Simulation motion = simulate(robot, model, *law, reference, {.f_m = log.f_m});
  EXPECT_EQ(motion.outcome, Outcome::completed) << motion.reason;
  ASSERT_EQ(motion.motion.samples(), log.samples());
  // Gains follow inertias, and joint 7 has next to none: its friction holds it up to 0.7 rad behind, and
  // nothing else is as far. A loop that diverges is radians away at once.
  constexpr double tracked = 1.0;  // rad
  EXPECT_LT((motion.motion.q - followed).cwiseAbs().maxCoeff(), tracked);
}

// Nothing is filtered but the motion that the loop follows; judged on the filtered rows, as WLS is.
TEST_F(PhysicalPanda, NeedsNoFilterWithInstrumentalVariables) {
  Experiment experiment = this->experiment();
  const SignalOptions filtered = experiment.estimation.signal;
  experiment.estimation.method = Wls{};
  const double of_wls = run(experiment).fit.relative_error;
  experiment.take_method("iv");
  experiment.estimation.signal = {.trim = filtered.trim};
  Identification found = run(experiment);
  ASSERT_EQ(found.status, Status::identified);
  found.estimation.signal = filtered;
  const auto logs = read_logs(experiment.log, experiment.robot);
  EXPECT_LT(validate(experiment.robot, found, logs.at(0)).fit.relative_error, 1.1 * of_wls);
}

class PhysicalKuka : public test::RealExperiment {
 protected:
  PhysicalKuka() : RealExperiment("kuka_kr300") {}
};

bool warns_of_weak_excitation(const Json& result) {
  return std::ranges::any_of(result["warnings"],
                             [](const Json& warning) { return warning["code"] == "weak_excitation"; });
}

TEST_F(PhysicalKuka, CarriesOneLogOverToAnotherByTheDescriptionAlone) {
  // The set that is the answer is the one that is judged.
  const Json found = result({"--log", "kuka_kr300/kr300_A.csv", "--physical"});
  ASSERT_EQ(found["validation"].size(), 2U);
  const Json& on_B = found["validation"][1];
  EXPECT_GT(on_B["relative_error"], 0.1);
  EXPECT_LE(on_B["physical"]["relative_error"], 0.065);
  EXPECT_FALSE(warns_of_weak_excitation(found));
}

TEST_F(PhysicalKuka, WarnsOfOneLogWithoutTheDescription) {
  EXPECT_TRUE(warns_of_weak_excitation(result({"--log", "kuka_kr300/kr300_A.csv"})));
}

// Neither set was asked for: blocks of time of the log say which one predicts better.
TEST_F(PhysicalKuka, IsTheAnswerOfOneLog) {
  for (const auto& [log, other] : {std::pair("kuka_kr300/kr300_A.csv", 1U), {"kuka_kr300/kr300_B.csv", 0U}}) {
    const Json found = result({"--log", log});
    ASSERT_TRUE(found.contains("physical"));
    EXPECT_TRUE(found["physical"]["better"]);
    const Json& there = found["validation"][other];
    EXPECT_LT(there["physical"]["relative_error"], 0.5 * there["relative_error"].get<double>()) << log;
  }
}

}  // namespace
}  // namespace rivid
