#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// A format that an identified robot is exported to. docs/write_back.md says what each has.
enum class ModelFormat {
  mjcf,       ///< a model for MuJoCo
  sdf,        ///< a world with the model, for Gazebo
  drake,      ///< URDF with transmissions for Drake, and a Python module that loads it
  pinocchio,  ///< URDF, SRDF with rotor parameters, and a Python module that loads both and adds friction
  urdf        ///< the URDF with other numbers, see rewritten_urdf()
};
template <>
inline constexpr std::array names_of<ModelFormat> =
    std::to_array<std::string_view>({"mjcf", "sdf", "drake", "pinocchio", "urdf"});

struct ModelExportOptions {
  bool force = false;  ///< export physically inconsistent links, too
  /// The main file, whose name the others are called after; mesh files are named relative to its folder.
  /// Nothing is written. Empty: beside the URDF, with its name, "_identified" and usual_ending().
  std::filesystem::path file = {};
  std::string origin = {};  ///< one line that says where the numbers come from, for the comment on top
};

/// A whole model, as one or several files.
struct [[nodiscard]] ExportedModel {
  struct File {
    std::filesystem::path path;
    std::string text;
  };
  std::vector<File> files;  ///< the main one first; empty where there are faults and force was not asked for
  std::vector<Finding> faults;  ///< as RewrittenUrdf::faults
  std::vector<Finding>
      warnings;  ///< what the format can not express, and what was changed on the way; in the files too
};

/// Names of the files that exported_model() makes, the main one first.
///
/// @param file  the main one
[[nodiscard]] std::vector<std::filesystem::path> exported_files(ModelFormat format,
                                                                const std::filesystem::path& file);

/// What the name of the main file ends in: ".urdf", ".xml", ".sdf", "_drake.urdf", "_pinocchio.urdf".
[[nodiscard]] std::string_view usual_ending(ModelFormat format);

/// An identified robot in the format of another program: a whole model that loads without an edit. Links,
/// joints, limits and shapes are those of the URDF, gravity that of the robot. The inertias are those of
/// rewritten_urdf(); the torques of the model are those of the robot, to 1e-9 of the largest, but for
/// friction that the format or its program does not know, which `warnings` name.
///
/// @param urdf    path of the URDF, which meshes are found by
/// @param robot   read from that URDF; options of its joints may have been changed since
/// @param chi_st  values of robot.standard_parameters() of physical bodies, (N_s) [SI, joint side]
/// @throws InputError  as rewritten_urdf()
ExportedModel exported_model(ModelFormat format, const std::filesystem::path& urdf, const Robot& robot,
                             const Eigen::Ref<const Vector>& chi_st, const ModelExportOptions& options);

}  // namespace rivid
