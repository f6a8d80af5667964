// Distances of convex hulls against those of FCL, and by what every answer must prove itself.

#include "model/convex.hpp"

#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <random>

namespace rivid::detail {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Vector3d gaussian(std::mt19937_64& random, double size) {
  std::normal_distribution<double> normal(0.0, size);
  const double x = normal(random);
  const double y = normal(random);
  return {x, y, normal(random)};
}

Matrix3Xd cloud(std::mt19937_64& random, Index points, const Vector3d& middle) {
  Matrix3Xd out(3, points);
  for (auto column : out.colwise()) {
    column = middle + gaussian(random, 0.2);
  }
  return out;
}

LinkPose random_pose(std::mt19937_64& random) {
  LinkPose out;
  out.R =
      Eigen::AngleAxisd(gaussian(random, 2.0).norm(), gaussian(random, 1.0).normalized()).toRotationMatrix();
  out.o = gaussian(random, 0.5);
  return out;
}

// A tetrahedron, of which FCL wants to know the faces.
fcl::Convexd tetrahedron(const Matrix3Xd& points) {
  auto vertices = std::make_shared<std::vector<fcl::Vector3d>>();
  for (const auto& column : points.colwise()) {
    vertices->emplace_back(column);
  }
  auto faces =
      std::make_shared<std::vector<int>>(std::vector<int>{3, 0, 1, 2, 3, 0, 1, 3, 3, 0, 2, 3, 3, 1, 2, 3});
  return {vertices, 4, faces};
}

TEST(Separation, OfTetrahedraIsThatOfFcl) {
  constexpr double oracle_tolerance = 2e-5;  // what FCL leaves of its iteration [m]
  std::mt19937_64 random(11);
  int apart = 0;
  for (int k = 0; k < 500; ++k) {
    const Matrix3Xd a = cloud(random, 4, Vector3d::Zero());
    const Matrix3Xd b = cloud(random, 4, Vector3d::Zero());
    const LinkPose at_a = random_pose(random);
    const LinkPose at_b = random_pose(random);
    const auto placed = [](const LinkPose& pose) {
      fcl::Transform3d out = fcl::Transform3d::Identity();
      out.linear() = pose.R;
      out.translation() = pose.o;
      return out;
    };
    const fcl::Convexd first = tetrahedron(a);
    const fcl::Convexd second = tetrahedron(b);
    fcl::DistanceRequestd request;
    request.gjk_solver_type = fcl::GST_LIBCCD;
    request.distance_tolerance = 1e-10;
    fcl::DistanceResultd result;
    fcl::distance(&first, placed(at_a), &second, placed(at_b), request, result);
    const Separation found = separation({a, at_a}, {b, at_b});
    if (result.min_distance > 0.0) {
      ++apart;
      EXPECT_NEAR(found.distance, result.min_distance, oracle_tolerance) << "draw " << k;
    } else {
      EXPECT_LE(found.distance, oracle_tolerance) << "draw " << k;
    }
  }
  EXPECT_GE(apart, 300);
}

// Points that are so near and a direction that all points are so far apart along: no other distance has both.
TEST(Separation, IsProvenByItsPointsAndItsDirection) {
  constexpr double precision = 1e-8;  // m
  std::mt19937_64 random(12);
  int overlapping = 0;
  int beaten = 0;
  for (int k = 0; k < 2000; ++k) {
    const Matrix3Xd a = cloud(random, 1 + k % 40, Vector3d::Zero());
    const Matrix3Xd b = cloud(random, 1 + k % 7, gaussian(random, 0.4));
    const Separation found = separation({a}, {b});
    ASSERT_NEAR(found.normal.norm(), 1.0, 1e-12) << "draw " << k;
    const double along =
        (found.normal.transpose() * a).minCoeff() - (found.normal.transpose() * b).maxCoeff();
    EXPECT_NEAR(along, found.distance, precision) << "draw " << k;
    if (found.distance > 0.0) {
      EXPECT_NEAR((found.first - found.second).norm(), found.distance, precision) << "draw " << k;
      continue;
    }
    // Moved as far along the direction they touch no more.
    ++overlapping;
    const Matrix3Xd moved = a.colwise() + Vector3d(-(found.distance - 1e-6) * found.normal);
    EXPECT_GT(separation({moved}, {b}).distance, 0.0) << "draw " << k;
    double best = found.distance;
    for (int other = 0; other < 200; ++other) {
      best = std::max(best, gap({a}, {b}, gaussian(random, 1.0).normalized()));
    }
    beaten += static_cast<int>(best > found.distance + 0.01);
  }
  // Of overlaps the optimum is a local one.
  EXPECT_LE(beaten, overlapping / 50);
  EXPECT_GE(overlapping, 200);
}

TEST(EnclosingHull, HoldsAllPointsAndLittleElse) {
  std::mt19937_64 random(13);
  for (const Index most : {Index{8}, Index{32}, Index{128}}) {
    Matrix3Xd ball = cloud(random, 20000, Vector3d::Zero());
    ball.colwise().normalize();
    ball *= 0.1;
    const Hull hull = enclosing_hull(ball, most);
    EXPECT_LE(hull.points.cols(), most);
    // A sphere has no corner to leave out: between n points there is 4 π / n of it.
    EXPECT_LT(hull.radius, 0.1 * 8.0 / static_cast<double>(most)) << most;
    for (int k = 0; k < 1000; ++k) {
      const Vector3d n = gaussian(random, 1.0).normalized();
      const double within = (n.transpose() * hull.points).maxCoeff() + hull.radius;
      EXPECT_GE(within, (n.transpose() * ball).maxCoeff() - 1e-9);
    }
  }
  // What has eight corners is kept as it is.
  Matrix3Xd box(3, 1000);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  for (Index k = 0; k < box.cols(); ++k) {
    box.col(k) << within(random), within(random), within(random);
    if (k < 8) {
      box.col(k) << (k % 2 == 0 ? 1 : -1), (k / 2 % 2 == 0 ? 1 : -1), (k / 4 == 0 ? 1 : -1);
    }
  }
  const Hull hull = enclosing_hull(box);
  EXPECT_EQ(hull.points.cols(), 8);
  EXPECT_NEAR(hull.radius, 0.0, 1e-9);
}

}  // namespace
}  // namespace rivid::detail
