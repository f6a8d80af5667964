#include "write_back.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/identify/prediction.hpp"
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

std::string refusal(const Path& file, const std::vector<Finding>& reasons) {
  std::string out;
  for (const Finding& reason : reasons) {
    out += in_words(reason) + "\n";
  }
  return out + "rivid_identify: " + file.string() + " is not written; --force does it nevertheless\n";
}

void put(const Path& file, const std::string& content, Outputs& outputs, WrittenBack& back) {
  outputs.put(file, content);
  back.files.push_back(file);
}

void put_urdf(const WriteBack& options, const Experiment& experiment, const Identification& result,
              Outputs& outputs, WrittenBack& back) {
  if (!result.physical) {
    back.refusal = "error: there is no estimate that a URDF could be written from\n";
    return;
  }
  const Robot& robot = experiment.robot;
  const Vector& chi_st = result.physical->parameters.chi_st;
  const std::string before = urdf_text(experiment.robot_file);
  const std::string input = experiment.robot_file.string();
  const RewrittenUrdf urdf = rewritten_urdf(before, input, robot, chi_st, {.force = options.force});
  if (urdf.text.empty()) {
    back.refusal = refusal(options.urdf, urdf.faults);
    return;
  }
  back.warnings = urdf.faults;
  std::ranges::copy(urdf.warnings, std::back_inserter(back.warnings));
  if (options.diff) {
    back.diff = unified_diff(before, urdf.text, input, options.urdf.string());
  }
  put(options.urdf, urdf.text, outputs, back);
  for (const std::string& name : options.sidecars) {
    put(sidecar_file(options.urdf, name), sidecar(format_of(name), robot, chi_st), outputs, back);
  }
}

void put_header(const WriteBack& options, const Experiment& experiment, const Identification& result,
                const std::string& run, Outputs& outputs, WrittenBack& back) {
  const DynamicModel model = identified_model(experiment.robot, result, {.force = options.force});
  if (!model.clamped().empty()) {
    back.warnings.push_back(Finding{"driving_friction",
                                    {},
                                    options.header.string() + ": " + listed(model.clamped()) +
                                        " would drive and not brake; taken as zero"});
  }
  put(options.header,
      c_header(model, c_identifier(options.header.stem().string()),
               result.title + " of " + experiment.file.filename().string() +
                   (result.physical ? ", physically consistent parameters" : "") + ", run " + run),
      outputs, back);
}

}  // namespace

std::vector<PlannedFile> WriteBack::files() const {
  std::vector<PlannedFile> out;
  if (!urdf.empty()) {
    out.push_back({urdf, ".urdf"});
    for (const std::string& name : sidecars) {
      out.push_back({sidecar_file(urdf, name), extension(format_of(name))});
    }
  }
  if (!header.empty()) {
    out.push_back({header, ".h"});
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

WrittenBack write_back(const WriteBack& options, const Experiment& experiment, const Identification& result,
                       const std::string& run, Outputs& outputs) {
  WrittenBack back;
  const std::vector<PlannedFile> files = options.files();
  if (files.empty()) {
    return back;
  }
  if (result.status != Status::identified && !options.force) {
    const std::string status(name(result.status));
    back.refusal =
        refusal(files.front().path, {Finding{status, {}, "the result is " + status + ", not identified"}});
    return back;
  }
  if (!options.urdf.empty()) {
    put_urdf(options, experiment, result, outputs, back);
  }
  if (!options.header.empty()) {
    put_header(options, experiment, result, run, outputs, back);
  }
  return back;
}

}  // namespace rivid::apps
