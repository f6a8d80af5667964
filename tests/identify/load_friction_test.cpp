// Identification of friction that follows the load, and the choice of friction laws.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "identify/choose/friction_fits.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/friction_choice.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/normal.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// A motion of sines, and the torques of a model on top of it, without noise.
struct Study {
  Robot robot;
  BaseParameters base;
  Vector truth;
  Log log;

  Study(int n, Friction law, std::uint64_t seed, Index samples = 1500) {
    std::mt19937_64 random(seed);
    robot = test::random_robot(n, random);
    robot.chain.gravity = {0.0, 0.0, -9.81};
    for (Joint& joint : robot.joints) {
      joint.friction = law;
    }
    base = base_parameters(robot);
    Vector chi_st = robot.chi_st();
    const std::vector<StandardParameter> list = robot.standard_parameters();
    std::uniform_real_distribution<double> part(0.03, 0.15);
    for (std::size_t i = 0; i < list.size(); ++i) {
      double& value = chi_st[static_cast<Index>(i)];
      value = list[i].kind == ParameterKind::Fl   ? part(random)
              : list[i].kind == ParameterKind::Fr ? 1.0 + 10.0 * part(random)
                                                  : value;
    }
    truth = base.from_standard(chi_st);
    log.source = "sines";
    log.f_m = 100.0;
    log.t = Vector::NullaryExpr(samples, [&](Index k) { return static_cast<double>(k) / log.f_m; });
    std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
    log.q = Matrix::Zero(samples, n);
    for (Index j = 0; j < n; ++j) {
      for (int harmonic = 1; harmonic <= 5; ++harmonic) {
        const double a = symmetric(random) * 0.9 / std::sqrt(harmonic);
        const double phase = 3.0 * symmetric(random);
        for (Index k = 0; k < samples; ++k) {
          log.q(k, j) += a * std::sin(0.0041 * harmonic * 2.0 * static_cast<double>(k) + phase);
        }
      }
    }
    log.tau = Matrix::Ones(samples, n);
    const Rows made = rows(robot, at_load(base, truth), log, signal());
    for (std::size_t j = 0; j < made.Y.size(); ++j) {
      const JointRows& joint = made.W.joints[j];
      log.tau.col(static_cast<Index>(j))(made.samples[j]) = joint.W * truth(joint.columns);
    }
  }

  static SignalOptions signal() { return {.rows = RowScheme::paper}; }

  [[nodiscard]] Log noisy(double sigma, std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    test::Normal normal(0.0, sigma);
    Log out = log;
    out.tau += Matrix::NullaryExpr(log.tau.rows(), log.tau.cols(), [&] { return normal(random); });
    return out;
  }
};

TEST(LoadFriction, IsFoundWithoutNoise) {
  for (const Friction law : {Friction::load, Friction::load_root}) {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      const Study study(static_cast<int>(2 + seed), law, seed);
      for (const Method& method : {Method(Ols{}), Method(Wls{})}) {
        const Identification found =
            identify(study.robot, study.log, {.method = method, .signal = Study::signal()});
        ASSERT_EQ(found.status, Status::identified);
        const Vector error = found.chi - study.truth;
        EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-6 * (1.0 + study.truth.cwiseAbs().maxCoeff())) << seed;
        EXPECT_LT(found.fit.relative_error, 1e-8);
        EXPECT_LT(validate(study.robot, found, study.log).fit.relative_error, 1e-8);
      }
    }
  }
}

TEST(LoadFriction, HasThePredictedTorquesOfItsModel) {
  const Study study(3, Friction::load, 7);
  const Identification found =
      identify(study.robot, study.noisy(0.3, 8), {.method = Wls{}, .signal = Study::signal()});
  const DynamicModel model(study.robot, found.base, found.chi);
  const Motion motion = [] {
    std::mt19937_64 random(9);
    return test::random_motion(30, 3, random);
  }();
  const Matrix W = observation(study.robot, found.base, motion).dense();
  const Matrix predicted = (W * found.chi).reshaped(motion.samples(), 3);
  for (Index k = 0; k < motion.samples(); ++k) {
    const Vector tau = inverse_dynamics(model, motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                                        motion.qdd.row(k).transpose());
    EXPECT_LT((predicted.row(k).transpose() - tau).cwiseAbs().maxCoeff(),
              1e-9 * (1.0 + tau.cwiseAbs().maxCoeff()));
  }
}

// Without the tangent the covariance would take the load for known.
TEST(LoadFriction, HasItsCoefficientsWithinTheirIntervals) {
  constexpr int arms = 10;
  constexpr int runs = 40;
  int held = 0;
  int all = 0;
  double bias = 0.0;
  for (std::uint64_t arm = 1; arm <= arms; ++arm) {
    const Study study(3, Friction::load, 100 + arm);
    for (std::uint64_t run = 0; run < runs; ++run) {
      const Identification found = identify(study.robot, study.noisy(2.0, 1000 * arm + run),
                                            {.method = Wls{}, .signal = Study::signal(), .judge = false});
      ASSERT_EQ(found.status, Status::identified);
      for (std::size_t i = 0; i < found.parameters.size(); ++i) {
        if (const ParameterKind kind = found.base.parameters[i].leading.kind;
            kind == ParameterKind::Fl || kind == ParameterKind::Fc) {
          const ParameterEstimate& p = found.parameters[i];
          const double truth = study.truth[static_cast<Index>(i)];
          held += p.interval_95[0] <= truth && truth <= p.interval_95[1] ? 1 : 0;
          bias += (p.value - truth) / p.sigma;
          ++all;
        }
      }
    }
  }
  const double coverage = static_cast<double>(held) / all;
  RecordProperty("coverage", std::to_string(coverage));
  EXPECT_GE(coverage, 0.93) << held << " of " << all;
  EXPECT_LE(coverage, 0.975) << held << " of " << all;
  EXPECT_LT(std::abs(bias / all), 4.0 / std::sqrt(all));
}

// Score tests stand on the rows of the estimate's own load.
TEST(LoadFriction, IsJudgedForOtherFaults) {
  Study study(3, Friction::load, 41, 3000);
  const Estimation estimation{.method = Wls{}, .signal = Study::signal()};
  const Log good = study.noisy(0.05, 42);
  const Identification found = identify(study.robot, good, estimation);
  EXPECT_EQ(found.status, Status::identified);
  EXPECT_TRUE(found.alternatives.empty());

  Log wrong = good;
  wrong.tau.col(1) *= 1.5;
  const Identification misled = identify(study.robot, wrong, estimation);
  EXPECT_EQ(misled.status, Status::doubtful);
  ASSERT_FALSE(misled.alternatives.empty());
  EXPECT_EQ(misled.alternatives.front().code, "torque_gain");
}

Robot with_open_laws(Robot robot) {
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::automatic;
  }
  return robot;
}

TEST(FrictionChoice, FindsOneLawOfAllJoints) {
  for (const Friction law : {Friction::symmetric, Friction::root, Friction::load, Friction::load_root}) {
    const Study study(3, law, 21, 3000);
    const Robot open = with_open_laws(study.robot);
    const std::array logs = {study.noisy(0.2, 22), study.noisy(0.2, 23)};
    const Estimation estimation{.method = Wls{}, .signal = Study::signal()};
    const FrictionChoices found =
        choose_friction(open, std::span(logs).first(1), estimation, std::span(logs).last(1));
    ASSERT_EQ(found.kinds.size(), 1U);
    const FrictionChoice& all = found.kinds.front();
    EXPECT_EQ(all.joints, (std::vector<int>{0, 1, 2}));
    EXPECT_EQ(all.law, law);
    ASSERT_TRUE(all.validation_error && all.symmetric_validation_error);
    EXPECT_NEAR(*all.validation_error / all.error, 1.0, 0.1);
    if (law != Friction::symmetric) {
      EXPECT_LT(all.error, all.symmetric_error);
      EXPECT_LT(*all.validation_error, *all.symmetric_validation_error);
    }
    const Robot chosen = with_friction(open, found.kinds);
    EXPECT_EQ(chosen.joints[1].friction, law);
    EXPECT_EQ(found.C.rows(), base_parameters(chosen).size());
    EXPECT_TRUE(
        chosen.notes.back().starts_with("all joints: " + std::string(name(law)) + " friction (Fv Fc"));
  }
}

TEST(FrictionChoice, IsOfEachKindOfJoint) {
  std::mt19937_64 random(5);
  Robot robot = test::random_robot(3, random);
  for (std::size_t j = 0; j < 3; ++j) {
    robot.joints[j].type = robot.chain.links[j].type = j < 2 ? JointType::revolute : JointType::prismatic;
  }
  Study study(3, Friction::symmetric, 21, 2000);
  robot = with_open_laws(robot);
  const FrictionChoices found =
      choose_friction(robot, std::span(&study.log, 1), {.method = Wls{}, .signal = Study::signal()});
  ASSERT_EQ(found.kinds.size(), 2U);
  EXPECT_EQ(found.kinds[0].joints, (std::vector<int>{0, 1}));
  EXPECT_EQ(found.kinds[1].joints, std::vector<int>{2});
}

// The law is chosen on a log that hardly shows it, and the intervals of Fv and Fc hold whatever it is.
TEST(FrictionChoice, WidensTheIntervalsByLawsThatItHardlyDistinguishes) {
  constexpr int runs = 40;
  int held = 0;
  int without = 0;
  int all = 0;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const Study study(3, run % 2 == 0 ? Friction::root : Friction::load, 300 + run % 8, 1200);
    const Log log = study.noisy(4.0, 7000 + run);
    Estimation estimation{.method = Wls{}, .signal = Study::signal(), .judge = false};
    const Robot open = with_open_laws(study.robot);
    const FrictionChoices choice = choose_friction(open, std::span(&log, 1), estimation);
    const Robot chosen = with_friction(open, choice.kinds);
    const Identification exact = identify(chosen, log, estimation);
    estimation.choice_covariance = choice.C;
    const Identification found = identify(chosen, log, estimation);
    ASSERT_EQ(found.status, Status::identified);
    EXPECT_LT((found.C_chi - exact.C_chi - choice.C).norm(), 1e-9 * found.C_chi.norm());
    for (std::size_t i = 0; i < found.parameters.size(); ++i) {
      const StandardParameter& p = found.base.parameters[i].leading;
      if (p.kind != ParameterKind::Fv && p.kind != ParameterKind::Fc) {
        continue;
      }
      for (std::size_t k = 0; k < study.base.parameters.size(); ++k) {
        const StandardParameter& planted = study.base.parameters[k].leading;
        if (planted.kind == p.kind && planted.joint == p.joint) {
          const double truth = study.truth[static_cast<Index>(k)];
          const auto holds = [&](const ParameterEstimate& e) {
            return e.interval_95[0] <= truth && truth <= e.interval_95[1] ? 1 : 0;
          };
          held += holds(found.parameters[i]);
          without += holds(exact.parameters[i]);
          ++all;
        }
      }
    }
  }
  RecordProperty("coverage", std::to_string(static_cast<double>(held) / all));
  EXPECT_GE(held, 0.92 * all) << held << " of " << all << ", without the choice " << without;
  EXPECT_GT(held, without);
}

// A joint of dry and viscous friction that has √|q̇| by the part of the log, of which only what they can not
// take up: else Fv and Fc would change with it.
Log with_root_friction(Study& study, const std::function<double(double part)>& Fr, double noise,
                       std::uint64_t seed) {
  for (std::size_t i = 0; i < study.base.parameters.size(); ++i) {
    if (study.base.parameters[i].leading.kind == ParameterKind::Fr) {
      study.truth[static_cast<Index>(i)] = 1.0;
    }
  }
  const Rows made = rows(study.robot, study.base, study.log, Study::signal());
  for (std::size_t j = 0; j < made.Y.size(); ++j) {
    JointRows joint = made.W.joints[j];
    const auto kind = [&](std::size_t c) {
      return study.base.parameters[static_cast<std::size_t>(joint.columns[c])].leading.kind;
    };
    std::vector<Index> others;
    for (std::size_t c = 0; c < joint.columns.size(); ++c) {
      if (kind(c) == ParameterKind::Fv || kind(c) == ParameterKind::Fc) {
        others.push_back(static_cast<Index>(c));
      }
    }
    const Matrix taken = joint.W(Eigen::all, others);
    for (std::size_t c = 0; c < joint.columns.size(); ++c) {
      if (kind(c) == ParameterKind::Fr) {
        const Vector root = joint.W.col(static_cast<Index>(c));
        joint.W.col(static_cast<Index>(c)) -= taken * taken.householderQr().solve(root);
      }
    }
    for (Index k = 0; k < made.Y[j].size(); ++k) {
      const Index sample = made.samples[j][static_cast<std::size_t>(k)];
      double tau = 0.0;
      for (std::size_t c = 0; c < joint.columns.size(); ++c) {
        const double part = static_cast<double>(sample) / static_cast<double>(study.log.samples());
        tau += joint.W(k, static_cast<Index>(c)) * study.truth[joint.columns[c]] *
               (kind(c) == ParameterKind::Fr ? Fr(part) : 1.0);
      }
      study.log.tau(sample, static_cast<Index>(j)) = tau;
    }
  }
  return study.noisy(noise, seed);
}

std::vector<FrictionChoice> choice_of(const Study& study, const Log& log) {
  Robot open = study.robot;
  for (Joint& joint : open.joints) {
    joint.friction = Friction::automatic;
  }
  return choose_friction(open, std::span(&log, 1), {.method = Wls{}, .signal = Study::signal()}).kinds;
}

TEST(FrictionChoice, AsksForAGainThatLasts) {
  // In half of the stretches: √|q̇| predicts those so much better that it wins on the whole, and the others
  // worse.
  Study study(1, Friction::root, 41, 3000);
  const Log log = with_root_friction(study, [](double part) { return part < 0.5 ? 5.0 : 0.0; }, 0.05, 42);
  EXPECT_EQ(choice_of(study, log).front().law, Friction::symmetric);
  const Log lasting = with_root_friction(study, [](double) { return 5.0; }, 0.05, 42);
  EXPECT_EQ(choice_of(study, lasting).front().law, Friction::root);
}

TEST(FrictionChoice, LeavesGainsThatAreSmall) {
  // The simple law is worse everywhere, and by two per cent of the error only.
  Study study(1, Friction::root, 43, 3000);
  const auto errors = [&](double Fr) {
    return choice_of(study, with_root_friction(study, [&](double) { return Fr; }, 1.0, 44)).front();
  };
  const FrictionChoice small = errors(1.0);
  EXPECT_EQ(small.law, Friction::symmetric);
  const FrictionChoice large = errors(4.0);
  EXPECT_EQ(large.law, Friction::root);
}

// Rows of a study with friction that bends, in stretches of which the last belongs to no fit.
std::vector<detail::StretchRows> stretches_of(const Robot& robot, const BaseParameters& base, const Log& log,
                                              std::size_t count) {
  std::vector<detail::StretchRows> out;
  const Rows made = rows(robot, base, log, Study::signal());
  for (std::size_t j = 0; j < made.Y.size(); ++j) {
    const JointRows& joint = made.W.joints[j];
    const Index length = made.Y[j].size() / static_cast<Index>(count);
    for (std::size_t fold = 0; fold < count; ++fold) {
      const Index first = static_cast<Index>(fold) * length;
      detail::StretchRows& s = out.emplace_back();
      s.joint = j;
      s.fold = fold;
      s.columns = joint.columns;
      s.W = s.rigid = joint.W.middleRows(first, length);
      s.y = made.Y[j].segment(first, length);
      for (std::size_t c = 0; c < joint.columns.size(); ++c) {
        const StandardParameter& p = base.parameters[static_cast<std::size_t>(joint.columns[c])].leading;
        const auto column = static_cast<Index>(c);
        if (p.kind == ParameterKind::Fc) {
          s.sign = s.W.col(column);
        }
        if (is_friction(p.kind)) {
          s.rigid.col(column).setZero();
        }
      }
    }
  }
  return out;
}

// By Householder reflections of all rows, to the end, what the fits find by sums.
TEST(FrictionFits, AreWeightedLeastSquares) {
  constexpr std::size_t folds = 4;
  constexpr std::size_t left_out = 1;
  constexpr Index n = 3;
  for (const Friction law : {Friction::symmetric, Friction::root, Friction::load, Friction::load_root}) {
    Study study(n, law, 51, 2000);
    const Log log = study.noisy(0.5, 52);
    Robot linear = study.robot;
    for (Joint& joint : linear.joints) {
      joint.friction = Friction::root;
    }
    const BaseParameters base = base_parameters(linear);
    const std::vector<detail::StretchRows> stretches = stretches_of(linear, base, log, folds + 1);
    const Index b = base.size();
    std::vector<Index> wanted;
    for (Index i = 0; i < b + n; ++i) {
      const bool bends =
          i < b && base.parameters[static_cast<std::size_t>(i)].leading.kind == ParameterKind::Fr;
      if (i < b ? !bends || has(law, Basis::root) : has(law, Basis::load)) {
        wanted.push_back(i);
      }
    }
    const auto torque = [&](const detail::StretchRows& s, const Vector& theta) {
      const Vector chi = theta(s.columns);
      return Vector(s.W * chi +
                    theta[b + static_cast<Index>(s.joint)] * s.sign.cwiseProduct((s.rigid * chi).cwiseAbs()));
    };
    Vector theta = Vector::Zero(b + n);
    Vector weights = Vector::Ones(n);
    Matrix R;
    for (int k = 0; k < 30; ++k) {
      Vector squares = Vector::Zero(n);
      Vector counts = Vector::Zero(n);
      std::vector<std::pair<Matrix, Vector>> parts;
      Index rows = 0;
      for (const detail::StretchRows& s : stretches) {
        if (s.fold == left_out || s.fold == folds) {
          continue;
        }
        const auto j = static_cast<Index>(s.joint);
        const Vector load = s.rigid * theta(s.columns);
        const Vector turned = s.sign.cwiseProduct(load.cwiseSign());
        Matrix S = Matrix::Zero(s.y.size(), b + n);
        S(Eigen::all, s.columns) = s.W + theta[b + j] * (turned.asDiagonal() * s.rigid).eval();
        S.col(b + j) = turned.cwiseProduct(load);
        const Vector rho = s.y - torque(s, theta);
        squares[j] += rho.squaredNorm();
        counts[j] += static_cast<double>(rho.size());
        parts.emplace_back(weights[j] * S(Eigen::all, wanted), weights[j] * rho);
        rows += rho.size();
      }
      Matrix W(rows, std::ssize(wanted));
      Vector Y(rows);
      Index at = 0;
      for (const auto& [S, rho] : parts) {
        W.middleRows(at, S.rows()) = S;
        Y.segment(at, S.rows()) = rho;
        at += S.rows();
      }
      const Eigen::ColPivHouseholderQR<Matrix> qr(W);  // no Fl has a column in the first step
      theta(wanted) += qr.solve(Y);
      weights = k > 0 ? Vector(counts.cwiseQuotient(squares).cwiseSqrt()) : weights;
      R = Eigen::HouseholderQR<Matrix>(W).matrixQR().topRows(W.cols()).triangularView<Eigen::Upper>();
    }
    detail::FrictionFits fits(linear, base, stretches, folds);
    const std::vector<Friction> laws(n, law);
    const detail::LawFit found = fits.fit(laws, left_out);
    const Vector sigma = R.inverse().rowwise().norm();
    const Vector error = (found.theta - theta)(wanted).cwiseQuotient(sigma);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 0.01) << name(law);
    EXPECT_TRUE(found.weights.cwiseQuotient(weights).isOnes(0.01)) << found.weights.transpose();
    const Matrix unseen = fits.unseen_errors(laws);
    for (const detail::StretchRows& s : stretches) {
      if (s.fold == left_out) {
        EXPECT_NEAR(unseen(static_cast<Index>(s.joint), left_out) / (s.y - torque(s, theta)).squaredNorm(),
                    1.0, 1e-3)
            << name(law);
      }
    }
    const Vector of_load = fits.load_sigma(found);
    for (Index j = 0; j < n; ++j) {
      if (has(law, Basis::load)) {
        EXPECT_NEAR(of_load[j] / sigma[sigma.size() - n + j], 1.0, 0.02) << name(law);
      } else {
        EXPECT_EQ(of_load[j], std::numeric_limits<double>::infinity());
      }
    }
  }
}

TEST(FrictionChoice, LeavesLawsThatAreGiven) {
  const Study study(2, Friction::load, 31);
  EXPECT_TRUE(choose_friction(study.robot, std::span(&study.log, 1), {}).kinds.empty());
}

TEST(FrictionChoice, IsMadeBeforeAnIdentification) {
  Study study(2, Friction::load, 32);
  study.robot.joints[1].friction = Friction::automatic;
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           static_cast<void>(identify(study.robot, study.log,
                                                      {.method = Wls{}, .signal = Study::signal()}));
                         }),
                         "choose_friction()"));
}

TEST(LoadFriction, IsRefusedWithAPrefilter) {
  const Study study(2, Friction::load, 33);
  Iv iv;
  iv.control = PdControl{};
  iv.prefilter = true;
  const Estimation estimation{.method = iv, .signal = {.rows = RowScheme::exact}};
  ASSERT_TRUE(estimation.complaint(study.robot));
  EXPECT_TRUE(test::says(*estimation.complaint(study.robot), "follows the load"));
}

}  // namespace
}  // namespace rivid
