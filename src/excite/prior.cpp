#include "excite/prior.hpp"

#include "rivid/simulate/measurement.hpp"

namespace rivid::detail {

Robot drawn_about(Robot described, double spread, std::uint64_t seed) {
  // Beyond the streams that white_noise() takes for a record of the same seed.
  constexpr std::uint64_t stream = std::uint64_t{1} << 62U;
  const CounterNoise noise(seed, stream);
  std::uint64_t next = 0;
  const auto deviation = [&] { return spread * (2.0 * noise.uniform(next++) - 1.0); };
  for (Inertial& body : described.inertials) {
    Eigen::Matrix4d A = Eigen::Matrix4d::Identity();
    for (double& entry : A.topLeftCorner<3, 3>().reshaped()) {
      entry += 0.5 * deviation();
    }
    const double s = 1.0 + deviation();
    body = inertial_from_pseudo_inertia(s * A * pseudo_inertia(body) * A.transpose());
  }
  for (Joint& joint : described.joints) {
    for (double* const value : {&joint.Ia, &joint.Fv, &joint.Fc}) {
      *value *= 1.0 + deviation();
    }
  }
  return described;
}

}  // namespace rivid::detail
