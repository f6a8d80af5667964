// EMPS in its closed loop: the published estimates and controller against the recorded motion.

#include <gtest/gtest.h>

#include <array>

#include "rivid/data/csv.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/references.hpp"
#include "support/real_data.hpp"

namespace {

using rivid::Index;
using rivid::Matrix;
using rivid::Vector;

constexpr Index left_out = 49;  // samples, as in the published comparison

struct Clock {
  double period = 1e-3;
  int delay = 0;
};

// Relative errors of position, velocity, acceleration and force [%].
using Errors = std::array<double, 4>;

class EmpsLoop : public rivid::test::RealData {
 protected:
  EmpsLoop() : RealData("emps") {}

  static double relative_error(const Matrix& simulated, const Matrix& measured) {
    const Index rows = measured.rows() - left_out;
    return 100.0 * (simulated - measured).bottomRows(rows).norm() / measured.bottomRows(rows).norm();
  }

  [[nodiscard]] Errors errors(const std::string& file, const Clock& clock, bool pulses = false) const {
    rivid::Robot robot = rivid::read_urdf(path("emps.urdf"));
    robot.joints[0].friction = rivid::Friction::symmetric;
    robot.joints[0].rotor_inertia = false;
    robot.joints[0].drive_gain = 35.15065188;
    const rivid::BaseParameters base = rivid::base_parameters(robot);
    const Eigen::Vector4d chi(95.1089, 203.5034, 20.3935, -3.1648);  // as published: M Fv Fc off

    const rivid::Log log = rivid::read_csv(path(file), {.rate_hz = 1000.0});

    const rivid::PdControl control{.k_p = Vector::Constant(1, 160.18),
                                   .k_v = Vector::Constant(1, 243.45),
                                   .v_tau_max = Vector::Constant(1, 10.0)};
    rivid::SimulationOptions options{.f_m = 1.0 / clock.period, .samples = log.samples()};
    options.sampling.period = clock.period;
    options.sampling.delay = clock.delay;
    options.sampling.velocity_filter = {0.5, 0.0, -0.5};
    if (pulses) {
      const rivid::Table table = rivid::read_table(path(file), {.columns = {"pulses_N"}});
      options.added_control = 1.014 * table.values;
    }
    // One sample a millisecond: the time columns drift by 8 and 16 ppm.
    const Vector t = Vector::LinSpaced(log.samples(), 0.0, 1e-3 * static_cast<double>(log.samples() - 1));
    const auto simulation = rivid::simulate(robot, base, chi, control, Vector::Constant(1, chi[0]),
                                            rivid::LoggedReference(t, log.q_r), options);
    EXPECT_EQ(simulation.outcome, rivid::Outcome::completed) << simulation.reason;

    const Matrix q = rivid::zero_phase(log.q, rivid::butterworth(4, 100.0, 1000.0));
    const rivid::Motion measured = rivid::differentiate(q, 1000.0);
    const double g_tau = robot.joints[0].g_tau();
    const Errors found = {relative_error(simulation.motion.q, measured.q),
                          relative_error(simulation.motion.qd, measured.qd),
                          relative_error(simulation.motion.qdd, measured.qdd),
                          relative_error(simulation.tau, g_tau * log.v_tau)};
    RecordProperty(file.substr(0, file.find('.')) + "_delay_" + std::to_string(clock.delay),
                   std::to_string(found[0]) + " " + std::to_string(found[1]) + " " +
                       std::to_string(found[2]) + " " + std::to_string(found[3]));
    return found;
  }
};

void expect_no_worse(const Errors& errors, const Errors& published) {
  constexpr std::array names = {"position", "velocity", "acceleration", "force"};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    EXPECT_LE(errors[i], published[i]) << names[i];
  }
}

// The recorded control signal shows no delay, and the samples are 1 ms apart (see the folder's README).
TEST_F(EmpsLoop, MovesAsRecorded) {
  expect_no_worse(errors("emps_ident.csv", {}), {0.013752, 0.22911, 8.6036, 5.848});
}

TEST_F(EmpsLoop, MovesAsRecordedUnderPulses) {
  expect_no_worse(errors("emps_pulses.csv", {}, true), {0.0080248, 0.47888, 19.8152, 8.9409});
}

// The authors' simulation delays the control signal by a sample; the recorded one is that of its own sample.
TEST_F(EmpsLoop, ADelayThatWasNotThereMakesItWorse) {
  for (const char* file : {"emps_ident.csv", "emps_pulses.csv"}) {
    const bool pulses = file == std::string("emps_pulses.csv");
    const Errors without = errors(file, {}, pulses);
    const Errors delayed = errors(file, {.period = 1e-3, .delay = 1}, pulses);
    for (std::size_t i = 0; i < without.size(); ++i) {
      EXPECT_GT(delayed[i], without[i]) << file << ", error " << i;
    }
  }
}

// The published simulation ran on a clock that was off by 16 ppm, and its position error is that clock's.
TEST_F(EmpsLoop, ThePublishedPositionErrorIsItsClocks) {
  const Errors found = errors("emps_ident.csv", {.period = 0.99998396e-3, .delay = 1});
  EXPECT_NEAR(found[0], 0.013752, 0.0001);
}

}  // namespace
