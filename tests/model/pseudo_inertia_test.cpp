#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "rivid/model/parameters.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// The same sums in another order.
constexpr double rounding = 1e-15;

double least_eigenvalue(const Inertial& inertial) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(pseudo_inertia(inertial)).eigenvalues().minCoeff();
}

TEST(PseudoInertia, IsTheSecondMomentOfPointMasses) {
  std::mt19937_64 random(41);
  Inertial whole = Inertial::Zero();
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  for (int k = 0; k < 5; ++k) {
    const double mass = 0.3 + k;
    const Eigen::Vector3d r = test::random_vector(random, 0.4);
    whole += inertial_from_com(mass, r, Eigen::Matrix3d::Zero());
    moments += mass * r.homogeneous() * r.homogeneous().transpose();
  }
  EXPECT_LT((pseudo_inertia(whole) - moments).norm(), 10 * rounding * moments.norm());
}

TEST(PseudoInertia, ReturnsTheInertialParametersItWasMadeOf) {
  std::mt19937_64 random(42);
  for (int k = 0; k < 20; ++k) {
    const Inertial inertial = test::random_inertial(random);
    const Inertial back = inertial_from_pseudo_inertia(pseudo_inertia(inertial));
    EXPECT_LT((back - inertial).norm(), 10 * rounding * inertial.norm()) << "body " << k;
    EXPECT_GT(least_eigenvalue(inertial), 0.0) << "body " << k;
  }
}

TEST(PseudoInertia, TellsInertiaTensorsThatNoBodyHas) {
  // XX + YY < ZZ about the centre of mass.
  const Eigen::Matrix3d no_triangle = Eigen::Vector3d(0.1, 0.1, 0.3).asDiagonal();
  EXPECT_LT(least_eigenvalue(inertial_from_com(1.0, {0.2, 0.0, 0.1}, no_triangle)), 0.0);
  const Eigen::Matrix3d ball = Eigen::Matrix3d::Identity() * 0.1;
  EXPECT_GT(least_eigenvalue(inertial_from_com(1.0, {0.2, 0.0, 0.1}, ball)), 0.0);
  EXPECT_LT(least_eigenvalue(inertial_from_com(-1.0, {0.0, 0.0, 0.0}, ball)), 0.0);
}

}  // namespace
}  // namespace rivid
