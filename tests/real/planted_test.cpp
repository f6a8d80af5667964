// Faults that users make, planted in logs of arms, are named by an identification alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iostream>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/text.hpp"
#include "support/real_experiment.hpp"

namespace {

using rivid::Index;
using rivid::Log;
using rivid::Matrix;
using rivid::Robot;

struct Fault {
  const char* name;
  std::set<std::string> codes;  // any of them names it
  std::function<void(Robot&, Log&)> plant;
};

void swap_columns(Matrix& x, Index a, Index b) { x.col(a).swap(x.col(b)); }

Matrix& torques(Log& log) { return log.tau.size() > 0 ? log.tau : log.v_tau; }

void delay(Log& log, Index samples) {
  Matrix& tau = torques(log);
  const Matrix before = tau;
  for (Index k = 0; k < tau.rows(); ++k) {
    tau.row(k) = before.row(std::max<Index>(k - samples, 0));
  }
}

void clip(Log& log, Index joint, double part) {
  auto tau = torques(log).col(joint);
  const double most = part * tau.cwiseAbs().maxCoeff();
  tau = tau.cwiseMax(-most).cwiseMin(most);
}

std::vector<Fault> faults() {
  static constexpr double degree = std::numbers::pi / 180.0;
  return {
      {"degrees", {"position_unit"}, [](Robot&, Log& log) { log.q /= degree; }},
      {"exchanged joints",
       {"joint_order"},
       [](Robot&, Log& log) {
         swap_columns(log.q, 1, 2);
         swap_columns(torques(log), 1, 2);
       }},
      {"both signs",
       {"torque_sign", "position_sign"},
       [](Robot&, Log& log) {
         log.q.col(1) *= -1.0;
         torques(log).col(1) *= -1.0;
       }},
      {"one sign", {"torque_sign", "position_sign"}, [](Robot&, Log& log) { torques(log).col(2) *= -1.0; }},
      {"zero off by 90 degrees",
       {"zero_offset"},
       [](Robot&, Log& log) { log.q.col(2).array() += 0.5 * std::numbers::pi; }},
      {"mN·m in one joint", {"torque_unit"}, [](Robot&, Log& log) { torques(log).col(3) *= 1000.0; }},
      {"ms",
       {"time_scale", "velocity_limit", "stated_rate"},
       [](Robot&, Log& log) {
         log.t *= 1000.0;
         log.f_m /= 1000.0;
       }},
      {"20 samples late", {"torque_delay", "torque_lag"}, [](Robot&, Log& log) { delay(log, 20); }},
      {"5 samples late", {"torque_delay", "torque_lag"}, [](Robot&, Log& log) { delay(log, 5); }},
      {"saturation", {"torque_saturated"}, [](Robot&, Log& log) { clip(log, 1, 0.6); }},
      {"wrong gravity",
       {"gravity_direction"},
       [](Robot& robot, Log&) { robot.chain.gravity = {9.80665, 0.0, 0.0}; }},
      {"gain times two", {"torque_gain"}, [](Robot&, Log& log) { torques(log).col(1) *= 2.0; }},
      {"clock 10 % off",
       {"clock_rate", "time_scale"},
       [](Robot&, Log& log) {
         log.t *= 1.1;
         log.f_m /= 1.1;
       }},
      {"stuck joint", {"joint_still"}, [](Robot&, Log& log) { log.q.col(4).setConstant(log.q(0, 4)); }},
  };
}

struct Arm {
  const char* name;
  // Faults that are named at least. At TX40 and KUKA friction and rotor inertias of their own make up most of
  // the torques of a joint: a wrong scale, zero or instant is taken up by these, and the log fits as well as
  // before.
  std::size_t least;

  friend std::ostream& operator<<(std::ostream& out, const Arm& arm) { return out << arm.name; }
};

class Planted : public rivid::test::RealExperiment, public testing::WithParamInterface<Arm> {
 protected:
  Planted() : RealExperiment(GetParam().name) {}
};

TEST_P(Planted, FaultsAreNamed) {
  const rivid::Experiment e = experiment();
  std::size_t named = 0;
  std::string missed;
  const double without = identify(e.robot, read_logs(e.log, e.robot), {}).fit.relative_error;
  const std::vector<Fault> all = faults();
  for (const Fault& fault : all) {
    Robot robot = e.robot;
    std::vector<Log> logs = read_logs(e.log, e.robot);
    for (Log& log : logs) {
      fault.plant(robot, log);
    }
    std::string told;
    bool found = false;
    bool refused = false;
    std::string fit;
    try {
      const rivid::Identification result = identify(robot, logs, {});
      fit = "; torques are missed by " + rivid::fixed(100.0 * result.fit.relative_error, 2) + " %, " +
            rivid::fixed(100.0 * without, 2) + " % without the fault";
      refused = result.status != rivid::Status::identified;
      for (const rivid::Finding& f : result.warnings) {
        told += ' ' + f.code;
        // Limits that another zero would keep, with its value, are a name of that fault too.
        const bool by_limits = f.code == "position_limits" && fault.codes.contains("zero_offset") &&
                               f.text.find("offset = -1.5708") != std::string::npos;
        found = found || fault.codes.contains(f.code) || by_limits;
      }
    } catch (const rivid::InputError& error) {
      told = error.what();
    }
    named += found ? 1U : 0U;
    if (!found) {
      missed += std::string("\n  ") + fault.name + (refused ? " (not identified)" : "") + ":" + told + fit;
    }
  }
  std::cout << "[ NAMED    ] " << GetParam().name << ": " << named << " of " << all.size() << missed << '\n';
  EXPECT_GE(named, GetParam().least) << missed;
}

INSTANTIATE_TEST_SUITE_P(Arms, Planted,
                         testing::Values(Arm{"ur10e", 13}, Arm{"panda", 14}, Arm{"tx40", 10},
                                         Arm{"kuka_kr300", 12}, Arm{"ur10_vrep", 14}),
                         [](const auto& arm) { return std::string(arm.param.name); });

}  // namespace
