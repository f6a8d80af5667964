#pragma once

#include <array>
#include <string>
#include <vector>

#include "model/link_poses.hpp"
#include "rivid/excite/limits.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

struct Segment {
  Eigen::Vector3d from;
  Eigen::Vector3d to;

  [[nodiscard]] Eigen::Vector3d at(double part) const { return from + part * (to - from); }
};

/// The nearest points of two bodies; where they touch, any that they share.
struct Nearest {
  Eigen::Vector3d first;
  Eigen::Vector3d second;

  [[nodiscard]] double distance() const { return (first - second).norm(); }
};

[[nodiscard]] Nearest nearest(const Segment& a, const Segment& b);
[[nodiscard]] Nearest nearest(const Segment& a, const Box& box);

/// Distances that a robot keeps, each between a capsule of a link and an obstacle or a capsule of another
/// link, with their exact derivatives by the joint positions.
class Clearances {
 public:
  /// Pairs of neighbours are left out, and pairs of links that are nearer than the clearance in each of many
  /// random poses. A pair with an obstacle is not, unless the first link stands there: its distance is the
  /// same in every pose.
  ///
  /// @param lower, upper  positions of the random poses, (n)
  /// @param findings      gets a finding for each pair that is left out
  Clearances(const Robot& robot, const Space& space, const Vector& lower, const Vector& upper,
             std::vector<Finding>& findings);

  [[nodiscard]] Index size() const { return std::ssize(pairs_); }
  /// Of all pairs, body by body with half-spaces, boxes and bodies, those that are not left out.
  [[nodiscard]] const std::vector<bool>& kept() const { return kept_; }
  [[nodiscard]] std::string first(Index pair) const;
  [[nodiscard]] std::string second(Index pair) const;

  /// Distances between the surfaces at one pose, negative by the radii at most where they overlap, (size)
  /// [m].
  ///
  /// @param slopes  where wanted: derivatives, (n × size)
  void at(const Eigen::Ref<const Vector>& q, Eigen::Ref<Vector> distances, Matrix* slopes);

 private:
  // A capsule in the frame of its joint; −1 is the base.
  struct Body {
    Index joint;
    Segment line;
    double radius;
    std::string name;
  };
  // Of the second one, one is not −1.
  struct Pair {
    std::size_t body;
    Index other = -1;
    Index box = -1;
    Index half_space = -1;
  };

  void add_bodies(const Space& space);
  void add_pairs(const Space& space);
  [[nodiscard]] std::array<Eigen::Vector3d, 2> ends_beside(const Pair& pair) const;
  [[nodiscard]] bool is_inside(const Pair& pair, double distance) const;
  void leave_out_pairs(const Vector& lower, const Vector& upper, double clearance,
                       std::vector<Finding>& findings);
  void place(const Eigen::Ref<const Vector>& q);
  [[nodiscard]] Nearest nearest_of(const Pair& pair) const;
  void add_slope(Index joint, const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                 Eigen::Ref<Vector> slope) const;

  const Robot& robot_;
  std::vector<HalfSpace> half_spaces_;
  std::vector<Box> boxes_;
  std::vector<Body> bodies_;
  std::vector<Pair> pairs_;
  std::vector<bool> kept_;
  std::vector<LinkPose> frames_;  // of the joints at the pose
  std::vector<Segment> placed_;   // lines of the bodies at the pose
};

}  // namespace rivid::detail
