// DIDIM and closed-loop output error: what else a simulated loop can be compared by.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "rivid/data/table.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/identification.hpp"
#include "support/complaint.hpp"
#include "support/scara_study.hpp"

namespace {

using rivid::Estimation;
using rivid::Identification;
using rivid::Index;
using rivid::Iv;
using rivid::Log;
using rivid::Matrix;
using rivid::PdControl;
using rivid::Robot;
using rivid::RowScheme;
using rivid::Status;
using rivid::Vector;

Estimation comparing(Estimation estimation, Iv::Compares what) {
  std::get<Iv>(estimation.method).compares = what;
  return estimation;
}

// An arm, its controller and its log, as a script beside this file has them.
struct OfAnOracle : public ::testing::Test {
  // file  columns of positions, torques and references, at 200 Hz
  OfAnOracle(Robot arm, const std::string& file, double sign_speed, PdControl gains)
      : robot(std::move(arm)), control(std::move(gains)) {
    const Index n = robot.size();
    const Matrix columns = read(file).values;
    log.source = file;
    log.f_m = 200.0;
    log.t = Vector::NullaryExpr(columns.rows(), [&](Index k) { return static_cast<double>(k) / log.f_m; });
    log.q = columns.leftCols(n);
    log.tau = columns.middleCols(n, n);
    log.q_r = columns.rightCols(n);
    for (rivid::Joint& joint : robot.joints) {
      joint.sign_speed = sign_speed;
    }
  }

  [[nodiscard]] static rivid::Table read(const std::string& file) {
    return rivid::read_table(std::filesystem::path(RIVID_TEST_DATA) / "identify" / file);
  }

  // Rows as the oracle has them: torques at the samples, no decimation, none left out.
  [[nodiscard]] Estimation estimation(Iv::Compares what) const {
    Iv iv{.control = control, .sampling = {.period = 1.0 / log.f_m}};
    iv.start_on_reference = true;
    iv.tolerance = 1e-12;
    iv.parameter_tolerance = 1e-6;
    iv.compares = what;
    iv.chi_0 = truth;
    iv.simulation.integrator = rivid::Integrator::dormand_prince;
    iv.simulation.rtol = 1e-7;
    iv.simulation.atol = 1e-9;
    if (what == Iv::Compares::positions) {
      // Below what differences of simulations tell.
      iv.parameter_tolerance = 1e-3;
    }
    rivid::SignalOptions signal{.rows = RowScheme::paper};
    signal.decimation.clear();
    signal.trim = {{0, 0}};
    return {.method = std::move(iv), .signal = signal};
  }

  Robot robot;
  PdControl control;
  Log log;
  Vector truth;
};

void expect_near(const Identification& found, const Vector& wanted, double part_of_sigma) {
  ASSERT_EQ(found.status, Status::identified) << (found.reasons.empty() ? "" : found.reasons.front());
  ASSERT_EQ(std::ssize(found.parameters), wanted.size());
  for (Index i = 0; i < wanted.size(); ++i) {
    const auto& p = found.parameters[static_cast<std::size_t>(i)];
    EXPECT_NEAR(p.value, wanted[i], part_of_sigma * p.sigma) << p.name;
  }
}

Robot scara_without_rotor() {
  Robot out = rivid::test::scara();
  out.joints[0].rotor_inertia = false;
  return out;
}

struct OfTheOracle : public OfAnOracle {
  OfTheOracle()
      : OfAnOracle(scara_without_rotor(), "loop_oracle.csv", 0.05,
                   {.k_p = Eigen::Vector2d(4.0, 6.0), .k_v = Eigen::Vector2d(14.0, 1.2)}) {
    truth = (Vector(8) << 3.44, 0.03, 0.82, 0.062, 0.242, 0.014, 0.013, 0.137).finished();
  }
};

TEST_F(OfTheOracle, DidimIsThatOfNumPy) {
  const Identification found = identify(robot, log, estimation(Iv::Compares::torques));
  EXPECT_EQ(found.method, "didim");
  EXPECT_EQ(found.title, "DIDIM");
  EXPECT_EQ(found.fit.rows, 2 * log.samples());
  expect_near(found,
              (Vector(8) << 3.43999812, 0.0312930316, 0.81252949, 0.0619205538, 0.242170886, 0.0140531537,
               0.0142830712, 0.134894623)
                  .finished(),
              1e-3);
}

TEST_F(OfTheOracle, OutputErrorIsThatOfSciPy) {
  const Identification found = identify(robot, log, estimation(Iv::Compares::positions));
  EXPECT_EQ(found.method, "output_error");
  expect_near(found,
              (Vector(8) << 3.43961229, 0.0317834137, 0.812239086, 0.0619001986, 0.242233149, 0.014158105,
               0.0140262652, 0.135552074)
                  .finished(),
              1e-3);
  ASSERT_TRUE(found.output_error);
  EXPECT_EQ(found.output_error->start, truth);
  EXPECT_EQ(found.output_error->instants, log.samples());
  EXPECT_LT(found.output_error->joint_error.norm(), found.output_error->start_error.norm());
}

// The arm of data/six_axis, and what six_joints_oracle.py finds in its log.
struct SixJoints : public OfAnOracle {
  SixJoints()
      : OfAnOracle(rivid::read_experiment(std::filesystem::path(RIVID_DATA) / "six_axis/simulate.toml",
                                          rivid::Use::simulation)
                       .robot,
                   "six_joints_oracle.csv", 0.2,
                   {.k_p = (Vector(6) << 10.0, 10.0, 12.5, 15.0, 15.0, 15.0).finished(),
                    .k_v = (Vector(6) << 80.0, 80.0, 20.0, 6.0, 6.0, 1.5).finished()}) {
    truth = base_parameters(robot).from_standard(robot.chi_st());
  }

  void expect_row(Iv::Compares what, Index row) const {
    const rivid::Table wanted = read("six_joints_oracle_found.csv");
    const Identification found = identify(robot, log, estimation(what));
    std::vector<std::string> names;
    for (const rivid::BaseParameter& p : found.base.parameters) {
      names.push_back(p.name);
    }
    EXPECT_EQ(names, wanted.names);
    expect_near(found, wanted.values.row(row), 1e-3);
  }
};

TEST_F(SixJoints, DidimIsThatOfNumPy) { expect_row(Iv::Compares::torques, 0); }

TEST_F(SixJoints, OutputErrorIsThatOfNumPy) { expect_row(Iv::Compares::positions, 1); }

struct LoopMethods : public ::testing::Test, public rivid::test::ScaraStudy {
  [[nodiscard]] PdControl actual_gains() const {
    return {.k_p = (control.omega_n.array() / control.zeta.array() / 2.0).matrix(),
            .k_v = (2.0 * control.zeta.array() * control.omega_n.array() * J.array()).matrix()};
  }

  // Part of the 95 % intervals that hold the truth.
  [[nodiscard]] double coverage(Iv::Compares what, int runs) const {
    const Estimation method = comparing(iv(), what);
    double held = 0.0;
    double all = 0.0;
    for (int run = 1; run <= runs; ++run) {
      const Identification found = identify(robot, log(1.0, static_cast<std::uint64_t>(run)), method);
      EXPECT_EQ(found.status, Status::identified) << "seed " << run;
      for (Index i = 0; i < base.size(); ++i) {
        const auto& p = found.parameters[static_cast<std::size_t>(i)];
        held += p.interval_95[0] <= truth[i] && truth[i] <= p.interval_95[1] ? 1.0 : 0.0;
        ++all;
      }
    }
    return held / all;
  }
};

// With the deviations of V, as if it did not depend on the parameters, 83 % hold.
TEST_F(LoopMethods, IntervalsOfDidimKnowThatTheSimulationFollowsTheParameters) {
  const double held = coverage(Iv::Compares::torques, 40);
  EXPECT_GT(held, 0.93);
  RecordProperty("coverage", std::to_string(held));
}

TEST_F(LoopMethods, WithoutNoiseFindTheTruth) {
  encoder_noise = 0.0;
  disturbance.setZero();
  const Log clean = log(1.0, 1);
  for (const Iv::Compares what : {Iv::Compares::torques, Iv::Compares::positions}) {
    Estimation method = comparing(iv(), what);
    // Exact rows: the others have errors of their own.
    method.signal = {.torque_held = true, .decimation = {20}};
    const Identification found = identify(robot, clean, method);
    for (Index i = 0; i < base.size(); ++i) {
      EXPECT_NEAR(found.chi[i], truth[i], 0.02 * std::abs(truth[i])) << found.title << " " << i;
    }
  }
}

// A joint without viscous friction: where noise would have it drive, the others are found with it at zero.
// The poles of the law are known alone, so its gains have the errors of the start.
TEST_F(LoopMethods, OutputErrorLetsNoFrictionDrive) {
  set("Fv2", 0.0);
  const Index at = index("Fv2");
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Identification found = identify(robot, log(1.0, seed), comparing(iv(), Iv::Compares::positions));
    EXPECT_EQ(found.status, Status::identified) << seed;
    EXPECT_GE(found.chi[at], 0.0) << seed;
    held += found.chi[at] == 0.0 ? 1 : 0;
    for (Index i = 0; i < base.size(); ++i) {
      EXPECT_NEAR(found.chi[i], truth[i], 4.0 * found.parameters[static_cast<std::size_t>(i)].sigma) << i;
    }
  }
  EXPECT_GE(held, 1);
  EXPECT_LT(held, 6);

  // Gains that are known have no such errors: the scale is far better known.
  Estimation known = comparing(iv(), Iv::Compares::positions);
  std::get<Iv>(known.method).control = actual_gains();
  const Index scale = index("ZZ1R");
  const auto sigma = [&](const Estimation& estimation) {
    const Identification found = identify(robot, log(1.0, 1), estimation);
    EXPECT_NEAR(found.chi[scale], truth[scale],
                4.0 * found.parameters[static_cast<std::size_t>(scale)].sigma);
    return found.parameters[static_cast<std::size_t>(scale)].sigma;
  };
  EXPECT_LT(sigma(known), 0.8 * sigma(comparing(iv(), Iv::Compares::positions)));
}

// Fifty starts, each parameter off by a factor of up to so many: how many lead to the estimate of the others.
TEST_F(LoopMethods, BasinsOfAttraction) {
  const Log one = log(1.0, 1);
  const auto reached = [&](Iv::Compares what, double factor) {
    Estimation method = comparing(iv(), what);
    method.signal = {.torque_held = true, .decimation = {20}};
    // Those that follow poles would follow the start.
    std::get<Iv>(method.method).control = actual_gains();
    const Identification wanted = identify(robot, one, method);
    std::mt19937_64 random(50);
    std::uniform_real_distribution<double> exponent(-std::log(factor), std::log(factor));
    int out = 0;
    for (int k = 0; k < 50; ++k) {
      std::get<Iv>(method.method).chi_0 =
          truth.unaryExpr([&](double x) { return x * std::exp(exponent(random)); });
      const Identification found = identify(robot, one, method);
      bool same = found.status == Status::identified;
      for (std::size_t i = 0; same && i < wanted.parameters.size(); ++i) {
        same = std::abs(found.parameters[i].value - wanted.parameters[i].value) < wanted.parameters[i].sigma;
      }
      out += same ? 1 : 0;
    }
    return out;
  };
  for (const double factor : {2.0, 5.0}) {
    const int by_iv = reached(Iv::Compares::instruments, factor);
    const int by_didim = reached(Iv::Compares::torques, factor);
    const int by_output_error = reached(Iv::Compares::positions, factor);
    std::cout << "[ BASIN    ] factor " << factor << ": IDIM-IV " << by_iv << ", DIDIM " << by_didim
              << ", output error " << by_output_error << " of 50\n";
    EXPECT_EQ(by_iv, 50);
    EXPECT_GE(by_didim, factor < 3.0 ? 45 : 20);
    EXPECT_GE(by_output_error, factor < 3.0 ? 45 : 35);
  }
}

// Gains off by up to 10 % and a delay off by 0.4 periods. Ratios of gains, and the delay, are seen; the scale
// of gains, inertia and friction is what is known of the gains beforehand.
TEST_F(LoopMethods, OutputErrorFindsGainsAndDelayButForTheirScale) {
  const rivid::PidControl actual{.K_p = Eigen::Vector2d(200.0, 40.0), .K_d = Eigen::Vector2d(40.0, 6.0)};
  const rivid::PidControl given{.K_p = Eigen::Vector2d(220.0, 38.0), .K_d = Eigen::Vector2d(37.0, 6.5)};
  Vector true_gains(4);
  true_gains << actual.K_d, actual.K_p;
  Vector given_gains(4);
  given_gains << given.K_d, given.K_p;
  constexpr double delay = 1.4;
  constexpr double prior = 0.1;
  constexpr Index runs = 3;
  int held = 0;
  int all = 0;
  const auto count = [&](const std::array<double, 2>& interval, double value) {
    held += interval[0] <= value && value <= interval[1] ? 1 : 0;
    ++all;
  };
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    rivid::SimulationOptions options{.f_m = f_m, .sampling = computer()};
    options.sampling.delay = delay;
    constexpr Index rows = 4001;
    options.sampling.position_noise = rivid::white_noise(seed, 1, rows, Vector::Constant(2, encoder_noise));
    options.disturbance = rivid::white_noise(seed, 2, rows, disturbance);
    const rivid::Simulation run = simulate(robot, base, truth, actual, J, moves(0.7), options);
    Log log;
    log.t = run.t;
    log.f_m = f_m;
    log.q = run.q_measured;
    log.v_tau = run.v_tau;
    log.q_r = run.q_r;
    Estimation method = comparing(iv(), Iv::Compares::positions);
    Iv& loop = std::get<Iv>(method.method);
    loop.control = given;
    loop.sampling.delay = 1.0;
    loop.gain_sigma = {{"K_p", prior}, {"K_d", prior}};
    loop.delay_sigma = 1.0;
    const Identification found = identify(robot, log, method);
    ASSERT_EQ(found.status, Status::identified) << found.reasons.front();
    const std::vector<rivid::LoopEstimate>& gains = found.output_error->loop;
    ASSERT_EQ(gains.size(), 5U);
    // Against the first gain, of which the scale is.
    const double scale = gains[0].value / true_gains[0];
    double logarithms = 0.0;
    for (Index i = 0; i < 4; ++i) {
      const rivid::LoopEstimate& gain = gains[static_cast<std::size_t>(i)];
      logarithms += std::log(gain.value / gain.prior);
      EXPECT_EQ(gain.name, i < 2 ? "K_d" : "K_p");
      EXPECT_EQ(gain.joint, robot.joints[static_cast<std::size_t>(i % 2)].name);
      EXPECT_EQ(gain.prior, given_gains[i]);
      EXPECT_NEAR(gain.value / (scale * true_gains[i]), 1.0, 0.02) << gain.name;
      // Four gains, each known to 10 %.
      EXPECT_NEAR(gain.sigma / gain.value, 0.5 * prior, 0.01) << gain.name;
      count(gain.interval_95, true_gains[i]);
    }
    // What is too large by a factor weighs as much as what is too small by it.
    EXPECT_NEAR(logarithms, 0.0, 1e-3);
    EXPECT_EQ(gains[4].name, "delay");
    EXPECT_NEAR(gains[4].value, delay, 0.2);
    EXPECT_LT(gains[4].sigma, 0.1);
    count(gains[4].interval_95, delay);
    Index inertia = 0;
    found.chi.maxCoeff(&inertia);
    EXPECT_NEAR(found.chi[inertia] / truth[inertia], scale, 0.005);
    EXPECT_NEAR(found.parameters[static_cast<std::size_t>(inertia)].sigma / found.chi[inertia], 0.5 * prior,
                0.01);
    for (Index i = 0; i < truth.size(); ++i) {
      count(found.parameters[static_cast<std::size_t>(i)].interval_95, truth[i]);
    }
    EXPECT_NE(found.output_error->scale.find("gain_sigma has right to 5 %"), std::string::npos)
        << found.output_error->scale;
  }
  EXPECT_GE(held, 0.9 * all) << held << " of " << all;
}

// Errors that come again with each period of a motion, as those of an encoder's steps do, are averaged over
// one.
TEST_F(LoopMethods, OutputErrorCountsErrorsThatRepeatOnce) {
  constexpr Index periods = 3;
  constexpr Index period = 2000;
  Matrix once(4, 2);
  once << 1.5, 2, -1, -1, 1, 1.5, -1.5, -2;
  Matrix via(1 + 4 * periods, 2);
  via << once.bottomRows(1), once.replicate(periods, 1);
  const PdControl fast{.k_p = Eigen::Vector2d(4.0, 6.0), .k_v = Eigen::Vector2d(14.0, 1.2)};
  const rivid::PointToPointReference there({.via = via, .durations = Vector::Constant(1, 2.5)});
  const rivid::Simulation run =
      simulate(robot, base, truth, fast, J, there, {.f_m = f_m, .sampling = computer()});
  Log log;
  log.t = run.t;
  log.f_m = f_m;
  log.v_tau = run.v_tau;
  log.q_r = run.q_r;
  const Index samples = run.t.size();
  const Matrix errors = rivid::white_noise(1, 1, samples, Vector::Constant(2, encoder_noise));
  const auto found = [&](const Matrix& added, double delay_sigma) {
    log.q = run.q_measured + added;
    Estimation method = comparing(iv(), Iv::Compares::positions);
    std::get<Iv>(method.method).control = fast;
    std::get<Iv>(method.method).delay_sigma = delay_sigma;
    Identification out = identify(robot, log, method);
    EXPECT_EQ(out.status, Status::identified);
    return out;
  };
  // Without an unknown the distance from IDIM-IV counts too.
  const auto sigma = [&](const Matrix& added) {
    return Vector(found(added, 1.0).C_chi.diagonal().cwiseSqrt());
  };
  const Matrix again = errors.topRows(period).replicate(periods + 1, 1).topRows(samples);
  const Vector ratio = sigma(again).cwiseQuotient(sigma(errors));
  EXPECT_NEAR(std::exp(ratio.array().log().mean()), std::sqrt(3.0), 0.25) << ratio.transpose();
  // So do blocks of time: those of each period by itself would scatter by the root of a third.
  EXPECT_GT(found(again, 0.0).covariance.block_ratio, 0.8);
}

TEST_F(LoopMethods, RefuseWhatTheyCanNotDo) {
  const auto complaint = [&](Estimation estimation) { return estimation.complaint(robot).value_or(""); };
  Estimation didim = comparing(iv(), Iv::Compares::torques);
  EXPECT_EQ(complaint(didim), "");
  std::get<Iv>(didim.method).prefilter = true;
  EXPECT_EQ(complaint(didim), "prefilter belongs to instrumental variables, not to DIDIM");
  Estimation output_error = comparing(iv(), Iv::Compares::positions);
  output_error.robust = rivid::Robust{};
  EXPECT_EQ(complaint(output_error),
            "robust belongs to least squares and instrumental variables, not to closed-loop output error");
  output_error.robust.reset();
  std::get<Iv>(output_error.method).follows = Iv::Follows::measured;
  std::get<Iv>(output_error.method).reference_cutoff_hz = 5.0;
  EXPECT_NE(complaint(output_error).find("must be reference"), std::string::npos);
  robot.joints[1].friction = rivid::Friction::load;
  EXPECT_EQ(complaint(comparing(iv(), Iv::Compares::torques)),
            "DIDIM does not go with friction that follows the load");
}

}  // namespace
