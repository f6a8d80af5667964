#include "rivid/export/model.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>

#include "export/model_tree.hpp"
#include "export/xml_edit.hpp"
#include "joined.hpp"
#include "rivid/error.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/model/kinds.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

using detail::ExportTask;
using detail::JointValues;

using Path = std::filesystem::path;
using Words = std::vector<std::string>;

Path itself(const Path& file) { return file; }
Path srdf_beside(const Path& file) { return Path(file).replace_extension(".srdf"); }
Path module_beside(const Path& file) {
  return file.parent_path() / (c_identifier(file.stem().string()) + ".py");
}

void tell_loss(ExportedModel& out, std::string text) {
  out.warnings.push_back(Finding{"format_has_no_place", {}, std::move(text)});
}

std::string gravity_of(const ExportTask& task) {
  const Eigen::Vector3d& g = task.tree.gravity;
  return "URDF has no place for gravity, which is [" + number(g.x()) + ", " + number(g.y()) + ", " +
         number(g.z()) + "] m/s²: ";
}

std::string module_of(const ExportTask& task) { return module_beside(task.file).filename().string(); }

Words with_rotor(const JointValues& values) { return values.unsaid(true); }
Words without_rotor(const JointValues& values) { return values.unsaid(false); }
Words of_coupled_motors(const JointValues& values) { return values.coupled; }

void tell_urdf(const ExportTask& task, ExportedModel& out) {
  tell_loss(out, gravity_of(task) + "set it in the program that reads the file");
}

void tell_mujoco(const ExportTask& task, ExportedModel& out) {
  std::erase_if(out.warnings, [](const Finding& warning) {  // which MuJoCo closes
    return warning.text.find("is of a four-bar linkage") != std::string::npos;
  });
  if (std::ranges::any_of(task.values, [](const JointValues& v) { return v.friction.value_or(0.0) > 0.0; })) {
    tell_loss(out,
              "MuJoCo takes the direction of dry friction from the velocity one time step later: it is "
              "another one where |q̇| is less than about 2 ms times |q̈|");
  }
}

void tell_sdf(const ExportTask& task, ExportedModel& out) {
  if (std::ranges::any_of(task.values, [](const JointValues& v) { return !v.rotor.empty(); })) {
    tell_loss(out, "the rotor inertias stand in drake:rotor_inertia, which Drake alone reads");
  }
}

void tell_drake(const ExportTask& task, ExportedModel& out) {
  tell_loss(out, gravity_of(task) + "load() of " + module_of(task) + " sets it");
  tell_loss(out, "MultibodyPlant has no friction but damping: friction_left_out() of " + module_of(task) +
                     " has the rest");
  for (const detail::ModelTree::Joint& joint : task.tree.joints) {
    if (joint.index >= 0 && joint.effort && *joint.effort == 0.0) {
      tell_loss(out, "joint \"" + joint.name +
                         "\": its effort limit is 0, for which Drake makes no actuator and "
                         "leaves its rotor inertia out; set the limit in the URDF");
    }
  }
}

void tell_pinocchio(const ExportTask& task, ExportedModel& out) {
  tell_loss(out, gravity_of(task) + "load() of " + module_of(task) + " sets it");
  tell_loss(out, "pinocchio.rnea() has no friction: inverse_dynamics() of " + module_of(task) + " adds it");
}

std::string commented_urdf(const ExportTask& task, std::string_view xml) {
  const detail::UrdfDocument document(xml, task.urdf.string());
  detail::Splice splice(xml);
  splice.insert_child(detail::start_tag(xml, static_cast<std::size_t>(document.robot().offset_debug())),
                      {"<!--" + detail::comment_text(task.heading) + "-->"});
  return splice.result();
}

std::string urdf(const ExportTask& task, Words& /*missing*/) { return commented_urdf(task, task.xml); }
std::string drake_urdf(const ExportTask& task, Words& /*missing*/) {
  return commented_urdf(task, detail::with_transmissions(task));
}

// A file of a format: how it is called, beside the main one, and what it says. `missing` gets what had to be
// left out.
struct FileRow {
  Path (*name)(const Path& main);
  std::string (*text)(const ExportTask& task, Words& missing);
};
constexpr std::array urdf_files = {FileRow{itself, urdf}};
constexpr std::array mjcf_files = {FileRow{itself, detail::mjcf}};
constexpr std::array sdf_files = {FileRow{itself, detail::sdf}};
constexpr std::array drake_files = {FileRow{itself, drake_urdf},
                                    FileRow{module_beside, detail::drake_module}};
constexpr std::array pinocchio_files = {FileRow{itself, urdf}, FileRow{srdf_beside, detail::rotor_parameters},
                                        FileRow{module_beside, detail::pinocchio_module}};

// All that is known of a format.
struct FormatRow {
  ModelFormat format;
  std::string_view title;
  std::string_view ending;
  bool finds_meshes;                                    // else it names mesh files as the URDF does
  Words (*unsaid)(const JointValues&);                  // parameters of a joint that it has no place for
  void (*tell)(const ExportTask&, ExportedModel& out);  // what else its program does not make of the model
  std::span<const FileRow> files;                       // the main one first
};
constexpr std::array format_rows = {
    FormatRow{ModelFormat::mjcf, "MJCF", ".xml", true, without_rotor, tell_mujoco, mjcf_files},
    FormatRow{ModelFormat::sdf, "SDF", ".sdf", true, with_rotor, tell_sdf, sdf_files},
    FormatRow{ModelFormat::drake, "URDF", "_drake.urdf", false, of_coupled_motors, tell_drake, drake_files},
    FormatRow{ModelFormat::pinocchio, "URDF", "_pinocchio.urdf", false, of_coupled_motors, tell_pinocchio,
              pinocchio_files},
    FormatRow{ModelFormat::urdf, "URDF", ".urdf", false, with_rotor, tell_urdf, urdf_files},
};
static_assert(detail::complete<format_rows, &FormatRow::format>() &&
                  names_of<ModelFormat>.size() == format_rows.size(),
              "one row and one name for each ModelFormat, in its order");

constexpr const FormatRow& about(ModelFormat format) { return format_rows[static_cast<std::size_t>(format)]; }

// What is lost of all joints.
void tell_joints(const FormatRow& format, const ExportTask& task, ExportedModel& out) {
  Words lost;
  for (const JointValues& joint : task.values) {
    std::ranges::move(format.unsaid(joint), std::back_inserter(lost));
  }
  if (!lost.empty()) {
    tell_loss(out, std::string(format.title) + " has no place for " + detail::joined(lost));
  }
}

// No program takes a rotor of negative inertia: it is a fault and, by force, written as 0.
void take_rotors(const Robot& robot, std::vector<JointValues>& values, ExportedModel& out) {
  for (std::size_t j = 0; j < values.size(); ++j) {
    if (values[j].Ia < 0.0) {
      out.faults.push_back(Finding{"no_body",
                                   {},
                                   "joint \"" + robot.joints[j].name + "\": its rotor inertia is " +
                                       number(values[j].Ia, 4) + ", must not be negative"});
      values[j].Ia = 0.0;
    }
  }
}

// Formats that keep the URDF's names of mesh files, which may be relative to its folder.
void tell_moved_meshes(const ExportTask& task, ExportedModel& out) {
  namespace fs = std::filesystem;
  const auto folder = [](const fs::path& file) {
    return fs::absolute(file).lexically_normal().parent_path();
  };
  if (folder(task.urdf) == folder(task.file)) {
    return;
  }
  for (const detail::ModelTree::Link& link : task.tree.links) {
    for (const detail::ModelTree::Shape& shape : link.shapes) {
      if (!shape.mesh.empty() && shape.mesh.find("://") == std::string::npos && shape.mesh.front() != '/') {
        out.warnings.push_back(Finding{"meshes_elsewhere",
                                       {},
                                       "mesh files such as " + in_quotes(shape.mesh) +
                                           " are named relative to " + folder(task.urdf).string() +
                                           ": write the model there, with --output"});
        return;
      }
    }
  }
}

// The comment on top of each file.
std::vector<std::string> heading_lines(const std::string& origin, const std::vector<Finding>& warnings) {
  std::vector<std::string> out = {std::string("Written by rivid ") + version +
                                  (origin.empty() ? "" : ": " + origin) + "."};
  for (const Finding& warning : warnings) {
    out.push_back(sentence(warning) + ".");
  }
  return out;
}

}  // namespace

std::string_view usual_ending(ModelFormat format) { return about(format).ending; }

std::vector<std::filesystem::path> exported_files(ModelFormat format, const std::filesystem::path& file) {
  std::vector<Path> out;
  for (const FileRow& each : about(format).files) {
    out.push_back(each.name(file));
  }
  return out;
}

ExportedModel exported_model(ModelFormat format, const std::filesystem::path& urdf, const Robot& robot,
                             const Eigen::Ref<const Vector>& chi_st, const ModelExportOptions& options) {
  if (robot.base_joints > 0 && format != ModelFormat::urdf) {
    throw InputError("exported_model: base of robot \"" + robot.name +
                     "\" floats; such a robot is written as URDF alone (urdf)");
  }
  const std::string text = urdf_text(urdf);
  const RewrittenUrdf rewritten =
      rewritten_urdf(text, urdf.string(), robot, chi_st, {.force = options.force});
  std::vector<JointValues> values = detail::joint_values(robot, chi_st, "exported_model");
  ExportedModel out{.files = {}, .faults = rewritten.faults, .warnings = rewritten.warnings};
  take_rotors(robot, values, out);
  if (!out.faults.empty() && !options.force) {
    return out;
  }
  const detail::ModelTree tree = detail::model_tree(rewritten.text, urdf.string(), robot);
  const FormatRow& row = about(format);
  ExportTask task{.robot = robot,
                  .values = values,
                  .tree = tree,
                  .xml = rewritten.text,
                  .urdf = urdf,
                  .file = options.file,
                  .heading = {}};
  if (task.file.empty()) {
    task.file = urdf.parent_path() / (urdf.stem().string() + "_identified" + std::string(row.ending));
  }
  tell_joints(row, task, out);
  row.tell(task, out);
  if (!row.finds_meshes) {
    tell_moved_meshes(task, out);
  }
  task.heading = heading_lines(options.origin, out.warnings);
  Words missing;
  for (const FileRow& each : row.files) {
    out.files.push_back({each.name(task.file), each.text(task, missing)});
  }
  for (std::string& each : missing) {
    tell_loss(out, std::move(each));
  }
  return out;
}

}  // namespace rivid
