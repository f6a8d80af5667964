#pragma once

#include <malloc.h>

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

/// The most memory that a run held beside what was held before it.
template <typename Run>
double peak_bytes(const Run& run) {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5" << std::flush;  // sets the peak to the present
  const double before = status_bytes("VmRSS");
  run();
  return status_bytes("VmHWM") - before;
}

}  // namespace rivid::benchmarks
