#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "export/joint_values.hpp"
#include "model/urdf_document.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

/// A URDF as writers of other formats need it: every link and joint, in the order of the file.
struct ModelTree {
  using Pose = UrdfPose;
  struct Shape {
    enum class Kind { box, cylinder, sphere, mesh };

    bool collision = false;
    Kind kind = Kind::box;
    Pose pose;
    Eigen::Vector3d size = Eigen::Vector3d::Zero();  // edges; or radius and length; or the scale of a mesh
    std::string mesh = {};                           // as the URDF names the file
    std::optional<std::array<double, 4>> rgba = std::nullopt;
  };
  struct Link {
    std::string name;
    std::optional<UrdfBody> body;
    std::vector<Shape> shapes;
    int parent = -1;  // joint
    std::vector<int> children;
    bool still = false;  // fixed to the root
  };
  struct Joint {
    struct Mimic {
      std::string joint;
      double multiplier = 1.0;
      double offset = 0.0;
    };

    std::string name;
    std::string type;  // as the URDF says it
    int parent = -1;   // links
    int child = -1;
    Pose pose;
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
    std::optional<double> lower = std::nullopt;
    std::optional<double> upper = std::nullopt;
    std::optional<double> effort = std::nullopt;
    std::optional<double> velocity = std::nullopt;
    double damping = 0.0;
    double friction = 0.0;
    std::optional<Mimic> mimic = std::nullopt;
    int index = -1;  // in the chain of the robot

    [[nodiscard]] bool slides() const { return type == "prismatic"; }
    [[nodiscard]] bool turns() const { return type == "revolute" || type == "continuous"; }
  };

  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
  int root = 0;
  Eigen::Vector3d gravity;  // in the frame of the root

  [[nodiscard]] const Link& link(int i) const { return links[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Joint& joint(int i) const { return joints[static_cast<std::size_t>(i)]; }
};

/// @param xml  of a URDF that the robot was read from, with the numbers that it is to have
[[nodiscard]] ModelTree model_tree(std::string_view xml, const std::string& source, const Robot& robot);

/// What the writers of one format are given.
struct ExportTask {
  const Robot& robot;
  const std::vector<JointValues>& values;
  const ModelTree& tree;
  std::string_view xml;              // the URDF with its new numbers
  std::filesystem::path urdf;        // the robot's own
  std::filesystem::path file;        // to be written
  std::vector<std::string> heading;  // lines of the comment on top
};

/// The file of a mesh, where the format needs one on this machine.
///
/// @return  nothing where it is not found
[[nodiscard]] std::optional<std::filesystem::path> mesh_file(const std::string& name,
                                                             const std::filesystem::path& urdf);
/// Its name relative to the file that is written.
[[nodiscard]] std::string beside_written(const std::filesystem::path& mesh, const ExportTask& task);

/// Lines of an XML comment, without the "--" that may not be in one.
[[nodiscard]] std::string comment_text(const std::vector<std::string>& lines);

/// A model for MuJoCo. What was left out for being unreadable is added to `missing`.
[[nodiscard]] std::string mjcf(const ExportTask& task, std::vector<std::string>& missing);
[[nodiscard]] std::string sdf(const ExportTask& task, std::vector<std::string>& missing);

/// The URDF with a transmission for each joint of the chain, in place of those that it has for them.
[[nodiscard]] std::string with_transmissions(const ExportTask& task);

/// An SRDF with <rotor_params>.
[[nodiscard]] std::string rotor_parameters(const ExportTask& task, std::vector<std::string>& missing);

/// Python modules that load the files for one program and add the friction that it leaves out.
[[nodiscard]] std::string drake_module(const ExportTask& task, std::vector<std::string>& missing);
[[nodiscard]] std::string pinocchio_module(const ExportTask& task, std::vector<std::string>& missing);

}  // namespace rivid::detail
