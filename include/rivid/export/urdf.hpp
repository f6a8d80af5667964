#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/finding.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

struct UrdfWriteOptions {
  bool force = false;  ///< write physically inconsistent links, too
};

/// A URDF with other numbers.
struct [[nodiscard]] RewrittenUrdf {
  std::string text;  ///< empty where there are faults and force was not asked for
  /// Links with a physically inconsistent inertial, joints with negative friction, in words.
  std::vector<Finding> faults;
  std::vector<Finding> warnings;  ///< what was divided anew among links
};

/// The URDF that a robot was read from, with other standard parameters: the same bytes save numbers of
/// `<inertial>` and `<dynamics>` of the chain's links and joints. Elements that are missing are added, none
/// is removed: `<mimic>`, too, where the experiment lets a joint follow another one. Numbers that come out as
/// they were keep their digits; others have as many as it takes to read them back exactly.
///
/// An `<inertial>` is given as URDF requires: at the centre of mass, in axes that keep the rpy of the file.
/// Of the links that are lumped into a moving one (behind fixed joints, and branches off the chain) each
/// keeps its own inertial, and the moving one gets the rest, if that is physically consistent. Else all
/// lumped inertials are scaled by one factor, half of the largest one that leaves the moving link a body.
///
/// `damping` becomes Fv and `friction` Fc, the mean of both directions where the law is asymmetric; what the
/// law does not have is left as it is. Friction below zero is a fault and, by force, written as 0. Rotor
/// inertias, offsets and coupled motors have no place in a URDF: exported_model() names them.
///
/// @param source  what the text is called in messages, such as a file's name
/// @param robot   read from that text; options of its joints may have been changed since
/// @param chi_st  values of robot.standard_parameters(), (N_s) [SI, joint side]
/// @throws InputError  where the robot was not read from that text; a text that is not UTF-8; a wrong number
///                     of values or one that is not finite; a link without mass that has a first moment
RewrittenUrdf rewritten_urdf(std::string_view xml, const std::string& source, const Robot& robot,
                             const Eigen::Ref<const Vector>& chi_st, const UrdfWriteOptions& options = {});

/// The same of a file, which is only read; see write_file() and unified_diff() for what to do with the
/// answer.
RewrittenUrdf rewritten_urdf(const std::filesystem::path& path, const Robot& robot,
                             const Eigen::Ref<const Vector>& chi_st, const UrdfWriteOptions& options = {});

/// The bytes of a file.
///
/// @throws InputError  where it can not be read
[[nodiscard]] std::string urdf_text(const std::filesystem::path& path);

/// Why these inertial parameters are physically inconsistent, in words with the eigenvalue: a mass that is
/// not positive, or second moments about the centre of mass that are not positive semidefinite (the triangle
/// inequality of the principal moments of inertia). Nothing where a body has them; nothing for zeros, a link
/// without a body.
[[nodiscard]] std::optional<std::string> body_complaint(const Inertial& inertial);

/// What changed between two texts, line by line, in the unified format that `patch -p0` takes: three lines of
/// context, the fewest lines removed and added (Myers 1986). Empty where nothing changed.
///
/// @param before_name, after_name  what follows "---" and "+++"
[[nodiscard]] std::string unified_diff(std::string_view before, std::string_view after,
                                       std::string_view before_name, std::string_view after_name);

}  // namespace rivid
