#include <utility>

#include "identify/figures/ellipsoid.hpp"
#include "model/link_poses.hpp"
#include "report/documents.hpp"

namespace rivid::detail {

namespace {

std::vector<LinkPose> link_poses(const Chain& chain, const Vector& q) {
  std::vector<LinkPose> out(chain.links.size());
  place_links(chain, q, out);
  return out;
}

}  // namespace

Skeleton skeleton_of(const Robot& robot, const Vector& q) {
  Skeleton out;
  out.joints.emplace_back(Eigen::Vector3d::Zero());
  const std::vector<LinkPose> poses = link_poses(robot.chain, q);
  int last = -1;
  for (const std::size_t j : link_tree(robot.chain).order) {
    // One line draws all: from the end of a branch it goes back to where the next one begins.
    for (int back = std::exchange(last, static_cast<int>(j)); back != robot.chain.parent(j);) {
      back = robot.chain.parent(static_cast<std::size_t>(back));
      out.joints.push_back(back < 0 ? out.joints.front() : poses[static_cast<std::size_t>(back)].o);
    }
    out.joints.push_back(poses[j].o);
  }
  return out;
}

void add_ellipsoids(const Robot& robot, const Vector& q, const std::vector<Inertial>& inertials,
                    const std::string& style, Skeleton& out) {
  const std::vector<LinkPose> poses = link_poses(robot.chain, q);
  for (std::size_t j = 0; j < poses.size() && j < inertials.size(); ++j) {
    if (const std::optional<SolidEllipsoid> body = solid_ellipsoid(inertials[j])) {
      const Eigen::Matrix3d to_base = poses[j].R * link_axes(robot.chain.links[j]).transpose();
      out.ellipsoids.push_back(
          {robot.link_name(j), style, body->mass, poses[j].o + to_base * body->centre, to_base * body->axes});
    }
  }
}

}  // namespace rivid::detail
