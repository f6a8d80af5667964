#include "rivid/export/model.hpp"

#include <algorithm>
#include <iterator>

#include "comma_list.hpp"
#include "export/model_tree.hpp"
#include "export/xml_edit.hpp"
#include "model/urdf_document.hpp"
#include "rivid/error.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

using detail::ExportTask;
using detail::JointValues;

constexpr std::array<std::string_view, 5> endings = {".urdf", ".xml", ".sdf", "_drake.urdf",
                                                     "_pinocchio.urdf"};
constexpr std::array<std::string_view, 5> titles = {"URDF", "MJCF", "SDF", "URDF", "URDF"};

void tell_loss(ExportedModel& out, std::string text) {
  out.warnings.push_back(Finding{"format_has_no_place", {}, std::move(text)});
}

std::filesystem::path module_beside(const std::filesystem::path& file) {
  return file.parent_path() / (c_identifier(file.stem().string()) + ".py");
}

// What is lost joint by joint, `parts` being the parameters that the format has no place for.
template <typename Parts>
void tell_joints(ModelFormat format, const ExportTask& task, const Parts& parts, ExportedModel& out) {
  for (std::size_t j = 0; j < task.values.size(); ++j) {
    if (const std::vector<std::string> lost = parts(task.values[j]); !lost.empty()) {
      tell_loss(out, "joint \"" + task.robot.joints[j].name +
                         "\": " + std::string(titles[static_cast<std::size_t>(format)]) +
                         " has no place for " + detail::comma_list(lost));
    }
  }
}

std::string gravity_of(const ExportTask& task) {
  const Eigen::Vector3d& g = task.tree.gravity;
  return "[" + number(g.x()) + ", " + number(g.y()) + ", " + number(g.z()) + "] m/s²";
}

bool has_dry_friction(const ExportTask& task) {
  return std::ranges::any_of(task.values,
                             [](const JointValues& v) { return v.friction.value_or(0.0) > 0.0; });
}

// What the program that reads the format makes of the model, where that is not what was identified.
void tell_program(ModelFormat format, const ExportTask& task, ExportedModel& out) {
  const std::string module = module_beside(task.file).filename().string();
  switch (format) {
    case ModelFormat::urdf:
      tell_loss(out, "URDF has no place for gravity, which is " + gravity_of(task) +
                         ": set it in the program that reads the file");
      tell_joints(format, task, [](const JointValues& v) { return v.unsaid(true); }, out);
      break;
    case ModelFormat::mjcf:
      tell_joints(format, task, [](const JointValues& v) { return v.unsaid(false); }, out);
      if (has_dry_friction(task)) {
        tell_loss(out,
                  "MuJoCo takes the direction of dry friction from the velocity one time step later: it is "
                  "another one where |q̇| is less than about 2 ms times |q̈|");
      }
      break;
    case ModelFormat::sdf:
      tell_joints(format, task, [](const JointValues& v) { return v.unsaid(true); }, out);
      if (std::ranges::any_of(task.values, [](const JointValues& v) { return !v.rotor.empty(); })) {
        tell_loss(out, "the rotor inertias stand in drake:rotor_inertia, which Drake alone reads");
      }
      break;
    case ModelFormat::drake:
      tell_joints(format, task, [](const JointValues& v) { return v.coupled; }, out);
      tell_loss(out, "URDF has no place for gravity, which is " + gravity_of(task) + ": load() of " + module +
                         " sets it");
      tell_loss(out, "MultibodyPlant has no friction but damping: friction_left_out() of " + module +
                         " has the rest");
      for (const detail::ModelTree::Joint& joint : task.tree.joints) {
        if (joint.index >= 0 && joint.effort && *joint.effort == 0.0) {
          tell_loss(out, "joint \"" + joint.name +
                             "\": its effort limit is 0, for which Drake makes no actuator and "
                             "leaves its rotor inertia out; set the limit in the URDF");
        }
      }
      break;
    case ModelFormat::pinocchio:
      tell_joints(format, task, [](const JointValues& v) { return v.coupled; }, out);
      tell_loss(out, "URDF has no place for gravity, which is " + gravity_of(task) + ": load() of " + module +
                         " sets it");
      tell_loss(out, "pinocchio.rnea() has no friction: inverse_dynamics() of " + module + " adds it");
      break;
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

std::string with_comment(const std::string& xml, const std::string& source,
                         const std::vector<std::string>& heading) {
  const detail::UrdfDocument document(xml, source);
  detail::Splice splice(xml);
  splice.insert_child(detail::start_tag(xml, static_cast<std::size_t>(document.robot().offset_debug())),
                      {"<!--" + detail::comment_text(heading) + "-->"});
  return splice.result();
}

void write_files(ModelFormat format, ExportTask& task, const std::string& xml, const std::string& origin,
                 ExportedModel& out) {
  const std::string source = task.urdf.string();
  task.heading = heading_lines(origin, out.warnings);
  const std::vector<std::filesystem::path> names = exported_files(format, task.file);
  std::vector<std::string> missing;
  const auto add = [&](std::string text) { out.files.push_back({names[out.files.size()], std::move(text)}); };
  switch (format) {
    case ModelFormat::urdf:
      add(with_comment(xml, source, task.heading));
      break;
    case ModelFormat::mjcf:
      add(detail::mjcf(task, missing));
      break;
    case ModelFormat::sdf:
      add(detail::sdf(task, missing));
      break;
    case ModelFormat::drake:
      add(with_comment(detail::with_transmissions(xml, source, task), source, task.heading));
      add(detail::drake_module(task));
      break;
    case ModelFormat::pinocchio:
      add(with_comment(xml, source, task.heading));
      add(detail::rotor_parameters(task));
      add(detail::pinocchio_module(task));
      break;
  }
  for (std::string& each : missing) {
    tell_loss(out, std::move(each));
  }
}

std::filesystem::path main_file(ModelFormat format, const std::filesystem::path& urdf,
                                const std::filesystem::path& asked) {
  if (!asked.empty()) {
    return asked;
  }
  return urdf.parent_path() / (urdf.stem().string() + "_identified" + std::string(usual_ending(format)));
}

}  // namespace

std::string_view usual_ending(ModelFormat format) { return endings[static_cast<std::size_t>(format)]; }

std::vector<std::filesystem::path> exported_files(ModelFormat format, const std::filesystem::path& file) {
  std::vector<std::filesystem::path> out = {file};
  if (format == ModelFormat::pinocchio) {
    out.push_back(std::filesystem::path(file).replace_extension(".srdf"));
  }
  if (format == ModelFormat::pinocchio || format == ModelFormat::drake) {
    out.push_back(module_beside(file));
  }
  return out;
}

ExportedModel exported_model(ModelFormat format, const std::filesystem::path& urdf, const Robot& robot,
                             const Eigen::Ref<const Vector>& chi_st, const ModelExportOptions& options) {
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
  ExportTask task{.robot = robot,
                  .values = values,
                  .tree = tree,
                  .urdf = urdf,
                  .file = main_file(format, urdf, options.file),
                  .heading = {}};
  tell_program(format, task, out);
  if (format != ModelFormat::mjcf && format != ModelFormat::sdf) {
    tell_moved_meshes(task, out);
  }
  write_files(format, task, rewritten.text, options.origin, out);
  return out;
}

}  // namespace rivid
