#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>

#include "excite/clearance.hpp"

namespace rivid::detail {

namespace {

std::vector<Eigen::Matrix3Xd> placed_parts(const Body& body, const LinkPose& at) {
  std::vector<Eigen::Matrix3Xd> out;
  for (const Hull& part : body.parts) {
    out.emplace_back((at.R * part.points).colwise() + at.o);
  }
  return out;
}

// What is at least between two placed bodies: what a direction separates of all points is apart, whoever
// found it. Where the directions of the pose before show more than `enough`, no better ones are sought.
double proven_distance(const Body& a, std::span<const Eigen::Matrix3Xd> of_a, const Body& b,
                       std::span<const Eigen::Matrix3Xd> of_b, double enough,
                       std::vector<Eigen::Vector3d>& normals) {
  double out = std::numeric_limits<double>::infinity();
  normals.resize(of_a.size() * of_b.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    for (std::size_t k = 0; k < of_b.size(); ++k) {
      Eigen::Vector3d& normal = normals[i * of_b.size() + k];
      const auto apart = [&] {
        const double cores =
            (normal.transpose() * of_a[i]).minCoeff() - (normal.transpose() * of_b[k]).maxCoeff();
        return cores / normal.norm() - a.parts[i].radius - b.parts[k].radius;
      };
      // Not a number, of the first pose, is not enough.
      if (!(apart() > enough)) {
        normal = separation({of_a[i]}, {of_b[k]}, normal).normal;
      }
      out = std::min(out, apart());
    }
  }
  return out;
}

double height(const Body& body, std::span<const Eigen::Matrix3Xd> parts, const HalfSpace& free) {
  double out = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double lowest =
        ((free.normal.transpose() * parts[i]).minCoeff() - free.offset) / free.normal.norm();
    out = std::min(out, lowest - body.parts[i].radius);
  }
  return out;
}

}  // namespace

std::vector<ClearanceUse> checked_clearances(const Robot& robot, const Space& space,
                                             const std::vector<bool>& kept, const Matrix& q, double f_m) {
  if (kept.empty()) {
    return {};
  }
  const LinkTree tree = link_tree(robot.chain);
  const std::vector<Body> bodies = bodies_of(robot, tree, space);
  const std::vector<BodyPair> pairs = pairs_of(tree, space, bodies);
  assert(pairs.size() == kept.size());
  std::vector<ClearanceUse> out;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const BodyPair& pair = pairs[k];
    out.push_back({.first = bodies[pair.body].name,
                   .second = pair.half_space >= 0
                                 ? space.half_spaces[static_cast<std::size_t>(pair.half_space)].name
                                 : bodies[static_cast<std::size_t>(pair.other)].name,
                   .distance = std::numeric_limits<double>::infinity(),
                   .wanted = kept[k] ? space.clearance : std::numeric_limits<double>::quiet_NaN()});
  }
  std::vector<Eigen::Isometry3d> placed(tree.order.size());
  std::vector<LinkPose> frames(tree.order.size() + 1);
  std::vector<std::vector<Eigen::Matrix3Xd>> parts(bodies.size());
  std::vector<std::vector<Eigen::Vector3d>> normals(pairs.size());
  for (Index row = 0; row < q.rows() && !pairs.empty(); ++row) {
    const Vector positions = expanded(tree, q.row(row).transpose());
    for (std::size_t j = 0; j < placed.size(); ++j) {
      const Chain::Link& link = tree.chain.links[j];
      const int parent = tree.chain.parent(j);
      const double x = positions[static_cast<Index>(j)];
      Eigen::Isometry3d& at = placed[j];
      at = parent < 0 ? Eigen::Isometry3d::Identity() : placed[static_cast<std::size_t>(parent)];
      at.translate(link.p).rotate(link.R);
      if (link.type == JointType::revolute) {
        at.rotate(Eigen::AngleAxisd(x, Eigen::Vector3d::UnitZ()));
      } else {
        at.translate(x * Eigen::Vector3d::UnitZ());
      }
      frames[j + 1] = {at.linear() * link_axes(link).transpose(), at.translation()};
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      parts[b] = placed_parts(bodies[b], frames[static_cast<std::size_t>(bodies[b].joint + 1)]);
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const std::size_t a = pairs[k].body;
      const auto b = static_cast<std::size_t>(pairs[k].other);
      const double distance =
          pairs[k].other < 0
              ? height(bodies[a], parts[a], space.half_spaces[static_cast<std::size_t>(pairs[k].half_space)])
              : proven_distance(bodies[a], parts[a], bodies[b], parts[b], out[k].distance, normals[k]);
      if (distance < out[k].distance) {
        out[k].distance = distance;
        out[k].time = static_cast<double>(row) / f_m;
      }
    }
  }
  std::ranges::stable_sort(
      out, {}, [](const ClearanceUse& use) { return std::pair(std::isnan(use.wanted), use.distance); });
  return out;
}

}  // namespace rivid::detail
