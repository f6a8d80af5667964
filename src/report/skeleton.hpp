#pragma once

#include <string>
#include <vector>

#include "report/document.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

// Joints' origins, in the frame of the base.
[[nodiscard]] Skeleton skeleton_of(const Robot& robot, const Vector& q);

// The equivalent ellipsoids of the links, of uniform density with the mass and inertia of the link; links
// without mass, or whose inertia no body can have, have none.
void add_ellipsoids(const Robot& robot, const Vector& q, const std::vector<Inertial>& inertials,
                    const std::string& style, Skeleton& out);

}  // namespace rivid::detail
