#include <sha2.h>
#include <sys/types.h>

#include <array>

#include "rivid/error.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

InputFile input_file(const std::filesystem::path& path) {
  if (std::error_code ignored; std::filesystem::is_fifo(path, ignored)) {
    throw InputError(path.string() + ": is a pipe, a file is required, which can be read more than once");
  }
  std::array<char, SHA256_DIGEST_STRING_LENGTH> digest{};
  if (SHA256File(path.c_str(), digest.data()) == nullptr) {
    throw InputError(path.string() + ": the file can not be read");
  }
  return {path.string(), digest.data()};
}

}  // namespace rivid
