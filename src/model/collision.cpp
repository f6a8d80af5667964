#include "rivid/model/collision.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "model/convex.hpp"
#include "model/mesh.hpp"
#include "model/urdf_document.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Path = std::filesystem::path;

constexpr int sides = 32;  // of the prism that stands for a cylinder, within 0.5 % of its radius; a choice

class CollisionReader {
 public:
  CollisionReader(const Path& urdf, const Robot& robot, const detail::UrdfDocument& document)
      : folder_(urdf.parent_path()),
        robot_(robot),
        document_(document),
        tree_(detail::urdf_topology(document)),
        frames_(robot.chain.links.size()),
        origins_(frames_.size() + 1) {
    // With all joints at 0, those that follow others too.
    const detail::LinkTree links = detail::link_tree(robot.chain);
    std::vector<detail::LinkPose> placed(frames_.size());
    detail::place_links(links.chain, Vector::Zero(std::ssize(placed)), placed);
    for (std::size_t k = 0; k < placed.size(); ++k) {
      frames_[links.order[k]] = placed[k];
    }
  }

  CollisionModel run() {
    visit();
    assume_bodies();
    return std::move(out_);
  }

 private:
  [[nodiscard]] const std::string& link_of(Index joint) const {
    return joint < 0 ? robot_.base : robot_.link_name(static_cast<std::size_t>(joint));
  }

  // The frame of a link of the robot at q = 0.
  [[nodiscard]] Isometry3d frame(Index joint) const {
    Isometry3d out = Isometry3d::Identity();
    if (joint >= 0) {
      const auto j = static_cast<std::size_t>(joint);
      out.linear() = frames_[j].R * link_axes(robot_.chain.links[j]).transpose();
      out.translation() = frames_[j].o;
    }
    return out;
  }

  // All links that hang on the base, each with the last joint of the robot's that moves it and its pose at
  // q = 0.
  void visit() {
    struct Place {
      int link;
      Index joint;
      Isometry3d pose;
    };
    const auto base = std::ranges::find(tree_.links, robot_.base, &detail::UrdfTopology::Link::name);
    std::vector<Place> open = {{static_cast<int>(base - tree_.links.begin()), -1, Isometry3d::Identity()}};
    while (!open.empty()) {
      const Place at = open.back();
      open.pop_back();
      const detail::UrdfTopology::Link& link = tree_.link(at.link);
      const Isometry3d in_link = frame(at.joint).inverse() * at.pose;
      origins_[static_cast<std::size_t>(at.joint + 1)].push_back(in_link.translation());
      for (const pugi::xml_node collision : link.node.children("collision")) {
        add(collision, in_link * document_.pose(collision).isometry(), at.joint, link.name);
      }
      for (const int j : link.children) {
        const detail::UrdfTopology::Joint& next = tree_.joint(j);
        const auto own = robot_.link_of(next.name);
        open.push_back({next.child, own ? static_cast<Index>(*own) : at.joint,
                        at.pose * document_.pose(next.node).isometry()});
      }
    }
  }

  double positive(pugi::xml_node node, const char* attribute, const std::string& who) {
    const double out = document_.number(node, attribute, who);
    if (!(out > 0.0)) {
      document_.refuse(node, who + ": its " + attribute + " is " + number(out) + " m, must be positive");
    }
    return out;
  }

  std::optional<Hull> shape(pugi::xml_node geometry, const std::string& who) {
    Hull out;
    const auto none = [&](const char* child) { return !geometry.child(child); };
    if (!none("box")) {
      const Vector3d size = document_.triple_or(Vector3d::Zero(), geometry.child("box"), "size", who);
      if (!(size.array() > 0.0).all()) {
        document_.refuse(geometry.child("box"), who + ": its size must be three positive numbers");
      }
      out.points.resize(3, 8);
      for (Index corner = 0; corner < 8; ++corner) {
        const Vector3d side(corner % 2 == 0 ? 0.5 : -0.5, corner / 2 % 2 == 0 ? 0.5 : -0.5,
                            corner / 4 == 0 ? 0.5 : -0.5);
        out.points.col(corner) = side.cwiseProduct(size);
      }
    } else if (!none("sphere")) {
      out.points = Vector3d::Zero();
      out.radius = positive(geometry.child("sphere"), "radius", who);
    } else if (!none("cylinder")) {
      const pugi::xml_node cylinder = geometry.child("cylinder");
      const double radius = positive(cylinder, "radius", who);
      const double half = 0.5 * positive(cylinder, "length", who);
      out.radius = radius * (1.0 - std::cos(std::numbers::pi / sides));
      out.points.resize(3, Index{2} * sides);
      for (Index k = 0; k < sides; ++k) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / sides;
        out.points.col(2 * k) << radius * std::cos(angle), radius * std::sin(angle), half;
        out.points.col(2 * k + 1) << radius * std::cos(angle), radius * std::sin(angle), -half;
      }
    } else if (!none("mesh")) {
      return mesh(geometry.child("mesh"), who);
    } else {
      document_.refuse(geometry, who + ": its <geometry> must be a box, cylinder, sphere or mesh");
    }
    return out;
  }

  std::optional<Hull> mesh(pugi::xml_node node, const std::string& who) {
    const std::string name = document_.text(node, "filename", who);
    const std::optional<Path> path = detail::found_mesh(name, folder_);
    if (!path) {
      out_.findings.push_back(Finding{"mesh_missing",
                                      {},
                                      document_.where(node) + who + ": its mesh " + in_quotes(name) +
                                          " is not found beside the URDF or in the folders above"});
      return std::nullopt;
    }
    out_.meshes.push_back(*path);
    const Vector3d scale = document_.triple_or(Vector3d::Ones(), node, "scale", who);
    return detail::enclosing_hull(scale.asDiagonal() * detail::read_mesh(*path));
  }

  void add(pugi::xml_node collision, const Isometry3d& pose, Index joint, const std::string& name) {
    const std::string who = "collision of link " + in_quotes(name);
    const pugi::xml_node geometry = document_.only_child(collision, "geometry", who);
    if (!geometry) {
      document_.refuse(collision, who + ": has no <geometry>");
    }
    if (std::optional<Hull> hull = shape(geometry, who)) {
      hull->link = link_of(joint);
      hull->points = (pose * hull->points).eval();
      out_.hulls.push_back(*std::move(hull));
    }
  }

  void assume_bodies() {
    const auto has_body = [&](Index joint) {
      return std::ranges::find(out_.hulls, link_of(joint), &Hull::link) != out_.hulls.end();
    };
    const Chain& chain = robot_.chain;
    for (Index joint = -1; joint < std::ssize(frames_); ++joint) {
      if (has_body(joint)) {
        continue;
      }
      std::vector<Vector3d>& points = origins_[static_cast<std::size_t>(joint + 1)];
      for (Index next = 0; next < std::ssize(frames_); ++next) {
        if (chain.parent(static_cast<std::size_t>(next)) == joint) {
          points.push_back(frame(joint).inverse() * frame(next).translation());
        }
      }
      const bool is_point = std::ranges::all_of(points, [](const Vector3d& p) { return p.norm() < 1e-9; });
      // A point is the end of the body before it, unless that one has a shape.
      if (!is_point || (joint >= 0 && has_body(chain.parent(static_cast<std::size_t>(joint))))) {
        Hull hull = detail::enclosing_hull(
            Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, static_cast<Index>(points.size())));
        hull.link = link_of(joint);
        hull.is_assumed = true;
        assumed_.push_back(std::move(hull));
      }
    }
    out_.hulls.insert(out_.hulls.end(), assumed_.begin(), assumed_.end());
  }

  Path folder_;
  const Robot& robot_;
  const detail::UrdfDocument& document_;
  detail::UrdfTopology tree_;
  std::vector<detail::LinkPose> frames_;
  std::vector<std::vector<Vector3d>> origins_;  // of the frames of each link, the base first
  std::vector<Hull> assumed_;
  CollisionModel out_;
};

}  // namespace

CollisionModel read_collision(const Path& urdf, const Robot& robot) {
  refuse_larger(urdf, robot_limit);
  const detail::UrdfDocument document(read_input(urdf).bytes(), urdf.string());
  return CollisionReader(urdf, robot, document).run();
}

}  // namespace rivid
