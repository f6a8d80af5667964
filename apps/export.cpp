#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "joined.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/export/c_header.hpp"
#include "rivid/export/model.hpp"
#include "rivid/export/samples.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/identify/posterior.hpp"
#include "rivid/input.hpp"
#include "rivid/output.hpp"
#include "rivid/text.hpp"
#include "subcommands.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

using Path = std::filesystem::path;

struct ExportArguments : Given {
  Path result;
  std::string to;
  Path urdf;
  std::optional<int> samples;
  std::uint64_t seed = 1;
  bool diff = false;
  bool force = false;
};

constexpr std::string_view c_header_format = "header";
constexpr std::string_view array_format = "npz";  // of samples

// "mjcf|sdf|…|header|npz".
std::string formats() {
  return detail::joined(names_of<ModelFormat>, "|") + "|" + std::string(c_header_format) + "|" +
         std::string(array_format);
}

// The URDF that the robot was read from.
Path urdf_of(const IdentifiedRobot& identified, const ExportArguments& arguments, const Path& result) {
  if (!arguments.urdf.empty()) {
    return arguments.urdf;
  }
  if (!identified.urdf) {
    throw InputError(result.string() + ": does not say which URDF its robot comes from, which --to " +
                     arguments.to + " needs; --urdf ROBOT.urdf names it, --to header does without");
  }
  const Path path = found_again(identified.urdf->path, result);
  if (!std::filesystem::exists(path)) {
    throw InputError(result.string() + ": its URDF " + path.string() +
                     " is not there; --urdf says where it is now");
  }
  if (input_file(path).sha256 != identified.urdf->sha256) {
    throw InputError(path.string() + ": has changed since " + result.string() +
                     " was made from it; identify again, or take it all the same with --urdf");
  }
  return path;
}

// One line that says where the numbers come from.
std::string origin_of(const IdentifiedRobot& identified) {
  std::string method = identified.method;
  std::ranges::transform(method, method.begin(), [](unsigned char c) { return std::toupper(c); });
  return "IDIM-" + method +
         (identified.experiment ? " of " + identified.experiment->path.filename().string() : "") +
         (identified.parameters == ParameterSet::physical ? ", physically consistent parameters" : "") +
         (identified.run.empty() ? "" : ", run " + identified.run);
}

// The main file where --output does not say: beside the result, called after the robot.
Path usual_file(const IdentifiedRobot& identified, const Path& result, std::string_view ending) {
  const std::string name =
      identified.urdf ? identified.urdf->path.stem().string() : c_identifier(identified.robot.name);
  return result.parent_path() / (name + "_identified" + std::string(ending));
}

ExportedModel header_of(const IdentifiedRobot& identified, const Path& file) {
  const DynamicModel model(identified.robot, identified.chi_st);
  ExportedModel out{
      .files = {{file, c_header(model, c_identifier(file.stem().string()), origin_of(identified))}},
      .faults = {},
      .warnings = {}};
  if (!model.clamped().empty()) {
    out.warnings.push_back(Finding{
        "driving_friction", {}, listed(model.clamped()) + " would drive and not brake; taken as zero"});
  }
  return out;
}

// Beside the main file of samples.
Path beside(const Path& file, const char* ending) {
  return file.parent_path() / (file.stem().string() + ending);
}
Path ranges_file(const Path& file) { return beside(file, "_ranges.json"); }
Path manifest_file(const Path& file) { return beside(file, "_samples.json"); }

// Robots drawn from the distribution of a result, in a format, or all of them as arrays.
ExportedModel samples_of(const IdentifiedRobot& identified, const ExportArguments& arguments,
                         const std::optional<ModelFormat>& format, const Path& urdf, const Path& file,
                         const Path& result) {
  const auto [robot, found] = result_of(read_input(result).bytes(), result.string());
  const PosteriorOptions options{.count = *arguments.samples, .seed = arguments.seed};
  const PosteriorSamples samples = posterior_samples(robot, found, options);
  ExportedModel out;
  for (int k = 0; format && k < options.count; ++k) {
    ExportedModel model = exported_model(*format, urdf, robot, samples.chi_st.row(k).transpose(),
                                         {.force = arguments.force,
                                          .file = sample_file(file, k),
                                          .origin = origin_of(identified) + ", sample " + std::to_string(k) +
                                                    " of seed " + std::to_string(options.seed)});
    if (out.warnings.empty()) {
      out.warnings = model.warnings;  // those of the others differ in their numbers
    }
    std::ranges::move(model.faults, std::back_inserter(out.faults));
    if (model.files.empty()) {
      out.files.clear();
      return out;
    }
    std::ranges::move(model.files, std::back_inserter(out.files));
  }
  if (!format) {
    out.files.push_back({file, to_npz(found.base, samples)});
  }
  if (!samples.held.empty()) {
    out.warnings.push_back(Finding{"not_drawn",
                                   {},
                                   "the result leaves " + listed(samples.held) +
                                       " undetermined: all samples have the physically consistent value"});
  }
  out.files.push_back({ranges_file(file), randomisation_ranges(robot, identified.chi_st, samples)});
  out.files.push_back(
      {manifest_file(file), sample_manifest(input_file(result), options, samples, out.files)});
  return out;
}

// Names of what is to be written.
std::vector<Path> files_of(const ExportArguments& arguments, const std::optional<ModelFormat>& format,
                           const Path& file) {
  if (!arguments.samples) {
    return format ? exported_files(*format, file) : std::vector<Path>{file};
  }
  std::vector<Path> out;
  for (int k = 0; format && k < *arguments.samples; ++k) {
    std::ranges::move(exported_files(*format, sample_file(file, k)), std::back_inserter(out));
  }
  if (!format) {
    out.push_back(file);
  }
  out.push_back(ranges_file(file));
  out.push_back(manifest_file(file));
  return out;
}

int refused(const Path& file, const std::vector<Finding>& faults) {
  tell(told_once(faults));
  tell("rivid export: " + file.string() + " is not written; --force does it nevertheless\n");
  return no_success;
}

int write(const ExportArguments& arguments, const ExportedModel& made, const std::vector<PlannedFile>& files,
          Outputs& outputs) {
  for (const auto& [path, text] : made.files) {
    outputs.put(path, text);
  }
  outputs.commit();
  if (!arguments.quiet) {
    tell(told_once(made.faults));
    tell(told_once(made.warnings));
    tell_written(files);
  }
  return success;
}

void expect_format_of_samples(const ExportArguments& arguments) {
  if (arguments.to == array_format && !arguments.samples) {
    throw InputError("--to npz holds samples of the result's distribution; it needs --samples N");
  }
  if (arguments.to == c_header_format && arguments.samples) {
    throw InputError("--samples is for models and npz; --to header has the torques of one robot");
  }
}

int export_from(const ExportArguments& arguments) {
  const Path result = result_file(arguments.result);
  const bool header = arguments.to == c_header_format;
  expect_format_of_samples(arguments);
  if (arguments.diff && arguments.to != "urdf") {
    throw InputError("--diff shows what changes in a URDF; it needs --to urdf");
  }
  const IdentifiedRobot identified = read_identified_robot(
      result, {.parameters = header ? std::nullopt : std::optional(ParameterSet::physical), .force = true});
  const std::optional<ModelFormat> format = named<ModelFormat>(arguments.to);
  const Path urdf = format ? urdf_of(identified, arguments, result) : Path();
  const Path usual = usual_file(identified, result, format ? usual_ending(*format) : header ? ".h" : ".npz");
  const Path file = arguments.output.empty() ? usual : arguments.output;
  std::vector<PlannedFile> files;
  for (const Path& path : files_of(arguments, format, file)) {
    files.push_back({path, (path == file ? usual : path).extension().string()});
  }
  std::vector<Path> inputs = {result};
  if (format) {
    inputs.push_back(urdf);
  }
  Outputs outputs = planned(inputs, files, arguments.force);
  if (identified.status != "identified" && !arguments.force) {
    return refused(
        file, {Finding{identified.status, {}, "the result is " + identified.status + ", not identified"}});
  }
  const ModelExportOptions options{.force = arguments.force, .file = file, .origin = origin_of(identified)};
  const ExportedModel made =
      arguments.samples ? samples_of(identified, arguments, format, urdf, file, result)
      : header          ? header_of(identified, file)
                        : exported_model(*format, urdf, identified.robot, identified.chi_st, options);
  if (made.files.empty()) {
    return refused(file, made.faults);
  }
  if (arguments.diff) {
    print(unified_diff(urdf_text(urdf), made.files.front().text, urdf.string(), file.string()));
  }
  if (arguments.dry_run) {
    print(would_write(files));
    return success;
  }
  return write(arguments, made, files, outputs);
}

}  // namespace

std::filesystem::path found_again(const std::filesystem::path& named, const std::filesystem::path& result) {
  const Path beside = std::filesystem::absolute(result).parent_path().parent_path() / named;
  return !std::filesystem::exists(named) && std::filesystem::exists(beside) ? beside : named;
}

int export_command(int argc, char** argv) {
  ExportArguments to;
  return run_command(
      {.name = "rivid export",
       .description = "Writes the identified robot as a whole model for another program.",
       .arguments =
           {{"result", "RESULT.json", "result.json of rivid identify, or the folder that it is in",
             &to.result, true},
            {.name = "--to",
             .value = formats(),
             .text =
                 "MuJoCo's format, Gazebo's, the files for Drake or Pinocchio, the robot's URDF with other "
                 "numbers, a C header with its torques, or samples as arrays of NumPy",
             .target = &to.to,
             .required = true},
            {"--output", "FILE", "The main file; default: ROBOT_identified beside the result", &to.output},
            {"--urdf", "ROBOT.urdf", "The robot's URDF, where the result does not know where it is",
             &to.urdf},
            {"--samples", "N",
             "N robots drawn from the result's distribution in place of one, with a manifest and the ranges "
             "of "
             "their parameters",
             &to.samples},
            {.name = "--seed",
             .value = "NUMBER",
             .text = "Seed of the samples; default: 1",
             .target = &to.seed,
             .needs = "--samples"},
            {.name = "--diff",
             .value = {},
             .text = "Print what changes in the URDF; with --to urdf",
             .target = &to.diff,
             .excludes = "--samples"},
            {"--force", "",
             "Write a model of a result that is not identified, physically inconsistent links, and over "
             "files of "
             "another kind",
             &to.force},
            {"--dry-run", "", "Print which files would be written", &to.dry_run},
            {"--quiet", "", "Print nothing but errors", &to.quiet}},
       .footer =
           "All but header need the physically consistent parameters of rivid identify --physical.\n"
           "Exit codes: 0 written; 1 the result is not identified, or a link is inconsistent; 2 bad input "
           "or usage."},
      argc, argv, [&] { return export_from(to); });
}

}  // namespace rivid::apps
