#pragma once

#include <limits>
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

  /// Distances between the surfaces of all pairs along a motion, negative where they overlap, (samples ×
  /// size) [m]. Of those that are larger than the smallest of the samples before by more than `beyond` it is
  /// a lower bound that is so, too.
  ///
  /// @param q       positions, (samples × n)
  /// @param slopes  where wanted: of each pair the derivatives by the joint positions, (samples × n); zero
  ///                where there is a bound alone
  [[nodiscard]] Matrix along(const Matrix& q, double beyond, std::vector<Matrix>* slopes = nullptr) const;

 private:
  // That a part lies within.
  struct Ball {
    Eigen::Vector3d centre;
    double radius = 0.0;
  };
  // Two parts of a pair, and what is known of them.
  struct PartPair {
    std::size_t first = 0;
    std::size_t second = 0;
    double distance = -std::numeric_limits<double>::infinity();  // at least; all of it where it is measured
    Separation cores = {};                                       // without the radii that are about them
    bool is_measured = false;
  };
  struct Known {
    std::vector<PartPair> parts;
    double distance = -std::numeric_limits<double>::infinity();  // of all of them, at least
    LinkPose seen = {};                                          // of the first body by the second one
  };

  // Of the joints at a pose, in the order of a LinkTree, then that of the base.
  [[nodiscard]] std::vector<LinkPose> frames(const Eigen::Ref<const Vector>& q) const;
  [[nodiscard]] static LinkPose pose_of(const Body& body, const std::vector<LinkPose>& frames);
  [[nodiscard]] std::vector<PartPair> parts_of(const BodyPair& pair) const;
  [[nodiscard]] LinkPose seen(const BodyPair& pair, const std::vector<LinkPose>& frames) const;
  void follow(const BodyPair& pair, const LinkPose& seen, Known& known) const;
  [[nodiscard]] Separation cores_of(const BodyPair& pair, const std::vector<LinkPose>& frames,
                                    const PartPair& parts, double enough) const;
  // Nothing but a bound where that is more than `enough`.
  struct Nearest {
    double distance;
    const Separation* cores = nullptr;
  };
  Nearest nearest_of(const BodyPair& pair, const std::vector<LinkPose>& frames, Known& known,
                     double enough = std::numeric_limits<double>::infinity()) const;
  [[nodiscard]] Vector slope_of(const BodyPair& pair, const std::vector<LinkPose>& frames,
                                const Separation& cores, const Eigen::Ref<const Vector>& q) const;
  [[nodiscard]] bool is_obstacle(const BodyPair& pair) const;
  void leave_out_pairs(const Vector& lower, const Vector& upper, const Space& space,
                       std::vector<Finding>& findings);
  void add_slope(Index joint, const std::vector<LinkPose>& frames, const Eigen::Vector3d& point,
                 const Eigen::Vector3d& direction, Vector& slope) const;

  Robot robot_;
  LinkTree tree_;
  std::vector<HalfSpace> half_spaces_;
  std::vector<Body> bodies_;              // parts in the frames of the joints
  std::vector<std::vector<Ball>> balls_;  // of their parts
  std::vector<double> reach_;             // of each body from the origin of its frame [m]
  std::vector<BodyPair> pairs_;
  std::vector<bool> kept_;
};

/// Smallest distance of every pair along a motion, the nearest first and those that are left out last. Frames
/// are Eigen's, and each distance is proven by a direction that separates all points of the two bodies: what
/// Clearances, which designs the motion, may have wrong in either does not hide what is near.
///
/// @param kept  Clearances::kept() of the same robot and space
/// @param q     (samples × n)
/// @param f_m   rate of the samples [Hz]
[[nodiscard]] std::vector<ClearanceUse> checked_clearances(const Robot& robot, const Space& space,
                                                           const std::vector<bool>& kept, const Matrix& q,
                                                           double f_m);

}  // namespace rivid::detail
