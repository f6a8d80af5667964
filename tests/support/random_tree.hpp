#pragma once

#include <gtest/gtest.h>

#include <kdl/tree.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>
#include <string>
#include <vector>

#include "rivid/model/kdl.hpp"
#include "support/random_chain.hpp"
#include "support/robots.hpp"

namespace rivid::test {

/// A tree of so many segments, each of which hangs on any of those before it or on the base.
inline KDL::Tree random_tree(RandomChain& draw, int segments) {
  KDL::Tree out("base");
  std::vector<std::string> hooks = {"base"};
  for (int i = 1; i <= segments; ++i) {
    const KDL::Segment segment = draw.segment(std::to_string(i), i > 2);
    // Mostly on one of the last three, so that branches grow long.
    const int last = static_cast<int>(hooks.size()) - 1;
    const int hook =
        draw.integer(0, 3) == 0 ? draw.integer(0, last) : draw.integer(std::max(0, last - 2), last);
    out.addSegment(segment, hooks[static_cast<std::size_t>(hook)]);
    hooks.push_back(segment.getName());
  }
  return out;
}

/// Torques of a tree by KDL, which numbers joints in the order in which their segments were added.
///
/// @param links   that the joints of the motion move
/// @param motion  (n_m × links)
inline Matrix kdl_torques(const KDL::Tree& tree, const Eigen::Vector3d& gravity,
                          const std::vector<std::string>& links, const Motion& motion) {
  KDL::TreeIdSolver_RNE solver(tree, KDL::Vector(gravity.x(), gravity.y(), gravity.z()));
  const auto n = static_cast<unsigned>(links.size());
  KDL::JntArray q(n);
  KDL::JntArray qd(n);
  KDL::JntArray qdd(n);
  KDL::JntArray tau(n);
  Matrix out(motion.samples(), n);
  const auto place = [&](Index j) {
    return GetTreeElementQNr(tree.getSegment(links[static_cast<std::size_t>(j)])->second);
  };
  for (Index k = 0; k < motion.samples(); ++k) {
    for (Index j = 0; j < n; ++j) {
      q(place(j)) = motion.q(k, j);
      qd(place(j)) = motion.qd(k, j);
      qdd(place(j)) = motion.qdd(k, j);
    }
    EXPECT_EQ(solver.CartToJnt(q, qd, qdd, KDL::WrenchMap(), tau), 0);
    for (Index j = 0; j < n; ++j) {
      out(k, j) = tau(place(j));
    }
  }
  return out;
}

/// The robot of a tree, rotors alone beside its bodies: KDL knows no friction.
inline Robot frictionless(const KDL::Tree& tree) {
  Robot robot = robot_from(tree);
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
  }
  return robot;
}

}  // namespace rivid::test
