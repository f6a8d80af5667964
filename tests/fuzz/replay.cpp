// Gives each file of the folders that are named to a harness, as libFuzzer does with -runs=0.

#include <cstdio>

#include "harness.hpp"

int main(int count, char** arguments) {
  int inputs = 0;
  for (int i = 1; i < count; ++i) {
    for (const auto& entry : std::filesystem::directory_iterator(arguments[i])) {
      const std::string bytes = rivid::test::content_of(entry.path());
      std::fprintf(stderr, "%s\n", entry.path().c_str());  // the last one is the one that failed
      LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
      ++inputs;
    }
  }
  std::printf("%d inputs\n", inputs);
  return inputs > 0 ? 0 : 1;
}
