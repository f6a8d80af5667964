#pragma once

#include <kdl/tree.hpp>
#include <string>
#include <vector>

#include "rivid/model/kdl.hpp"
#include "support/random_chain.hpp"

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

/// The robot of a tree, rotors alone beside its bodies: KDL knows no friction.
inline Robot frictionless(const KDL::Tree& tree) {
  Robot robot = robot_from(tree);
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
  }
  return robot;
}

}  // namespace rivid::test
