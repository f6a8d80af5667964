#include "excite/checked_clearances.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "excite/clearance.hpp"
#include "rivid/model/kdl.hpp"

namespace rivid::detail {

namespace {

LinkPose pose_of(const KDL::Frame& frame) {
  LinkPose out;
  for (int row = 0; row < 3; ++row) {
    out.o[row] = frame.p[row];
    for (int column = 0; column < 3; ++column) {
      out.R(row, column) = frame.M(row, column);
    }
  }
  return out;
}

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
  const KDL::Chain chain = kdl_chain(robot);
  const std::vector<Body> bodies = bodies_of(robot, space);
  const std::vector<BodyPair> pairs = pairs_of(space, bodies);
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
  std::vector<LinkPose> frames(robot.joints.size() + 1);
  const auto frame = [&](const Body& body) { return frames[static_cast<std::size_t>(body.joint + 1)]; };
  for (Index row = 0; row < q.rows() && !pairs.empty(); ++row) {
    KDL::Frame at;
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      at = at * chain.getSegment(static_cast<unsigned>(j)).pose(q(row, static_cast<Index>(j)));
      frames[j + 1] = pose_of(at);
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
