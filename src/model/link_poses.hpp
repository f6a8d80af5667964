#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/model/robot.hpp"

namespace rivid::detail {

/// Names of all links that have a body, from Robot::first_body() on.
inline std::vector<std::string> link_names(const Robot& robot) {
  std::vector<std::string> out;
  for (auto j = static_cast<std::size_t>(robot.first_body()); j < robot.chain.links.size(); ++j) {
    out.push_back(robot.link_name(j));
  }
  return out;
}

/// The moving link of that name, counted from 0; nothing where there is none.
inline std::optional<std::size_t> link_called(const Robot& robot, std::string_view name) {
  const std::vector<std::string> links = link_names(robot);
  const auto at = std::ranges::find(links, name);
  return at == links.end() ? std::nullopt
                           : std::optional<std::size_t>(at - links.begin() + robot.first_body());
}

/// Where frame j is, in the frame of the base.
struct LinkPose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d o = Eigen::Vector3d::Zero();
};

/// Positions of the joints of all links in the order of a tree, as Dependence::expand() writes them.
inline Vector expanded(const LinkTree& tree, const Eigen::Ref<const Vector>& q) {
  if (tree.dependence.empty()) {
    return q;
  }
  Vector out(static_cast<Index>(tree.dependence.memory(1)));
  tree.dependence.expand<double>({q.data(), nullptr, nullptr}, 1, out.data());
  return out;
}

/// The frames of all links at a posture.
///
/// @param q    (n)
/// @param out  (links), or more
inline void place_links(const Chain& chain, const Eigen::Ref<const Vector>& q, std::vector<LinkPose>& out) {
  if (!chain.dependents.empty()) {
    const LinkTree tree = link_tree(chain);
    std::vector<LinkPose> placed(tree.order.size());
    place_links(tree.chain, expanded(tree, q), placed);
    for (std::size_t k = 0; k < placed.size(); ++k) {
      out[tree.order[k]] = placed[k];
    }
    return;
  }
  for (std::size_t j = 0; j < chain.links.size(); ++j) {
    const int parent = chain.parent(j);
    LinkPose at = parent < 0 ? LinkPose{} : out[static_cast<std::size_t>(parent)];
    const Chain::Link& link = chain.links[j];
    const double x = q[static_cast<Index>(j)];
    const bool turns = link.type == JointType::revolute;
    at.o += at.R * (turns ? link.p : Eigen::Vector3d(link.p + x * link.R.col(2)));
    at.R = at.R * link.R;
    if (turns) {
      Eigen::Matrix3d turned = at.R;
      turned.col(0) = std::cos(x) * at.R.col(0) + std::sin(x) * at.R.col(1);
      turned.col(1) = std::cos(x) * at.R.col(1) - std::sin(x) * at.R.col(0);
      at.R = turned;
    }
    out[j] = at;
  }
}

}  // namespace rivid::detail
