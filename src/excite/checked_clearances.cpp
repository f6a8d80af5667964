#include "excite/checked_clearances.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "excite/clearance.hpp"

namespace rivid::detail {

namespace {

// What is at least between two bodies: what a direction separates of all points is apart, whoever found it.
double proven_distance(const Body& a, const LinkPose& at_a, const Body& b, const LinkPose& at_b) {
  double out = std::numeric_limits<double>::infinity();
  for (const Hull& first : a.parts) {
    const Eigen::Matrix3Xd points = (at_a.R * first.points).colwise() + at_a.o;
    for (const Hull& second : b.parts) {
      const Eigen::Matrix3Xd others = (at_b.R * second.points).colwise() + at_b.o;
      const Eigen::Vector3d normal = separation({points}, {others}).normal;
      const double apart =
          (normal.transpose() * points).minCoeff() - (normal.transpose() * others).maxCoeff();
      out = std::min(out, apart / normal.norm() - first.radius - second.radius);
    }
  }
  return out;
}

double height(const Body& body, const LinkPose& at, const HalfSpace& free) {
  double out = std::numeric_limits<double>::infinity();
  for (const Hull& part : body.parts) {
    const Eigen::Matrix3Xd points = (at.R * part.points).colwise() + at.o;
    const double lowest = ((free.normal.transpose() * points).minCoeff() - free.offset) / free.normal.norm();
    out = std::min(out, lowest - part.radius);
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
  const auto frame = [&](const Body& body) { return frames[static_cast<std::size_t>(body.joint + 1)]; };
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
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Body& body = bodies[pairs[k].body];
      const Body* const other =
          pairs[k].other < 0 ? nullptr : &bodies[static_cast<std::size_t>(pairs[k].other)];
      const double distance =
          other == nullptr
              ? height(body, frame(body), space.half_spaces[static_cast<std::size_t>(pairs[k].half_space)])
              : proven_distance(body, frame(body), *other, frame(*other));
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
