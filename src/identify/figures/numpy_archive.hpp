#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

// Arrays in one file of NumPy (.npz): a zip archive whose members are stored as they are. Equal arrays are
// equal files.
class NumpyArchive {
 public:
  void add(const std::string& name, const Vector& values);
  void add(const std::string& name, const Matrix& values);
  void add(const std::string& name, const std::vector<std::string>& texts);

  // The bytes of the file, once.
  [[nodiscard]] std::string finished();

 private:
  void store(const std::string& name, const std::string& content);

  std::string out_;
  std::string directory_;
  std::uint64_t members_ = 0;
};

}  // namespace rivid::detail
