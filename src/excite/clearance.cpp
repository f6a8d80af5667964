#include "excite/clearance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

std::optional<std::string> Space::complaint(const Robot& robot) const {
  const std::vector<std::string> names = detail::link_names(robot);
  const auto is_none = [&](const std::string& link) {
    return link != robot.base && std::ranges::find(names, link) == names.end();
  };
  for (const Capsule& capsule : capsules) {
    if (is_none(capsule.link)) {
      return "capsules: the robot has no link " + in_quotes(capsule.link) + did_you_mean(capsule.link, names);
    }
    if (!(capsule.radius > 0.0)) {
      return "capsules: the radius of " + in_quotes(capsule.link) + " is " + number(capsule.radius) +
             " m, must be positive";
    }
  }
  for (const LinkPair& pair : ignored) {
    for (const std::string& link : {pair.first, pair.second}) {
      if (is_none(link)) {
        return "ignored: the robot has no link " + in_quotes(link) + did_you_mean(link, names);
      }
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

namespace {

using Eigen::Vector3d;

// Nearer than this a distance has not changed [m].
constexpr double unchanged = 1e-6;

Hull part_of(const std::string& link, const Eigen::Matrix3Xd& points, double radius) {
  return {.link = link, .points = points, .radius = radius};
}

// The most that a point at a distance of 1 m from the origin moves, by the rotation alone: the spectral norm
// of the difference.
double turn(const LinkPose& from, const LinkPose& to) { return (to.R - from.R).norm() / std::numbers::sqrt2; }

Eigen::Matrix3Xd corners(const Box& box) {
  Eigen::Matrix3Xd out(3, 8);
  for (Index k = 0; k < out.cols(); ++k) {
    out.col(k) << (k % 2 == 0 ? box.min : box.max).x(), (k / 2 % 2 == 0 ? box.min : box.max).y(),
        (k / 4 == 0 ? box.min : box.max).z();
  }
  return out;
}

// The lines from the joint to the next ones, of a link that nobody gave a shape; of points that are the end
// of the body before it none.
std::vector<Eigen::Matrix3Xd> usual_lines(const Chain& chain, Index joint, bool is_free) {
  std::vector<Eigen::Matrix3Xd> out;
  const auto add = [&](const Vector3d& to) {
    if (!to.isZero(0.0) || (is_free && out.empty())) {
      out.emplace_back(3, 2) << Vector3d::Zero(), to;
    }
  };
  for (std::size_t k = 0; k < chain.links.size(); ++k) {
    if (chain.parent(k) == joint) {
      const Vector3d& to = chain.links[k].p;
      add(joint < 0 ? to : Vector3d(link_axes(chain.links[static_cast<std::size_t>(joint)]) * to));
    }
  }
  if (out.empty()) {
    add(Vector3d::Zero());
  }
  return out;
}

// Whether one of two links carries the other.
bool are_neighbours(const Chain& chain, Index a, Index b) {
  return (b >= 0 && chain.parent(static_cast<std::size_t>(b)) == a) ||
         (a >= 0 && chain.parent(static_cast<std::size_t>(a)) == b);
}

}  // namespace

std::vector<Body> bodies_of(const Robot& robot, const LinkTree& tree, const Space& space) {
  std::vector<Body> out;
  for (Index joint = -1; joint < std::ssize(tree.order); ++joint) {
    const std::string& name =
        joint < 0 ? robot.base : robot.link_name(tree.order[static_cast<std::size_t>(joint)]);
    Body body{.joint = joint, .name = name};
    for (const Capsule& capsule : space.capsules) {
      if (capsule.link == name) {
        Eigen::Matrix3Xd ends(3, 2);
        ends << capsule.from, capsule.to;
        body.parts.push_back(part_of(name, ends, capsule.radius));
      }
    }
    const bool is_given = !body.parts.empty();
    for (const Hull& hull : space.model.hulls) {
      if (!is_given && hull.link == name) {
        body.parts.push_back(hull);
        body.is_assumed = hull.is_assumed;
        body.parts.back().radius += hull.is_assumed ? space.radius : 0.0;
      }
    }
    if (body.parts.empty()) {
      const auto before = std::ranges::find_if(
          out, [&](const Body& b) { return are_neighbours(tree.chain, b.joint, joint); });
      const bool is_free = before != out.end() && !before->is_assumed;
      for (const Eigen::Matrix3Xd& line : usual_lines(tree.chain, joint, is_free)) {
        body.parts.push_back(part_of(name, line, space.radius));
        body.is_assumed = true;
      }
    }
    if (!body.parts.empty()) {
      out.push_back(std::move(body));
    }
  }
  for (const Box& box : space.boxes) {
    out.push_back({.name = box.name, .parts = {part_of(box.name, corners(box), 0.0)}, .is_obstacle = true});
  }
  return out;
}

std::vector<BodyPair> pairs_of(const LinkTree& tree, const Space& space, const std::vector<Body>& bodies) {
  std::vector<BodyPair> out;
  const std::size_t links = bodies.size() - space.boxes.size();
  for (std::size_t a = 0; a < links; ++a) {
    const bool moves = bodies[a].joint >= 0;
    for (Index k = 0; moves && k < std::ssize(space.half_spaces); ++k) {
      out.push_back({.body = a, .half_space = k});
    }
    for (std::size_t b = links; moves && b < bodies.size(); ++b) {
      out.push_back({.body = a, .other = static_cast<Index>(b)});
    }
    for (std::size_t b = a + 1; space.self_collision && b < links; ++b) {
      // Guesses of neighbours have the joint in common.
      const bool meet = are_neighbours(tree.chain, bodies[a].joint, bodies[b].joint) &&
                        bodies[a].is_assumed && bodies[b].is_assumed;
      if (!meet) {
        out.push_back({.body = a, .other = static_cast<Index>(b)});
      }
    }
  }
  return out;
}

Clearances::Clearances(const Robot& robot, const Space& space, const Vector& lower, const Vector& upper,
                       std::vector<Finding>& findings)
    : robot_(robot),
      tree_(link_tree(robot.chain)),
      half_spaces_(space.half_spaces),
      bodies_(bodies_of(robot, tree_, space)),
      pairs_(pairs_of(tree_, space, bodies_)),
      kept_(pairs_.size(), false) {
  for (HalfSpace& half_space : half_spaces_) {
    const double length = half_space.normal.norm();
    half_space.normal /= length;
    half_space.offset /= length;
  }
  std::string assumed;
  for (Body& body : bodies_) {
    double reach = 0.0;
    std::vector<Ball>& balls = balls_.emplace_back();
    for (Hull& part : body.parts) {
      if (body.joint >= 0) {
        // The user's link frame has the origin of frame j and its axes, renamed.
        const Chain::Link& link = tree_.chain.links[static_cast<std::size_t>(body.joint)];
        part.points = (link_axes(link).transpose() * part.points).eval();
      }
      const Vector3d centre = 0.5 * (part.points.rowwise().minCoeff() + part.points.rowwise().maxCoeff());
      balls.push_back({centre, (part.points.colwise() - centre).colwise().norm().maxCoeff() + part.radius});
    }
    for (const Ball& ball : balls) {
      reach = std::max(reach, ball.centre.norm() + ball.radius);
    }
    reach_.push_back(reach);
    if (body.is_assumed) {
      assumed += (assumed.empty() ? "" : ", ") + body.name;
    }
  }
  if (!pairs_.empty() && !assumed.empty()) {
    findings.push_back(Finding{"body_assumed", robot.name,
                               "no shape is known of " + assumed + ": all within " + number(space.radius) +
                                   " m of the lines between the origins of their frames stands for them"});
  }
  leave_out_pairs(lower, upper, space, findings);
}

const std::string& Clearances::first(Index pair) const {
  return bodies_[pairs_[static_cast<std::size_t>(pair)].body].name;
}

const std::string& Clearances::second(Index pair) const {
  const BodyPair& p = pairs_[static_cast<std::size_t>(pair)];
  return p.half_space >= 0 ? half_spaces_[static_cast<std::size_t>(p.half_space)].name
                           : bodies_[static_cast<std::size_t>(p.other)].name;
}

void Clearances::leave_out_pairs(const Vector& lower, const Vector& upper, const Space& space,
                                 std::vector<Finding>& findings) {
  // random ones, in each of which a pair must be too near to be left out; a choice
  constexpr int poses = 200;
  constexpr double deep = 1e-3;  // [m] a body deeper in an obstacle does not stand on it; a choice
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  std::vector<double> at_first(pairs_.size());
  std::vector<double> at_last(pairs_.size());
  for (int pose = 0; pose < poses; ++pose) {
    Vector q(robot_.size());
    for (Index j = 0; j < q.size(); ++j) {
      const bool bounded = std::isfinite(lower[j]) && std::isfinite(upper[j]);
      q[j] = bounded ? lower[j] + part(random) * (upper[j] - lower[j]) : part(random);
    }
    const std::vector<LinkPose> at = frames(q);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      if (kept_[k]) {
        continue;
      }
      Known known{.parts = parts_of(pairs_[k])};
      const Nearest nearest = nearest_of(pairs_[k], at, known);
      at_last[k] = nearest.distance;
      at_first[k] = pose == 0 ? at_last[k] : at_first[k];
      bool kept = at_last[k] >= space.clearance;
      if (is_obstacle(pairs_[k])) {
        // What the first link stands on it stands on in every pose. Inside of it, the obstacle is not where
        // it was meant to be.
        kept = kept || std::abs(at_last[k] - at_first[k]) > unchanged ||
               !are_neighbours(tree_.chain, -1, bodies_[pairs_[k].body].joint) ||
               nearest.cores->distance < -deep;
      }
      kept_[k] = kept;
    }
  }
  const auto is_ignored = [&](Index k) {
    return std::ranges::any_of(space.ignored, [&](const LinkPair& pair) {
      return (pair.first == first(k) && pair.second == second(k)) ||
             (pair.first == second(k) && pair.second == first(k));
    });
  };
  std::vector<BodyPair> kept;
  std::string neighbours;
  const std::string never = " than the clearance in each of " + std::to_string(poses) + " random poses";
  for (Index k = 0; k < size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const BodyPair& pair = pairs_[i];
    if (is_ignored(k)) {
      kept_[i] = false;
    } else if (kept_[i]) {
      kept.push_back(pair);
    } else if (is_obstacle(pair)) {
      findings.push_back(Finding{"clearance_fixed", first(k),
                                 "is " + number(at_last[i], 3) + " m from " + second(k) +
                                     " in every pose, where " + number(space.clearance, 3) +
                                     " m is asked: it stands there, and no motion changes that"});
    } else if (are_neighbours(tree_.chain, bodies_[pair.body].joint,
                              bodies_[static_cast<std::size_t>(pair.other)].joint)) {
      neighbours += (neighbours.empty() ? "" : ", ") + first(k) + " and " + second(k);
    } else {
      findings.push_back(Finding{"clearance_left_out", first(k),
                                 "is nearer to " + second(k) + never + "; the pair is left out"});
    }
  }
  if (!neighbours.empty()) {
    findings.push_back(
        Finding{"clearance_left_out", robot_.name,
                "neighbours that are nearer to each other" + never + " are left out: " + neighbours});
  }
  pairs_ = std::move(kept);
}

bool Clearances::is_obstacle(const BodyPair& pair) const {
  return pair.half_space >= 0 || bodies_[static_cast<std::size_t>(pair.other)].is_obstacle;
}

// Behind the frames of the joints is that of what stands still.
LinkPose Clearances::pose_of(const Body& body, const std::vector<LinkPose>& frames) {
  return body.joint < 0 ? frames.back() : frames[static_cast<std::size_t>(body.joint)];
}

std::vector<LinkPose> Clearances::frames(const Eigen::Ref<const Vector>& q) const {
  std::vector<LinkPose> out(tree_.order.size() + 1);
  place_links(tree_.chain, expanded(tree_, q), out);
  return out;
}

std::vector<Clearances::PartPair> Clearances::parts_of(const BodyPair& pair) const {
  std::vector<PartPair> out;
  const std::size_t others =
      pair.half_space >= 0 ? 1 : bodies_[static_cast<std::size_t>(pair.other)].parts.size();
  for (std::size_t i = 0; i < bodies_[pair.body].parts.size(); ++i) {
    for (std::size_t k = 0; k < others; ++k) {
      out.push_back({.first = i, .second = k});
    }
  }
  return out;
}

LinkPose Clearances::seen(const BodyPair& pair, const std::vector<LinkPose>& frames) const {
  LinkPose at = pose_of(bodies_[pair.body], frames);
  if (pair.other < 0) {
    return at;
  }
  const LinkPose from = pose_of(bodies_[static_cast<std::size_t>(pair.other)], frames);
  LinkPose out;
  out.R = from.R.transpose() * at.R;
  out.o = from.R.transpose() * (at.o - from.o);
  return out;
}

// What is shown of parts without a look at their shapes: balls about them are apart, and what was apart
// before is so by less than the first part has moved as the second one sees it.
void Clearances::follow(const BodyPair& pair, const LinkPose& seen, Known& known) const {
  const double turned = turn(known.seen, seen);
  for (PartPair& parts : known.parts) {
    const Ball& ball = balls_[pair.body][parts.first];
    const Vector3d centre = seen.o + seen.R * ball.centre;
    const double moved = (centre - known.seen.o - known.seen.R * ball.centre).norm() + turned * ball.radius;
    double apart = 0.0;
    if (pair.half_space >= 0) {
      const HalfSpace& free = half_spaces_[static_cast<std::size_t>(pair.half_space)];
      apart = free.normal.dot(centre) - free.offset;
    } else {
      const Ball& other = balls_[static_cast<std::size_t>(pair.other)][parts.second];
      apart = (centre - other.centre).norm() - other.radius;
    }
    parts.distance = std::max(parts.distance - moved, apart - ball.radius);
    parts.is_measured = false;
  }
  known.seen = seen;
}

Separation Clearances::cores_of(const BodyPair& pair, const std::vector<LinkPose>& frames,
                                const PartPair& parts, double enough) const {
  const Body& body = bodies_[pair.body];
  const PlacedHull first{body.parts[parts.first].points, pose_of(body, frames)};
  if (pair.half_space >= 0) {
    const HalfSpace& free = half_spaces_[static_cast<std::size_t>(pair.half_space)];
    const Vector3d lowest = first.farthest(-free.normal);
    return {lowest, lowest, free.normal, free.normal.dot(lowest) - free.offset};
  }
  const Body& other = bodies_[static_cast<std::size_t>(pair.other)];
  return separation(first, {other.parts[parts.second].points, pose_of(other, frames)}, parts.cores.normal,
                    enough);
}

Clearances::Nearest Clearances::nearest_of(const BodyPair& pair, const std::vector<LinkPose>& frames,
                                           Known& known, double enough) const {
  const LinkPose now = seen(pair, frames);
  const double moved = (now.o - known.seen.o).norm() + turn(known.seen, now) * reach_[pair.body];
  if (known.distance - moved > enough) {
    return {known.distance - moved};
  }
  follow(pair, now, known);
  for (;;) {
    PartPair& parts = *std::ranges::min_element(known.parts, {}, &PartPair::distance);
    known.distance = parts.distance;
    if (known.distance > enough) {
      return {known.distance};
    }
    if (parts.is_measured) {
      return {known.distance, &parts.cores};
    }
    double radii = bodies_[pair.body].parts[parts.first].radius;
    if (pair.other >= 0) {
      radii += bodies_[static_cast<std::size_t>(pair.other)].parts[parts.second].radius;
    }
    parts.cores = cores_of(pair, frames, parts, enough + radii);
    parts.distance = parts.cores.distance - radii;
    parts.is_measured = true;
  }
}

// Velocity of a point of a link along a direction, by the joints that move it.
void Clearances::add_slope(Index joint, const std::vector<LinkPose>& frames, const Vector3d& point,
                           const Vector3d& direction, Vector& slope) const {
  for (Index k = joint; k >= 0; k = tree_.chain.parent(static_cast<std::size_t>(k))) {
    const LinkPose& frame = frames[static_cast<std::size_t>(k)];
    const Vector3d z = frame.R.col(2);
    const bool turns = tree_.chain.links[static_cast<std::size_t>(k)].type == JointType::revolute;
    slope[k] += direction.dot(turns ? Vector3d(z.cross(point - frame.o)) : z);
  }
}

Vector Clearances::slope_of(const BodyPair& pair, const std::vector<LinkPose>& frames,
                            const Separation& cores, const Eigen::Ref<const Vector>& q) const {
  Vector of_links = Vector::Zero(std::ssize(tree_.order));
  add_slope(bodies_[pair.body].joint, frames, cores.first, cores.normal, of_links);
  if (pair.other >= 0) {
    add_slope(bodies_[static_cast<std::size_t>(pair.other)].joint, frames, cores.second, -cores.normal,
              of_links);
  }
  if (tree_.dependence.empty()) {
    return of_links;
  }
  Vector out(robot_.size());
  tree_.dependence.fold(of_links.data(), robot_.joints.size(), expanded(tree_, q).data(), out.data());
  return out;
}

Matrix Clearances::along(const Matrix& q, double beyond, std::vector<Matrix>* slopes) const {
  std::vector<std::vector<LinkPose>> motion;
  for (const auto& pose : q.rowwise()) {
    motion.push_back(frames(pose.transpose()));
  }
  Matrix out(q.rows(), size());
  if (slopes != nullptr) {
    slopes->assign(pairs_.size(), Matrix::Zero(q.rows(), robot_.size()));
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    Known known{.parts = parts_of(pairs_[p])};
    double least = std::numeric_limits<double>::infinity();
    for (Index k = 0; k < q.rows(); ++k) {
      const std::vector<LinkPose>& at = motion[static_cast<std::size_t>(k)];
      const Nearest nearest = nearest_of(pairs_[p], at, known, least + beyond);
      out(k, static_cast<Index>(p)) = nearest.distance;
      if (slopes != nullptr && nearest.cores != nullptr) {
        (*slopes)[p].row(k) = slope_of(pairs_[p], at, *nearest.cores, q.row(k).transpose()).transpose();
      }
      least = std::min(least, nearest.distance);
    }
  }
  return out;
}

}  // namespace detail

}  // namespace rivid
