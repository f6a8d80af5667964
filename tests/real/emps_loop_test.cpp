// EMPS in its closed loop: the published estimates and controller against the recorded motion.

#include <gtest/gtest.h>

#include <array>

#include "rivid/data/csv.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/signal/differentiate.hpp"
#include "rivid/signal/zero_phase.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/logged_reference.hpp"
#include "rivid/simulate/pd_control.hpp"
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
    const Vector t = Vector::LinSpaced(log.samples(), 0.0, 1e-3 * static_cast<double>(log.samples() - 1));
    const auto simulation =
        rivid::simulate(robot, base, chi, control, Vector::Constant(1, chi[0]),
                        rivid::LoggedReference(t, log.q_r), options);
    EXPECT_EQ(simulation.outcome, rivid::Outcome::completed) << simulation.reason;

    const Matrix q = rivid::zero_phase(log.q, rivid::butterworth(4, 100.0, 1000.0));
    const rivid::Motion measured = rivid::differentiate(q, 1000.0);
    const double g_tau = robot.joints[0].g_tau();
    RecordProperty("mode_changes", std::to_string(simulation.effort.mode_changes));
    return {relative_error(simulation.motion.q, measured.q), relative_error(simulation.motion.qd, measured.qd),
            relative_error(simulation.motion.qdd, measured.qdd), relative_error(simulation.tau, g_tau * log.v_tau)};
  }
};

TEST_F(EmpsLoop, MovesAsRecorded) {
  for (auto& [file,pulses] : std::array<std::pair<const char*,bool>,2>{{{"emps_ident.csv",false},{"emps_pulses.csv",true}}})
    for (const Clock& c : std::array<Clock, 3>{{{1e-3, 0}, {1e-3, 1}, {0.99998396e-3, 1}}}) {
      const Errors e = errors(file, c, pulses);
      std::printf("%s %.8g %d: %.6f %.5f %.4f %.4f\n", file, c.period, c.delay, e[0], e[1], e[2], e[3]);
    }
}

}  // namespace
