#include "excite/clearance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// The joint that moves a link, −1 for the base, nothing for a name that is none.
std::optional<Index> joint_of(const Robot& robot, const std::string& link) {
  if (link == robot.base) {
    return -1;
  }
  const auto found = std::ranges::find(robot.joints, link, &Joint::link);
  return found == robot.joints.end() ? std::nullopt : std::optional<Index>(found - robot.joints.begin());
}

std::vector<std::string> link_names(const Robot& robot) {
  std::vector<std::string> out(robot.joints.size());
  std::ranges::transform(robot.joints, out.begin(), &Joint::link);
  return out;
}

}  // namespace

std::optional<std::string> Space::complaint(const Robot& robot) const {
  for (const Capsule& capsule : capsules) {
    if (!joint_of(robot, capsule.link)) {
      return "capsules: the robot has no link " + in_quotes(capsule.link) +
             did_you_mean(capsule.link, link_names(robot));
    }
    if (!(capsule.radius > 0.0)) {
      return "capsules: the radius of " + in_quotes(capsule.link) + " is " + number(capsule.radius) +
             " m, must be positive";
    }
  }
  for (const Box& box : boxes) {
    if (!(box.min.array() < box.max.array()).all()) {
      return "boxes: min of " + in_quotes(box.name) + " must lie below its max along each axis";
    }
  }
  for (const HalfSpace& half_space : half_spaces) {
    if (!(half_space.normal.norm() > 0.0)) {
      return "half_spaces: the normal of " + in_quotes(half_space.name) + " must not be zero";
    }
  }
  return range_fault(*this);
}

namespace detail {

// Nearer than this a line touches, and farther it has moved [m].
constexpr double touching = 1e-6;

Clearances::Clearances(const Robot& robot, const Space& space, const Vector& lower, const Vector& upper,
                       std::vector<Finding>& findings)
    : robot_(robot), half_spaces_(space.half_spaces), boxes_(space.boxes), frames_(robot.joints.size()) {
  for (HalfSpace& half_space : half_spaces_) {
    const double length = half_space.normal.norm();
    half_space.normal /= length;
    half_space.offset /= length;
  }
  add_bodies(space);
  placed_.resize(bodies_.size());
  add_pairs(space);
  leave_out_pairs(lower, upper, space.clearance, findings);
}

void Clearances::add_bodies(const Space& space) {
  std::vector<bool> has_body(robot_.joints.size() + 1, false);
  for (const Capsule& capsule : space.capsules) {
    const Index joint = *joint_of(robot_, capsule.link);
    // The user's link frame has the origin of frame j and its axes, renamed.
    const Eigen::Matrix3d C = joint < 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                        : link_axes(robot_.chain.links[static_cast<std::size_t>(joint)]);
    bodies_.push_back(
        {joint, {C.transpose() * capsule.from, C.transpose() * capsule.to}, capsule.radius, capsule.link});
    has_body[static_cast<std::size_t>(joint + 1)] = true;
  }
  for (Index joint = -1; joint < robot_.size(); ++joint) {
    if (has_body[static_cast<std::size_t>(joint + 1)]) {
      continue;
    }
    const Eigen::Vector3d to = joint + 1 < robot_.size()
                                   ? robot_.chain.links[static_cast<std::size_t>(joint + 1)].p
                                   : Eigen::Vector3d(Eigen::Vector3d::Zero());
    // A point is the end of the capsule before it, unless that one was given.
    if (to.isZero(0.0) && !(joint >= 0 && has_body[static_cast<std::size_t>(joint)])) {
      continue;
    }
    const std::string& name = joint < 0 ? robot_.base : robot_.joints[static_cast<std::size_t>(joint)].link;
    bodies_.push_back({joint, {Eigen::Vector3d::Zero(), to}, space.radius, name});
  }
}

void Clearances::add_pairs(const Space& space) {
  for (std::size_t a = 0; a < bodies_.size(); ++a) {
    for (Index k = 0; bodies_[a].joint >= 0 && k < std::ssize(half_spaces_); ++k) {
      pairs_.push_back({.body = a, .half_space = k});
    }
    for (Index k = 0; bodies_[a].joint >= 0 && k < std::ssize(boxes_); ++k) {
      pairs_.push_back({.body = a, .box = k});
    }
    for (std::size_t b = 0; space.self_collision && b < bodies_.size(); ++b) {
      if (bodies_[b].joint > bodies_[a].joint + 1) {
        pairs_.push_back({.body = a, .other = static_cast<Index>(b)});
      }
    }
  }
}

// Where the ends of a body's line are; along the normal of a half-space, whatever else they do.
std::array<Eigen::Vector3d, 2> Clearances::ends_beside(const Pair& pair) const {
  const Segment& line = placed_[pair.body];
  if (pair.box >= 0) {
    return {line.from, line.to};
  }
  const Eigen::Vector3d& normal = half_spaces_[static_cast<std::size_t>(pair.half_space)].normal;
  return {normal.dot(line.from) * normal, normal.dot(line.to) * normal};
}

// Whether the line of a body, without its radius, is in an obstacle.
bool Clearances::is_inside(const Pair& pair, double distance) const {
  if (pair.box >= 0) {
    const Box& box = boxes_[static_cast<std::size_t>(pair.box)];
    const Box smaller{.name = {}, .min = box.min.array() + touching, .max = box.max.array() - touching};
    return nearest(placed_[pair.body], smaller).distance() == 0.0;
  }
  return distance < -bodies_[pair.body].radius - touching;
}

void Clearances::leave_out_pairs(const Vector& lower, const Vector& upper, double clearance,
                                 std::vector<Finding>& findings) {
  constexpr int poses = 200;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  kept_.assign(pairs_.size(), false);
  Vector distances(size());
  std::vector<std::array<Eigen::Vector3d, 2>> first_ends(pairs_.size());
  for (int pose = 0; pose < poses; ++pose) {
    Vector q(robot_.size());
    for (Index j = 0; j < q.size(); ++j) {
      const bool bounded = std::isfinite(lower[j]) && std::isfinite(upper[j]);
      q[j] = bounded ? lower[j] + part(random) * (upper[j] - lower[j]) : part(random);
    }
    at(q, distances, nullptr);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const Pair& pair = pairs_[k];
      const double distance = distances[static_cast<Index>(k)];
      bool kept = distance >= clearance;
      if (pair.other < 0) {
        const std::array<Eigen::Vector3d, 2> ends = ends_beside(pair);
        first_ends[k] = pose == 0 ? ends : first_ends[k];
        const bool moves =
            (ends[0] - first_ends[k][0]).norm() > touching || (ends[1] - first_ends[k][1]).norm() > touching;
        // What the first link stands on it stands on in every pose. Inside of it, the obstacle is not where
        // it was meant to be.
        kept = kept || moves || bodies_[pair.body].joint > 0 || is_inside(pair, distance);
      }
      kept_[k] = kept_[k] || kept;
    }
  }
  std::vector<Pair> kept;
  for (Index k = 0; k < size(); ++k) {
    const Pair& pair = pairs_[static_cast<std::size_t>(k)];
    if (kept_[static_cast<std::size_t>(k)]) {
      kept.push_back(pair);
    } else if (pair.other >= 0) {
      findings.push_back(Finding{"clearance_left_out", first(k),
                                 "is nearer to " + second(k) + " than the clearance in each of " +
                                     std::to_string(poses) + " random poses; the pair is left out"});
    } else {
      findings.push_back(Finding{"clearance_fixed", first(k),
                                 "is " + number(distances[k], 3) + " m from " + second(k) +
                                     " in every pose, where " + number(clearance, 3) +
                                     " m is asked: it stands there, and no motion changes that"});
    }
  }
  pairs_ = std::move(kept);
}

std::string Clearances::first(Index pair) const {
  return bodies_[pairs_[static_cast<std::size_t>(pair)].body].name;
}

std::string Clearances::second(Index pair) const {
  const Pair& p = pairs_[static_cast<std::size_t>(pair)];
  if (p.other >= 0) {
    return bodies_[static_cast<std::size_t>(p.other)].name;
  }
  return p.box >= 0 ? boxes_[static_cast<std::size_t>(p.box)].name
                    : half_spaces_[static_cast<std::size_t>(p.half_space)].name;
}

void Clearances::place(const Eigen::Ref<const Vector>& q) {
  place_links(robot_.chain, q, frames_);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = bodies_[b];
    placed_[b] = body.line;
    if (body.joint >= 0) {
      const LinkPose& frame = frames_[static_cast<std::size_t>(body.joint)];
      placed_[b] = {frame.o + frame.R * body.line.from, frame.o + frame.R * body.line.to};
    }
  }
}

Nearest Clearances::nearest_of(const Pair& pair) const {
  const Segment& line = placed_[pair.body];
  if (pair.other >= 0) {
    return nearest(line, placed_[static_cast<std::size_t>(pair.other)]);
  }
  return nearest(line, boxes_[static_cast<std::size_t>(pair.box)]);
}

// Velocity of a point of a link along a direction, by the joints before it.
void Clearances::add_slope(Index joint, const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                           Eigen::Ref<Vector> slope) const {
  for (Index k = 0; k <= joint; ++k) {
    const LinkPose& frame = frames_[static_cast<std::size_t>(k)];
    const Eigen::Vector3d z = frame.R.col(2);
    const bool turns = robot_.chain.links[static_cast<std::size_t>(k)].type == JointType::revolute;
    slope[k] += direction.dot(turns ? Eigen::Vector3d(z.cross(point - frame.o)) : z);
  }
}

void Clearances::at(const Eigen::Ref<const Vector>& q, Eigen::Ref<Vector> distances, Matrix* slopes) {
  place(q);
  if (slopes != nullptr) {
    slopes->setZero(q.size(), size());
  }
  for (Index k = 0; k < size(); ++k) {
    const Pair& pair = pairs_[static_cast<std::size_t>(k)];
    const Body& body = bodies_[pair.body];
    Eigen::Vector3d point;
    Eigen::Vector3d direction;
    if (pair.half_space >= 0) {
      const HalfSpace& space = half_spaces_[static_cast<std::size_t>(pair.half_space)];
      const Segment& line = placed_[pair.body];
      direction = space.normal;
      point = direction.dot(line.from) < direction.dot(line.to) ? line.from : line.to;
      distances[k] = direction.dot(point) - space.offset - body.radius;
    } else {
      const Nearest found = nearest_of(pair);
      const double apart = found.distance();
      point = found.first;
      direction = apart > 0.0 ? Eigen::Vector3d((found.first - found.second) / apart)
                              : Eigen::Vector3d(Eigen::Vector3d::Zero());
      distances[k] = apart - body.radius;
      if (pair.other >= 0) {
        const Body& other = bodies_[static_cast<std::size_t>(pair.other)];
        distances[k] -= other.radius;
        if (slopes != nullptr) {
          add_slope(other.joint, found.second, -direction, slopes->col(k));
        }
      }
    }
    if (slopes != nullptr) {
      add_slope(body.joint, point, direction, slopes->col(k));
    }
  }
}

}  // namespace detail

}  // namespace rivid
