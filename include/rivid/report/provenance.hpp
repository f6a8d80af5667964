#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rivid {

/// A file that a result was made from.
struct InputFile {
  std::string path;    ///< as the user named it
  std::string sha256;  ///< of its content, 64 hexadecimal digits
};

/// @throws InputError where the file can not be read
[[nodiscard]] InputFile input_file(const std::filesystem::path& path);

/// Where a result comes from: enough to make it again.
struct Provenance {
  std::string program;            ///< "rivid_identify"
  std::vector<InputFile> inputs;  ///< experiment, robot, logs
  std::vector<std::pair<std::string, std::string>>
      overrides;  ///< command line flags that changed the experiment
};

}  // namespace rivid
