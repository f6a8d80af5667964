#include "write_back.hpp"

#include <iostream>
#include <optional>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/report/file.hpp"
#include "rivid/text.hpp"

namespace rivid::apps {

namespace {

using Path = std::filesystem::path;

Sidecar format_of(const std::string& name) {
  const std::optional<Sidecar> format = sidecar_named(name);
  if (!format) {
    throw InputError("--sidecar: " + in_quotes(name) + " is no format");
  }
  return *format;
}

Path sidecar_file(const Path& urdf, const std::string& name) {
  return Path(urdf).replace_extension(extension(format_of(name)));
}

bool refuse(const Path& file, const std::vector<Finding>& reasons) {
  tell(reasons);
  std::cerr << "rivid_identify: " << file.string() << " is not written; --force does it nevertheless\n";
  return false;
}

void write(const Path& file, const std::string& content, bool quiet) {
  write_file(file, content);
  if (!quiet) {
    std::cerr << "wrote " << file.string() << '\n';
  }
}

bool write_urdf(const WriteBack& options, const Experiment& experiment, const Identification& result,
                bool quiet) {
  if (!result.physical) {
    std::cerr << "error: there is no estimate that a URDF could be written from\n";
    return false;
  }
  const Robot& robot = experiment.robot;
  const Vector& chi_st = result.physical->parameters.chi_st;
  const std::string before = urdf_text(experiment.robot_file);
  const std::string input = experiment.robot_file.string();
  const RewrittenUrdf urdf = rewritten_urdf(before, input, robot, chi_st, {.force = options.force});
  if (urdf.text.empty()) {
    return refuse(options.urdf, urdf.faults);
  }
  std::vector<std::pair<Path, std::string>> files = {{options.urdf, urdf.text}};
  for (const std::string& name : options.sidecars) {
    files.emplace_back(sidecar_file(options.urdf, name), sidecar(format_of(name), robot, chi_st));
  }
  if (!quiet) {
    tell(urdf.faults);
    tell(urdf.warnings);
  }
  if (options.diff && !quiet) {
    print(unified_diff(before, urdf.text, input, options.urdf.string()));
  }
  for (const auto& [file, content] : files) {
    write(file, content, quiet);
  }
  return true;
}

void write_header(const WriteBack& options, const Experiment& experiment, const Identification& result,
                  bool quiet) {
  const DynamicModel model = identified_model(experiment.robot, result, {.force = options.force});
  if (!quiet && !model.clamped().empty()) {
    tell({Finding{"driving_friction",
                  {},
                  options.header.string() + ": " + listed(model.clamped()) +
                      " would drive and not brake; taken as zero"}});
  }
  write(options.header,
        c_header(model, c_identifier(options.header.stem().string()),
                 result.title + " of " + experiment.file.filename().string() +
                     (result.physical ? ", physically consistent parameters" : "")),
        quiet);
}

}  // namespace

std::vector<Path> WriteBack::files() const {
  std::vector<Path> out;
  if (!urdf.empty()) {
    out.push_back(urdf);
    for (const std::string& name : sidecars) {
      out.push_back(sidecar_file(urdf, name));
    }
  }
  if (!header.empty()) {
    out.push_back(header);
  }
  return out;
}

std::vector<Argument> arguments(WriteBack& options) {
  return {
      {"--write-urdf", "FILE", "The robot's URDF with the identified numbers, else as it is", &options.urdf},
      {.name = "--diff",
       .value = "",
       .text = "Print what changes in the URDF",
       .target = &options.diff,
       .needs = "--write-urdf",
       .excludes = "--json"},
      {.name = "--sidecar",
       .value = "mujoco|drake|pinocchio",
       .text = "What a URDF can not say, beside it, for these programs",
       .target = &options.sidecars,
       .needs = "--write-urdf"},
      {"--write-header", "FILE.h", "C header with the torques of the identified robot", &options.header},
      {"--force", "", "Write these files even if the result is not identified or no body has such inertias",
       &options.force}};
}

void check(const WriteBack& options, const Experiment& experiment) {
  if (!options.urdf.empty() && experiment.robot.base.empty()) {
    throw InputError("--write-urdf: the robot comes from " + experiment.robot_file.string() +
                     ", which is no URDF");
  }
}

bool write_back(const WriteBack& options, const Experiment& experiment, const Identification& result,
                bool quiet) {
  const std::vector<Path> files = options.files();
  if (files.empty()) {
    return true;
  }
  if (result.status != Status::identified && !options.force) {
    const std::string status(name(result.status));
    return refuse(files.front(), {Finding{status, {}, "the result is " + status + ", not identified"}});
  }
  const bool written = options.urdf.empty() || write_urdf(options, experiment, result, quiet);
  if (!options.header.empty()) {
    write_header(options, experiment, result, quiet);
  }
  return written;
}

}  // namespace rivid::apps
