// Identification of a robot with a four-bar linkage: planted friction, rotors and bodies within their
// intervals.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

#include "rivid/excite/excitation.hpp"
#include "rivid/export/model.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/dependent.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/normal.hpp"
#include "support/robots.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

constexpr const char* linkage = R"(<robot name="linkage">
<link name="base"/>
<joint name="crank" type="revolute"><parent link="base"/><child link="crank_link"/><axis xyz="0 1 0"/>
  <limit lower="-2" upper="2" effort="9" velocity="9"/></joint>
<link name="crank_link"><inertial><origin xyz="0.1 0.01 0.15"/><mass value="2"/>
  <inertia ixx="0.02" iyy="0.03" izz="0.01" ixy="0" ixz="0.002" iyz="0"/></inertial></link>
<joint name="coupler" type="continuous"><parent link="crank_link"/><child link="coupler_link"/>
  <origin xyz="0.1 0 0.3"/><axis xyz="0 1 0"/></joint>
<link name="coupler_link"><inertial><origin xyz="0.2 0 0.05"/><mass value="1.5"/>
  <inertia ixx="0.01" iyy="0.04" izz="0.03" ixy="0" ixz="0" iyz="0.001"/></inertial></link>
<joint name="rocker" type="continuous"><parent link="base"/><child link="rocker_link"/>
  <origin xyz="0.5 0 0.02"/><axis xyz="0 -1 0"/></joint>
<link name="rocker_link"><inertial><origin xyz="0.02 0 0.2"/><mass value="1"/>
  <inertia ixx="0.02" iyy="0.02" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="wrist" type="revolute"><parent link="coupler_link"/><child link="hand"/>
  <origin xyz="0.45 0 0.15"/><axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="9" velocity="9"/></joint>
<link name="hand"><inertial><origin xyz="0.05 0.03 0.02"/><mass value="0.8"/>
  <inertia ixx="0.003" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>)";

Robot with_linkage(const Eigen::Vector3d& at = {0.05, 0.0, 0.43}) {
  const FourBar bar{.crank = "crank", .coupler = "coupler", .rocker = "rocker", .at = at};
  return parse_urdf(linkage, "linkage.urdf", {.base = {}, .tip = {}, .four_bars = {bar}});
}

TEST(FourBar, IsClosedByAConstraintInMujoco) {
  const test::TemporaryFolder folder;
  folder.write("linkage.urdf", linkage);
  const Robot robot = with_linkage();
  const ExportedModel model =
      exported_model(ModelFormat::mjcf, folder.path() / "linkage.urdf", robot, robot.chi_st(), {});
  ASSERT_FALSE(model.files.empty());
  const std::string& text = model.files[0].text;
  const std::string_view open = "<connect body1=\"coupler_link\" body2=\"rocker_link\" anchor=\"";
  const std::size_t at = text.find(open);
  ASSERT_NE(at, std::string::npos) << text;
  std::istringstream numbers(text.substr(at + open.size()));
  Eigen::Vector3d anchor;
  numbers >> anchor[0] >> anchor[1] >> anchor[2];
  EXPECT_LT((anchor - Eigen::Vector3d(0.45, 0.0, 0.15)).norm(), 1e-14);
  for (const Finding& warning : model.warnings) {
    EXPECT_EQ(warning.text.find("four-bar"), std::string::npos) << warning.text;
  }
}

TEST(FourBar, RefusesPositionsThatItDoesNotReach) {
  Log log;
  log.source = "linkage.csv";
  log.t = Vector::LinSpaced(100, 0.0, 0.99);
  log.f_m = 100.0;
  log.q = Matrix::Zero(100, 2);
  log.q.col(0).setLinSpaced(0.0, 3.0);
  log.tau = Matrix::Ones(100, 2);
  const std::string said =
      test::complaint_of([&] { return identify(with_linkage({-0.1, 0.0, 0.2}), log, {.method = Wls{}}); });
  EXPECT_TRUE(test::says(said, "linkage.csv: row "));
  EXPECT_TRUE(test::says(said, "the linkage or table of \"coupler\" reaches from"));
}

TEST(FourBar, MotionsAreDesignedWithinItsReach) {
  const Robot robot = with_linkage({-0.1, 0.0, 0.2});
  const auto [least, most] = robot.chain.reach(0);
  ASSERT_TRUE(std::isfinite(least) && std::isfinite(most));
  ExcitationOptions options{.duration = 5.0, .starts = 1, .evaluations = 40};
  options.limits.acceleration = Vector::Constant(2, 12.0);
  options.limits.torque = Eigen::Vector2d(60.0, 20.0);
  const Excitation found = design(robot, options);
  EXPECT_GE(found.motion.q.col(0).minCoeff(), least);
  EXPECT_LE(found.motion.q.col(0).maxCoeff(), most);
  InverseDynamics dynamics(DynamicModel(robot, robot.chi_st()));
  double largest = 0.0;
  Vector tau(2);
  for (Index k = 0; k < found.motion.samples(); ++k) {
    dynamics.torque(Vector(found.motion.q.row(k)), Vector(found.motion.qd.row(k)),
                    Vector(found.motion.qdd.row(k)), tau);
    largest = std::max({largest, std::abs(tau[0]) / 60.0, std::abs(tau[1]) / 20.0});
  }
  EXPECT_LE(largest, 1.0 + 1e-3);
}

TEST(FourBar, ParametersLieWithinTheirIntervals) {
  const Robot robot = with_linkage();
  ASSERT_EQ(robot.size(), 2);
  const BaseParameters base = base_parameters(robot);
  const Vector chi = base.from_standard(test::distinct_friction(robot));
  constexpr Index samples = 10000;
  constexpr int runs = 20;
  double held = 0.0;
  double all = 0.0;
  for (int run = 0; run < runs; ++run) {
    std::mt19937_64 random(static_cast<std::uint64_t>(run + 1));
    test::Normal normal;
    Log log;
    log.source = "linkage.csv";
    log.t = Vector::LinSpaced(samples, 0.0, 9.999);
    log.f_m = 1000.0;
    Motion motion{Matrix::Zero(samples, 2), Matrix::Zero(samples, 2), Matrix::Zero(samples, 2)};
    for (Index j = 0; j < 2; ++j) {
      for (int l = 1; l <= 5; ++l) {
        const double omega = 0.4 * std::numbers::pi * l;
        const double a = 0.4 * normal(random) / std::sqrt(l);
        const double phase = 3.0 * normal(random);
        const auto angle = (omega * log.t.array() + phase).eval();
        motion.q.col(j).array() += a * angle.sin();
        motion.qd.col(j).array() += a * omega * angle.cos();
        motion.qdd.col(j).array() -= a * omega * omega * angle.sin();
      }
    }
    log.q = motion.q;
    log.tau = (observation(robot, base, motion).dense() * chi).reshaped(samples, 2);
    log.tau += Matrix::NullaryExpr(samples, 2, [&] { return 0.2 * normal(random); });
    const Identification found =
        identify(robot, log, {.method = Wls{}, .signal = {.torque_held = false, .decimation = {10}}});
    ASSERT_EQ(found.status, Status::identified) << run << found.reasons.front();
    for (Index i = 0; i < chi.size(); ++i) {
      const auto& interval = found.parameters[static_cast<std::size_t>(i)].interval_95;
      held += interval[0] <= chi[i] && chi[i] <= interval[1] ? 1.0 : 0.0;
      all += 1.0;
    }
  }
  RecordProperty("coverage", std::to_string(held / all));
  EXPECT_GE(held / all, 0.92);
  EXPECT_LE(held / all, 0.995);
}

}  // namespace
}  // namespace rivid
