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
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
};

/// Arguments of the command line that set them.
[[nodiscard]] std::vector<Argument> arguments(WriteBack& options);

/// Before anything is computed.
///
/// @throws InputError  where a URDF is asked for and the robot was not read from one
void check(const WriteBack& options, const Experiment& experiment);

/// Writes what is asked for and reports it on standard error; the difference goes to standard output.
///
/// @return  whether all was written; else standard error says why not
[[nodiscard]] bool write_back(const WriteBack& options, const Experiment& experiment,
                              const Identification& result, bool quiet);

}  // namespace rivid::apps
