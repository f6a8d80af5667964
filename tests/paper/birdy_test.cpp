// BIRDy's TX40 scenario, from its own scheme of making data: errors of the base parameters against a replica
// that was written by others, in the replica's base parameters (Leboutet et al., Applied Sciences 2021, for
// the scenario).

#include "support/birdy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "rivid/identify/identification.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace {

using rivid::Estimation;
using rivid::Identification;
using rivid::Index;
using rivid::Iv;
using rivid::Log;
using rivid::Matrix;
using rivid::Ols;
using rivid::PdControl;
using rivid::SignalOptions;
using rivid::Status;
using rivid::Vector;
using rivid::Wls;
using rivid::test::BirdyTx40;

constexpr std::uint64_t seeds = 5;
// Means over five seeds of errors that are mostly noise; the replica has other seeds.
constexpr double other_seeds = 0.30;

class Birdy : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(RIVID_REAL_DATA).parent_path() / "reference" / "birdy_tx40_trajectory.csv";
    if (!std::filesystem::exists(file_)) {
      GTEST_SKIP() << "no " << file_;
    }
  }

  [[nodiscard]] Log log(double noise, std::uint64_t seed) const {
    return scenario_.log(BirdyTx40::reference(file_.string()), noise, seed);
  }

  // ‖β̂ − β‖ / ‖β‖ [%].
  [[nodiscard]] double error(const Vector& chi) const {
    const Vector beta = T_ * robot_.chi_st();
    return 100.0 * (T_ * base_.to_standard(chi) - beta).norm() / beta.norm();
  }

  // Its controller, known; the signs of W are those of the data, as it has them.
  [[nodiscard]] Estimation iv(const Log& log, const SignalOptions& signal, bool adapted = true) const {
    PdControl control = scenario_.control;
    if (adapted) {
      control.J_apriori = rivid::design_inertia(rivid::DynamicModel(robot_, robot_.chi_st()), log.q);
    }
    Iv iv{.control = control, .sampling = BirdyTx40::loop(0.0, 0).sampling, .signs = Iv::Signs::measured};
    iv.sampling.position_noise.resize(0, 0);
    return {.method = iv, .signal = signal, .judge = false};
  }

  // Nothing known but rotors of 10 kg·m².
  [[nodiscard]] Vector heavy_rotors() const {
    Vector chi_st = Vector::Zero(static_cast<Index>(base_.standard.size()));
    for (std::size_t i = 0; i < base_.standard.size(); ++i) {
      chi_st[static_cast<Index>(i)] = base_.standard[i].kind == rivid::ParameterKind::Ia ? 10.0 : 0.0;
    }
    return base_.from_standard(chi_st);
  }

  struct Table {
    double ols, ols_filtered, wls_filtered, iv, iv_filtered;
  };
  void expect_table(double noise, const Table& replica) const {
    Table found{};
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const Log log = this->log(noise, seed);
      const auto add = [&](double& to, const Identification& result) {
        EXPECT_EQ(result.status, Status::identified) << result.title << ", seed " << seed;
        to += error(result.chi) / static_cast<double>(seeds);
      };
      add(found.ols, identify(robot_, log, {.method = Ols{}, .signal = raw(), .judge = false}));
      add(found.ols_filtered, identify(robot_, log, {.method = Ols{}, .signal = filtered(), .judge = false}));
      add(found.wls_filtered, identify(robot_, log, {.method = Wls{}, .signal = filtered(), .judge = false}));
      add(found.iv, identify(robot_, log, iv(log, raw())));
      add(found.iv_filtered, identify(robot_, log, iv(log, filtered())));
    }
    EXPECT_NEAR(found.ols, replica.ols, other_seeds * replica.ols);
    EXPECT_NEAR(found.ols_filtered, replica.ols_filtered, other_seeds * replica.ols_filtered);
    EXPECT_NEAR(found.wls_filtered, replica.wls_filtered, other_seeds * replica.wls_filtered);
    EXPECT_NEAR(found.iv, replica.iv, other_seeds * replica.iv);
    EXPECT_NEAR(found.iv_filtered, replica.iv_filtered, other_seeds * replica.iv_filtered);
    RecordProperty("errors", std::to_string(found.ols) + " " + std::to_string(found.ols_filtered) + " " +
                                 std::to_string(found.wls_filtered) + " " + std::to_string(found.iv) + " " +
                                 std::to_string(found.iv_filtered));
  }

  static SignalOptions raw() { return {.rows = rivid::RowScheme::paper, .trim = {{50, 50}}}; }
  static SignalOptions filtered() {
    return {.rows = rivid::RowScheme::paper, .cutoff_hz = 50.0, .trim = {{50, 50}}};
  }

  std::filesystem::path file_;
  BirdyTx40 scenario_;
  rivid::Robot robot_ = scenario_.smooth_robot();
  rivid::BaseParameters base_ = rivid::base_parameters(robot_);
  Matrix T_ = BirdyTx40::its_base_parameters(robot_);
};

TEST_F(Birdy, HasAsManyBaseParametersByTheNormsOfColumns) {
  EXPECT_EQ(T_.rows(), 52);
  EXPECT_EQ(base_.size(), 52);
}

TEST_F(Birdy, AtLowNoiseTheErrorsAreThoseOfTheReplica) {
  expect_table(BirdyTx40::low_noise,
               {.ols = 0.96, .ols_filtered = 0.52, .wls_filtered = 0.50, .iv = 0.27, .iv_filtered = 0.41});
}

TEST_F(Birdy, AtStandardNoiseTheErrorsAreThoseOfTheReplica) {
  expect_table(BirdyTx40::standard_noise,
               {.ols = 14.5, .ols_filtered = 2.9, .wls_filtered = 2.7, .iv = 3.2, .iv_filtered = 2.7});
}

// The replica goes on with an M(q) that is not positive definite, and does not converge with fixed gains (416
// % after 14 iterations). Here such an iterate is told, and the nearest physical parameters are simulated in
// its place: that brings fixed gains home too, so what adapted gains spare is the help.
TEST_F(Birdy, FromRotorsMuchTooHeavyAdaptedGainsNeedNoHelpAndFixedOnesMostlyDo) {
  int helped = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Log log = this->log(BirdyTx40::standard_noise, seed);
    Estimation method = iv(log, raw());
    const Identification known = identify(robot_, log, method);
    std::get<Iv>(method.method).chi_0 = heavy_rotors();
    const Identification adapted = identify(robot_, log, method);
    ASSERT_EQ(adapted.status, Status::identified);
    EXPECT_LE(adapted.iv->iterations.size(), 5U);
    EXPECT_NEAR(error(adapted.chi), error(known.chi), 0.01 * error(known.chi));
    for (const rivid::IvIteration& iteration : adapted.iv->iterations) {
      EXPECT_EQ(iteration.safeguard, "");
    }
    method = iv(log, raw(), false);
    std::get<Iv>(method.method).chi_0 = heavy_rotors();
    const Identification fixed = identify(robot_, log, method);
    helped += std::ranges::any_of(fixed.iv->iterations, [](const rivid::IvIteration& iteration) {
      return iteration.safeguard.find("nearest physical parameters") != std::string::npos;
    });
    // The start itself is far slower than the robot, where adapted gains keep it at the robot's poles.
    EXPECT_GT(fixed.iv->iterations[0].relative_error, 2.0 * adapted.iv->iterations[0].relative_error);
    std::string history;
    for (const rivid::IvIteration& iteration : fixed.iv->iterations) {
      history += std::to_string(error(iteration.chi)) + " " + iteration.safeguard + "; ";
    }
    RecordProperty("fixed_" + std::to_string(seed), std::string(name(fixed.status)) + " " + history);
  }
  EXPECT_GE(helped, 3);
}

}  // namespace
