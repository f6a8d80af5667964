// The physically consistent model of the SCARA of data/scara, whose truth is known.

#include <gtest/gtest.h>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {
namespace {

class PhysicalScara : public testing::Test {
 protected:
  PhysicalScara() : experiment_(read_experiment(RIVID_DATA "/scara/scara.toml")) {
    experiment_.estimation.physical = Physical{};
  }

  void expect_truth_in_the_intervals() const {
    const Identification found = run(experiment_);
    ASSERT_TRUE(found.physical);
    // truth.json tells offsets as well, which this fit does not have; they are zero.
    Robot with_offsets = experiment_.robot;
    for (Joint& joint : with_offsets.joints) {
      joint.friction = Friction::symmetric;
    }
    const BaseParameters wide = base_parameters(with_offsets);
    const Vector truth = wide.from_standard(read_parameters(RIVID_DATA "/scara/truth.json", wide));
    for (Index i = 0; i < wide.size(); ++i) {
      const std::string& name = wide.parameters[static_cast<std::size_t>(i)].name;
      for (std::size_t k = 0; k < found.parameters.size(); ++k) {
        const ParameterEstimate& p = found.parameters[k];
        if (p.name == name) {
          const double half_width = 0.5 * (p.interval_95[1] - p.interval_95[0]);
          EXPECT_NEAR(found.physical->parameters.chi[static_cast<Index>(k)], truth[i], half_width) << name;
        }
      }
    }
  }

  Experiment experiment_;
};

TEST_F(PhysicalScara, HasTheTruthWithinItsIntervals) { expect_truth_in_the_intervals(); }

TEST_F(PhysicalScara, HasTheTruthWithinItsIntervalsWithAWrongDescription) {
  for (Inertial& inertial : experiment_.robot.inertials) {
    inertial *= 1.5;
  }
  expect_truth_in_the_intervals();
}

// Robust estimates leave no blocks of time out: there the pull of the description may cost one twentieth of
// the squared residuals.
TEST_F(PhysicalScara, LosesTheWeightOfAWrongDescriptionByItsPrice) {
  for (Inertial& inertial : experiment_.robot.inertials) {
    inertial *= 3.0;
  }
  experiment_.estimation.robust = Robust{};
  experiment_.estimation.physical->weight = 1e4;
  const Identification found = run(experiment_);
  ASSERT_TRUE(found.physical);
  EXPECT_LT(found.physical->options.weight, 1e4);
  EXPECT_LE(found.physical->parameters.distance,
            0.05 * static_cast<double>(found.fit.rows - found.chi.size()));
}

TEST_F(PhysicalScara, HasAPositiveDefiniteMassMatrixEverywhere) {
  for (const Physical::Prior prior : {Physical::Prior::log_det, Physical::Prior::ridge}) {
    experiment_.estimation.physical->prior = prior;
    const Identification found = run(experiment_);
    const DynamicModel model(experiment_.robot, found.physical->parameters.chi_st);
    constexpr int positions = 720;  // M depends on q2 alone
    for (int k = 0; k < positions; ++k) {
      const Vector q = Eigen::Vector2d(0.3, 2.0 * EIGEN_PI * k / positions);
      EXPECT_GT(smallest_eigenvalue(model, q), 0.0) << "q2 = " << q[1];
    }
  }
}

TEST_F(PhysicalScara, IsJudgedOnTheLogsOfTheValidation) {
  const Identification found = run(experiment_);
  ASSERT_EQ(found.validation.size(), 1U);
  ASSERT_TRUE(found.validation[0].physical);
  // The truth is physical: consistency costs next to nothing, and the estimate is the least-squares one.
  constexpr double next_to_nothing = 1e-3;
  EXPECT_NEAR(found.physical->fit.relative_error, found.fit.relative_error,
              next_to_nothing * found.fit.relative_error);
  EXPECT_NEAR(found.validation[0].physical->relative_error, found.validation[0].fit.relative_error,
              0.05 * found.validation[0].fit.relative_error);
}

}  // namespace
}  // namespace rivid
