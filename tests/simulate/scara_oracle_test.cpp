// The experiment file that data/scara is made with, against an integrator that shares nothing with ours.

#include <gtest/gtest.h>

#include <cmath>

#include "rivid/data/table.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/text.hpp"

namespace rivid {
namespace {

// 100 rtol of the file, at a motion of some radians.
constexpr double tolerance = 1e-8;

TEST(ScaraOracle, MovesAsAnIndependentIntegratorSays) {
  const Experiment experiment = read_experiment(RIVID_DATA "/scara/simulate_s2.toml", Use::simulation);
  const Table oracle = read_table(RIVID_TEST_DATA "/simulate/scara_oracle.csv");
  const DynamicModel model(experiment.robot, experiment.robot.chi_st());
  const PointToPointReference reference(std::get<PointToPoint>(experiment.reference->motion));

  SimulationOptions options = experiment.simulation->options;
  options.sampling = experiment.control->sampling;
  options.disturbance = Matrix(static_cast<Index>(reference.duration() * options.f_m) + 1, 2);
  for (Index k = 0; k < options.disturbance.rows(); ++k) {
    const auto period = static_cast<double>(k);
    options.disturbance.row(k) << 0.06 * std::sin(1.7 * period), 0.015 * std::cos(2.3 * period);
  }
  const auto law = experiment.control->control({experiment.robot, model, Vector::Ones(2)});
  const Simulation simulation = simulate(experiment.robot, model, *law, reference, options);
  ASSERT_EQ(simulation.outcome, Outcome::completed) << simulation.reason;

  constexpr Index row = 20;
  ASSERT_EQ(simulation.t.size(), row * (oracle.rows() - 1) + 1);
  double error = 0.0;
  for (Index i = 0; i < oracle.rows(); ++i) {
    ASSERT_NEAR(simulation.t[row * i], oracle.values(i, 0), 1e-12);
    error = std::max(
        {error, (simulation.motion.q.row(row * i) - oracle.values.block<1, 2>(i, 1)).cwiseAbs().maxCoeff(),
         (simulation.motion.qd.row(row * i) - oracle.values.block<1, 2>(i, 3)).cwiseAbs().maxCoeff()});
  }
  RecordProperty("error", number(error, 2));
  EXPECT_LT(error, tolerance);
}

}  // namespace
}  // namespace rivid
