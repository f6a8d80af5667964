#pragma once

#include <string>
#include <vector>

#include "rivid/model/urdf.hpp"
#include "urdf_document.hpp"

namespace rivid::detail {

/// The links and joints of a URDF as a tree, by their places in the file.
struct UrdfTopology {
  struct Link {
    std::string name;
    pugi::xml_node node;
    int parent = -1;            // joint that moves it, none for the root
    std::vector<int> children;  // joints that hang on it
  };
  struct Joint {
    std::string name;
    std::string type;
    pugi::xml_node node;
    int parent = -1;  // links
    int child = -1;

    [[nodiscard]] bool moves() const { return type != "fixed"; }
  };

  std::vector<Link> links;
  std::vector<Joint> joints;
  int root = -1;

  [[nodiscard]] const Link& link(int i) const { return links[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Joint& joint(int i) const { return joints[static_cast<std::size_t>(i)]; }
};

/// The tree, or an InputError that names the link or joint that keeps the file from being one.
[[nodiscard]] UrdfTopology urdf_topology(const UrdfDocument& document);

/// What the robot consists of.
struct UrdfPath {
  int base = -1;            // link
  std::vector<int> joints;  // base to tip, fixed ones among them

  [[nodiscard]] int tip(const UrdfTopology& tree) const {
    return joints.empty() ? base : tree.joint(joints.back()).child;
  }
};

/// The chain that the options ask for; at least one of its joints moves.
[[nodiscard]] UrdfPath urdf_path(const UrdfDocument& document, const UrdfTopology& tree,
                                 const UrdfOptions& options);

}  // namespace rivid::detail
