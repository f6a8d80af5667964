#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "rivid/error.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/instruments.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/scara_study.hpp"

namespace {

using rivid::BaseParameters;
using rivid::Estimation;
using rivid::Index;
using rivid::Iv;
using rivid::Matrix;
using rivid::Robot;
using rivid::Status;
using rivid::Vector;

TEST(RegularStart, IsOneForRotorsAndElseForTheLinkItself) {
  const Robot slider = rivid::test::slider();
  EXPECT_EQ(regular_start(slider, rivid::base_parameters(slider)), (Vector(4) << 1, 0, 0, 0).finished());
  const Robot with_rotor = rivid::test::slider(rivid::Friction::none, true);
  EXPECT_NEAR(regular_start(with_rotor, rivid::base_parameters(with_rotor))[0], 1.0, 1e-12);
}

TEST(RegularStart, OfThePapersScaraIsItsOwn) {
  Robot scara = rivid::test::scara();
  scara.joints[0].rotor_inertia = false;
  const BaseParameters base = rivid::base_parameters(scara);
  const Vector chi = regular_start(scara, base);
  for (Index i = 0; i < 8; ++i) {
    const std::string& name = base.parameters[static_cast<std::size_t>(i)].name;
    EXPECT_EQ(chi[i], name == "ZZ1R" || name == "ZZ2" ? 1.0 : 0.0) << name;
  }
}

TEST(RegularStart, MakesTheMassMatrixOfAnyRobotPositiveDefinite) {
  std::mt19937_64 random(61);
  for (int n = 1; n <= 9; ++n) {
    Robot robot = rivid::test::random_robot(n, random);
    for (const bool rotors : {true, false}) {
      for (rivid::Joint& joint : robot.joints) {
        joint.rotor_inertia = rotors;
      }
      const BaseParameters base = rivid::base_parameters(robot);
      const rivid::DynamicModel model(robot, base, regular_start(robot, base));
      const Vector q = rivid::test::random_motion(1, n, random).q.row(0);
      EXPECT_GT(smallest_eigenvalue(model, q), 1e-6) << n << " joints";
    }
  }
}

struct IvOfTheScara : public ::testing::Test, public rivid::test::ScaraStudy {
  std::string refusal(const Estimation& method, const rivid::Log& log) const {
    return rivid::test::complaint_of([&] { return identify(robot, log, method); });
  }
};

TEST_F(IvOfTheScara, WithoutNoiseAndFilterFindsTheInertias) {
  encoder_noise = 0.0;
  disturbance.setZero();
  const auto found = identify(robot, log(1.0, 1), iv());
  ASSERT_EQ(found.status, Status::identified);
  for (const char* name : {"ZZ1R", "ZZ2"}) {
    // Rows where a joint sticks or reverses obey no model; that floor is the same at any noise.
    constexpr double floor = 0.01;
    EXPECT_NEAR(found.chi[index(name)], truth[index(name)], floor * truth[index(name)]) << name;
  }
}

// R² of Shea (1997): what least squares knows of a parameter over what the instruments do.
TEST_F(IvOfTheScara, TellsTheStrengthOfItsInstruments) {
  Estimation estimation = iv();
  Iv& method = std::get<Iv>(estimation.method);
  method.weights = Iv::Weights::none;
  method.signs = Iv::Signs::measured;
  method.max_iterations = 50;
  estimation.judge = false;
  const rivid::Log log = this->log(1.0, 1);
  const auto found = identify(robot, log, estimation);
  ASSERT_EQ(found.status, Status::identified) << found.reasons.front();
  const Matrix W = rivid::rows(robot, base, log, found.estimation.signal).W.dense();
  const Matrix V = rivid::instrument_rows(robot, found, std::span(&log, 1)).front().dense();
  ASSERT_EQ(V.rows(), W.rows());
  const Matrix by_ls = (W.transpose() * W).inverse();
  const Matrix VW = (V.transpose() * W).inverse();
  const Matrix by_iv = VW * (V.transpose() * V) * VW.transpose();
  const auto freedom = static_cast<double>(W.rows() - base.size());
  for (Index i = 0; i < base.size(); ++i) {
    const double R2 = by_ls(i, i) / by_iv(i, i);
    EXPECT_LT(R2, 1.0);
    EXPECT_NEAR(found.iv->first_stage_F[i] / (freedom * R2 / (1.0 - R2)), 1.0, 1e-3) << i;
  }
}

TEST_F(IvOfTheScara, SeveralLogsCountTogether) {
  const std::vector<rivid::Log> logs = {log(1.0, 1), log(2.0, 2)};
  const auto both = identify(robot, logs, iv());
  const auto first = identify(robot, logs[0], iv());
  ASSERT_EQ(both.status, Status::identified);
  EXPECT_EQ(both.fit.rows, 2 * first.fit.rows);
  EXPECT_LT(both.parameters[static_cast<std::size_t>(index("ZZ1R"))].sigma,
            first.parameters[static_cast<std::size_t>(index("ZZ1R"))].sigma);
}

TEST_F(IvOfTheScara, IsTheSameWithAnyNumberOfThreads) {
  const rivid::Log log = this->log(2.0, 1);
  Estimation method = iv();
  const auto one = identify(robot, log, method);
  method.threads = 3;
  const auto three = identify(robot, log, method);
  EXPECT_EQ(one.chi, three.chi);
  EXPECT_EQ(one.C_chi, three.C_chi);
}

TEST_F(IvOfTheScara, ScalesWithTheDriveGain) {
  rivid::Log log = this->log(2.0, 1);
  const auto right = identify(robot, log, iv());
  for (rivid::Joint& joint : robot.joints) {
    joint.drive_gain = 2.0;
  }
  const auto doubled = identify(robot, log, iv());
  ASSERT_EQ(doubled.status, Status::identified);
  EXPECT_LT((doubled.chi - 2.0 * right.chi).norm(), 1e-3 * right.chi.norm());
}

TEST_F(IvOfTheScara, TellsOfAWrongController) {
  Estimation method = iv(0.5);
  method.signal = filtered();
  const auto found = identify(robot, log(2.0, 1), method);
  ASSERT_FALSE(found.warnings.empty());
  const auto told = [&](const char* code, const char* what) {
    return std::ranges::any_of(found.warnings, [&](const rivid::Finding& warning) {
      return warning.code == code && warning.text.find(what) != std::string::npos;
    });
  };
  EXPECT_TRUE(told("loop_mismatch", "the assumed controller may not be the actual one"));
  EXPECT_TRUE(
      told("loop_bandwidth", "the bandwidth of the assumed controller may be far from the actual one"));
}

TEST_F(IvOfTheScara, WithoutAReferenceFollowsTheMeasuredMotion) {
  rivid::Log log = this->log(2.0, 1);
  log.q_r.resize(0, 0);
  Estimation method = iv(20.0);
  std::get<Iv>(method.method).control = rivid::PdControl{
      .omega_n = Eigen::Vector2d(20, 20), .zeta = Eigen::Vector2d(1, 1), .reference_velocity = true};
  std::get<Iv>(method.method).sampling = {};
  EXPECT_NE(refusal(method, log).find("no reference columns"), std::string::npos);
  std::get<Iv>(method.method).follows = Iv::Follows::measured;
  std::get<Iv>(method.method).reference_cutoff_hz = 5.0;
  const auto found = identify(robot, log, method);
  ASSERT_EQ(found.status, Status::identified);
  EXPECT_NEAR(found.chi[index("ZZ1R")], 3.44, 0.03 * 3.44);
}

TEST_F(IvOfTheScara, RefusesWhatItCanNotUse) {
  const rivid::Log log = this->log(1.0, 1);
  Estimation method = iv();
  std::get<Iv>(method.method).control = {};
  EXPECT_NE(refusal(method, log).find("control is not set"), std::string::npos);
  std::get<Iv>(method.method).control = [](const rivid::Plant&) { return nullptr; };
  EXPECT_NE(refusal(method, log).find("control returns no law"), std::string::npos);
  method = iv();
  std::get<Iv>(method.method).tolerance = 0.0;
  EXPECT_EQ(refusal(method, log), "identify(IDIM-IV): tolerance is 0, must be at least 1e-12");
  method = iv();
  std::get<Iv>(method.method).max_iterations = 0;
  EXPECT_EQ(refusal(method, log), "identify(IDIM-IV): max_iterations is 0, must be at least 1");
  method = iv();
  std::get<Iv>(method.method).chi_0 = Vector::Zero(3);
  EXPECT_EQ(refusal(method, log),
            "identify(IDIM-IV): chi_0 has 3 values, must have one, finite, for each of 8 base parameters");
}

TEST_F(IvOfTheScara, AStartThatIsNoRobotIsToldOrMended) {
  Estimation method = iv();
  std::get<Iv>(method.method).chi_0 = truth;
  std::get<Iv>(method.method).chi_0[index("ZZ2")] = -0.5;
  const auto found = identify(robot, log(2.0, 1), method);
  if (found.status == Status::identified) {
    EXPECT_NE(found.iv->iterations.front().safeguard.find("must be positive"), std::string::npos)
        << found.iv->iterations.front().safeguard;
  } else {
    EXPECT_FALSE(found.reasons.empty());
  }
}

}  // namespace
