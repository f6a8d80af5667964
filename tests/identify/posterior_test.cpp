#include "rivid/identify/posterior.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <numeric>
#include <random>

#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

// A result whose every parameter is as uncertain as `relative` of its value.
Identification uncertain(const Robot& robot, double relative) {
  Identification out;
  out.base = base_parameters(robot);
  out.chi = out.base.from_standard(robot.chi_st());
  out.C_chi = (relative * out.chi.cwiseAbs().array() + 1e-3).square().matrix().asDiagonal();
  out.covariance.quantile_975 = 1.96;
  out.physical.emplace();
  out.physical->parameters.chi_st = robot.chi_st();
  out.physical->parameters.chi = out.chi;
  return out;
}

// By the triangle inequality of the principal moments about the centre of mass, as textbooks have it.
void expect_body(const Vector& p, Index draw) {
  const double mass = p[9];
  ASSERT_GT(mass, 0.0) << "draw " << draw;
  Eigen::Matrix3d I;
  I << p[0], p[1], p[2], p[1], p[3], p[4], p[2], p[4], p[5];
  const Eigen::Vector3d com = p.segment<3>(6) / mass;
  I -= mass * (com.squaredNorm() * Eigen::Matrix3d::Identity() - com * com.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(I);
  const Eigen::Vector3d moments = eigen.eigenvalues();
  // Bodies as flat as roundings make them lie on the boundary.
  const double rounding = 1e-9 * (moments.sum() + mass * com.squaredNorm());
  EXPECT_GT(moments[0], -rounding) << "draw " << draw;
  EXPECT_GT(moments[0] + moments[1] - moments[2], -rounding) << "draw " << draw;
}

class Posterior : public testing::Test {
 protected:
  Posterior() {
    std::mt19937_64 random(301);
    robot_ = test::random_robot(4, random);
    for (Joint& joint : robot_.joints) {
      joint.Fv = 0.2;
      joint.Fc = 0.3;
      joint.Ia = joint.rotor_inertia ? 0.1 : 0.0;
    }
  }

  Robot robot_;
};

TEST_F(Posterior, EachDrawIsARobotOfBodiesThatBrake) {
  const Identification wide = uncertain(robot_, 1.5);
  const PosteriorSamples drawn = posterior_samples(robot_, wide, {.count = 32, .seed = 5});
  ASSERT_EQ(drawn.chi_st.rows(), 32);
  const std::vector<StandardParameter> parameters = robot_.standard_parameters();
  for (Index k = 0; k < drawn.chi_st.rows(); ++k) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const auto at = static_cast<Index>(i);
      if (parameters[i].kind == ParameterKind::XX) {
        expect_body(drawn.chi_st.row(k).segment(at, inertial_count).transpose(), k);
      } else if (role(parameters[i].kind) == Role::viscous || parameters[i].kind == ParameterKind::Fc ||
                 parameters[i].kind == ParameterKind::Ia) {
        EXPECT_GE(drawn.chi_st(k, at), 0.0) << parameters[i].name() << ", draw " << k;
      }
    }
    EXPECT_EQ(Vector(drawn.chi.row(k).transpose()), wide.base.from_standard(drawn.chi_st.row(k).transpose()));
  }
}

TEST_F(Posterior, DrawsAreThoseOfTheSeedWhateverTheirCount) {
  const Identification result = uncertain(robot_, 0.1);
  const PosteriorSamples four = posterior_samples(robot_, result, {.count = 4, .seed = 9});
  const PosteriorSamples seven = posterior_samples(robot_, result, {.count = 7, .seed = 9});
  EXPECT_EQ(four.chi_st, seven.chi_st.topRows(4));
  EXPECT_NE(four.chi_st, posterior_samples(robot_, result, {.count = 4, .seed = 10}).chi_st);
}

// Far inside of the set of bodies nothing is projected: mean and covariance are those of the result.
TEST_F(Posterior, HasTheCovarianceOfTheResultWhereAllDrawsAreBodies) {
  Identification narrow = uncertain(robot_, 0.0);
  const Index b = narrow.base.size();
  std::mt19937_64 random(302);
  std::normal_distribution<double> normal;
  const Matrix mixed = Matrix::NullaryExpr(b, b, [&] { return 1e-4 * normal(random); });
  narrow.C_chi = mixed * mixed.transpose();
  constexpr int count = 600;
  const PosteriorSamples drawn = posterior_samples(robot_, narrow, {.count = count, .seed = 3});
  const Matrix whitened =
      mixed.inverse() * (drawn.chi.rowwise() - narrow.chi.transpose()).transpose();  // (b × count)
  const Matrix C = whitened * whitened.transpose() / count;
  // Four standard errors of a mean, and of a variance.
  EXPECT_LT(whitened.rowwise().mean().cwiseAbs().maxCoeff(), 4.0 / std::sqrt(count));
  EXPECT_LT((C - Matrix::Identity(b, b)).cwiseAbs().maxCoeff(), 4.0 * std::sqrt(2.0 / count));
}

TEST_F(Posterior, KeepsWhatTheResultLeavesUndetermined) {
  Identification result = uncertain(robot_, 0.1);
  result.C_chi(2, 2) = std::numeric_limits<double>::infinity();
  result.chi[2] = std::numeric_limits<double>::quiet_NaN();
  const PosteriorSamples drawn = posterior_samples(robot_, result, {.count = 3});
  EXPECT_EQ(drawn.held, std::vector<std::string>{result.base.parameters[2].name});
  EXPECT_TRUE(drawn.chi_st.allFinite());
}

TEST_F(Posterior, RefusesWhatItCanNotDrawFrom) {
  Identification result = uncertain(robot_, 0.1);
  EXPECT_EQ(test::complaint_of([&] { return posterior_samples(robot_, result, {.count = 0}); }),
            "posterior_samples: count is 0, must be at least 1");
  result.physical.reset();
  EXPECT_NE(test::complaint_of([&] {
              return posterior_samples(robot_, result);
            }).find("no physically consistent parameters to draw bodies near; identify with --physical"),
            std::string::npos);
  EXPECT_NE(test::complaint_of([&] {
              return posterior_samples(test::scara(), uncertain(robot_, 0.1));
            }).find("that of another robot than \"scara\""),
            std::string::npos);
}

// The SCARA of [RIV] with its noise: torques of 39 draws at states that no log has. Of 40 places among them
// the true torque has each as often, and is between the least and the largest in 95 %.
TEST(PosteriorOfTheScara, TorquesOfDrawsCoverTheTruthAsOftenAsTheySay) {
  const test::ScaraStudy study;
  const DynamicModel truth(study.robot, study.base, study.truth);
  constexpr int experiments = 120;
  constexpr int draws = 39;
  constexpr int states = 40;
  std::mt19937_64 random(303);
  const auto wide = [&](double most) { return Vector(test::random_vector(random, most).head<2>()); };
  std::array<int, draws + 1> ranks{};
  for (int experiment = 0; experiment < experiments; ++experiment) {
    const auto seed = static_cast<std::uint64_t>(1000 + experiment);
    const Identification found = identify(study.robot, study.log(1.0, seed),
                                          {.method = Wls{}, .physical = Physical{}, .judge = false});
    const PosteriorSamples drawn = posterior_samples(study.robot, found, {.count = draws, .seed = seed});
    std::vector<DynamicModel> models;
    for (Index k = 0; k < draws; ++k) {
      models.emplace_back(study.robot, drawn.chi_st.row(k).transpose());
    }
    for (int state = 0; state < states; ++state) {
      const Vector q = wide(2.0);
      const Vector qd = wide(1.5);
      const Vector qdd = wide(5.0);
      const Vector tau = inverse_dynamics(truth, q, qd, qdd);
      const Index joint = state % 2;
      ++ranks.at(static_cast<std::size_t>(std::ranges::count_if(models, [&](const DynamicModel& model) {
        return inverse_dynamics(model, q, qd, qdd)[joint] < tau[joint];
      })));
    }
  }
  const double all = experiments * states;
  const double covered = 1.0 - (ranks.front() + ranks.back()) / all;
  EXPECT_GE(covered, 0.93);
  EXPECT_LE(covered, 0.97);
  constexpr std::size_t bin = (draws + 1) / 4;
  for (std::size_t first = 0; first <= draws; first += bin) {
    const double part = std::accumulate(ranks.begin() + first, ranks.begin() + first + bin, 0) / all;
    // Some eight directions of 120 experiments: four standard errors of a quarter.
    EXPECT_NEAR(part, 0.25, 0.06) << "ranks from " << first;
  }
  RecordProperty("covered", std::to_string(covered));
}

}  // namespace
}  // namespace rivid
