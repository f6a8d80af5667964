#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "tool.hpp"

// What rivid_identify writes beside its result: the robot's URDF with the identified numbers, and code for controllers.
namespace rivid::apps {

struct WriteBack {
  std::filesystem::path urdf;
  bool diff = false;
  std::vector<std::string> sidecars;
  std::filesystem::path header;
  bool force = false;

  /// Files that will be written.
  [[nodiscard]] std::vector<PlannedFile> files() const;
};

/// What became of them.
struct WrittenBack {
  std::vector<std::filesystem::path> files;
  std::vector<Finding> warnings;
  std::string diff;     ///< for standard output, or empty
  std::string refusal;  ///< for standard error: why a file is not written, or empty
};

/// Arguments of the command line that set them.
[[nodiscard]] std::vector<Argument> arguments(WriteBack& options);

/// Before anything is computed.
///
/// @throws InputError  where a URDF is asked for and the robot was not read from one
void check(const WriteBack& options, const Experiment& experiment);

/// Puts what is asked for to the outputs of the run.
///
/// @param run  its run_id()
[[nodiscard]] WrittenBack write_back(const WriteBack& options, const Experiment& experiment,
                                     const Identification& result, const std::string& run, Outputs& outputs);

}  // namespace rivid::apps
