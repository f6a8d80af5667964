// DIDIM and closed-loop output error on the log of EMPS, against NumPy and SciPy: emps_loop_oracle.py.

#include <gtest/gtest.h>

#include "rivid/data/csv.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "support/real_data.hpp"

namespace rivid {
namespace {

class EmpsLoopMethods : public test::RealData {
 protected:
  EmpsLoopMethods() : RealData("emps") {}

  [[nodiscard]] Identification found(Iv::Compares what) const {
    Robot robot = read_urdf(path("emps.urdf"));
    Joint& joint = robot.joints[0];
    joint.friction = Friction::symmetric;
    joint.rotor_inertia = false;
    joint.sign_speed = 0.005;
    joint.drive_gain = 35.15065188;
    Log log = excerpt(read_csv(path("emps_ident.csv"), {.rate_hz = 1000.0}), 3104, 8000);
    log.tau.resize(0, 0);
    Iv iv{.control = PdControl{.k_p = Vector::Constant(1, 160.18),
                               .k_v = Vector::Constant(1, 243.45),
                               .v_tau_max = Vector::Constant(1, 10.0)},
          .sampling = {.period = 1.0 / log.f_m, .velocity_filter = {0.5, 0.0, -0.5}}};
    iv.start_on_reference = true;
    iv.chi_0 = Eigen::Vector4d(95.1089, 203.5034, 20.3935, -3.1648);  // as published: M Fv Fc off
    iv.tolerance = 1e-12;
    iv.parameter_tolerance = what == Iv::Compares::positions ? 1e-3 : 1e-6;
    iv.compares = what;
    iv.simulation.integrator = Integrator::automatic;
    iv.simulation.rtol = 1e-11;
    iv.simulation.atol = 1e-13;
    SignalOptions signal{.rows = RowScheme::paper};
    signal.decimation.clear();
    signal.trim = {{0, 0}};
    return identify(robot, log, {.method = std::move(iv), .signal = signal});
  }
};

void expect_near(const Identification& found, const Eigen::Vector4d& wanted) {
  ASSERT_EQ(found.status, Status::identified) << (found.reasons.empty() ? "" : found.reasons.front());
  for (Index i = 0; i < wanted.size(); ++i) {
    const ParameterEstimate& p = found.parameters[static_cast<std::size_t>(i)];
    EXPECT_NEAR(p.value, wanted[i], 1e-3 * p.sigma) << p.name;
  }
}

TEST_F(EmpsLoopMethods, DidimIsThatOfNumPy) {
  expect_near(found(Iv::Compares::torques), {95.6691608, 202.759229, 20.4884142, -2.97458893});
}

TEST_F(EmpsLoopMethods, OutputErrorIsThatOfSciPy) {
  expect_near(found(Iv::Compares::positions), {95.1254436, 204.033381, 20.3722572, -2.94874705});
}

}  // namespace
}  // namespace rivid
