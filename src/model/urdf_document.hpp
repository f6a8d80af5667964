#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/finding.hpp"
#include "rivid/model/urdf.hpp"

namespace rivid::detail {

/// An <origin>.
struct UrdfPose {
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();  // about fixed axes, x first

  [[nodiscard]] Eigen::Matrix3d rotation() const;
  [[nodiscard]] Eigen::Transform<double, 3, Eigen::Isometry> isometry() const;
};

/// Attributes of an <inertia>, XX XY XZ YY YZ ZZ.
inline constexpr std::array<const char*, 6> urdf_tensor_names = {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};

/// The symmetric matrix with these six entries.
[[nodiscard]] Eigen::Matrix3d symmetric_tensor(const double* entries);

/// An <inertial>.
struct UrdfBody {
  UrdfPose pose;  // of the centre of mass
  double mass = 0.0;
  std::array<double, 6> inertia{};  // XX XY XZ YY YZ ZZ about it, in the axes of the pose
};

/// The XML of a URDF: well formed, with one <robot>, no xacro; and its numbers, read strictly. Every fault
/// throws an InputError that begins with source and line.
class UrdfDocument {
 public:
  UrdfDocument(std::string_view xml, std::string source);

  [[nodiscard]] const std::string& source() const { return source_; }
  [[nodiscard]] pugi::xml_node robot() const { return document_.child("robot"); }

  /// "scara.urdf:42: "
  [[nodiscard]] std::string where(pugi::xml_node node) const;
  [[noreturn]] void refuse(pugi::xml_node node, const std::string& message) const;

  /// The only child of that name, null if there is none.
  /// @param who  what `parent` is, in messages: `link "link_1"`
  [[nodiscard]] pugi::xml_node only_child(pugi::xml_node parent, const char* name,
                                          const std::string& who) const;

  /// A required attribute with text.
  [[nodiscard]] std::string text(pugi::xml_node node, const char* attribute, const std::string& who) const;

  /// A required attribute that is a finite number.
  [[nodiscard]] double number(pugi::xml_node node, const char* attribute, const std::string& who) const;
  [[nodiscard]] double number_or(double fallback, pugi::xml_node node, const char* attribute,
                                 const std::string& who) const;

  /// Three finite numbers, `fallback` where the element or the attribute is missing.
  [[nodiscard]] Eigen::Vector3d triple_or(const Eigen::Vector3d& fallback, pugi::xml_node node,
                                          const char* attribute, const std::string& who) const;

  /// The <origin> of an element, zeros where it has none.
  [[nodiscard]] UrdfPose pose(pugi::xml_node node) const;
  /// The <inertial> of a link, none where it has none.
  [[nodiscard]] std::optional<UrdfBody> body(pugi::xml_node link) const;

 private:
  [[nodiscard]] std::string where(std::ptrdiff_t offset) const;
  void check_well_formed(const pugi::xml_parse_result& result) const;
  void check_elements() const;

  std::string source_;
  std::vector<std::size_t> newlines_;  // their byte offsets
  pugi::xml_document document_;
};

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
    bool held = false;  // on the way to joints of the robot, but none of them

    [[nodiscard]] bool moves() const { return type != "fixed" && !held; }
    [[nodiscard]] pugi::xml_node mimic() const { return node.child("mimic"); }
    [[nodiscard]] std::string leader() const { return mimic().attribute("joint").value(); }
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
  std::vector<int> joints;  // depth first, fixed ones among them
};

/// The chain or tree that the options ask for; at least one of its joints moves. Marks joints that are held.
[[nodiscard]] UrdfPath urdf_path(const UrdfDocument& document, UrdfTopology& tree,
                                 const UrdfOptions& options);

/// Elements that let the root of a URDF move freely, on one line: Robot::base_joints and the links between
/// them.
[[nodiscard]] std::string floating_joints(const UrdfDocument& document);
/// The URDF with them at its end.
[[nodiscard]] std::string with_floating_joints(std::string_view xml, const std::string& source);

/// A limit that the file does not give is written as this value or beyond.
inline constexpr double urdf_unlimited = 1e300;

/// A URDF of which every number and name has been checked.
struct CheckedUrdf {
  /// The same robot in the few elements that matter here, numbers in plain form, limits complete, joints
  /// without motion of one axis fixed: urdfdom has nothing left to misread or to complain about.
  std::string xml;
  std::string base;
  std::vector<std::string> links;  // of the chain or tree without the base, depth first
  std::vector<Finding> warnings;
  std::vector<DependentJoint> dependent;
};

/// @throws InputError  see read_urdf()
[[nodiscard]] CheckedUrdf checked_urdf(const UrdfDocument& document, const UrdfOptions& options);

}  // namespace rivid::detail
