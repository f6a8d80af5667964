#pragma once

#include <string>
#include <vector>

#include "model/convex.hpp"
#include "model/link_poses.hpp"
#include "rivid/excite/limits.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// A link, or an obstacle, as convex parts.
struct Body {
  Index joint = -1;  ///< that moves it, in the order of a LinkTree; −1: nothing does
  std::string name;
  std::vector<Hull> parts = {};
  bool is_assumed = false;   ///< a guess of where the link is
  bool is_obstacle = false;  ///< no link
};

/// Two of them, or a body and a half-space.
struct BodyPair {
  std::size_t body = 0;
  Index other = -1;
  Index half_space = -1;
};

/// Links with their parts in the frames of the links, then the boxes.
///
/// @param tree  link_tree() of the robot
[[nodiscard]] std::vector<Body> bodies_of(const Robot& robot, const LinkTree& tree, const Space& space);

/// All pairs that can be kept apart, body by body with half-spaces, boxes and bodies.
[[nodiscard]] std::vector<BodyPair> pairs_of(const LinkTree& tree, const Space& space,
                                             const std::vector<Body>& bodies);

/// Distances that a robot keeps, each between a link and an obstacle or another link, with their exact
/// derivatives by the joint positions.
class Clearances {
 public:
  /// Pairs of links that are nearer than the clearance in each of many random poses are left out. A pair with
  /// an obstacle is not, unless the first link stands there: its distance is the same in every pose.
  ///
  /// @param lower, upper  positions of the random poses, (n)
  /// @param findings      gets a finding for each pair that is left out
  Clearances(const Robot& robot, const Space& space, const Vector& lower, const Vector& upper,
             std::vector<Finding>& findings);

  [[nodiscard]] Index size() const { return std::ssize(pairs_); }
  /// Of all pairs those that are not left out.
  [[nodiscard]] const std::vector<bool>& kept() const { return kept_; }
  [[nodiscard]] const std::string& first(Index pair) const;
  [[nodiscard]] const std::string& second(Index pair) const;

  /// Frames of the joints at a pose, in the order of a LinkTree, then that of the base.
  [[nodiscard]] std::vector<LinkPose> frames(const Eigen::Ref<const Vector>& q) const;

  /// Distance between the surfaces of a pair, negative where they overlap [m].
  ///
  /// @param frames  of frames()
  [[nodiscard]] double distance(Index pair, const std::vector<LinkPose>& frames) const;

  /// Its derivatives by the joint positions, (n).
  ///
  /// @param frames  of frames(q)
  [[nodiscard]] Vector slope(Index pair, const std::vector<LinkPose>& frames,
                             const Eigen::Ref<const Vector>& q) const;

  /// Distances of all pairs at one pose, (size) [m].
  [[nodiscard]] Vector at(const Eigen::Ref<const Vector>& q) const;

  /// Distances of all pairs along a motion, (samples × size) [m]. Of those that are larger than the smallest
  /// of their pair by more than `beyond` it is a lower bound that is so, too.
  [[nodiscard]] Matrix along(const std::vector<std::vector<LinkPose>>& motion, double beyond) const;

 private:
  // That a part lies within.
  struct Ball {
    Eigen::Vector3d centre;
    double radius = 0.0;
  };
  // Nearest parts, without the radii that are about them.
  struct Nearest {
    Separation cores;
    double radii = 0.0;

    [[nodiscard]] double distance() const { return cores.distance - radii; }
  };

  [[nodiscard]] Nearest nearest_of(const BodyPair& pair, const std::vector<LinkPose>& frames) const;
  [[nodiscard]] double travel(Index body, const std::vector<LinkPose>& from,
                              const std::vector<LinkPose>& to) const;
  [[nodiscard]] bool is_obstacle(const BodyPair& pair) const;
  void leave_out_pairs(const Vector& lower, const Vector& upper, const Space& space,
                       std::vector<Finding>& findings);
  void add_slope(Index joint, const std::vector<LinkPose>& frames, const Eigen::Vector3d& point,
                 const Eigen::Vector3d& direction, Vector& slope) const;

  const Robot& robot_;
  LinkTree tree_;
  std::vector<HalfSpace> half_spaces_;
  std::vector<Body> bodies_;              // parts in the frames of the joints
  std::vector<std::vector<Ball>> balls_;  // of their parts
  std::vector<double> reach_;             // of each body from the origin of its frame [m]
  std::vector<BodyPair> pairs_;
  std::vector<bool> kept_;
};

}  // namespace rivid::detail
