#pragma once

#include <fstream>
#include <string>

namespace rivid::benchmarks {

/// Bytes of a line of /proc/self/status.
inline double status_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == name + ":") {
      double kilobytes = 0.0;
      status >> kilobytes;
      return 1024.0 * kilobytes;
    }
  }
  return 0.0;
}

}  // namespace rivid::benchmarks
