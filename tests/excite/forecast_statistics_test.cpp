// The forecast against what many identifications of the motion come to.

#include <gtest/gtest.h>

#include <random>

#include "rivid/excite/excitation.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/urdf.hpp"

namespace rivid {
namespace {

TEST(Forecast, IsTheSpreadOfManyIdentifications) {
  Robot robot = read_urdf(RIVID_DATA "/six_axis/six_axis.urdf");
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::coulomb;
  }
  ExcitationOptions options{.duration = 10.0, .rate_hz = 250.0, .starts = 1, .evaluations = 60};
  options.limits.acceleration = Vector::Constant(6, 12.0);
  options.noise.sigma = Vector::LinSpaced(6, 2.0, 0.3);
  const Excitation found = design(robot, options);
  Log log;
  log.f_m = options.rate_hz;
  log.t = found.t;
  log.q = found.motion.q;
  constexpr int runs = 100;
  constexpr std::uint64_t seed = 19;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Index b = found.forecast.base.size();
  Matrix errors(runs, b);
  for (int k = 0; k < runs; ++k) {
    log.tau = found.forecast.tau;
    for (Index j = 0; j < 6; ++j) {
      for (double& tau : log.tau.col(j)) {
        tau += options.noise.sigma[j] * normal(random);
      }
    }
    const Identification result = identify(robot, log, {.method = Wls{}, .signal = {.decimation = {5}}});
    ASSERT_EQ(result.status, Status::identified);
    errors.row(k) = (result.chi - found.forecast.chi).transpose();
  }
  // The spread of 100 runs is known to 7 %. The mean over the parameters, which are not independent, is held
  // to 10 %, each parameter to four of its standard errors. Decimation by five costs 1 % of the deviation.
  const Vector spread = (errors.array().square().colwise().sum() / runs).sqrt();
  double sum = 0.0;
  for (Index i = 0; i < b; ++i) {
    const ForecastParameter& parameter = found.forecast.parameters[static_cast<std::size_t>(i)];
    const double ratio = parameter.sigma / spread[i];
    EXPECT_NEAR(ratio, 1.0, 0.3) << parameter.name << ", seed " << seed;
    sum += ratio;
  }
  EXPECT_NEAR(sum / static_cast<double>(b), 1.0, 0.1);
}

}  // namespace
}  // namespace rivid
