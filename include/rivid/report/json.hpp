#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/simulate/closed_loop.hpp"

namespace rivid {

/// A file that a result was made from.
struct InputFile {
  std::string path;    ///< as the user named it
  std::string sha256;  ///< of its content, 64 hexadecimal digits
};

/// @throws InputError where the file can not be read
[[nodiscard]] InputFile input_file(const std::filesystem::path& path);

/// The first input of the run that wrote a JSON document, its experiment file, as the user named it. Empty
/// where the document does not say.
[[nodiscard]] std::filesystem::path recorded_experiment(const std::filesystem::path& document);

/// Where a result comes from: enough to make it again.
struct Provenance {
  std::string program;            ///< "rivid_identify"
  std::vector<InputFile> inputs;  ///< experiment, robot, logs
  std::vector<std::pair<std::string, std::string>>
      overrides;                       ///< command line flags that changed the experiment
  std::vector<Setting> settings = {};  ///< all that it was made with, see settings()
  /// Files of the same run that have no place for its id, such as tables, by their names.
  std::vector<InputFile> outputs = {};
};

/// What all files of one run carry: 16 hexadecimal digits of the SHA-256 of program, version, inputs and
/// settings. Equal runs have the same, and files that have different ones come from different runs.
[[nodiscard]] std::string run_id(const Provenance& provenance);

/// A result as JSON, the content of result.json; docs/result.md describes its members. Numbers are written so
/// that they read back bit by bit; what is not a number or infinite becomes null.
///
/// @throws InputError where the result has other joints than the robot
[[nodiscard]] std::string to_json(const Robot& robot, const Identification& result,
                                  const Provenance& provenance);

/// What rivid simulate reports of a simulation, the content of simulation.json; docs/simulation.md describes
/// its members. read_parameters() reads it as a parameter file. Numbers are written so that they read back
/// bit by bit; what is not a number becomes null.
[[nodiscard]] std::string to_json(const Robot& robot, const SimulationRecord& record,
                                  const Provenance& provenance);

/// The same for people: verdict, tracking and friction joint by joint, effort.
///
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string summary(const Robot& robot, const SimulationRecord& record, std::size_t screen = 0);

}  // namespace rivid
