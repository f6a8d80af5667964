#include "rivid/simulate/measurement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/references.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// A carriage of 2 kg that moves half a metre.
class Measurement : public testing::Test {
 protected:
  Measurement() { options_.sampling.period = 0.01; }

  [[nodiscard]] Simulation run(const NoiseOptions& noise) const {
    return simulate(robot_, base_, Vector{{2.0, 0.3, 0.1, 0.0}}, control_, Vector{{2.0}}, reference_,
                    with_noise(options_, noise, 1));
  }
  [[nodiscard]] Log log(const NoiseOptions& noise) const { return measured_log(run(noise), options_, noise); }

  // What with_noise() says.
  [[nodiscard]] std::string refusal(const NoiseOptions& noise) const {
    return test::complaint_of([&] { return with_noise(options_, noise, 1); });
  }

  const Robot robot_ = test::slider();
  const BaseParameters base_ = base_parameters(robot_);
  const PdControl control_{.omega_n = Vector{{10.0}}, .zeta = Vector{{1.0}}};
  const PointToPointReference reference_{{.via = Matrix{{0.0}, {0.5}}, .durations = Vector{{1.0}}}};
  SimulationOptions options_{.f_m = 100.0, .samples = 101};
};

const Vector sd{{1e-3}};

TEST_F(Measurement, WithoutErrorsIsTheTruth) {
  const Simulation simulation = run({});
  const Log log = measured_log(simulation, options_, {});
  EXPECT_EQ(log.q, simulation.motion.q);
  EXPECT_EQ(log.tau, simulation.tau);
  EXPECT_EQ(log.v_tau, simulation.v_tau);
  EXPECT_EQ(log.q_r, simulation.q_r);
  EXPECT_EQ(log.complaint(), std::nullopt);
}

TEST_F(Measurement, ErrorsGoThroughTheControllerOrAreInTheLogAlone) {
  const Simulation quiet = run({});
  EXPECT_NE(run({.position = sd}).motion.q, quiet.motion.q);
  const NoiseOptions in_the_log{.position = sd, .feedback = false};
  const Simulation simulation = run(in_the_log);
  EXPECT_EQ(simulation.motion.q, quiet.motion.q);
  const Vector error = measured_log(simulation, options_, in_the_log).q - simulation.motion.q;
  // Four standard errors of a deviation of 101 samples.
  EXPECT_NEAR(std::sqrt(error.squaredNorm() / 101.0), 1e-3, 4.0 * 1e-3 / std::sqrt(2.0 * 101.0));
}

TEST_F(Measurement, IsRoundedToTheQuantumLast) {
  options_.sampling.quantum = Vector{{0.01}};
  for (const bool feedback : {true, false}) {
    const Log log = this->log({.position = sd, .feedback = feedback});
    const Vector steps = log.q / 0.01;
    EXPECT_LT((steps.array() - steps.array().round()).abs().maxCoeff(), 1e-9) << feedback;
    EXPECT_GT(steps.cwiseAbs().maxCoeff(), 40.0);
  }
}

TEST_F(Measurement, IsRoundedToTheNearestStep) {
  options_.sampling.quantum = Vector{{0.01}};
  for (const bool feedback : {true, false}) {
    const NoiseOptions noise{.position = Vector{{1e-9}}, .feedback = feedback};
    const Simulation simulation = run(noise);
    const Vector error = measured_log(simulation, options_, noise).q - simulation.motion.q;
    EXPECT_LE(error.cwiseAbs().maxCoeff(), 0.005 + 1e-8) << feedback;
    EXPECT_GT(error.maxCoeff(), 0.002) << feedback;
    EXPECT_LT(error.minCoeff(), -0.002) << feedback;
  }
}

TEST_F(Measurement, TorqueNoiseIsInTheRecordAlone) {
  const Simulation simulation = run({.torque = sd});
  EXPECT_EQ(simulation.motion.q, run({}).motion.q);
  const Log log = measured_log(simulation, options_, {.torque = sd});
  EXPECT_NE(log.tau, simulation.tau);
  EXPECT_EQ(log.v_tau, simulation.v_tau);
}

TEST_F(Measurement, TheDisturbanceMovesTheRobotAndIsNotRecorded) {
  const NoiseOptions noise{.disturbance = Vector{{0.5}}};
  const Simulation simulation = run(noise);
  EXPECT_NE(simulation.motion.q, run({}).motion.q);
  EXPECT_EQ(measured_log(simulation, options_, noise).tau, simulation.tau);
}

TEST_F(Measurement, OfOneSeedIsTheSameTwice) {
  const NoiseOptions noise{.position = sd, .torque = sd, .disturbance = sd, .seed = 12};
  EXPECT_EQ(log(noise).q, log(noise).q);
  NoiseOptions other = noise;
  other.seed = 13;
  EXPECT_NE(log(noise).q, log(other).q);
}

TEST_F(Measurement, RefusesWhatNobodyCanMeasure) {
  EXPECT_NE(refusal({.position = Vector{{-1.0}}}).find("position_noise of joint 1 is -1"), std::string::npos);
  EXPECT_NE(refusal({.position = Vector{{1.0, 1.0}}}).find("has 2 entries"), std::string::npos);
  options_.f_m = 75.0;
  EXPECT_NE(refusal({.position = sd}).find("the controller measures at 100 Hz and the log is taken at 75 Hz"),
            std::string::npos);
  EXPECT_EQ(refusal({.position = sd, .feedback = false}), "");
  options_.sampling.period = 1e-12;
  EXPECT_NE(refusal({.disturbance = sd}).find("control periods of 1e-12 s"), std::string::npos);
  options_.sampling.period = 0.0;
  EXPECT_NE(refusal({.position = sd}).find("go through a sampled law only"), std::string::npos);
}

TEST_F(Measurement, LeavesOutRowsThatAreNotFinite) {
  Simulation simulation = run({});
  simulation.tau(70, 0) = std::nan("");
  const Log log = measured_log(simulation, options_, {});
  EXPECT_EQ(log.samples(), 70);
  EXPECT_EQ(log.q.rows(), 70);
}

TEST_F(Measurement, RefusesNoiseOfOtherJoints) {
  const Simulation simulation = run({});
  const auto message = [&](const NoiseOptions& noise) {
    return test::complaint_of([&] { return measured_log(simulation, options_, noise); });
  };
  EXPECT_EQ(message({.position = Vector::Ones(3), .feedback = false}),
            "measured_log: position_noise has 3 entries, must have one for each of 1 joint");
  EXPECT_EQ(message({.torque = Vector::Ones(2)}),
            "measured_log: torque_noise has 2 entries, must have one for each of 1 joint");
  EXPECT_TRUE(test::says(message({.torque = Vector{{std::nan("")}}}), "torque_noise of joint 1 is nan"));
  options_.sampling.quantum = Vector::Ones(2);
  EXPECT_EQ(message({}), "measured_log: sampling.quantum has 2 values, must have one for each of 1 joint");
  options_.sampling.quantum = {};
  options_.samples = -5;
  EXPECT_EQ(refusal({.disturbance = sd}),
            "with_noise: samples is -5, must be that of the motion which noise is drawn for");
}

}  // namespace
}  // namespace rivid
