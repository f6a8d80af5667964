#include <cmath>

#include "dense.hpp"
#include "identify/physical/physical_problem.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Second moments below this part of the largest count as physically inconsistent.
constexpr double flat = 1e-4;
// What they are raised to.
constexpr double round_enough = 0.1;
// A body whose radius of gyration is below this part of the other bodies' is a point mass, and becomes a ball
// of ten times that size.
constexpr double point = 1e-2;
constexpr double ball = 0.1;
constexpr double unknown_mass = 1.0;    // [kg] where no body of the robot has a mass; a choice
constexpr double unknown_radius = 0.1;  // [m] of gyration, where no body has an extent; a choice

// Second moments about the centre of mass per unit of mass [m²].
Eigen::Matrix3d spread(const Eigen::Matrix4d& P) {
  const Eigen::Vector3d com = P.topRightCorner<3, 1>() / P(3, 3);
  return P.topLeftCorner<3, 3>() / P(3, 3) - com * com.transpose();
}

bool has_mass(const Eigen::Matrix4d& P) { return P.allFinite() && P(3, 3) > 0.0; }

struct Typical {
  double mass = unknown_mass;
  double radius = unknown_radius;  // of gyration, along one axis
};

Typical typical(const std::vector<Eigen::Matrix4d>& bodies) {
  double masses = 0.0;
  double squares = 0.0;
  double count = 0.0;
  double extended = 0.0;
  for (const Eigen::Matrix4d& P : bodies) {
    if (has_mass(P)) {
      masses += P(3, 3);
      count += 1.0;
      const double square = spread(P).trace() / 3.0;
      if (square > 0.0) {
        squares += square;
        extended += 1.0;
      }
    }
  }
  Typical out;
  out.mass = count > 0.0 ? masses / count : unknown_mass;
  out.radius = extended > 0.0 ? std::sqrt(squares / extended) : unknown_radius;
  return out;
}

Eigen::Matrix4d body(double mass, const Eigen::Vector3d& com, const Eigen::Matrix3d& spread) {
  Eigen::Matrix4d P;
  P.topLeftCorner<3, 3>() = mass * (spread + com * com.transpose());
  P.topRightCorner<3, 1>() = mass * com;
  P.bottomLeftCorner<1, 3>() = mass * com.transpose();
  P(3, 3) = mass;
  return P;
}

// Half-way from the origin of link j to that of the next one on it, in the axes of the link frame.
Eigen::Vector3d half_way(const Chain& chain, std::size_t j) {
  if (j + 1 >= chain.links.size() || chain.parent(j + 1) != static_cast<int>(j)) {
    return Eigen::Vector3d::Zero();
  }
  return 0.5 * link_axes(chain.links[j]) * chain.links[j + 1].p;
}

// The body with its second moments raised where they are physically inconsistent; returns whether they were.
bool mend(double radius, Eigen::Matrix4d& P) {
  const SymmetricEigen eigen = symmetric_eigen(spread(P));
  Eigen::Vector3d moments = eigen.values;
  const double largest = moments.maxCoeff();
  if (!(largest > std::pow(point * radius, 2))) {
    moments.setConstant(std::pow(ball * radius, 2));
  } else if (moments.minCoeff() < flat * largest) {
    moments = (moments.array() < flat * largest).select(round_enough * largest, moments);
  } else {
    return false;
  }
  const Eigen::Matrix3d axes = eigen.vectors;
  const Eigen::Matrix3d mended = axes * moments.asDiagonal() * axes.transpose();
  P = body(P(3, 3), P.topRightCorner<3, 1>() / P(3, 3), mended);
  return true;
}

}  // namespace

NominalBodies nominal_bodies(const Robot& robot, const std::vector<Inertial>& inertials) {
  NominalBodies out;
  for (const Inertial& inertial : inertials) {
    out.pseudo_inertias.push_back(pseudo_inertia(inertial));
  }
  const Typical usual = typical(out.pseudo_inertias);
  for (std::size_t k = 0; k < inertials.size(); ++k) {
    const std::size_t j = static_cast<std::size_t>(robot.first_body()) + k;
    Eigen::Matrix4d& P = out.pseudo_inertias[k];
    const std::string link = "link \"" + robot.link_name(j) + "\" ";
    if (!has_mass(P)) {
      const double square = usual.radius * usual.radius;
      P = body(usual.mass, half_way(robot.chain, j), square * Eigen::Matrix3d::Identity());
      out.notes.push_back(link + "has no mass in the robot description: a body of " + number(usual.mass, 3) +
                          " kg with radii of gyration of " + number(usual.radius, 3) +
                          " m stands in for it where the physical parameters are pulled to");
    } else if (mend(usual.radius, P)) {
      out.notes.push_back(link +
                          "has an inertia tensor that belongs to no extended body in the robot description: "
                          "its second moments were raised where the physical parameters are pulled to");
    }
  }
  return out;
}

}  // namespace rivid::detail
