#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "rivid/error.hpp"
#include "support/temporary_folder.hpp"

// A harness is one file of this folder: LLVMFuzzerTestOneInput() gives bytes to a reader and checks what comes out.
// With the preset `fuzz` libFuzzer calls it, else replay.cpp does, with each file of corpus/<harness>.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace rivid::fuzz {

/// Ends the program where a claim does not hold: the input is a finding.
inline void require(bool holds, std::string_view claim) {
  if (!holds) {
    std::fprintf(stderr, "does not hold: %.*s\n", static_cast<int>(claim.size()), claim.data());
    std::abort();
  }
}

/// What a reader makes of an input; nothing where it refuses the input in words. Any other exception is a finding.
template <typename Read>
[[nodiscard]] auto accepted(const Read& read) {
  std::optional<decltype(read())> out;
  try {
    out.emplace(read());
  } catch (const Error& e) {
    require(std::string_view(e.what()).find('\n') == std::string_view::npos, "a message has one line");
  }
  return out;
}

/// What a reader makes of a text that this library wrote, which it must not refuse.
template <typename Read>
[[nodiscard]] auto read_back(std::string_view claim, const Read& read) {
  try {
    return read();
  } catch (const Error& e) {
    require(false, std::string(claim) + ": " + e.what());
    throw;
  }
}

/// The bytes of an input in turn.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(reinterpret_cast<const char*>(data), size) {}

  /// One of `count` cases, by the next byte: the letters from 'a' on, so that a corpus can be read. 0 at the end.
  [[nodiscard]] std::size_t choice(std::size_t count) {
    if (rest_.empty()) {
      return 0;
    }
    const auto letter = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return static_cast<unsigned char>(letter - 'a') % count;
  }

  /// The bytes before the next line "=====", or all that there are: one file of several.
  [[nodiscard]] std::string_view file() {
    constexpr std::string_view end = "\n=====\n";
    const std::size_t at = rest_.find(end);
    const std::string_view out = rest_.substr(0, at);
    rest_.remove_prefix(at == std::string_view::npos ? rest_.size() : at + end.size());
    return out;
  }

  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

/// The folder for the files of a harness, one for all inputs. TMPDIR says where; one in memory is fastest.
inline const test::TemporaryFolder& folder() {
  static const test::TemporaryFolder out;
  return out;
}

/// Path of a file in folder() with this content.
inline std::filesystem::path file_with(std::string_view content, const std::string& name) {
  folder().write(name, content);
  return folder().path() / name;
}

/// FNV-1a, 64 bits: the checksum of files whose damage must be seen. A harness puts in the right one, lest no input came
/// further than that.
[[nodiscard]] inline std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t sum = 0xCBF29CE484222325U;
  for (const char c : bytes) {
    sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  }
  return sum;
}

}  // namespace rivid::fuzz
